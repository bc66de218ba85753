"""Projection of one point with its derivatives, compiled.

A camera is seventeen numbers here: fx, fy, cx, cy, skew, then the twelve coefficients of the lens
in OpenCV's order. The model is that of `adibas.geometry.distortion_kernels`.
"""

import math

from adibas.arrays import FloatArray
from adibas.kernels import compiled

N_NUMBERS = 17
LENS = 5
"""Where the lens begins."""


@compiled
def lens_slopes(x: float, y: float, k: FloatArray, by_k: FloatArray) -> tuple[float, float]:
    """Fill the (2, 12) derivatives of the distorted (x, y); return (radial, denominator).

    The denominator is NaN at a pole.
    """
    r2 = x * x + y * y
    r4 = r2 * r2
    r6 = r4 * r2
    denominator = 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]))
    if denominator == 0.0:
        denominator = math.nan
    radial = (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / denominator
    for axis in range(2):
        along = (x if axis == 0 else y) / denominator
        by_k[axis, 0] = along * r2
        by_k[axis, 1] = along * r4
        by_k[axis, 4] = along * r6
        by_k[axis, 5] = -along * radial * r2
        by_k[axis, 6] = -along * radial * r4
        by_k[axis, 7] = -along * radial * r6
        by_k[axis, 8] = r2 if axis == 0 else 0.0
        by_k[axis, 9] = r4 if axis == 0 else 0.0
        by_k[axis, 10] = 0.0 if axis == 0 else r2
        by_k[axis, 11] = 0.0 if axis == 0 else r4
    by_k[0, 2] = 2.0 * x * y
    by_k[0, 3] = r2 + 2.0 * x * x
    by_k[1, 2] = r2 + 2.0 * y * y
    by_k[1, 3] = 2.0 * x * y
    return radial, denominator


@compiled
def distorted_with_slopes(
    x: float, y: float, k: FloatArray, by_k: FloatArray, by_xy: FloatArray
) -> tuple[float, float]:
    """Distort (x, y); fill the (2, 12) derivatives by the lens and the (2, 2) by (x, y)."""
    radial, denominator = lens_slopes(x, y, k, by_k)
    r2 = x * x + y * y
    numerator_slope = k[0] + r2 * (2.0 * k[1] + r2 * 3.0 * k[4])
    denominator_slope = k[5] + r2 * (2.0 * k[6] + r2 * 3.0 * k[7])
    slope = 2.0 * (numerator_slope - radial * denominator_slope) / denominator
    prism_x = 2.0 * (k[8] + 2.0 * k[9] * r2)
    prism_y = 2.0 * (k[10] + 2.0 * k[11] * r2)
    cross = x * y * slope + 2.0 * k[2] * x + 2.0 * k[3] * y
    by_xy[0, 0] = radial + x * x * slope + 2.0 * k[2] * y + 6.0 * k[3] * x + prism_x * x
    by_xy[0, 1] = cross + prism_x * y
    by_xy[1, 0] = cross + prism_y * x
    by_xy[1, 1] = radial + y * y * slope + 6.0 * k[2] * y + 2.0 * k[3] * x + prism_y * y
    out_x = x * radial + k[2] * by_k[0, 2] + k[3] * by_k[0, 3] + r2 * (k[8] + k[9] * r2)
    out_y = y * radial + k[2] * by_k[1, 2] + k[3] * by_k[1, 3] + r2 * (k[10] + k[11] * r2)
    return out_x, out_y


@compiled
def project_with_slopes(
    point_m: FloatArray, camera: FloatArray, by_camera: FloatArray, by_point: FloatArray
) -> tuple[float, float]:
    """Project (x, y, z), z > 0; fill the (2, 17) derivatives by the camera, (2, 3) by the point."""
    x, y = point_m[0] / point_m[2], point_m[1] / point_m[2]
    # The bends by the lens go where those by the camera's lens will be.
    by_lens = by_camera[:, 5:]
    by_xy = by_point[:, :2]
    bent_x, bent_y = distorted_with_slopes(x, y, camera[5:], by_lens, by_xy)
    fx, fy, skew = camera[0], camera[1], camera[4]
    for i in range(12):
        by_lens[0, i] = fx * by_lens[0, i] + skew * by_lens[1, i]
        by_lens[1, i] *= fy
    for i in range(2):
        by_point[0, i] = (fx * by_xy[0, i] + skew * by_xy[1, i]) / point_m[2]
        by_point[1, i] = fy * by_xy[1, i] / point_m[2]
    for axis in range(2):
        by_point[axis, 2] = -(x * by_point[axis, 0] + y * by_point[axis, 1])
        for i in range(5):
            by_camera[axis, i] = 0.0
    by_camera[0, 0] = bent_x
    by_camera[0, 2] = 1.0
    by_camera[0, 4] = bent_y
    by_camera[1, 1] = bent_y
    by_camera[1, 3] = 1.0
    return fx * bent_x + skew * bent_y + camera[2], fy * bent_y + camera[3]


@compiled
def project_all_with_slopes(
    points_m: FloatArray,
    camera: FloatArray,
    by_camera: FloatArray,
    by_point: FloatArray,
    pixels: FloatArray,
) -> None:
    """Project (N, 3) points; fill (N, 2, 17), (N, 2, 3) and (N, 2)."""
    for i in range(points_m.shape[0]):
        u, v = project_with_slopes(points_m[i], camera, by_camera[i], by_point[i])
        pixels[i, 0] = u
        pixels[i, 1] = v
