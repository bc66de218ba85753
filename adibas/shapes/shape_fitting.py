"""Fitting a point distribution model to points: pose and shape in turns.

Source: thesis, equations 6.13-6.15; Cootes & Taylor, Statistical models of appearance for computer
vision (2004), section 4.8. The shape step is the least squares of the points that are there, with
the model's own variances as prior (MAP): with points missing, equation 6.11 alone would take the
missing ones to be the mean's. It leaves the pose free to follow (variable projection: Golub &
Pereyra, SIAM Journal on Numerical Analysis 10, 1973); else the two would creep towards the answer,
since with points missing a change of shape looks like one of pose.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.shapes.point_distribution import PointDistribution
from adibas.shapes.shape_fitting_kernels import most_probable_shape
from adibas.shapes.similarity import Similarity, fit_similarity

MAX_ROUNDS = 50
DONE = 1e-8


@dataclass(frozen=True, slots=True, eq=False)
class FitRound:
    """One round of a fit.

    Attributes
    ----------
    pose : Similarity
        From the model's frame into that of the points.
    parameters : (t,) array
        The shape b.
    rms : float
        Root mean square distance of the points that are there from the model's (6.15).
    """

    pose: Similarity
    parameters: FloatArray
    rms: float


@dataclass(frozen=True, slots=True, eq=False)
class ShapeFit:
    """A model laid onto points.

    Attributes
    ----------
    points : (N, D) array
        The model's, also where none was given.
    rounds : tuple of FitRound
        Every round, the last one is the result.
    is_plausible : bool
        Whether the shape was within the model's limit before it was drawn back to it.
    distance : float
        Squared Mahalanobis distance of the shape before that.
    """

    points: FloatArray
    rounds: tuple[FitRound, ...]
    is_plausible: bool
    distance: float

    @property
    def result(self) -> FitRound:
        """The last round."""
        return self.rounds[-1]


def fit_shape(
    model: PointDistribution,
    points: FloatArray,
    sigma: float,
    start: FloatArray | None = None,
) -> ShapeFit | None:
    """Lay a model onto points that are named.

    Parameters
    ----------
    model : PointDistribution
        Of the same points.
    points : (N, D) array
        NaN where one is missing.
    sigma : float
        Standard deviation of a coordinate of `points`, in their unit: how far the model may be
        pulled from its mean.
    start : (t,) array or None
        Shape to begin with; None for the mean.

    Returns
    -------
    fit : ShapeFit or None
        None where the points that are there do not fix a pose.
    """
    check_shape("points", points, model.mean.shape)
    is_there = np.asarray(~np.isnan(points).any(axis=1))
    parameters = np.zeros(len(model.variances)) if start is None else start
    free = parameters
    rounds: list[FitRound] = []
    for _ in range(MAX_ROUNDS):
        shape = model.shape(parameters)
        pose = fit_similarity(points, shape, has_scale=model.has_scale)
        if pose is None:
            return None
        off = pose.inverse().apply(points) - model.mean
        noise = (sigma / pose.scale) ** 2 + model.rest_variance
        free = most_probable_shape(
            off, is_there, model.modes, model.variances, shape, noise, model.has_scale
        )
        new = model.nearest_plausible(free)
        rest = points[is_there] - pose.apply(model.shape(new)[is_there])
        rounds.append(FitRound(pose, new, float(np.sqrt((rest**2).sum(axis=1).mean()))))
        change = float(np.abs((new - parameters) / np.sqrt(model.variances)).max())
        parameters = new
        if change < DONE:
            break
    last = rounds[-1]
    return ShapeFit(
        points=last.pose.apply(model.shape(last.parameters)),
        rounds=tuple(rounds),
        is_plausible=model.is_plausible(free),
        distance=model.distance(free),
    )
