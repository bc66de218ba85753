"""A surface as surfels: small discs that frames add, confirm and remove.

Source: thesis, section 5.2.2; Krainin et al., Manipulator and Object Tracking (2011); Keller et
al., Real-Time 3D Reconstruction (2013). The confidence is in units of a square look from one metre.
"""

from dataclasses import dataclass

import numpy as np

from adibas.alignment.joint_fit import goal_of
from adibas.alignment.sights import color_pixels
from adibas.alignment.surfel_blocks import boxes_of, order_by_place
from adibas.alignment.surfel_kernels import (
    COLOR,
    CONFIDENCE,
    MISSES,
    N_COLUMNS,
    NORMAL,
    PLACE,
    RADIUS,
    Shot,
    add_shot,
    arrange,
    find_surfels,
)
from adibas.alignment.views import View
from adibas.arrays import Float32Array, FloatArray, UInt8Array, check_shape, read_only
from adibas.data.calibration import RgbdCalibration
from adibas.geometry.rigid import RigidTransform

UNSEEN = 128
"""Grey where the colour camera does not look."""
FEWEST_ROWS = 1 << 16
MISSED_SHARE = 0.02
"""Of all surfels, that are there no more and take room until then."""
LATER_SHARE = 0.25
"""Of all surfels, that lie as frames brought them until then."""


@dataclass(frozen=True, slots=True)
class SurfelParams:
    """How frames make surfels.

    Attributes
    ----------
    gate_per_m : float
        A surfel and a pixel that differ by more in 1/z are different surfaces: 0.012.
    largest_angle_rad : float
        Between ray and normal, where surfels are added: 1.22 (70 degrees).
    alike_rad : float
        Between normals of one surface: 0.79 (45 degrees).
    most_misses : int
        A surfel that was seen through so often in a row is removed: 3.
    least_confidence : float
        Those that stay below are left out at the end: 0.5.
    capacity : int
        Surfels at most: 4,000,000 (208 MB).
    """

    gate_per_m: float = 0.012
    largest_angle_rad: float = 1.22
    alike_rad: float = 0.79
    most_misses: int = 3
    least_confidence: float = 0.5
    capacity: int = 4_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """The finished map; all arrays have N rows.

    Attributes
    ----------
    points_m, normals : (N, 3) float32 arrays
        In the world's axes; normals point towards where the surface was seen from.
    colors_rgb : (N, 3) uint8 array
    radii_m, confidences : (N,) float32 arrays
    """

    points_m: Float32Array
    normals: Float32Array
    colors_rgb: UInt8Array
    radii_m: Float32Array
    confidences: Float32Array

    def __post_init__(self) -> None:
        n = len(self.points_m)
        for name in ("points_m", "normals", "colors_rgb"):
            check_shape(name, getattr(self, name), (n, 3))
        for name in ("radii_m", "confidences"):
            check_shape(name, getattr(self, name), (n,))
        for array in (
            self.points_m,
            self.normals,
            self.colors_rgb,
            self.radii_m,
            self.confidences,
        ):
            read_only(array)


@dataclass(frozen=True, slots=True, eq=False)
class Distances:
    """Between a frame and a surface.

    Attributes
    ----------
    points_m : (N, 3) array
        Of the surface, in the world's axes.
    behind_m : (N,) array
        How far behind them the frame sees its own, along its normal.
    """

    points_m: FloatArray
    behind_m: FloatArray


class SurfelMap:
    """Grows frame by frame."""

    def __init__(self, params: SurfelParams | None = None) -> None:
        self._params = params or SurfelParams()
        self._surfels = np.zeros((min(FEWEST_ROWS, self._params.capacity), N_COLUMNS), np.float32)
        self._boxes = boxes_of(self._surfels[:0, PLACE : PLACE + 3], len(self._surfels))
        self._n = self._n_missed = self._n_in_order = 0
        self._was_full = False

    def __len__(self) -> int:
        """Return the number of surfels."""
        return self._n - self._n_missed

    @property
    def was_full(self) -> bool:
        """Whether no more surfels fitted in at some moment, so that some may have been left out."""
        return self._was_full

    def add(
        self,
        view: View,
        color_rgb: UInt8Array,
        calibration: RgbdCalibration,
        world_from_camera: RigidTransform,
    ) -> None:
        """Fuse a frame seen from a pose of the depth camera; the finest level is enough."""
        params = self._params
        shot = _shot(view, _cell_colors(view, color_rgb, calibration), world_from_camera)
        cells = shot.colors.shape[0] * shot.colors.shape[1]
        if self._n + cells > params.capacity:
            self._put_in_order()
        self._reserve(min(self._n + cells, params.capacity))
        gate = (params.gate_per_m, float(params.most_misses))
        seen, n_missed = find_surfels(self._surfels, self._boxes, self._n, shot, gate)
        self._n_missed += n_missed
        limits = (float(np.cos(params.largest_angle_rad)), float(np.cos(params.alike_rad)))
        self._n = add_shot(self._surfels, self._boxes, self._n, shot, seen, limits)
        self._was_full |= self._n >= params.capacity
        n_later = self._n - self._n_in_order
        if self._n_missed > MISSED_SHARE * self._n or n_later > LATER_SHARE * self._n:
            self._put_in_order()

    def distances_m(self, view: View, world_from_camera: RigidTransform) -> "Distances":
        """Return how far what a frame sees lies behind the surface; nothing is fused.

        Parameters
        ----------
        view : View
            The finest level is enough.
        """
        shot = _shot(view, np.zeros((1, 1, 3), np.uint8), world_from_camera)
        known = self._surfels[: self._n].copy()  # what is seen through would be counted
        gate = (self._params.gate_per_m, float(self._params.most_misses))
        seen, _n_missed = find_surfels(known, self._boxes, self._n, shot, gate)
        cells = seen >= 0
        points_m = known[seen[cells], PLACE : PLACE + 3].astype(float)
        planes = shot.goal.planes[cells].astype(float)
        inside = world_from_camera.inverse().apply(points_m)
        ahead = (planes * inside).sum(axis=1)
        lengths = np.linalg.norm(planes, axis=1)
        return Distances(points_m, np.asarray((1.0 - ahead) / lengths))

    def surface(self) -> Surface:
        """Return what is sure enough."""
        doubtful = self._surfels[: self._n, CONFIDENCE] < self._params.least_confidence
        doubtful |= self._surfels[: self._n, MISSES] >= self._params.most_misses
        kept = np.delete(self._surfels[: self._n], np.nonzero(doubtful)[0], axis=0)
        return Surface(
            kept[:, PLACE : PLACE + 3].copy(),
            kept[:, NORMAL : NORMAL + 3].copy(),
            np.round(kept[:, COLOR : COLOR + 3]).astype(np.uint8),
            kept[:, RADIUS].copy(),
            kept[:, CONFIDENCE].copy(),
        )

    def _reserve(self, n: int) -> None:
        if n > len(self._surfels):
            larger = np.zeros((min(2 * n, self._params.capacity), N_COLUMNS), np.float32)
            larger[: self._n] = self._surfels[: self._n]
            self._surfels = larger
            boxes = boxes_of(larger[:0, PLACE : PLACE + 3], len(larger))
            boxes[: len(self._boxes)] = self._boxes
            self._boxes = boxes

    def _put_in_order(self) -> None:
        """Put near surfels side by side, and leave out those that are there no more."""
        if self._n_missed or self._n_in_order < self._n:
            known = self._surfels[: self._n]
            is_missed = known[:, MISSES] >= self._params.most_misses
            order = order_by_place(known[:, PLACE : PLACE + 3])
            is_missed = is_missed[order]
            arrange(known, np.concatenate([order[~is_missed], order[is_missed]]))
            self._n -= int(np.count_nonzero(is_missed))
            self._n_missed, self._n_in_order = 0, self._n
            places_m = self._surfels[: self._n, PLACE : PLACE + 3]
            self._boxes = boxes_of(places_m, len(self._surfels))


def _shot(view: View, colors: UInt8Array, world_from_camera: RigidTransform) -> Shot:
    """Return a frame as the kernels take it."""
    rays = view.levels[0].rays
    pose = np.hstack([world_from_camera.rotation, world_from_camera.translation_m[:, None]])
    return Shot(goal_of(view, 0), rays, _sides(rays), colors, pose)


def _sides(rays: Float32Array) -> tuple[float, float, float, float]:
    """Return the least and largest x/z, and y/z, of a picture of pixels with these rays."""
    border = np.concatenate([rays[0], rays[-1], rays[:, 0], rays[:, -1]])
    least, most = border.min(axis=0).astype(float), border.max(axis=0).astype(float)
    a_pixel = (most - least) / (min(rays.shape[:2]) - 1)
    left, top = (least - a_pixel).tolist()
    right, bottom = (most + a_pixel).tolist()
    return left, right, top, bottom


def _cell_colors(view: View, color_rgb: UInt8Array, calibration: RgbdCalibration) -> UInt8Array:
    """Return the colour that each cell of the finest planes has in the picture."""
    level = view.levels[0]
    middle = level.cell_px // 2
    n_rows, n_columns, _ = level.planes.shape
    rays = level.rays[middle :: level.cell_px, middle :: level.cell_px][:n_rows, :n_columns]
    inverse = (level.planes[..., :2] * rays).sum(axis=2) + level.planes[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(inverse > 0, 1.0 / inverse, np.nan)
    points = np.stack([rays[..., 0] * z, rays[..., 1] * z, z], axis=-1).reshape(-1, 3)
    pixels: FloatArray = np.rint(color_pixels(points, calibration))
    height, width, _ = color_rgb.shape
    with np.errstate(invalid="ignore"):
        is_inside = ((pixels >= 0) & (pixels < (width, height))).all(axis=1, keepdims=True)
    columns, rows = np.where(is_inside, pixels, 0).astype(int).T
    colors: UInt8Array = np.where(is_inside, color_rgb[rows, columns], UNSEEN)
    return np.ascontiguousarray(colors.reshape(n_rows, n_columns, 3), np.uint8)
