"""How good a calibration is: where its corners lie, how the boards leaned, what error is left.

Source: thesis, section 8.1.3: the table of pixel, real place, computed place and error, and Q_k
(equation 8.1). There the pose of the board comes from the same corners that are judged; here it
comes from every other corner, and the rest are judged.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray, read_only
from adibas.calibration.refinement import Estimate, observe, refine_poses
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.data.camera_fit import CameraFit, ViewFit
from adibas.geometry.distortion import undistort_pixels
from adibas.geometry.projection import camera_numbers
from adibas.geometry.rigid import RigidTransform

CELLS = (6, 8)
"""Rows and columns that the image is divided into."""

LEAST_CORNERS = 6
"""For a pose that says something."""


@dataclass(frozen=True, slots=True, eq=False)
class ResidualMap:
    """What is left of the corners, cell by cell of the image.

    Attributes
    ----------
    counts : (R, C) array
        Corners that took part.
    means_px : (R, C, 2) array
        Mean residual; far from 0, the lens model lacks a term there. NaN in empty cells.
    rms_px : (R, C) array
        Over points; NaN in empty cells.
    """

    counts: IntArray
    means_px: FloatArray
    rms_px: FloatArray

    def __post_init__(self) -> None:
        for array in (self.counts, self.means_px, self.rms_px):
            read_only(array)

    @property
    def covered_share(self) -> float:
        """Share of the cells that have a corner."""
        return float((self.counts > 0).mean())


@dataclass(frozen=True, slots=True)
class CornerRow:
    """One line of the thesis' table: a corner that had no part in the board's pose.

    Attributes
    ----------
    image : str
        Where it is seen.
    u_px, v_px : float
        Pixel.
    x_m, y_m : float
        Real place on the board.
    computed_x_m, computed_y_m : float
        Where the pixel's ray meets the board.
    """

    image: str
    u_px: float
    v_px: float
    x_m: float
    y_m: float
    computed_x_m: float
    computed_y_m: float

    @property
    def error_m(self) -> tuple[float, float]:
        """Real minus computed, as the thesis counts."""
        return self.x_m - self.computed_x_m, self.y_m - self.computed_y_m


@dataclass(frozen=True, slots=True)
class BoardError:
    """Q_k of one image.

    Attributes
    ----------
    image : str
        Name.
    distance_m : float
        Of the board's middle from the camera.
    q_m : float
        Mean distance of real and computed places (equation 8.1).
    rows : tuple of CornerRow
        Those corners.
    """

    image: str
    distance_m: float
    q_m: float
    rows: tuple[CornerRow, ...]


def map_residuals(fit: CameraFit, cells: tuple[int, int] = CELLS) -> ResidualMap:
    """Return the residuals of the corners that took part, by (rows, columns) cells."""
    pixels = [view.pixels[view.is_used] for view in fit.used_views]
    residuals = [view.residuals_px[view.is_used] for view in fit.used_views]
    place = _cell(np.concatenate(pixels), fit.camera, cells)
    joined = np.concatenate(residuals)
    n = cells[0] * cells[1]
    counts = np.bincount(place, minlength=n)
    sums = [np.bincount(place, weights, n) for weights in (*joined.T, (joined**2).sum(axis=1))]
    with np.errstate(invalid="ignore"):
        means_px = np.stack(sums[:2], axis=-1) / counts[:, None]
        rms_px = np.sqrt(sums[2] / counts)
    return ResidualMap(counts.reshape(cells), means_px.reshape(*cells, 2), rms_px.reshape(cells))


def tilts_rad(fit: CameraFit) -> FloatArray:
    """Return the (V,) angles between each board's normal and the optical axis, 0 when frontal."""
    normals = np.array([view.camera_from_board.rotation[:, 2] for view in fit.used_views])
    return np.asarray(np.arccos(np.clip(np.abs(normals.reshape(-1, 3)[:, 2]), 0.0, 1.0)))


def tilt_directions_rad(fit: CameraFit) -> FloatArray:
    """Return the (V,) directions in the image, -pi to pi, to which each board leans away."""
    normals = np.array([view.camera_from_board.rotation[:, 2] for view in fit.used_views])
    return np.asarray(np.arctan2(normals.reshape(-1, 3)[:, 1], normals.reshape(-1, 3)[:, 0]))


def board_errors(fit: CameraFit) -> tuple[BoardError, ...]:
    """Return Q_k of every image that took part and shows corners enough for it."""
    found = [_board_error(view, fit) for view in fit.used_views]
    return tuple(error for error in found if error is not None)


def mean_board_error_m(errors: Sequence[BoardError]) -> float:
    """Return the mean of Q_k over images, as the thesis does; NaN without any."""
    return float(np.mean([error.q_m for error in errors])) if errors else float("nan")


def computed_on_board(
    pixels: FloatArray, camera: CameraCalibration, camera_from_board: RigidTransform
) -> FloatArray:
    """Return the (N, 2) places in metres where the rays of (N, 2) pixels meet the board."""
    rays = undistort_pixels(pixels, camera.intrinsics, camera.distortion)
    directions = np.concatenate([rays, np.ones((len(rays), 1))], axis=1)
    board_from_camera = camera_from_board.inverse()
    turned = directions @ board_from_camera.rotation.T
    origin_m = board_from_camera.translation_m
    reach = -origin_m[2] / turned[:, 2]
    return np.asarray(origin_m[:2] + reach[:, None] * turned[:, :2])


def _board_error(view: ViewFit, fit: CameraFit) -> BoardError | None:
    is_for_pose = _every_other(fit.board) & view.is_used
    is_judged = ~_every_other(fit.board) & view.is_used
    if is_for_pose.sum() < LEAST_CORNERS or not is_judged.any():
        return None
    camera_from_board = _pose_from(view, is_for_pose, fit)
    real_m = fit.board.points_m()[is_judged, :2]
    pixels = view.pixels[is_judged]
    computed_m = computed_on_board(pixels, fit.camera, camera_from_board)
    rows = tuple(
        CornerRow(view.image, *pixel, *real, *computed)
        for pixel, real, computed in zip(
            pixels.tolist(), real_m.tolist(), computed_m.tolist(), strict=True
        )
    )
    middle_m = camera_from_board.apply(fit.board.points_m().mean(axis=0))
    q_m = np.hypot(*(real_m - computed_m).T).mean()
    return BoardError(view.image, float(np.linalg.norm(middle_m)), float(q_m), rows)


def _every_other(board: Board) -> BoolArray:
    row, column = np.divmod(np.arange(board.n_corners), board.columns)
    return np.asarray((row + column) % 2 == 0)


def _pose_from(view: ViewFit, is_kept: BoolArray, fit: CameraFit) -> RigidTransform:
    """Return the pose by these corners alone; the joint one says which of two poses it is."""
    pixels = np.where(is_kept[:, None], view.pixels, np.nan)
    joint = view.camera_from_board
    start = Estimate(
        camera_numbers(fit.camera.intrinsics, fit.camera.distortion),
        joint.rotation[None].copy(),
        joint.translation_m[None].copy(),
    )
    found = refine_poses(observe(fit.board.points_m(), pixels[None]), start)
    return RigidTransform(found.rotations[0], found.translations_m[0])


def _cell(pixels: FloatArray, camera: CameraCalibration, cells: tuple[int, int]) -> IntArray:
    """Return the (N,) numbers of the cells, row by row."""
    rows, columns = cells
    column = np.floor((pixels[:, 0] + 0.5) / camera.width * columns).astype(np.int64)
    row = np.floor((pixels[:, 1] + 0.5) / camera.height * rows).astype(np.int64)
    inside = np.clip(row, 0, rows - 1) * columns + np.clip(column, 0, columns - 1)
    return np.asarray(inside)
