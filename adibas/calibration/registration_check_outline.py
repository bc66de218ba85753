"""Where near surfaces end in a depth image, drawn into the colour image."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import ndimage

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.data.calibration import CameraCalibration
from adibas.geometry.distortion import pixel_rays, project_distorted
from adibas.geometry.rigid import RigidTransform

N_BLOCKS = 6


@dataclass(frozen=True, slots=True)
class OutlineParams:
    """What an outline is.

    Attributes
    ----------
    step_m : float
        What is behind an outline is farther by so much, 0.15, or not measured.
    reach_px : int
        Depth pixels without a reading that may lie between: 24, a shadow of the projector.
    border_px : int
        Outline points nearer to the border take no part: 12.
    """

    step_m: float = 0.15
    reach_px: int = 24
    border_px: int = 12


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Outline points in the colour image: (N, 2) pixels, outward normals, and (N,) blocks."""

    pixels: FloatArray
    normals: FloatArray
    blocks: FloatArray


def outline_in_color(
    depth_m: Float32Array,
    cameras: tuple[CameraCalibration, CameraCalibration],
    color_from_depth: RigidTransform,
    params: OutlineParams,
) -> Outline:
    """Return where near surfaces end, drawn into the colour image.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Bias corrected, metres; NaN where not measured.
    cameras : (CameraCalibration, CameraCalibration)
        Colour and depth.
    """
    color, _ = cameras
    # Nothing measured counts as far; smoothed, the slope points to the near side.
    inverse = np.where(np.isfinite(depth_m), 1.0 / depth_m, 0.0)
    down = ndimage.gaussian_filter(inverse, 2.0, order=(1, 0))
    right = ndimage.gaussian_filter(inverse, 2.0, order=(0, 1))
    points, normals, depths = [], [], []
    for row_step, column_step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        rows, columns = np.nonzero(_ends(depth_m, (row_step, column_step), params))
        outward = -np.stack([right[rows, columns], down[rows, columns]], axis=-1)
        outward /= np.maximum(np.linalg.norm(outward, axis=1), 1e-12)[:, None]
        # Slanting outlines are met from both sides; each step counts where it is the larger part.
        is_own = outward @ (column_step, row_step) > np.sqrt(0.5)
        points.append(
            np.stack([columns + 0.5 * column_step, rows + 0.5 * row_step], axis=-1)[is_own]
        )
        normals.append(outward[is_own])
        depths.append(depth_m[rows, columns][is_own].astype(float))
    pixels, ahead, z_m = np.concatenate(points), np.concatenate(normals), np.concatenate(depths)
    here = _drawn(pixels, z_m, color_from_depth, cameras)
    there = _drawn(pixels + ahead, z_m, color_from_depth, cameras)
    direction = there - here
    direction /= np.maximum(np.linalg.norm(direction, axis=1), 1e-12)[:, None]
    kept = np.isfinite(here + direction).all(axis=1)
    kept &= ((here > 0) & (here < (color.width - 1, color.height - 1))).all(axis=1)
    here = here[kept]
    size = np.array([color.width, color.height]) / N_BLOCKS
    # One column more than there are: neighbours in every direction differ by an odd number.
    block = (here // size).astype(int) @ (1, N_BLOCKS + 1)
    return Outline(here, direction[kept], block.astype(float))


def _ends(depth_m: Float32Array, step: tuple[int, int], params: OutlineParams) -> BoolArray:
    """Say at which pixels the surface ends in the direction of `step`."""
    row_step, column_step = step
    border = max(params.border_px, 1)
    near = depth_m[border:-border, border:-border]
    far = np.full(near.shape, np.nan, np.float32)
    first = None
    for distance in range(1, params.reach_px + 1):
        rows, columns = row_step * distance, column_step * distance
        shifted = _shifted(depth_m, rows, columns, border)
        if first is None:
            first = shifted
        far = np.where(np.isnan(far), shifted, far)
    assert first is not None  # noqa: S101  (the reach is one pixel at least)
    with np.errstate(invalid="ignore"):
        is_step = np.isnan(first) | (first > near + params.step_m)
        is_behind = np.isnan(far) | (far > near + params.step_m)
        ends = np.isfinite(near) & is_step & is_behind
    whole = np.zeros(depth_m.shape, bool)
    whole[border:-border, border:-border] = ends
    return whole


def _shifted(depth_m: Float32Array, rows: int, columns: int, border: int) -> Float32Array:
    """Return the inner part of the image, `rows` and `columns` farther on; NaN outside."""
    height, width = depth_m.shape
    rows_at = np.arange(border, height - border) + rows
    columns_at = np.arange(border, width - border) + columns
    inside = ((rows_at >= 0) & (rows_at < height))[:, None] & (
        (columns_at >= 0) & (columns_at < width)
    )
    taken = depth_m[np.clip(rows_at, 0, height - 1)[:, None], np.clip(columns_at, 0, width - 1)]
    shifted: Float32Array = np.where(inside, taken, np.float32(np.nan))
    return shifted


@lru_cache(maxsize=2)
def _rays(camera: CameraCalibration) -> FloatArray:
    return pixel_rays((camera.height, camera.width), camera.intrinsics, camera.distortion)


def _drawn(
    pixels: FloatArray,
    z_m: FloatArray,
    color_from_depth: RigidTransform,
    cameras: tuple[CameraCalibration, CameraCalibration],
) -> FloatArray:
    """Return where (N, 2) depth pixels with (N,) depths appear in the colour image."""
    color, depth = cameras
    rays = _rays(depth)
    places = [pixels[:, 1], pixels[:, 0]]
    x, y = (ndimage.map_coordinates(rays[..., i], places, order=1, mode="nearest") for i in (0, 1))
    points_m = np.stack([x * z_m, y * z_m, z_m], axis=-1)
    moved_m = color_from_depth.apply(points_m)
    return project_distorted(moved_m, color.intrinsics, color.distortion)
