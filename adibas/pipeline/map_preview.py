"""What is seen of a map while it grows: discs of its key-frames, then of its surface."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from adibas.alignment.sights import Sight, color_pixels
from adibas.alignment.surfels import Surface
from adibas.arrays import Float32Array, FloatArray, UInt8Array, check_shape, read_only
from adibas.data.discs import Discs
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.surface_discs import grid_discs, grid_points

MOST_DISCS = 150_000
STEP = 2
"""Every so many points of the coarsest resolution, along a side."""
GREY = 128


@dataclass(frozen=True, slots=True, eq=False)
class MapPicture:
    """A map as far as it goes, in the axes of its first frame's depth camera.

    Attributes
    ----------
    discs : Discs
    path_m : (P, 3) array
        Where the camera was at key-frames.
    """

    discs: Discs
    path_m: FloatArray

    def __post_init__(self) -> None:
        check_shape("path_m", self.path_m, (None, 3))
        read_only(self.path_m)


MapWatch = Callable[[MapPicture], None]
"""Is told how a map grows; called in the thread that maps."""


class GrowingPicture:
    """Discs of key-frames, put where these are known to be at the moment."""

    def __init__(self) -> None:
        self._seen: list[Discs] = []

    def __len__(self) -> int:
        """Return the number of key-frames."""
        return len(self._seen)

    def add(self, sight: Sight, color_rgb: UInt8Array) -> None:
        """Take a key-frame's discs."""
        points_m, normals, radii_m = _sampled(sight)
        pixels = np.rint(color_pixels(points_m, sight.calibration))
        height, width, _ = color_rgb.shape
        inside = ((pixels >= 0) & (pixels < (width, height))).all(axis=1)
        colors = np.full((len(points_m), 3), GREY, np.uint8)
        columns, rows = pixels[inside].astype(int).T
        colors[inside] = color_rgb[rows, columns]
        self._seen.append(
            Discs(points_m.astype(np.float32), normals.astype(np.float32), radii_m, colors)
        )

    def picture(self, world_from_key: Sequence[RigidTransform]) -> MapPicture:
        """Return all of it, with fewer discs of a key-frame the more there are."""
        most = MOST_DISCS // max(len(self), 1)
        seen = [discs.at_most(most) for discs in self._seen]
        placed = list(zip(world_from_key, seen, strict=True))
        return MapPicture(
            Discs(
                _joined(pose.apply(one.points_m.astype(float)) for pose, one in placed),
                _joined(one.normals @ pose.rotation.T for pose, one in placed),
                np.concatenate([one.radii_m for one in seen]),
                np.concatenate([one.colors_rgb for one in seen]),
            ),
            np.array([pose.translation_m for pose in world_from_key]),
        )


def _joined(parts: Iterable[FloatArray]) -> Float32Array:
    return np.concatenate(list(parts), dtype=np.float32)


def picture_of(surface: Surface, world_from_camera: Sequence[RigidTransform]) -> MapPicture:
    """Return a finished surface, with fewer discs than it has where these are many."""
    discs = Discs(surface.points_m, surface.normals, surface.radii_m, surface.colors_rgb)
    return MapPicture(
        discs.at_most(MOST_DISCS),
        np.array([pose.translation_m for pose in world_from_camera]).reshape(-1, 3),
    )


def _sampled(sight: Sight) -> tuple[FloatArray, FloatArray, Float32Array]:
    """Return (N, 3) points of the coarsest resolution, their normals, and radii."""
    level = sight.view.levels[-1]
    inverse = level.inverse_per_m[::STEP, ::STEP].astype(float)
    points_m, is_known = grid_points(inverse, level.rays[::STEP, ::STEP].astype(float))
    spacing = STEP * level.reduction / sight.view.camera.intrinsics.fx
    normals, radii_m = grid_discs(points_m, spacing)
    return points_m[is_known], normals[is_known], radii_m[is_known]
