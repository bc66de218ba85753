"""Where a board stood before a camera whose lens is known, and how sure that is.

A pose is moved by a small turn about the camera's axes through the board's origin and a shift.

Source: Zhang, PAMI 22 (2000), section 3.1, for the start; Schweighofer & Pinz, Robust pose
estimation from a planar target, PAMI 28 (2006), for the second pose that a small plane allows.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, check_shape, read_only
from adibas.calibration.closed_form import pose_from_homography
from adibas.calibration.homography import fit_homography
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import undistort_pixels
from adibas.geometry.projection import camera_numbers, project_with_slopes
from adibas.geometry.rigid import RigidTransform, rotation_from_vector

N_POSE = 6
LEAST_CORNERS = 6
MOST_STEPS = 30
DONE = 1e-9


@dataclass(frozen=True, slots=True)
class PoseParams:
    """How a pose is sought.

    Attributes
    ----------
    least_gain : float
        By how much the second pose of a plane must fit worse, in the sum of squared standard
        deviations: 20. Else the image does not tell which of the two it shows.
    same_rad : float
        Normals nearer than this are one pose: 2 degrees.
    cut_sigmas : float
        Corners farther off take no part: 6.
    """

    least_gain: float = 20.0
    same_rad: float = 0.035
    cut_sigmas: float = 6.0


@dataclass(frozen=True, slots=True, eq=False)
class BoardPose:
    """Where a board stood.

    Attributes
    ----------
    camera_from_board : RigidTransform
        Best estimate.
    covariance : (6, 6) array
        Of turn (radians) and shift (metres), by the noise of the corners alone.
    by_camera : (6, 17) array
        How turn and shift go with `adibas.geometry.projection.CAMERA_PARAMETERS`.
    squares : float
        Sum of the squared residuals in standard deviations.
    n_degrees : int
        Degrees of freedom of `squares`.
    """

    camera_from_board: RigidTransform
    covariance: FloatArray
    by_camera: FloatArray
    squares: float
    n_degrees: int

    def __post_init__(self) -> None:
        check_shape("covariance", self.covariance, (N_POSE, N_POSE))
        check_shape("by_camera", self.by_camera, (N_POSE, None))
        read_only(self.covariance)
        read_only(self.by_camera)


def find_pose(
    corners: BoardCorners,
    board: Board,
    camera: CameraCalibration,
    params: PoseParams | None = None,
) -> BoardPose | None:
    """Return where the board stood.

    Parameters
    ----------
    corners : BoardCorners
        In the image as taken; `sigma_px` up to a common factor.
    board : Board
        Whose corners they are.
    camera : CameraCalibration
        Known; `BoardPose.by_camera` says what its error does.

    Returns
    -------
    pose : BoardPose or None
        None for fewer than six corners, corners on a line, or an image that two poses fit.
    """
    params = params or PoseParams()
    problem = _problem(corners, board, camera)
    if problem is None:
        return None
    start = _start(problem, camera)
    if start is None:
        return None
    best = _settled(problem, start)
    other = _settled(problem, _mirrored(best, problem.points_m.mean(axis=0)))
    if other.squares < best.squares:
        best, other = other, best
    turn = np.arccos(np.clip(best.rotation[:, 2] @ other.rotation[:, 2], -1.0, 1.0))
    if turn > params.same_rad and other.squares - best.squares < params.least_gain:
        return None
    kept = best.lengths < params.cut_sigmas * max(1.0, float(np.sqrt(np.median(best.lengths**2))))
    if not kept.all():
        if kept.sum() < LEAST_CORNERS:
            return None
        problem = problem.only(kept)
        best = _settled(problem, best)
    return _with_covariance(problem, best)


@dataclass(frozen=True, slots=True, eq=False)
class _Problem:
    points_m: FloatArray
    pixels: FloatArray
    sigmas: FloatArray
    camera: FloatArray

    def only(self, kept: BoolArray) -> "_Problem":
        return _Problem(self.points_m[kept], self.pixels[kept], self.sigmas[kept], self.camera)


@dataclass(frozen=True, slots=True, eq=False)
class _Try:
    rotation: FloatArray
    translation_m: FloatArray
    squares: float
    lengths: FloatArray
    normal: FloatArray
    slope: FloatArray


def _problem(corners: BoardCorners, board: Board, camera: CameraCalibration) -> _Problem | None:
    is_seen = np.isfinite(corners.sigma_px)
    if is_seen.sum() < LEAST_CORNERS:
        return None
    return _Problem(
        board.points_m()[is_seen],
        corners.pixels[is_seen],
        corners.sigma_px[is_seen],
        camera_numbers(camera.intrinsics, camera.distortion),
    )


def _start(problem: _Problem, camera: CameraCalibration) -> "_Try | None":
    ideal = undistort_pixels(problem.pixels, camera.intrinsics, camera.distortion)
    homography = fit_homography(problem.points_m[:, :2], ideal)
    if homography is None:
        return None
    pose = pose_from_homography(homography, np.eye(3))
    return _tried(problem, pose.rotation, pose.translation_m)


def _mirrored(pose: _Try, centre_m: FloatArray) -> _Try:
    """Return the pose whose normal is mirrored at the line of sight to the board's centre."""
    seen_m = pose.rotation @ centre_m + pose.translation_m
    sight = seen_m / np.linalg.norm(seen_m)
    half_turn = 2.0 * np.outer(sight, sight) - np.eye(3)
    # A half turn about the line of sight, and one in the board's plane that undoes it there.
    rotation = half_turn @ pose.rotation @ np.diag([-1.0, -1.0, 1.0])
    return _Try(
        rotation, seen_m - rotation @ centre_m, np.inf, pose.lengths, pose.normal, pose.slope
    )


def _tried(problem: _Problem, rotation: FloatArray, translation_m: FloatArray) -> _Try:
    turned_m = problem.points_m @ rotation.T
    slopes = project_with_slopes(turned_m + translation_m, problem.camera)
    residuals = (problem.pixels - slopes.pixels) / problem.sigmas[:, None]
    by_pose = _by_pose(turned_m, slopes.by_point) / problem.sigmas[:, None, None]
    squares = float((residuals**2).sum())
    return _Try(
        rotation,
        translation_m,
        squares if np.isfinite(squares) else np.inf,
        np.hypot(*residuals.T),
        np.einsum("nai,naj->ij", by_pose, by_pose),
        np.einsum("nai,na->i", by_pose, residuals),
    )


def _by_pose(turned_m: FloatArray, by_point: FloatArray) -> FloatArray:
    """Return the (N, 2, 6) derivatives by turn and shift of (N, 3) points about the origin."""
    # by_point . (w x p) = w . (p x by_point)
    by_turn = np.cross(turned_m[:, None, :], by_point)
    return np.concatenate([by_turn, by_point], axis=-1)


def _settled(problem: _Problem, start: _Try) -> _Try:
    """Descend by Levenberg and Marquardt."""
    best = _tried(problem, start.rotation, start.translation_m)
    damping = 1e-4
    for _ in range(MOST_STEPS):
        damped = best.normal + damping * np.diag(np.diag(best.normal))
        step = np.asarray(np.linalg.lstsq(damped, best.slope)[0], float)
        tried = _tried(
            problem,
            rotation_from_vector(step[:3]) @ best.rotation,
            best.translation_m + step[3:],
        )
        gain = best.squares - tried.squares
        if gain >= 0:
            is_done = gain <= DONE * (1.0 + best.squares)
            best, damping = tried, damping * 0.1
            if is_done:
                break
        else:
            damping *= 10.0
            if damping > 1.0 / DONE:
                break
    return best


def _with_covariance(problem: _Problem, found: _Try) -> BoardPose | None:
    turned_m = problem.points_m @ found.rotation.T
    slopes = project_with_slopes(turned_m + found.translation_m, problem.camera)
    weights = 1.0 / problem.sigmas**2
    by_pose = _by_pose(turned_m, slopes.by_point)
    mixed = np.einsum("nai,naj,n->ij", by_pose, slopes.by_camera, weights)
    try:
        covariance: FloatArray = np.asarray(np.linalg.inv(found.normal), float)
    except np.linalg.LinAlgError:
        return None
    if not (np.isfinite(covariance).all() and np.isfinite(found.squares)):
        return None
    left, _, right = np.linalg.svd(found.rotation)
    return BoardPose(
        RigidTransform(left @ right, found.translation_m),
        covariance,
        -covariance @ mixed,
        found.squares,
        2 * len(problem.points_m) - N_POSE,
    )
