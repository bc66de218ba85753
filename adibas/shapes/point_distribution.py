"""The point distribution model: a mean shape and the ways in which shapes depart from it.

Source: thesis, equations 6.7-6.12; Cootes, Taylor, Cooper & Graham, Active shape models: their
training and application, CVIU 61 (1995). The threshold of plausibility is not "an average value"
but calibrated: the distance within which shapes fall that the model was not made of.
"""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.shapes.procrustes import align_shapes

KEPT_VARIANCE = 0.98
PLAUSIBLE_SHARE = 0.99
N_FOLDS = 10
LEAST_SHAPES = 3
SMALLEST_VARIANCE = 1e-12
"""Of the mean shape's size squared: below it a direction is rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class PointDistribution:
    """What shapes of one kind look like.

    Attributes
    ----------
    names : tuple of str
        Of the N points.
    mean : (N, D) array
        Centred; of size 1 where `has_scale`, else in the unit of the shapes.
    modes : (t, N * D) array
        Orthonormal ways to depart from the mean, the commonest first.
    variances : (t,) array
        Of the shape parameters b, largest first.
    rest_variance : float
        Of one coordinate, outside the modes.
    limit : float
        Plausible shapes have a squared distance (see `distance`) up to this.
    has_scale : bool
        Whether sizes were taken out.
    """

    names: tuple[str, ...]
    mean: FloatArray
    modes: FloatArray
    variances: FloatArray
    rest_variance: float
    limit: float
    has_scale: bool

    def __post_init__(self) -> None:
        n_modes = len(self.variances)
        check_shape("mean", self.mean, (len(self.names), None))
        check_shape("modes", self.modes, (n_modes, self.mean.size))
        if not (self.variances > 0).all() or not self.limit > 0 or not self.rest_variance >= 0:
            raise ValueError("variances and limit must be positive")
        for array in (self.mean, self.modes, self.variances):
            read_only(array)

    def shape(self, parameters: FloatArray) -> FloatArray:
        """Return the (N, D) shape of (t,) parameters b (equation 6.10)."""
        return self.mean + (parameters @ self.modes).reshape(self.mean.shape)

    def parameters(self, shape: FloatArray) -> FloatArray:
        """Return b (t,) of an (N, D) shape in the mean's frame (equation 6.11)."""
        return np.asarray(self.modes @ (shape - self.mean).ravel())

    def distance(self, parameters: FloatArray) -> float:
        """Return the squared Mahalanobis distance of b (t,) from the mean.

        It falls as the density p(b) of a normal distribution rises: ``p(b) >= p_t`` is
        ``distance(b) <= limit``.
        """
        return float((parameters**2 / self.variances).sum())

    def is_plausible(self, parameters: FloatArray) -> bool:
        """Say whether b looks like what the model was made of."""
        return self.distance(parameters) <= self.limit

    def nearest_plausible(self, parameters: FloatArray) -> FloatArray:
        """Return b itself or, drawn back towards the mean, the first plausible b' (6.12)."""
        distance = self.distance(parameters)
        shrink = 1.0 if distance <= self.limit else math.sqrt(self.limit / distance)
        return np.asarray(parameters * shrink)


def learn_distribution(
    names: tuple[str, ...],
    shapes: FloatArray,
    *,
    has_scale: bool = True,
    kept_variance: float = KEPT_VARIANCE,
    plausible_share: float = PLAUSIBLE_SHARE,
) -> PointDistribution:
    """Learn a model from labelled shapes.

    Parameters
    ----------
    names : tuple of str
        Of the points.
    shapes : (S, N, D) array
        At least three; every point of every shape is known.
    has_scale : bool
        Whether sizes are taken out: so where the points are pixels.
    kept_variance : float
        Share of the variance that the modes hold.
    plausible_share : float
        Of shapes that a model has not seen, which it shall find plausible.

    Raises
    ------
    ValueError
        There are fewer shapes, or they are all the same.
    """
    check_shape("shapes", shapes, (None, len(names), None))
    if len(shapes) < LEAST_SHAPES:
        raise ValueError(f"a model needs at least {LEAST_SHAPES} shapes, got {len(shapes)}")
    aligned = align_shapes(shapes, has_scale=has_scale)
    modes, variances, rest = _principal_modes(aligned.shapes, aligned.mean, kept_variance)
    limit = _limit(aligned.shapes, kept_variance, plausible_share)
    return PointDistribution(names, aligned.mean, modes, variances, rest, limit, has_scale)


def _principal_modes(
    aligned: FloatArray, mean: FloatArray, kept_variance: float
) -> tuple[FloatArray, FloatArray, float]:
    """Return modes, their variances (6.8, 6.9) and what one coordinate varies beside them."""
    n_shapes = len(aligned)
    rows = aligned.reshape(n_shapes, -1) - aligned.mean(axis=0).ravel()
    _, spread, modes = np.linalg.svd(rows, full_matrices=False)
    variances = spread**2 / (n_shapes - 1)
    is_real = variances > SMALLEST_VARIANCE * (mean**2).sum()
    variances, modes = variances[is_real], modes[is_real]
    if variances.size == 0:
        raise ValueError("a model needs shapes that differ")
    held = np.cumsum(variances) / variances.sum()
    n_kept = int(np.searchsorted(held, kept_variance - 1e-12)) + 1
    rest = float(variances[n_kept:].sum() / mean.size)
    return modes[:n_kept].copy(), variances[:n_kept].copy(), rest


def _limit(aligned: FloatArray, kept_variance: float, plausible_share: float) -> float:
    """Return the distance within which that share of left-out shapes falls.

    Every tenth shape is measured by the model of the others; where these are too few to make a
    model, a normal distribution's own quantile stands in.
    """
    distances: list[float] = []
    n_folds = min(N_FOLDS, len(aligned))
    n_modes = 1
    for fold in range(n_folds):
        is_left_out = np.arange(len(aligned)) % n_folds == fold
        others = aligned[~is_left_out]
        mean = others.mean(axis=0)
        if len(others) < LEAST_SHAPES:
            break
        modes, variances, _ = _principal_modes(others, mean, kept_variance)
        n_modes = max(n_modes, len(variances))
        b = (aligned[is_left_out] - mean).reshape(np.count_nonzero(is_left_out), -1) @ modes.T
        distances += (b**2 / variances).sum(axis=1).tolist()
    from scipy.stats import chi2

    normal = float(chi2.ppf(plausible_share, n_modes))
    return max(normal, float(np.quantile(distances, plausible_share))) if distances else normal
