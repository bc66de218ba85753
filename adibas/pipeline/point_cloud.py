"""The surface of a burst as coloured points, to be looked at from any side."""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.data.calibration import RgbdCalibration
from adibas.data.surface import BurstDisparity
from adibas.geometry.distortion import project_distorted, undistort_pixels


@dataclass(frozen=True, slots=True, eq=False)
class PointCloud:
    """Points of a surface.

    Attributes
    ----------
    points_m : (N, 3) array
        In the colour camera's axes.
    colors_rgb : (N, 3) uint8 array
        Of the picture at each point.
    """

    points_m: FloatArray
    colors_rgb: UInt8Array


def surface_points(
    surface: BurstDisparity,
    calibration: RgbdCalibration,
    picture_rgb: UInt8Array,
    most_points: int = 50_000,
) -> PointCloud:
    """Return the measured surface in the colour camera's axes, with the picture's colours.

    Parameters
    ----------
    surface : BurstDisparity
        Of the depth camera, bias corrected.
    calibration : RgbdCalibration
        With both cameras.
    picture_rgb : (H, W, 3) array
        Of the same burst. Points beside it are left out; a point that the colour camera does not
        see has the colour of what hides it.
    most_points : int
        Rows and columns are left out evenly until there are no more pixels than this.
    """
    if calibration.color is None or calibration.depth is None:
        raise ValueError("a point cloud needs both cameras")
    step = max(1, math.ceil(math.sqrt(surface.mean_per_m.size / most_points)))
    per_m = surface.mean_per_m[::step, ::step]
    rows, columns = np.nonzero(per_m > 0)  # NaN is no more than anything
    z_m = 1.0 / per_m[rows, columns].astype(float)
    pixels = np.stack([columns, rows], axis=-1).astype(float) * step
    depth = calibration.depth
    rays = undistort_pixels(pixels, depth.intrinsics, depth.distortion)
    points_m = np.concatenate([rays * z_m[:, None], z_m[:, None]], axis=1)
    return _colored(calibration.color_from_depth.apply(points_m), calibration, picture_rgb)


def _colored(
    points_m: FloatArray, calibration: RgbdCalibration, picture_rgb: UInt8Array
) -> PointCloud:
    color = calibration.color
    if color is None:
        raise ValueError("colours need the colour camera")
    places = project_distorted(points_m, color.intrinsics, color.distortion)
    is_known = np.isfinite(places).all(axis=1)
    u, v = np.rint(places[is_known]).astype(np.int64).T
    height, width = picture_rgb.shape[:2]
    is_inside = (u >= 0) & (u < width) & (v >= 0) & (v < height)
    return PointCloud(
        np.ascontiguousarray(points_m[is_known][is_inside]),
        np.ascontiguousarray(picture_rgb[v[is_inside], u[is_inside]]),
    )
