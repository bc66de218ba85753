"""Descent to pose, depth bias and planes of all shots.

The colour camera may be wrong by its covariance, and then all boards are wrong together: its error
is sought along with the rest, in units in which it is likely (`color_units`). Taken for exact, it
is amplified: where boards hardly tell the shift along z from the offset of the depth, a wrong focal
length looks like either.

Source: Madsen, Nielsen & Tingleff, Methods for non-linear least squares problems (2004), section
3.2, for the damping; Huber, Robust statistics (1981), for scale and weights.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.calibration.extrinsics_model import (
    N_CAMERA,
    N_EXTRINSIC,
    DepthState,
    Prior,
    Rows,
    bias_numbers,
    board_rows,
    camera_numbers,
    corrected_inverse,
    plane_priors,
    wall_rows,
    with_terms,
)
from adibas.calibration.extrinsics_start import start_extrinsics
from adibas.calibration.shots import (
    MAD_TO_SD,
    N_PLANE,
    BoardShot,
    Cells,
    InversePlane,
    WallShot,
    fit_inverse_plane,
    plane_of,
    total_squares,
)
from adibas.data.calibration import CameraCalibration, DepthBias
from adibas.geometry.projection import CAMERA_PARAMETERS
from adibas.geometry.rigid import IDENTITY, RigidTransform

N_LINEAR_TERMS = 2
LEAST_VARIANCE = 1e-12
LEAST_DAMPING = 1e-9
LARGEST_DAMPING = 1e6


@dataclass(frozen=True, slots=True)
class DepthFitParams:
    """How pose and depth bias are sought.

    Attributes
    ----------
    n_image_terms : int
        Of `DepthBias.image_term`: 5, a parabola (Herrera et al. 2012 show smooth maps).
    shift_sd_m : float or None
        How well the shift of the start is known, for each axis; None: not at all. The maker's
        value holds within a millimetre or two.
    offset_sd_m, factor_sd, square_sd_per_m : float
        How large `a`, `b - 1` and `c` may be: 0.03, 0.03, 0.01; devices err by 1-3 cm at 2-3 m
        (Boehm 2014).
    image_sd_per_m : float
        How large the image terms may be: 0.02, 2 cm at 2 m at the middle of the border.
    focal_sd, centre_sd_px : float
        How wrong focal lengths (as a share) and principal point of the depth camera may be; 0 of
        either: it is known. Makers give one value for all devices: 0.01 and 6 pixels.
    cut_sigmas : float
        Cells farther off have no weight (biweight): 5.
    largest_distance : float
        Boards whose depth is farther from the colour camera's plane, in squared standard
        deviations, are left out: 25 (chance 2e-5), but see `outlier_factor`.
    outlier_factor : float
        And farther than so many times what the other boards show: 6.
    least_left : float
        Of the weight of a board's cells, below which it is left out, too: 0.5.
    most_steps : int
        Of the descent: 40.
    done : float
        Step, in standard deviations, at which it ends: 1e-3.
    """

    n_image_terms: int = 5
    shift_sd_m: float | None = None
    offset_sd_m: float = 0.03
    factor_sd: float = 0.03
    square_sd_per_m: float = 0.01
    image_sd_per_m: float = 0.02
    focal_sd: float = 0.0
    centre_sd_px: float = 0.0
    cut_sigmas: float = 5.0
    largest_distance: float = 25.0
    outlier_factor: float = 6.0
    least_left: float = 0.5
    most_steps: int = 40
    done: float = 1e-3


@dataclass(frozen=True, slots=True)
class DepthStart:
    """What is known of a depth camera before its calibration.

    Attributes
    ----------
    camera : CameraCalibration
        Its lens stays as it is.
    bias : DepthBias
        An earlier one, or none.
    color_covariance : (17, 17) array or None
        Of the colour camera's `CAMERA_PARAMETERS`; None: it is exact.
    """

    camera: CameraCalibration
    bias: DepthBias = field(default_factory=DepthBias)
    color_covariance: FloatArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Everything that is seen, and what is known beforehand."""

    cells: tuple[Cells, ...]
    planes: tuple[InversePlane, ...]
    priors: tuple[Prior, ...]
    """Of the boards; the shots after them are walls."""
    corner_variance: float
    start: RigidTransform
    depth: DepthStart
    information: FloatArray
    """Of the globals, beforehand, (n,); the last are the colour camera's error."""
    free: IntArray
    params: DepthFitParams

    @property
    def n_global(self) -> int:
        """How many unknowns all shots share."""
        return len(self.information)

    @property
    def n_kept(self) -> int:
        """How many of them are told in the end: all but the colour camera's error."""
        return N_EXTRINSIC + 3 + self.params.n_image_terms + N_CAMERA

    def rows(self, index: int, state: DepthState) -> Rows:
        """Return residuals and derivatives of one shot."""
        make = board_rows if index < len(self.planes) else wall_rows
        return make(self.cells[index], state.planes[index], state)


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """Of the cells, by the scatter of all."""

    sigma_per_m: float
    of_cells: tuple[FloatArray, ...]
    """Share of each cell times what the robust loss leaves of it."""


def pose_problem(
    boards: Sequence[BoardShot],
    walls: Sequence[WallShot],
    start: RigidTransform | None,
    depth: DepthStart,
    params: DepthFitParams,
) -> Problem:
    """Gather what is seen and known; see `adibas.calibration.extrinsics.fit_depth`."""
    planes = tuple(plane_of(shot.pose) for shot in boards)
    corner_variance = total_squares(boards) if boards else 1.0
    corner_variance = max(corner_variance, LEAST_VARIANCE)
    n_known = N_EXTRINSIC + 3 + params.n_image_terms
    units = color_units(depth.color_covariance)
    information = np.zeros(n_known + N_CAMERA + units.shape[1])
    information[n_known + N_CAMERA :] = 1.0
    if start is not None and params.shift_sd_m is not None:
        information[3:N_EXTRINSIC] = params.shift_sd_m**-2
    sds = (params.offset_sd_m, params.factor_sd, params.square_sd_per_m)
    information[N_EXTRINSIC : N_EXTRINSIC + 3] = 1.0 / np.square(sds)
    information[N_EXTRINSIC + 3 : n_known] = params.image_sd_per_m**-2
    first = 0 if boards else N_EXTRINSIC + 3 + N_LINEAR_TERMS
    free = np.arange(first, n_known)
    k = depth.camera.intrinsics
    sizes = np.array([params.focal_sd * k.fx, params.focal_sd * k.fy, *[params.centre_sd_px] * 2])
    is_open = np.flatnonzero(sizes > 0)
    information[n_known + is_open] = sizes[is_open] ** -2
    if boards:
        color_error = np.arange(n_known + N_CAMERA, len(information))
        free = np.concatenate([free, n_known + is_open, color_error])
    return Problem(
        cells=(*(shot.cells for shot in boards), *(shot.cells for shot in walls)),
        planes=planes,
        priors=tuple(plane_priors(planes, corner_variance, units)),
        corner_variance=corner_variance,
        start=start or IDENTITY,
        depth=depth,
        information=information,
        free=free,
        params=params,
    )


def start_state(problem: Problem, start: RigidTransform | None) -> DepthState:
    """Return the first guess."""
    start_bias = (problem.depth.bias, problem.depth.camera)
    seen = np.array(
        [
            fit_inverse_plane(cells.rays, corrected_inverse(cells, *start_bias), cells.shares)
            for cells in problem.cells
        ]
    )
    n_boards = len(problem.planes)
    known = np.array([plane.m for plane in problem.planes]).reshape(-1, 3)
    if start is None:
        start = start_extrinsics(known, seen[:n_boards]) or problem.start
    no_error = np.zeros(problem.n_global - problem.n_kept)
    return DepthState(start, *start_bias, np.concatenate([known, seen[n_boards:]]), no_error)


def color_units(covariance: FloatArray | None) -> FloatArray:
    """Return (17, n) errors of the colour camera, independent and of standard deviation 1."""
    if covariance is None:
        return np.zeros((len(CAMERA_PARAMETERS), 0))
    scale = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    by_scale = np.where(scale > 0, 1.0 / np.where(scale > 0, scale, 1.0), 0.0)
    variances, axes = np.linalg.eigh(covariance * np.outer(by_scale, by_scale))
    is_open = variances > LEAST_VARIANCE
    return np.asarray(scale[:, None] * axes[:, is_open] * np.sqrt(variances[is_open]))


def _prior_slope(problem: Problem, state: DepthState) -> FloatArray:
    """Return how far the (n,) globals are from what is known beforehand.

    The bias is thought to be none, not the one of an earlier calibration.
    """
    none = with_terms(DepthBias(), problem.params.n_image_terms)
    away = np.zeros(problem.n_global)
    away[3:N_EXTRINSIC] = state.color_from_depth.translation_m - problem.start.translation_m
    n_known = problem.n_kept - N_CAMERA
    away[N_EXTRINSIC:n_known] = bias_numbers(state.bias) - bias_numbers(none)
    away[n_known : problem.n_kept] = camera_numbers(state.camera) - camera_numbers(
        problem.depth.camera
    )
    away[problem.n_kept :] = state.color_error
    return problem.information * away


def _weighted(problem: Problem, state: DepthState, *, is_hard: bool) -> Weights:
    """Return the weights by the scatter of all cells.

    Biweight, to find the way; in the end all or nothing, so that the scatter is that of squares.
    """
    scaled = []
    for index, cells in enumerate(problem.cells):
        residuals = problem.rows(index, state).residuals
        scaled.append(residuals * np.sqrt(cells.shares))
    lengths = np.abs(np.concatenate(scaled))
    n_planes = N_PLANE * len(problem.cells)
    # Each plane takes three degrees of freedom from its own cells.
    freed = np.sqrt(lengths.size / max(lengths.size - n_planes, 1))
    sigma = max(MAD_TO_SD * float(np.median(lengths)) * freed, LEAST_VARIANCE)
    limit = problem.params.cut_sigmas * sigma
    left = [np.maximum(1.0 - (part / limit) ** 2, 0.0) for part in scaled]
    kept = [np.where(part > 0, 1.0, 0.0) if is_hard else part**2 for part in left]
    of_cells = zip(problem.cells, kept, strict=True)
    return Weights(sigma, tuple(cells.shares * part for cells, part in of_cells))


def normal_equations(
    problem: Problem, state: DepthState, weights: Weights
) -> tuple[FloatArray, FloatArray]:
    """Return the (N, N) normal matrix of all unknowns and the (N,) downhill slope."""
    n_global, n_kept = problem.n_global, problem.n_kept
    n = n_global + N_PLANE * len(problem.cells)
    normal, slope = np.zeros((n, n)), np.zeros(n)
    normal[:n_global, :n_global] = np.diag(problem.information)
    slope[:n_global] = -_prior_slope(problem, state)
    for index, of_cells in enumerate(weights.of_cells):
        rows = problem.rows(index, state)
        own = slice(n_global + N_PLANE * index, n_global + N_PLANE * (index + 1))
        share = (of_cells / weights.sigma_per_m**2)[:, None]
        normal[:n_kept, :n_kept] += rows.by_global.T @ (share * rows.by_global)
        normal[own, own] += rows.by_plane.T @ (share * rows.by_plane)
        normal[:n_kept, own] = rows.by_global.T @ (share * rows.by_plane)
        normal[own, :n_kept] = normal[:n_kept, own].T
        slope[:n_kept] -= rows.by_global.T @ (share[:, 0] * rows.residuals)
        slope[own] -= rows.by_plane.T @ (share[:, 0] * rows.residuals)
        if index < len(problem.priors):
            by_prior, pull = prior_slopes(problem, index), problem.priors[index].information
            normal += by_prior.T @ pull @ by_prior
            slope -= by_prior.T @ pull @ _from_prior(problem, state, index)
    return normal, slope


def prior_slopes(problem: Problem, index: int) -> FloatArray:
    """Return the (3, N) derivatives of `_from_prior` by all unknowns."""
    slopes = np.zeros((N_PLANE, problem.n_global + N_PLANE * len(problem.cells)))
    slopes[:, problem.n_kept : problem.n_global] = -problem.priors[index].by_color
    first = problem.n_global + N_PLANE * index
    slopes[:, first : first + N_PLANE] = np.eye(N_PLANE)
    return slopes


def _from_prior(problem: Problem, state: DepthState, index: int) -> FloatArray:
    """Return how far a board's (3,) plane is from what the colour camera says."""
    prior = problem.priors[index]
    return np.asarray(state.planes[index] - prior.mean - prior.by_color @ state.color_error)


def _distances(problem: Problem, state: DepthState) -> FloatArray:
    """Return how far each board's plane is from the colour camera's, squared, in deviations."""
    apart = [_from_prior(problem, state, index) for index in range(len(problem.priors))]
    return np.array(
        [m @ prior.information @ m for m, prior in zip(apart, problem.priors, strict=True)]
    )


def _loss(problem: Problem, state: DepthState, weights: Weights) -> float:
    """Return the weighted squares of everything, in standard deviations."""
    slope = _prior_slope(problem, state)
    known = problem.information > 0
    total = float((slope[known] ** 2 / problem.information[known]).sum())
    for index, of_cells in enumerate(weights.of_cells):
        residuals = problem.rows(index, state).residuals
        total += float((of_cells * residuals**2).sum()) / weights.sigma_per_m**2
    return total + float(_distances(problem, state).sum())


def unknowns_of(problem: Problem) -> IntArray:
    """Return which of all unknowns are sought."""
    planes = np.arange(problem.n_global, problem.n_global + N_PLANE * len(problem.cells))
    return np.concatenate([problem.free, planes])


def settled(problem: Problem, state: DepthState) -> tuple[DepthState, Weights]:
    """Descend with robust weights, then with squares of what they left."""
    for _ in range(problem.params.most_steps):
        weights = _weighted(problem, state, is_hard=False)
        state, is_done = _descended(problem, state, weights)
        if is_done:
            break
    weights = _weighted(problem, state, is_hard=True)
    for _ in range(problem.params.most_steps):
        state, is_done = _descended(problem, state, weights)
        if is_done:
            break
    return state, weights


def _descended(problem: Problem, state: DepthState, weights: Weights) -> tuple[DepthState, bool]:
    """Take one step by Levenberg and Marquardt, and say whether it was worth it."""
    unknowns = unknowns_of(problem)
    normal, slope = normal_equations(problem, state, weights)
    before = _loss(problem, state, weights)
    step, sizes = np.zeros(len(slope)), np.zeros(len(slope))
    damping = LEAST_DAMPING
    while damping < LARGEST_DAMPING:
        step[unknowns], sizes[unknowns] = _step(normal, slope, unknowns, damping)
        tried = state.moved(step)
        if _loss(problem, tried, weights) <= before:
            return tried, bool((np.abs(step) <= problem.params.done * sizes).all())
        damping *= 10.0
    return state, True


def _step(
    normal: FloatArray, slope: FloatArray, unknowns: IntArray, damping: float
) -> tuple[FloatArray, FloatArray]:
    """Return the step of the unknowns and their standard deviations by the normal matrix."""
    part = normal[np.ix_(unknowns, unknowns)]
    scale = 1.0 / np.sqrt(np.diag(part))
    scaled = part * np.outer(scale, scale)
    inverse = np.linalg.pinv(scaled + damping * np.eye(len(scaled)), hermitian=True)
    return scale * (inverse @ (scale * slope[unknowns])), scale * np.sqrt(
        np.maximum(np.diag(inverse), 0.0)
    )


def suspects_of(problem: Problem, state: DepthState, weights: Weights) -> BoolArray:
    """Say which boards the others contradict: in their place, or in what the depth camera saw."""
    distances = _distances(problem, state)
    if not distances.size:
        return np.zeros(0, bool)
    usual = max(1.0, float(np.median(distances)) / N_PLANE)
    limit = max(problem.params.largest_distance, problem.params.outlier_factor * N_PLANE * usual)
    boards = zip(weights.of_cells, problem.cells, problem.planes, strict=False)
    left = np.array([part.sum() / cells.shares.sum() for part, cells, _ in boards])
    suspects: BoolArray = (distances > limit) | (left < problem.params.least_left)
    # Where half of the boards contradict the other half, nobody knows which are wrong.
    return suspects if suspects.mean() < 1 / 3 else np.zeros(len(distances), bool)
