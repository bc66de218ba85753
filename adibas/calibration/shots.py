"""A flat board or wall as the depth camera saw it, in cells of some pixels.

On a plane 1/z is linear in the pixel's ray, and a structured-light sensor's noise is constant in
1/z; so the mean of 1/z over a cell, at the mean ray, is as good as its pixels. Neighbouring pixels
err together (the sensor matches windows of 9 x 7 pixels): cells are larger than that.

Source: Konolige & Mihelich, Technical description of Kinect calibration (ROS), for window and
disparity; Khoshelham & Elberink, Sensors 12 (2012), for the noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.ndimage import binary_opening, maximum_filter

from adibas.arrays import (
    BoolArray,
    Float32Array,
    FloatArray,
    IntArray,
    check_shape,
    read_only,
)
from adibas.calibration.extrinsics_pose import BoardPose
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.data.surface import BurstDisparity
from adibas.geometry.distortion import pixel_rays
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform

N_PLANE = 3
MAD_TO_SD = 1.4826
LEAST_PIXELS = 60
N_ROUNDS = 4
ENOUGH_PIXELS = 20_000
"""To fit a plane by."""
LEAST_SCALE_PER_M = 1e-9


@dataclass(frozen=True, slots=True)
class ShotParams:
    """How the pixels of a plane are chosen and gathered.

    Attributes
    ----------
    cell_px : int
        Side of a cell: 16, nearly twice the sensor's window of 9 x 7 pixels.
    least_cell_px : int
        Pixels that a cell needs: 32.
    margin_px : float
        Pixels nearer to the board's outline take no part: 6, half a window and the jitter of
        edges (0.8 px, Nguyen et al. 2012).
    cut_sigmas : float
        Pixels farther from the plane are no part of it: 4.
    board_bend_per_m, wall_bend_per_m : float
        By which a plane may be bent, as 1/z, by noise and device: 0.004 (16 mm at 2 m) over a
        board, 0.006 over the whole image.
    floor_bend_per_m : float
        Likewise of a floor after correction: 0.002 (2 cm at 3 m). A wall that rises from it is
        within this for one row of pixels.
    floor_cell_share : float
        Of a cell's pixels that must be floor: 0.8. Others lie at the foot of a wall or person.
    largest_error_per_m : float
        Of the device's 1/z: 0.03 (2 cm at 0.8 m, 12 cm at 2 m). Farther from where the board is
        expected is something else.
    least_share : float
        Of the pixels inside the outline that must lie on the plane: 0.5.
    """

    cell_px: int = 16
    least_cell_px: int = 32
    margin_px: float = 6.0
    cut_sigmas: float = 4.0
    board_bend_per_m: float = 0.004
    wall_bend_per_m: float = 0.006
    floor_bend_per_m: float = 0.002
    floor_cell_share: float = 0.8
    largest_error_per_m: float = 0.03
    least_share: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Mean depth of the cells that a plane covers.

    Attributes
    ----------
    rays : (N, 2) array
        Mean (x/z, y/z), without the lens.
    pixels : (N, 2) array
        Mean (u, v).
    inverse_m : (N,) array
        Mean 1/z as measured, 1/metres.
    n_pixels : (N,) array
        Behind each mean.
    blocks : (N, 2) int array
        Row and column of the cell.
    """

    rays: FloatArray
    pixels: FloatArray
    inverse_m: FloatArray
    n_pixels: FloatArray
    blocks: IntArray

    def __post_init__(self) -> None:
        for array in (self.rays, self.pixels, self.inverse_m, self.n_pixels, self.blocks):
            read_only(array)

    def __len__(self) -> int:
        return len(self.inverse_m)

    @property
    def shares(self) -> FloatArray:
        """Information of each cell, 1 where it is as full as the fullest."""
        return np.asarray(self.n_pixels / self.n_pixels.max())


@dataclass(frozen=True, slots=True, eq=False)
class BoardShot:
    """One moment at which board and depth camera stood still.

    Attributes
    ----------
    name : str
        For the reader.
    pose : BoardPose
        In the colour camera.
    cells : Cells
        Of the board in the depth camera, as measured.
    time_s : float
        When, for the drift.
    """

    name: str
    pose: BoardPose
    cells: Cells
    time_s: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class WallShot:
    """A flat wall in the depth camera, as measured; nothing says where it stood."""

    name: str
    cells: Cells
    time_s: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class InversePlane:
    """A plane as the 1/z of its points: ``1/z = m . (x/z, y/z, 1)``.

    Attributes
    ----------
    m : (3,) array
        Normal over distance, 1/metres.
    covariance : (3, 3) array
        By the noise of the corners.
    by_camera : (3, 17) array
        How it goes with the camera's parameters.
    """

    m: FloatArray
    covariance: FloatArray
    by_camera: FloatArray


def plane_of(pose: BoardPose) -> InversePlane:
    """Return the board's plane in the camera that the pose is for."""
    normal = pose.camera_from_board.rotation[:, 2]
    origin_m = pose.camera_from_board.translation_m
    distance_m = float(normal @ origin_m)
    m = normal / distance_m
    # The normal moves by w x n, the distance by (w x n) . t + n . dt.
    x, y, z = normal
    by_turn = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    by_pose = np.empty((3, 6))
    by_pose[:, :3] = (by_turn - np.outer(m, origin_m @ by_turn)) / distance_m
    by_pose[:, 3:] = -np.outer(m, normal) / distance_m
    return InversePlane(m, by_pose @ pose.covariance @ by_pose.T, by_pose @ pose.by_camera)


def moved_plane(m: FloatArray, to_from: RigidTransform) -> FloatArray:
    """Return the inverse plane (3,) of ``to``, seen in the axes of ``from``."""
    return np.asarray(to_from.rotation.T @ m / (1.0 - float(m @ to_from.translation_m)))


def cells_on_board(
    disparity: BurstDisparity,
    depth: CameraCalibration,
    board: Board,
    depth_from_board: RigidTransform,
    params: ShotParams | None = None,
) -> Cells | None:
    """Gather the depth pixels that lie on a board.

    Parameters
    ----------
    disparity : BurstDisparity
        As measured, without correction.
    depth : CameraCalibration
        That took it.
    board : Board
        Held somewhere before the camera.
    depth_from_board : RigidTransform
        Where it is expected, good to some pixels.

    Returns
    -------
    cells : Cells or None
        None where the depth camera sees too little of the board, or mostly something else there.
    """
    params = params or ShotParams()
    check_shape("mean_per_m", disparity.mean_per_m, (depth.height, depth.width))
    rays = _rays(depth)
    homogeneous = np.concatenate([rays, np.ones((*rays.shape[:2], 1))], axis=-1)
    m = depth_from_board.rotation[:, 2] / float(
        depth_from_board.rotation[:, 2] @ depth_from_board.translation_m
    )
    expected = homogeneous @ m
    with np.errstate(invalid="ignore", divide="ignore"):
        points_m = depth_from_board.inverse().apply(homogeneous / expected[..., None])
        margin_m = params.margin_px / (expected * depth.intrinsics.fx)
        square_m = board.square_m
        inside = (
            (expected > 0)
            & (points_m[..., 0] > margin_m - square_m)
            & (points_m[..., 0] < board.columns * square_m - margin_m)
            & (points_m[..., 1] > margin_m - square_m)
            & (points_m[..., 1] < board.rows * square_m - margin_m)
        )
        near = np.abs(disparity.mean_per_m - expected) < params.largest_error_per_m
    n_inside = int(inside.sum())
    chosen = np.nonzero(inside & near & np.isfinite(disparity.mean_per_m))
    kept = _on_plane(rays[chosen], disparity.mean_per_m[chosen], params, params.board_bend_per_m)
    if kept.sum() < max(LEAST_PIXELS, params.least_share * n_inside):
        return None
    pixels = (chosen[0][kept], chosen[1][kept])
    return _in_cells(pixels, disparity.mean_per_m[pixels], rays[pixels], depth, params)


def cells_on_wall(
    disparity: BurstDisparity,
    depth: CameraCalibration,
    params: ShotParams | None = None,
) -> Cells | None:
    """Gather the depth pixels of a flat wall that fills most of the picture; else None."""
    params = params or ShotParams()
    check_shape("mean_per_m", disparity.mean_per_m, (depth.height, depth.width))
    rays = _rays(depth)
    chosen = np.nonzero(np.isfinite(disparity.mean_per_m))
    kept = _on_plane(rays[chosen], disparity.mean_per_m[chosen], params, params.wall_bend_per_m)
    if kept.sum() < params.least_share * disparity.mean_per_m.size:
        return None
    is_wall = np.zeros(disparity.mean_per_m.shape, bool)
    is_wall[chosen[0][kept], chosen[1][kept]] = True
    is_other = np.isfinite(disparity.mean_per_m) & ~is_wall
    rows, columns = np.nonzero(is_wall & ~_near(is_other, params.margin_px))
    pixels = (rows, columns)
    return _in_cells(pixels, disparity.mean_per_m[pixels], rays[pixels], depth, params)


def _near(is_other: BoolArray, margin_px: float) -> BoolArray:
    """Say which pixels are near other things; the first rows of a floor are hardly off a wall."""
    surfaces = binary_opening(is_other, np.ones((3, 3), bool))
    return np.asarray(maximum_filter(surfaces, size=2 * round(margin_px) + 1), bool)


def cells_near_plane(
    depth_m: Float32Array,
    depth: CameraCalibration,
    plane: Plane,
    params: ShotParams | None = None,
) -> FloatArray:
    """Return the (N, 3) means over cells of the points on a floor, in metres.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Bias corrected, metres; NaN where not measured.
    plane : Plane
        In the depth camera's axes, good to a few millimetres.
    """
    params = params or ShotParams()
    least = round(params.floor_cell_share * params.cell_px**2)
    params = replace(params, least_cell_px=least)
    check_shape("depth_m", depth_m, (depth.height, depth.width))
    rays = _rays(depth)
    homogeneous = np.concatenate([rays, np.ones((*rays.shape[:2], 1))], axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        inverse_m = (1.0 / depth_m).astype(np.float32)
        expected = -(homogeneous @ plane.normal) / plane.offset_m
        rows, columns = np.nonzero(np.abs(inverse_m - expected) < params.floor_bend_per_m)
    if not len(rows):
        return np.empty((0, 3))
    pixels = (rows, columns)
    cells = _in_cells(pixels, inverse_m[pixels], rays[pixels], depth, params)
    if cells is None:
        return np.empty((0, 3))
    return _homogeneous(cells.rays) / cells.inverse_m[:, None]


def fit_inverse_plane(
    rays: FloatArray, inverse_m: FloatArray, weights: FloatArray | None = None
) -> FloatArray:
    """Return the (3,) plane of least squares in 1/z, of (N, 2) rays."""
    share = np.ones(len(inverse_m)) if weights is None else np.sqrt(weights)
    system = _homogeneous(rays) * share[:, None]
    return np.asarray(np.linalg.lstsq(system, inverse_m * share)[0])


def _on_plane(
    rays: FloatArray, inverse_m: Float32Array, params: ShotParams, bend_per_m: float
) -> BoolArray:
    """Say which pixels lie on the plane that most of them share; none if they are too few."""
    values = inverse_m.astype(float)
    kept = np.ones(len(values), bool)
    few = slice(None, None, max(1, len(values) // ENOUGH_PIXELS))
    for _ in range(N_ROUNDS):
        if kept[few].sum() < LEAST_PIXELS:
            return np.zeros(len(values), bool)
        residuals = values - _homogeneous(rays) @ _planar(rays[few], values[few], kept[few])
        spread = MAD_TO_SD * np.median(np.abs(residuals[kept] - np.median(residuals[kept])))
        kept = np.abs(residuals) < max(params.cut_sigmas * spread, bend_per_m)
    return kept


def _planar(rays: FloatArray, inverse_m: FloatArray, kept: BoolArray) -> FloatArray:
    """Return the plane through the kept pixels with little heed to those far off."""
    m = fit_inverse_plane(rays, inverse_m, kept.astype(float))
    for _ in range(3):
        distances = np.abs(inverse_m - _homogeneous(rays) @ m)
        scale = max(float(np.median(distances[kept])), LEAST_SCALE_PER_M)
        m = fit_inverse_plane(rays, inverse_m, kept / (1.0 + (distances / (2.0 * scale)) ** 2))
    return m


def _homogeneous(rays: FloatArray) -> FloatArray:
    return np.column_stack([rays, np.ones(len(rays))])


@lru_cache(maxsize=2)
def _rays(camera: CameraCalibration) -> FloatArray:
    rays = pixel_rays((camera.height, camera.width), camera.intrinsics, camera.distortion)
    read_only(rays)
    return rays


def _in_cells(
    pixels: tuple[IntArray, IntArray],
    inverse_m: Float32Array,
    rays: FloatArray,
    depth: CameraCalibration,
    params: ShotParams,
) -> Cells | None:
    rows, columns = pixels
    across = -(-depth.width // params.cell_px)
    number = rows // params.cell_px * across + columns // params.cell_px
    cells, member, counts = np.unique(number, return_inverse=True, return_counts=True)
    is_full = counts >= params.least_cell_px
    if not is_full.any():
        return None

    def mean(values: FloatArray) -> FloatArray:
        means: FloatArray = np.bincount(member, values)[is_full] / counts[is_full]
        return means

    return Cells(
        rays=np.stack([mean(rays[:, 0]), mean(rays[:, 1])], axis=-1),
        pixels=np.stack([mean(columns.astype(float)), mean(rows.astype(float))], axis=-1),
        inverse_m=mean(inverse_m.astype(float)),
        n_pixels=counts[is_full].astype(float),
        blocks=np.stack(np.divmod(cells[is_full], across), axis=-1),
    )


def total_squares(shots: Sequence[BoardShot]) -> float:
    """Return the variance of the corners by their own account: 1 where their sigmas are right."""
    n_degrees = sum(shot.pose.n_degrees for shot in shots)
    return sum(shot.pose.squares for shot in shots) / max(n_degrees, 1)
