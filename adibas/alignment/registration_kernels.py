"""Loops of the registration: project every depth pixel, and draw its footprint.

Compiled for float32 images only. `table` holds, for each depth pixel, its ray turned into the
colour camera's axes (x, y, z for one metre of depth), `camera` the numbers fx, fy, cx, cy of the
colour camera, and `distortion` its twelve coefficients (all 0 where it has none).
"""

import numpy as np

from adibas.arrays import Float32Array, Int32Array
from adibas.kernels import compiled

NO_DEPTH = np.float32(np.inf)


@compiled
def distorted(x: float, y: float, k: Float32Array) -> tuple[float, float]:
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
    distortion: Float32Array,
) -> Float32Array:
    """Return (H, W, 3): colour pixel u, v and depth of every depth pixel; NaN where it has none."""
    height, width = depth_m.shape
    seen = np.empty((height, width, 3), np.float32)
    is_bent = np.any(distortion != 0)
    for row in range(height):
        for column in range(width):
            z_m = depth_m[row, column]
            z_color_m = z_m * table[row, column, 2] + shift_m[2]
            if not (z_m > 0 and z_color_m > 0):
                seen[row, column] = np.nan
                continue
            x = (z_m * table[row, column, 0] + shift_m[0]) / z_color_m
            y = (z_m * table[row, column, 1] + shift_m[1]) / z_color_m
            if is_bent:
                x, y = distorted(x, y, distortion)
            seen[row, column, 0] = camera[0] * x + camera[2]
            seen[row, column, 1] = camera[1] * y + camera[3]
            seen[row, column, 2] = z_color_m
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
    for i in range(shape[0]):
        for j in range(shape[1]):
            if registered[i, j] == NO_DEPTH:
                registered[i, j] = np.nan
    return registered


@compiled
def draw_footprints(
    seen: Float32Array, spacing: Float32Array, steps: tuple[float, float], shape: tuple[int, int]
) -> tuple[Float32Array, Int32Array]:
    """Draw every depth pixel as a rectangle that meets those of its neighbours on one surface.

    Parameters
    ----------
    seen : (H, W, 3) array
        From `project_pixels`.
    spacing : (2,) array
        Colour pixels from one depth pixel to the next where both look at the same depth.
    steps : tuple
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
    height, width = seen.shape[:2]
    depth = np.full(shape, np.nan, np.float32)
    source = np.full(shape, np.int32(-1), np.int32)
    for row in range(height):
        for column in range(width):
            u, v, z = seen[row, column]
            if not z > 0:
                continue
            left, right, slope_u = _extent(seen, row, column, 0, spacing[0], steps)
            top, bottom, slope_v = _extent(seen, row, column, 1, spacing[1], steps)
            rows = max(int(np.ceil(top)), 0), min(int(np.floor(bottom)), shape[0] - 1)
            columns = max(int(np.ceil(left)), 0), min(int(np.floor(right)), shape[1] - 1)
            for i in range(rows[0], rows[1] + 1):
                for j in range(columns[0], columns[1] + 1):
                    here = z + slope_u * (j - u) + slope_v * (i - v)
                    if not here >= depth[i, j]:
                        depth[i, j] = here
                        source[i, j] = row * width + column
    return depth, source


@compiled
def _extent(
    seen: Float32Array, row: int, column: int, axis: int, spacing: float, steps: tuple[float, float]
) -> tuple[float, float, float]:
    """Return where the footprint begins and ends along one axis, and the depth's slope there."""
    slack = np.float32(0.03)
    step_per_m, step_m = steps
    half = np.float32(0.5)
    down, across = (0, 1) if axis == 0 else (1, 0)
    z, here = seen[row, column, 2], seen[row, column, axis]
    begin, end = here - half * spacing, here + half * spacing
    z_first, at_first, z_last, at_last = z, here, z, here
    if row - down >= 0 and column - across >= 0:
        other = seen[row - down, column - across, 2]
        at = seen[row - down, column - across, axis]
        if abs(other - z) < max(step_per_m * z * other, step_m) and at < here:
            begin = half * (here + at)
            z_first, at_first = other, at
    if row + down < seen.shape[0] and column + across < seen.shape[1]:
        other = seen[row + down, column + across, 2]
        at = seen[row + down, column + across, axis]
        if abs(other - z) < max(step_per_m * z * other, step_m) and at > here:
            end = half * (here + at)
            z_last, at_last = other, at
    slope = (z_last - z_first) / (at_last - at_first) if at_last > at_first else z * 0
    return begin - slack, end + slack, slope
