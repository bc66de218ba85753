"""Alignment of two moments from a guess: pairs of features and point-to-plane distances together.

Source: thesis, section 5.2.1 (the joint error of RGBD-ICP); Newcombe et al., KinectFusion (2011)
for projective association. Distances are taken in inverse depth, in which a structured-light
sensor's noise is even, and features in pixels: each where its own error is even.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from adibas.alignment.features import Pairs
from adibas.alignment.projective_kernels import (
    BEFORE,
    FACED,
    KNOWN,
    SQUARES,
    USED,
    WEIGHTS,
    Goal,
    normal_equations,
    sum_steps,
)
from adibas.alignment.registration import twelve_coefficients
from adibas.alignment.sights import Sight
from adibas.alignment.views import View
from adibas.arrays import FloatArray, read_only
from adibas.geometry.distortion import undistort_pixels
from adibas.geometry.rigid import RigidTransform, rotation_from_vector

N_UNKNOWNS = 6
TUKEY_SDS = 4.685
"""95 % efficiency for normal errors (Huber 1981)."""
LEAST_ERROR_PER_M = 1e-5
"""Of depth in 1/z, whatever the fit says: 0.04 mm at 2 m."""
Equations = tuple[FloatArray, FloatArray]
"""Matrix and right side of a twist: a small turn (radians) and a shift (metres)."""
Also = Callable[[RigidTransform, int], tuple[Equations, int]]


@dataclass(frozen=True, slots=True)
class JointParams:
    """Settings; tuples are for the levels from the finest on.

    Attributes
    ----------
    strides_px : tuple of int
        Every so many pixels of a level take part.
    rounds : tuple of int
        Steps at a level.
    scales_per_m : tuple of float
        Errors in 1/z beyond this count nothing: 0.01 at the finest, five times the noise.
    pair_factors : tuple of float
        By how much errors of features may be larger than theirs at the end.
    least_step : float
        Steps at a level end where a turn (radians) and a shift (metres) are smaller: 2e-5.
    pixels_alike : float
        Pixels of the full image whose errors are as good as one: 63, the sensor's window of 9 x 7
        (Konolige & Mihelich 2011).
    step_sd : float
        Standard deviation, radians and metres, of one step beforehand: 0.05. It holds back where
        the surfaces tell nothing, such as along a wall.
    """

    strides_px: tuple[int, ...] = (4, 2, 1)
    rounds: tuple[int, ...] = (3, 3, 6)
    scales_per_m: tuple[float, ...] = (0.01, 0.03, 0.08)
    pair_factors: tuple[float, ...] = (1.0, 5.0, 20.0)
    least_step: float = 2e-5
    pixels_alike: float = 63.0
    step_sd: float = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class JointFit:
    """What the fit gives.

    Attributes
    ----------
    target_from_source : RigidTransform
    information : (6, 6) array
        Of a small turn (radians) and shift (metres) after the motion.
    rms_per_m : float
        Of the errors in 1/z that count.
    overlap : float
        Share of the source's pixels that lie on a surface of the target.
    before : float
        Of its pixels that face a surface of the target, the share that lies before it, where the
        target saw nothing.
    n_pairs, n_pairs_kept : int
        Features offered, and those that agree.
    """

    target_from_source: RigidTransform
    information: FloatArray
    rms_per_m: float
    overlap: float
    before: float
    n_pairs: int
    n_pairs_kept: int

    def __post_init__(self) -> None:
        read_only(self.information)


def fit_joint(
    target: Sight,
    source: Sight,
    guess: RigidTransform,
    pairs: Pairs | None = None,
    params: JointParams | None = None,
) -> JointFit | None:
    """Improve a guess of where the source lies; None where hardly anything fits.

    Parameters
    ----------
    guess : RigidTransform
        Target from source.
    pairs : Pairs or None
        Features; None: by the surfaces alone.
    """
    params = params or JointParams()
    if pairs is None or not len(pairs.pixels):
        return fit_views(target.view, source.view, guess, params)
    offered = pairs

    def of_pairs(motion: RigidTransform, number: int) -> tuple[Equations, int]:
        limit_px = TUKEY_SDS * offered.sd_px * params.pair_factors[number]
        return pair_equations(target, offered, motion, limit_px)

    fit = fit_views(target.view, source.view, guess, params, of_pairs)
    return None if fit is None else replace(fit, n_pairs=len(pairs.pixels))


def fit_views(
    target: View,
    source: View,
    guess: RigidTransform,
    params: JointParams,
    also: Also | None = None,
) -> JointFit | None:
    """Improve a guess by the surfaces and what else is known; None where hardly anything fits.

    Parameters
    ----------
    guess : RigidTransform
        Target from source.
    also : callable or None
        Gives, for a motion and the number of a level, further normal equations of a twist, and how
        many observations agree with the motion.
    """
    fit = None
    motion = guess
    for number in reversed(range(len(target.levels))):
        for _ in range(params.rounds[number]):
            stepped = _step(target, source, motion, number, params, also)
            if stepped is None:
                return None
            step, fit = stepped
            motion = fit.target_from_source
            if np.abs(step).max() < params.least_step:
                break
    return fit


def look_through(
    target: Sight, source: Sight, motion: RigidTransform, params: JointParams | None = None
) -> tuple[float, float]:
    """Return `JointFit.overlap` and `JointFit.before` of a motion, target from source, as it is."""
    sums = _dense_sums(target.view, source.view, motion, 0, params or JointParams())
    return _shares(sums.sum(axis=0))


def _shares(total: FloatArray) -> tuple[float, float]:
    """Return overlap and what lies before, of summed counts; 0 of nothing."""
    overlap = total[USED] / max(total[KNOWN], 1.0)
    return float(overlap), float(total[BEFORE] / max(total[FACED], 1.0))


def moved(motion: RigidTransform, twist: FloatArray) -> RigidTransform:
    """Return the motion with a small turn (first three) and a shift after it.

    Its rotation is one to the last digit: where each frame's guess comes from the two before,
    rounding would double with every frame. Source: Higham (1986), one step of Newton's iteration.
    """
    turn = rotation_from_vector(twist[:3])
    rotation = turn @ motion.rotation
    rotation = rotation @ (1.5 * np.eye(3) - 0.5 * rotation.T @ rotation)
    return RigidTransform(rotation, turn @ motion.translation_m + twist[3:])


def cross_matrices(points: FloatArray) -> FloatArray:
    """Return (N, 3, 3): their product with a vector is the cross product of (N, 3) points."""
    crosses = np.zeros((len(points), 3, 3))
    x, y, z = points.T
    crosses[:, 0, 1], crosses[:, 0, 2], crosses[:, 1, 2] = -z, y, -x
    return crosses - crosses.transpose(0, 2, 1)


def _step(
    target: View,
    source: View,
    motion: RigidTransform,
    number: int,
    params: JointParams,
    also: Also | None,
) -> tuple[FloatArray, JointFit] | None:
    """Return one step and what holds after it."""
    sums = _dense_sums(target, source, motion, number, params)
    total = sums.sum(axis=0)
    if total[USED] < N_UNKNOWNS:
        return None
    matrix, right = normal_equations(sums)
    variance = max(total[SQUARES] / total[WEIGHTS], LEAST_ERROR_PER_M**2)
    pixel_px = source.levels[number].reduction * params.strides_px[number]
    alike = max(params.pixels_alike / pixel_px**2, 1.0)
    matrix, right = matrix / (variance * alike), right / (variance * alike)
    n_kept = 0
    if also is not None:
        (more, side), n_kept = also(motion, number)
        matrix, right = matrix + more, right + side
    step = np.linalg.solve(matrix + np.eye(N_UNKNOWNS) / params.step_sd**2, right)
    fit = JointFit(
        moved(motion, step), matrix, float(np.sqrt(variance)), *_shares(total), 0, n_kept
    )
    return step, fit


def _dense_sums(
    target: View, source: View, motion: RigidTransform, number: int, params: JointParams
) -> FloatArray:
    own = source.levels[number]
    return sum_steps(
        own.inverse_per_m,
        own.rays,
        params.strides_px[number],
        goal_of(target, number),
        np.hstack([motion.rotation, motion.translation_m[:, None]]),
        params.scales_per_m[number],
    )


def goal_of(view: View, number: int) -> Goal:
    """Return what a level of a view offers to kernels."""
    level, camera = view.levels[number], view.camera
    lens = camera.intrinsics
    return Goal(
        level.planes,
        level.cell_px,
        (lens.fx, lens.fy, lens.cx, lens.cy),
        twelve_coefficients(camera),
        any(camera.distortion),
    )


def pair_equations(
    target: Sight, pairs: Pairs, motion: RigidTransform, limit_px: float
) -> tuple[Equations, int]:
    """Return the normal equations of a twist by features, and how many of these agree.

    Parameters
    ----------
    limit_px : float
        Pairs that miss by more count nothing (Tukey's weights up to there).
    """
    camera = target.color_camera
    seen = undistort_pixels(pairs.pixels, camera.intrinsics, camera.distortion)
    turn = target.calibration.color_from_depth
    points = motion.apply(pairs.source_m)
    x, y, z = turn.apply(points).T
    focal = np.array([camera.intrinsics.fx, camera.intrinsics.fy])
    errors = (np.column_stack([x / z, y / z]) - seen) * focal
    share = np.minimum(np.linalg.norm(errors, axis=1) / limit_px, 1.0)
    weights = np.where(z > 0, (1.0 - share**2) ** 2, 0.0) / pairs.sd_px**2
    by_point = np.zeros((len(x), 2, 3))
    by_point[:, 0, 0], by_point[:, 1, 1] = focal[0] / z, focal[1] / z
    by_point[:, 0, 2], by_point[:, 1, 2] = -focal[0] * x / z**2, -focal[1] * y / z**2
    by_point = by_point @ turn.rotation
    gradient = np.concatenate([-by_point @ cross_matrices(points), by_point], axis=2)
    matrix = np.einsum("n,nki,nkj->ij", weights, gradient, gradient)
    right = -np.einsum("n,nki,nk->i", weights, gradient, errors)
    return (matrix, right), int((weights > 0).sum())
