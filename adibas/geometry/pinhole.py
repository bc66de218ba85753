"""Pin-hole projection between pixels and camera-frame points.

Axes are right-handed: x right, y down, z forward, origin at the optical centre. Pixel (0, 0) is
the centre of the top-left pixel; u counts columns, v counts rows.

Source: thesis, equations 3.1-3.4 (read as ``R p + t``); Hartley & Zisserman, Multiple View
Geometry, 2nd ed., section 6.1.
"""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Focal lengths and principal point of a distortion-free camera, in pixels."""

    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        if not (self.fx > 0 and self.fy > 0):
            raise ValueError(f"focal lengths must be positive: fx={self.fx}, fy={self.fy}")
        if not all(math.isfinite(value) for value in (self.fx, self.fy, self.cx, self.cy)):
            raise ValueError("focal lengths and principal point must be finite")

    def matrix(self) -> FloatArray:
        """Return the (3, 3) matrix K of equation 3.2, without skew."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])


def normalise(pixels: FloatArray, camera: Intrinsics) -> FloatArray:
    """Turn (..., 2) pixels (u, v) into (..., 2) coordinates (x/z, y/z)."""
    u, v = np.moveaxis(np.asarray(pixels, float), -1, 0)
    return np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy], axis=-1)


def denormalise(normalised: FloatArray, camera: Intrinsics) -> FloatArray:
    """Turn (..., 2) coordinates (x/z, y/z) into (..., 2) pixels (u, v)."""
    x, y = np.moveaxis(np.asarray(normalised, float), -1, 0)
    return np.stack([camera.fx * x + camera.cx, camera.fy * y + camera.cy], axis=-1)


def project(points_m: FloatArray, camera: Intrinsics) -> FloatArray:
    """Map camera-frame points to pixels (equations 3.1-3.3, points already in camera axes).

    Parameters
    ----------
    points_m : (..., 3) array
        Camera-frame points in metres; NaN stays NaN.

    Returns
    -------
    pixels : (..., 2) array
        (u, v); NaN for points that are not in front of the camera (z <= 0).
    """
    points_m = np.asarray(points_m, float)
    z_m = np.where(points_m[..., 2] > 0, points_m[..., 2], np.nan)
    return denormalise(points_m[..., :2] / z_m[..., None], camera)


def back_project(depth_m: FloatArray, camera: Intrinsics) -> FloatArray:
    """Turn a depth image into camera-frame points (equation 3.4).

    Parameters
    ----------
    depth_m : (H, W) array
        Distance along z, in metres; NaN where the sensor measured nothing.
    camera : Intrinsics
        Of the camera that took `depth_m`.

    Returns
    -------
    points_m : (H, W, 3) array
        (x, y, z) of every pixel, in metres; NaN where `depth_m` is NaN.
    """
    height, width = depth_m.shape
    x_m = (np.arange(width) - camera.cx) / camera.fx * depth_m
    y_m = ((np.arange(height) - camera.cy) / camera.fy)[:, None] * depth_m
    return np.stack([x_m, y_m, depth_m], axis=-1)
