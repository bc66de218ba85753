"""Loops of the registration: project every depth pixel, and draw its footprint.

Compiled for float32 images only. `table` holds, for each depth pixel, its ray turned into the
colour camera's axes (x, y, z for one metre of depth), `camera` the numbers fx, fy, cx, cy of the
colour camera, and `distortion` its twelve coefficients (all 0 where it has none).
"""

import math
from typing import TypeAlias

import numpy as np

from adibas.arrays import Float32Array, Int32Array
from adibas.kernels import compiled

Coefficients: TypeAlias = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float
]

NO_DEPTH = np.float32(np.inf)


@compiled
def distorted(x: float, y: float, k: Coefficients) -> tuple[float, float]:
    """Bend one normalised point by twelve coefficients in OpenCV's order (equations 4.1-4.5)."""
    r2 = x * x + y * y
    radial = (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (
        1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]))
    )
    x_bent = x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x) + r2 * (k[8] + r2 * k[9])
    y_bent = y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y + r2 * (k[10] + r2 * k[11])
    return x_bent, y_bent


@compiled
def project_pixels(
    depth_m: Float32Array,
    table: Float32Array,
    shift_m: Float32Array,
    camera: Float32Array,
    distortion: Coefficients,
) -> Float32Array:
    """Return (3, H, W): colour pixel u, v and depth of every depth pixel; NaN where it has none."""
    height, width = depth_m.shape
    seen = np.empty((3, height, width), np.float32)
    is_bent = False
    for coefficient in distortion:
        is_bent = is_bent or coefficient != 0.0
    for row in range(height):
        for column in range(width):
            z_m = depth_m[row, column]
            z_color_m = z_m * table[row, column, 2] + shift_m[2]
            if not (z_m > 0 and z_color_m > 0):
                seen[2, row, column] = np.nan
                continue
            x = (z_m * table[row, column, 0] + shift_m[0]) / z_color_m
            y = (z_m * table[row, column, 1] + shift_m[1]) / z_color_m
            if is_bent:
                x, y = distorted(x, y, distortion)
            seen[0, row, column] = camera[0] * x + camera[2]
            seen[1, row, column] = camera[1] * y + camera[3]
            seen[2, row, column] = z_color_m
    return seen


@compiled
def nearest_pixels(
    depth_m: Float32Array,
    table: Float32Array,
    shift_m: Float32Array,
    camera: Float32Array,
    shape: tuple[int, int],
) -> Float32Array:
    """Move each depth pixel to the one nearest colour pixel; the nearest surface wins."""
    height, width = depth_m.shape
    registered = np.full(shape, NO_DEPTH, np.float32)
    half = np.float32(0.5)
    for row in range(height):
        for column in range(width):
            z_m = depth_m[row, column]
            z_color_m = z_m * table[row, column, 2] + shift_m[2]
            if not (z_m > 0 and z_color_m > 0):
                continue
            inverse = np.float32(1) / z_color_m
            x = (z_m * table[row, column, 0] + shift_m[0]) * inverse
            y = (z_m * table[row, column, 1] + shift_m[1]) * inverse
            u = camera[0] * x + camera[2] + half
            v = camera[1] * y + camera[3] + half
            if 0 <= u < shape[1] and 0 <= v < shape[0]:
                i, j = int(v), int(u)
                registered[i, j] = min(registered[i, j], z_color_m)
    _mark_missing(registered)
    return registered


@compiled
def draw_footprints(
    seen: Float32Array, spacing: Float32Array, steps: Float32Array, shape: tuple[int, int]
) -> tuple[Float32Array, Int32Array]:
    """Draw every depth pixel as a rectangle that meets those of its neighbours on one surface.

    Parameters
    ----------
    seen : (3, H, W) array
        From `project_pixels`.
    spacing : (2,) array
        Colour pixels from one depth pixel to the next where both look at the same depth.
    steps : (2,) array
        Neighbours on two surfaces differ by more than the first in inverse depth (1/m), and by
        more than the second in depth (m).
    shape : tuple
        Of the colour image.

    Returns
    -------
    depth : array of `shape`
        NaN where nothing was drawn.
    source : int32 array of `shape`
        row * W + column of the depth pixel that was drawn; -1 for none.
    """
    us, vs, zs = seen
    height, width = zs.shape
    depth = np.full(shape, NO_DEPTH, np.float32)
    source = np.full(shape, np.int32(-1), np.int32)
    for row in range(height):
        above, below = max(row - 1, 0), min(row + 1, height - 1)
        for column in range(width):
            u, v, z = us[row, column], vs[row, column], zs[row, column]
            if not z > 0:
                continue
            before, after = max(column - 1, 0), min(column + 1, width - 1)
            limit = max(steps[0] * z * z, steps[1])
            left, right, slope_u = _footprint(
                (us[row, before], u, us[row, after]),
                (zs[row, before], z, zs[row, after]),
                (spacing[0], limit),
            )
            top, bottom, slope_v = _footprint(
                (vs[above, column], v, vs[below, column]),
                (zs[above, column], z, zs[below, column]),
                (spacing[1], limit),
            )
            first, last = max(math.ceil(left), 0), min(math.floor(right), shape[1] - 1)
            at_origin = z - slope_u * u - slope_v * v
            for i in range(max(math.ceil(top), 0), min(math.floor(bottom), shape[0] - 1) + 1):
                at_row = at_origin + slope_v * np.float32(i)
                for j in range(first, last + 1):
                    here = at_row + slope_u * np.float32(j)
                    if here < depth[i, j]:
                        depth[i, j] = here
                        source[i, j] = row * width + column
    _mark_missing(depth)
    return depth, source


@compiled
def _footprint(
    at: tuple[float, float, float], z: tuple[float, float, float], limits: tuple[float, float]
) -> tuple[float, float, float]:
    """Return where the footprint begins and ends along one axis, and the depth's slope there.

    `at` and `z` are pixel and depth of the neighbour before, the pixel itself and the one after.
    """
    slack = 0.03
    spacing, limit = limits
    begin, end = at[1] - 0.5 * spacing, at[1] + 0.5 * spacing
    at_first, z_first, at_last, z_last = at[1], z[1], at[1], z[1]
    if abs(z[0] - z[1]) < limit and at[0] < at[1]:
        begin, at_first, z_first = 0.5 * (at[0] + at[1]), at[0], z[0]
    if abs(z[2] - z[1]) < limit and at[2] > at[1]:
        end, at_last, z_last = 0.5 * (at[2] + at[1]), at[2], z[2]
    slope = (z_last - z_first) / max(at_last - at_first, 0.1)
    return begin - slack, end + slack, slope


@compiled
def _mark_missing(depth: Float32Array) -> None:
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            if depth[i, j] == NO_DEPTH:
                depth[i, j] = np.nan
