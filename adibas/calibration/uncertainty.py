"""How sure the parameters of a refined camera are.

The covariance is that of an M-estimator at its solution: the inverse of the normal equations
times the variance of its influence, and times Birge's ratio where the views contradict one
another more than that (a board that is not flat, a model with too few terms). A pose moves by a
small turn and shift as in `refinement_kernels`.

Source: Huber, Robust statistics (1981), equation 7.6.5, with the derivatives of a loss of a
vector's length; for the moves that a camera's frame makes up with, mrcal's documentation, section
"Projection uncertainty" (cross-reprojection), secretsauce.net/mrcal.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.calibration import refinement_kernels as kernels
from adibas.calibration.lens_models import LensModel
from adibas.calibration.refinement import (
    Observations,
    Refinement,
    accumulated,
    empty_arrow,
)
from adibas.calibration.view_shares import birge_ratio, view_shares
from adibas.geometry.projection import CAMERA_PARAMETERS

SURPRISING_SDS = 2.0
"""Smaller excess of Birge's ratio over 1 is chance, and enlarges nothing."""

SKEW = CAMERA_PARAMETERS.index("skew")


@dataclass(frozen=True, slots=True, eq=False)
class Uncertainty:
    """Covariances of a refined camera.

    Attributes
    ----------
    covariance : (n, n) array
        Of the model's parameters.
    pose_covariances : (V, 6, 6) array
        Of each view's turn and shift.
    implied_moves : (6, n) array
        See `CameraFit.implied_moves`.
    sigma_px : float
        Standard deviation of one coordinate.
    birge_ratio : float
        How much more the views contradict one another than noise explains; clearly above
        1 it is a factor of the covariances.
    """

    covariance: FloatArray
    pose_covariances: FloatArray
    implied_moves: FloatArray
    sigma_px: float
    birge_ratio: float


def uncertainty_of(
    observations: Observations, refinement: Refinement, model: LensModel, cut_sigmas: float
) -> Uncertainty | None:
    """Return how sure a refined camera is; None where the views do not fix the parameters.

    Parameters
    ----------
    observations : Observations
        What it was refined from.
    refinement : Refinement
        With squares, or with the biweight that ends at `cut_sigmas`.
    model : LensModel
        Its unknowns.
    cut_sigmas : float
        Infinite for squares.
    """
    free = model.free()
    sigmas = np.where(refinement.weights > 0, observations.sigmas, np.inf)
    n_used = int(np.isfinite(sigmas).sum())
    left = 2 * n_used - len(free) - 6 * len(sigmas)
    arrow, pulling = empty_arrow(len(free), len(sigmas)), empty_arrow(len(free), len(sigmas))
    estimate, scale_px = refinement.estimate, refinement.scale_px
    accumulated(observations, sigmas, estimate, free, (kernels.PLAIN, np.inf), arrow)
    shares = view_shares(arrow)
    inverse = None if shares is None else shares.inverse()
    if left <= 0 or shares is None or inverse is None:
        return None
    influence, pull, slope = _influence(observations, refinement, cut_sigmas)
    loss = (kernels.TUKEY if np.isfinite(cut_sigmas) else kernels.PLAIN, cut_sigmas * scale_px)
    accumulated(observations, sigmas, estimate, free, loss, pulling)
    pulled = view_shares(arrow, pulling) or shares
    ratio, ratio_sd = birge_ratio(pulled, influence / left)
    is_surprising = ratio > 1.0 + SURPRISING_SDS * ratio_sd
    variance = influence / left / slope**2 * (ratio if is_surprising else 1.0)
    poses = np.linalg.inv(arrow.c)
    follow = shares.b_over_c
    return Uncertainty(
        inverse * variance,
        (poses + follow.swapaxes(1, 2) @ inverse @ follow) * variance,
        _implied_moves(arrow.b, arrow.c, estimate.translations_m),
        float(np.sqrt(pull / left / slope)),
        ratio,
    )


def skew_of(
    observations: Observations, refinement: Refinement, model: LensModel
) -> tuple[float, float]:
    """Return the skew in pixels that one more step would take, and its standard deviation.

    NaN where the views do not fix it.
    """
    free: IntArray = np.append(model.free(), SKEW)
    weights = np.where(refinement.weights > 0, refinement.weights, np.nan)
    sigmas = np.nan_to_num(observations.sigmas / np.sqrt(weights), nan=np.inf, posinf=np.inf)
    arrow = empty_arrow(len(free), len(sigmas))
    accumulated(observations, sigmas, refinement.estimate, free, (kernels.PLAIN, np.inf), arrow)
    shares = view_shares(arrow)
    inverse = None if shares is None else shares.inverse()
    if shares is None or inverse is None:
        return float("nan"), float("nan")
    skew_px = float(inverse[-1] @ shares.pulls.sum(axis=0))
    return skew_px, float(refinement.scale_px * np.sqrt(inverse[-1, -1]))


def _influence(
    observations: Observations, refinement: Refinement, cut_sigmas: float
) -> tuple[float, float, float]:
    """Return the sums of influence^2 and of influence times residual, px^2, and the mean slope.

    For the weight w(r) of a residual of length r the influence is w r, and its mean slope over
    the directions of the plane is w + r w' / 2. Under Gauss' law with standard deviation s the
    mean of influence times residual is 2 s^2 times the mean slope (Stein).
    """
    is_used = refinement.weights > 0
    lengths_px = np.hypot(*np.moveaxis(refinement.residuals_px, -1, 0)) / observations.sigmas
    squares = lengths_px[is_used] ** 2
    weights = refinement.weights[is_used]
    shares = squares / (cut_sigmas * refinement.scale_px) ** 2
    slopes = (1.0 - shares) * (1.0 - 3.0 * shares)
    pull = float((weights * squares).sum())
    return float((weights**2 * squares).sum()), pull, float(slopes.mean())


def _implied_moves(b: FloatArray, c: FloatArray, translations_m: FloatArray) -> FloatArray:
    """Return the (6, n) moves of the camera's frame that make up best for the parameters.

    A turn about the optical centre moves a board's origin, t, by w x t.
    """
    normal, mixed = np.zeros((6, 6)), np.zeros((6, b.shape[1]))
    for blocks, pose, (x, y, z) in zip(b, c, translations_m, strict=True):
        move = np.eye(6)
        move[3:, :3] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
        normal += move.T @ pose @ move
        mixed += move.T @ blocks.T
    return np.asarray(-np.linalg.solve(normal, mixed))
