"""The lens model with the fewest terms that the images support.

Models are judged by leaving out one view after the other: how well does the camera that the
others give explain it, its own pose fitted? Corners of one view share errors (a board that is not
flat, a finder that leans one way), so that criteria that count corners take many terms for
granted; views are nearly independent. Of all models whose loss is within two standard errors of
the best one's the one with the fewest terms is taken.

Source: Breiman et al., Classification and regression trees (1984), section 3.4.3 (there
one standard error, here two of the views' differences); Schwarz, Annals of Statistics 6 (1978),
for the criterion that is given beside it.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration import refinement_kernels as kernels
from adibas.calibration.lens_models import CANDIDATES, LensModel
from adibas.calibration.refinement import (
    Estimate,
    Loss,
    Observations,
    Refinement,
    RefinementParams,
    accumulated,
    empty_arrow,
    refine,
)
from adibas.calibration.view_shares import left_out_losses, view_shares
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import FoldWarning, undistort_pixels
from adibas.geometry.pinhole import Intrinsics

N_BORDER = 33
STANDARD_ERRORS = 2.0
LEAST_VARIANCE_PX2 = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One lens model, fitted by least squares.

    Attributes
    ----------
    model : LensModel
        Its terms.
    estimate : Estimate
        Camera and poses.
    rms_px : float
        Over points.
    left_out_px2 : (V,) array
        Mean squared error of each view under the camera that the others give, px^2.
    bic : float
        Bayesian information criterion over corners.
    """

    model: LensModel
    estimate: Estimate
    rms_px: float
    left_out_px2: FloatArray
    bic: float


def fit_models(
    observations: Observations, start: Estimate, models: Sequence[LensModel] = CANDIDATES
) -> tuple[Candidate, ...]:
    """Fit every model to the same corners, in the order of `models`.

    Those that do not converge or are not fixed by the views are missing.

    Parameters
    ----------
    observations : Observations
        Without outliers: their loss would choose.
    start : Estimate
        Near the answer.
    models : sequence of LensModel
        Each starts where the one before ended, without the terms that it does not have.
    """
    params = RefinementParams(loss=Loss.SQUARES)
    found = []
    estimate = start
    for model in models:
        refined = refine(observations, _only(estimate, model), model, params)
        if not refined.has_converged:
            continue
        estimate = refined.estimate
        candidate = _candidate(observations, refined, model)
        if candidate is not None:
            found.append(candidate)
    return tuple(found)


def choose(candidates: Sequence[Candidate], size: tuple[int, int]) -> Candidate | None:
    """Return the candidate with the fewest terms that the views support.

    Parameters
    ----------
    candidates : sequence of Candidate
        The ones with fewer terms first.
    size : (height, width)
        Of the images; the lens must be one-to-one all over them.

    Returns
    -------
    candidate : Candidate or None
        None where no lens is.
    """
    sound = [one for one in candidates if covers(one.estimate.camera, size)]
    if not sound:
        return None
    best = min(sound, key=lambda one: float(one.left_out_px2.mean()))
    return next(one for one in sound if _is_as_good(one.left_out_px2, best.left_out_px2))


def _is_as_good(losses: FloatArray, best: FloatArray) -> bool:
    differences = losses - best
    if not np.isfinite(differences).all():
        return False
    error = differences.std(ddof=1) / math.sqrt(len(differences)) if len(differences) > 1 else 0.0
    return bool(differences.mean() <= STANDARD_ERRORS * error)


def _candidate(
    observations: Observations, refined: Refinement, model: LensModel
) -> Candidate | None:
    free = model.free()
    arrow = empty_arrow(len(free), len(observations.pixels))
    plain = (kernels.PLAIN, np.inf)
    accumulated(observations, observations.sigmas, refined.estimate, free, plain, arrow)
    shares = view_shares(arrow)
    if shares is None:
        return None
    squares = (refined.residuals_px / observations.sigmas[..., None]) ** 2
    losses = np.nansum(squares, axis=(1, 2))
    n = 2 * observations.n_seen
    variance = max(float(losses.sum()) / n, LEAST_VARIANCE_PX2)
    return Candidate(
        model,
        refined.estimate,
        math.sqrt(2.0 * variance),
        left_out_losses(shares, losses) / np.isfinite(observations.sigmas).sum(axis=1),
        n * math.log(variance) + len(model.parameters) * math.log(n),
    )


def covers(camera: FloatArray, size: tuple[int, int]) -> bool:
    """Say whether a (17,) camera gives every pixel of an image of (height, width) a direction."""
    if not (camera[:2] > 0).all():
        return False
    height, width = size
    share = np.linspace(0.0, 1.0, N_BORDER)
    u, v = -0.5 + share * width, -0.5 + share * height
    border = np.concatenate(
        [np.stack([u, np.full(N_BORDER, edge)], axis=-1) for edge in (-0.5, height - 0.5)]
        + [np.stack([np.full(N_BORDER, edge), v], axis=-1) for edge in (-0.5, width - 0.5)]
    )
    intrinsics = Intrinsics(*(float(value) for value in camera[:4]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FoldWarning)
        return bool(np.isfinite(undistort_pixels(border, intrinsics, camera[5:].tolist())).all())


def calibrated_camera(
    camera: FloatArray, model: LensModel, size: tuple[int, int]
) -> CameraCalibration:
    """Return the (17,) camera without its skew, as a calibration holds it."""
    height, width = size
    return CameraCalibration(
        width,
        height,
        Intrinsics(*(float(value) for value in camera[:4])),
        tuple(camera[5 : 5 + model.n_stored].tolist()),
    )


def _only(estimate: Estimate, model: LensModel) -> Estimate:
    """Return the estimate without the terms that `model` does not have."""
    camera = np.zeros_like(estimate.camera)
    free = model.free()
    camera[free] = estimate.camera[free]
    return Estimate(camera, estimate.rotations, estimate.translations_m)
