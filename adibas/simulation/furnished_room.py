"""A furnished room for a camera that moves: boxes and spheres, cast ray by ray, exact everywhere.

World axes: x right, y down, z ahead, metres; the floor is at y = 0, and the room's middle at
x = z = 0.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from adibas.arrays import Float32Array, FloatArray, IntArray, read_only
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import pixel_rays
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.furnished_room_kernels import cast_rays

HALF_WIDTH_M, HEIGHT_M = 2.4, 2.6
N_BOXES, N_SPHERES = 14, 8
PATTERN_M = (0.42, 0.13, 0.04)
"""Sides of the patches of a surface's pattern, at three sizes."""
PATTERN_SHARE = (0.22, 0.16, 0.1)
ROOM = np.array(
    [[0.0, -HEIGHT_M / 2, 0.0, HALF_WIDTH_M, HEIGHT_M / 2, HALF_WIDTH_M, 1.0, 0.0]], np.float64
)
"""As `cast_rays` takes boxes."""


@dataclass(frozen=True, slots=True, eq=False)
class RoomView:
    """What a camera in the room sees; all (H, W[, 3]) float32.

    Attributes
    ----------
    inverse_depth : (H, W) array
        True 1/z, 1/metres.
    reflectance : (H, W) array
        In infrared, 0 to 1.
    rgb : (H, W, 3) array
        sRGB, 0 to 1, evenly lit.
    """

    inverse_depth: Float32Array
    reflectance: Float32Array
    rgb: Float32Array


class FurnishedRoom:
    """One room.

    Parameters
    ----------
    seed : int
        Of furniture and patterns.
    is_plain : bool
        Without furniture and patterns: nothing tells places along the walls from one another.
    """

    def __init__(self, seed: int, *, is_plain: bool = False) -> None:
        rng = np.random.default_rng([seed, 0x100])
        self._is_plain = is_plain
        n_boxes = 0 if is_plain else N_BOXES
        middles = rng.uniform(-1, 1, (n_boxes, 3)) * [HALF_WIDTH_M - 0.3, 0, HALF_WIDTH_M - 0.3]
        halves = rng.uniform(0.1, 0.4, (n_boxes, 3)) * [1.0, 2.0, 1.0]
        middles[:, 1] = -halves[:, 1] - rng.choice([0.0, 0.5], n_boxes)
        angles = rng.uniform(0, np.pi, n_boxes)
        turns = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        self._boxes = np.concatenate([ROOM, np.hstack([middles, halves, turns])])
        n_spheres = 0 if is_plain else N_SPHERES
        centres = rng.uniform(-1, 1, (n_spheres, 3)) * (HALF_WIDTH_M - 0.4)
        centres[:, 1] = -rng.uniform(0.3, 1.8, n_spheres)
        self._spheres = np.hstack([centres, rng.uniform(0.12, 0.35, (n_spheres, 1))])
        self._colors = rng.uniform(0.25, 0.8, (1 + n_boxes + n_spheres, 3))
        self._salt = int(rng.integers(2**31))

    def look(self, camera: CameraCalibration, camera_from_world: RigidTransform) -> RoomView:
        """Return what a camera sees from inside the room."""
        world_from_camera = camera_from_world.inverse()
        rays = _rays(camera)
        ways = (rays @ world_from_camera.rotation.T).reshape(-1, 3)
        origin = world_from_camera.translation_m
        depths, owner = cast_rays(origin, ways, self._boxes, self._spheres)
        points = origin + ways * depths[:, None]
        rgb = self._painted(points, owner).reshape(*rays.shape)
        inverse = (1.0 / depths).reshape(rays.shape[:2])
        reflectance = np.full(rays.shape[:2], 0.6, np.float32)
        return RoomView(inverse.astype(np.float32), reflectance, rgb.astype(np.float32))

    def is_free(self, place_m: FloatArray, margin_m: float = 0.35) -> bool:
        """Return whether a camera at a place is away from all furniture."""
        for box in self._boxes[1:]:
            off_m = _turn(box[6], box[7]) @ (place_m - box[:3])
            if (np.abs(off_m) < box[3:6] + margin_m).all():
                return False
        apart_m = np.linalg.norm(place_m - self._spheres[:, :3], axis=1)
        return bool((apart_m > self._spheres[:, 3] + margin_m).all())

    def _painted(self, points: FloatArray, owner: IntArray) -> FloatArray:
        color: FloatArray = self._colors[owner]
        if self._is_plain:
            return color
        for side_m, share in zip(PATTERN_M, PATTERN_SHARE, strict=True):
            cells = np.floor(points / side_m + 0.317).astype(np.int64)
            color = color + share * (_hashed(cells, self._salt)[:, None] - 0.5)
        shown: FloatArray = np.clip(color, 0.02, 0.98)
        return shown


@lru_cache(maxsize=4)
def _rays(camera: CameraCalibration) -> FloatArray:
    """Return the (H, W, 3) rays of one metre of depth."""
    rays = np.ones((camera.height, camera.width, 3))
    rays[..., :2] = pixel_rays((camera.height, camera.width), camera.intrinsics, camera.distortion)
    read_only(rays)
    return rays


def _turn(c: float, s: float) -> FloatArray:
    """Return the turn about the vertical from the world into a box's axes."""
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def _hashed(cells: IntArray, salt: int) -> FloatArray:
    """Return (N,) numbers in [0, 1) that depend on (N, 3) whole numbers alone."""
    mixed = cells.astype(np.uint64) @ np.array([73856093, 19349663, 83492791], np.uint64)
    mixed ^= np.uint64(salt)
    mixed *= np.uint64(0x9E3779B97F4A7C15)
    mixed ^= mixed >> np.uint64(29)
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    shares: FloatArray = (mixed >> np.uint64(40)).astype(float) / 2.0**24
    return shares
