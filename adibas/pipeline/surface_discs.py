"""The surface of a burst as coloured discs, to be looked at from any side."""

import math

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, UInt8Array
from adibas.body.grid_kernels import grid_normals
from adibas.data.calibration import RgbdCalibration
from adibas.data.discs import HALF_DIAGONAL, LEAST_FACING, Discs
from adibas.data.surface import BurstDisparity
from adibas.geometry.distortion import project_distorted, undistort_pixels


def surface_discs(
    surface: BurstDisparity,
    calibration: RgbdCalibration,
    picture_rgb: UInt8Array,
    most: int = 100_000,
) -> Discs:
    """Return the measured surface in the colour camera's axes, with the picture's colours.

    Parameters
    ----------
    surface : BurstDisparity
        Of the depth camera, bias corrected.
    calibration : RgbdCalibration
        With both cameras.
    picture_rgb : (H, W, 3) array
        Of the same burst. Discs beside it are left out; one that the colour camera does not see
        has the colour of what hides it.
    most : int
        Rows and columns are left out evenly until there are no more pixels than this.
    """
    if calibration.color is None or calibration.depth is None:
        raise ValueError("coloured discs need both cameras")
    depth, color = calibration.depth, calibration.color
    step = max(1, math.ceil(math.sqrt(surface.mean_per_m.size / most)))
    per_m = surface.mean_per_m[::step, ::step].astype(float)
    rows, columns = np.mgrid[: per_m.shape[0], : per_m.shape[1]] * float(step)
    rays = undistort_pixels(np.stack([columns, rows], -1), depth.intrinsics, depth.distortion)
    points_m, is_known = grid_points(per_m, rays)
    normals, radii_m = grid_discs(points_m, step / depth.intrinsics.fx)
    placed_m = calibration.color_from_depth.apply(points_m[is_known])
    pixels = np.rint(project_distorted(placed_m, color.intrinsics, color.distortion))
    height, width = picture_rgb.shape[:2]
    is_inside = ((pixels >= 0) & (pixels < (width, height))).all(axis=1)  # none for NaN
    columns_px, rows_px = pixels[is_inside].astype(np.int64).T
    turned = normals[is_known][is_inside] @ calibration.color_from_depth.rotation.T
    return Discs(
        placed_m[is_inside].astype(np.float32),
        turned.astype(np.float32),
        radii_m[is_known][is_inside],
        np.ascontiguousarray(picture_rgb[rows_px, columns_px]),
    )


def grid_points(inverse_per_m: FloatArray, rays: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return the (h, w, 3) points of inverse depths (NaN without) and which are known.

    Parameters
    ----------
    inverse_per_m : (h, w) array
    rays : (h, w, 2) array
        Of the pixels, at depth 1.
    """
    is_known = inverse_per_m > 0  # NaN is no more than anything
    z_m = np.full(inverse_per_m.shape, np.nan)
    z_m[is_known] = 1.0 / inverse_per_m[is_known]
    return np.concatenate([rays * z_m[..., None], z_m[..., None]], axis=-1), is_known


def grid_discs(points_m: FloatArray, spacing: float) -> tuple[FloatArray, Float32Array]:
    """Return the normals (NaN where unknown) and radii of discs that cover a grid of points.

    Parameters
    ----------
    points_m : (h, w, 3) array
        In the axes of the camera that saw them; NaN where unknown.
    spacing : float
        Between neighbours, at depth 1.
    """
    normals = grid_normals(points_m)
    distances_m = np.linalg.norm(points_m, axis=-1)
    cosines = np.abs((normals * points_m).sum(axis=-1)) / distances_m
    cosines = np.where(np.isnan(cosines), 1.0, np.maximum(cosines, LEAST_FACING))
    radii_m = HALF_DIAGONAL * spacing * points_m[..., 2] / cosines
    return normals, radii_m.astype(np.float32)
