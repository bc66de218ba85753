"""What is seen of a map while it grows: points of its key-frames, then of its surface."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from adibas.alignment.sights import Sight, color_pixels
from adibas.alignment.surfels import Surface
from adibas.arrays import FloatArray, UInt8Array, read_only
from adibas.geometry.rigid import RigidTransform

MOST_POINTS = 150_000
STEP = 2
"""Every so many points of the coarsest resolution, along a side."""
GREY = 128


@dataclass(frozen=True, slots=True, eq=False)
class MapPicture:
    """A map as far as it goes, in the axes of its first frame's depth camera.

    Attributes
    ----------
    points_m : (N, 3) array
    colors_rgb : (N, 3) uint8 array
    path_m : (P, 3) array
        Where the camera was at key-frames.
    """

    points_m: FloatArray
    colors_rgb: UInt8Array
    path_m: FloatArray

    def __post_init__(self) -> None:
        for array in (self.points_m, self.colors_rgb, self.path_m):
            read_only(array)


MapWatch = Callable[[MapPicture], None]
"""Is told how a map grows; called in the thread that maps."""


class GrowingPicture:
    """Points of key-frames, put where these are known to be at the moment."""

    def __init__(self) -> None:
        self._points_m: list[FloatArray] = []
        self._colors: list[UInt8Array] = []

    def __len__(self) -> int:
        """Return the number of key-frames."""
        return len(self._points_m)

    def add(self, sight: Sight, color_rgb: UInt8Array) -> None:
        """Take a key-frame's points."""
        points_m = _sampled(sight)
        pixels = np.rint(color_pixels(points_m, sight.calibration))
        height, width, _ = color_rgb.shape
        inside = ((pixels >= 0) & (pixels < (width, height))).all(axis=1)
        colors = np.full((len(points_m), 3), GREY, np.uint8)
        columns, rows = pixels[inside].astype(int).T
        colors[inside] = color_rgb[rows, columns]
        self._points_m.append(points_m)
        self._colors.append(colors)

    def picture(self, world_from_key: Sequence[RigidTransform]) -> MapPicture:
        """Return all of it, with fewer points the more there are."""
        step = 1 + sum(len(points) for points in self._points_m) // MOST_POINTS
        placed = [
            pose.apply(points[::step])
            for pose, points in zip(world_from_key, self._points_m, strict=True)
        ]
        return MapPicture(
            np.concatenate(placed),
            np.concatenate([colors[::step] for colors in self._colors]),
            np.array([pose.translation_m for pose in world_from_key]),
        )


def picture_of(surface: Surface, world_from_camera: Sequence[RigidTransform]) -> MapPicture:
    """Return a finished surface, with fewer points than it has where these are many."""
    step = 1 + len(surface.points_m) // MOST_POINTS
    return MapPicture(
        surface.points_m[::step].astype(float),
        surface.colors_rgb[::step].copy(),
        np.array([pose.translation_m for pose in world_from_camera]).reshape(-1, 3),
    )


def _sampled(sight: Sight) -> FloatArray:
    """Return (N, 3) points of the coarsest resolution."""
    level = sight.view.levels[-1]
    inverse = level.inverse_per_m[::STEP, ::STEP].astype(float)
    rays = level.rays[::STEP, ::STEP]
    known = inverse > 0  # false for NaN
    z = 1.0 / inverse[known]
    return np.column_stack([rays[known] * z[:, None], z])
