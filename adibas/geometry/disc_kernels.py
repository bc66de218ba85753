"""Draws discs in parallel projection, as a graphics card would, where there may be none.

Source of the two passes, the second of which blends what lies nearest: M. Botsch, A. Hornung,
M. Zwicker, L. Kobbelt, High-quality surface splatting on today's GPUs, PBG 2005, section 4.
"""

import math
from typing import Any, TypeAlias

import numpy as np

from adibas.arrays import BoolArray, Float32Array, UInt8Array
from adibas.kernels import compiled_fused

LEAST_RADIUS_PX, MOST_RADIUS_PX = 0.75, 40.0
"""A disc that faces the viewer covers the middle of a pixel at least."""
STEEPEST = 4.0
"""Rise of a disc by its way across the picture; steeper ones would be too thin to be seen."""
LIGHT = (-0.30, -0.40, -0.866)
"""Towards the lamp: right, down, away. It stands behind the viewer, above on the left."""
AMBIENT = 0.5
"""Share of the light that comes from everywhere."""
INSIDE = 0.6
"""Share of the light on the side that nobody saw."""
LEAST_WEIGHT = np.float32(0.02)
HALF, ONE = np.float32(0.5), np.float32(1.0)
Number: TypeAlias = float | np.floating[Any]
Disc: TypeAlias = tuple[Number, Number, Number, Number, Number, Number]
"""Right, down and away in pixels; rise to the right and downwards; 1 by the radius squared."""
Window: TypeAlias = tuple[int, int, int, int]
"""First row, one past the last, and the same of columns."""


@compiled_fused
def draw_discs(
    places_px: Float32Array,
    normals: Float32Array,
    radii_px: Float32Array,
    colors_rgb: UInt8Array,
    shape: tuple[int, int],
) -> tuple[UInt8Array, BoolArray, Float32Array]:
    """Draw discs on a picture of (rows, columns).

    Parameters
    ----------
    places_px : (N, 3) float32 array
        Right and down from the picture's corner, and away from the viewer, all in pixels.
    normals : (N, 3) float32 array
        In the same axes, unit length; a disc without (NaN) faces the viewer.
    radii_px : (N,) float32 array
    colors_rgb : (N, 3) uint8 array

    Returns
    -------
    picture_rgb : (H, W, 3) uint8 array
    is_drawn : (H, W) bool array
    nearest_px : (H, W) float32 array
        How far away the nearest disc is at each pixel; infinite where there is none.
    """
    nearest = np.full(shape, np.inf, np.float32)
    sums = np.zeros((*shape, 4), np.float32)
    tilt = np.empty(3, np.float32)
    for is_blending in (False, True):
        for index in range(len(places_px)):
            x, y, z = places_px[index]
            radius = min(max(radii_px[index], LEAST_RADIUS_PX), MOST_RADIUS_PX)
            rows, columns = _covered(y, radius, shape[0]), _covered(x, radius, shape[1])
            if rows[0] >= rows[1] or columns[0] >= columns[1]:
                continue
            window = (*rows, *columns)
            _tilt(normals[index], tilt)
            disc = (x, y, z, tilt[0], tilt[1], np.float32(1.0 / radius**2))
            if is_blending:
                red, green, blue = colors_rgb[index]
                lit = (tilt[2] * red, tilt[2] * green, tilt[2] * blue)
                _blend(disc, window, np.float32(radius), lit, nearest, sums)
            else:
                _bring_near(disc, window, nearest)
    return _blended(sums), sums[..., 3] > 0.0, nearest


@compiled_fused
def _covered(middle_px: float, radius_px: float, size: int) -> tuple[int, int]:
    """Return the first pixel whose middle a disc may cover along a side, and one past the last."""
    first = max(math.ceil(middle_px - radius_px - HALF), 0)
    return first, min(math.floor(middle_px + radius_px - HALF) + 1, size)


@compiled_fused
def _bring_near(disc: Disc, window: Window, nearest: Float32Array) -> None:
    for row in range(window[0], window[1]):
        for column in range(window[2], window[3]):
            share, away = _hit(disc, row, column)
            if share <= ONE:
                nearest[row, column] = min(nearest[row, column], away)


@compiled_fused
def _blend(
    disc: Disc,
    window: Window,
    radius_px: Number,
    lit: tuple[Number, Number, Number],
    nearest: Float32Array,
    sums: Float32Array,
) -> None:
    """Add the colour of a disc where it lies no farther off than a radius behind the nearest."""
    red, green, blue = lit
    for row in range(window[0], window[1]):
        for column in range(window[2], window[3]):
            share, away = _hit(disc, row, column)
            if share <= ONE and away <= nearest[row, column] + radius_px:
                weight = ONE - share + LEAST_WEIGHT
                sums[row, column, 0] += weight * red
                sums[row, column, 1] += weight * green
                sums[row, column, 2] += weight * blue
                sums[row, column, 3] += weight


@compiled_fused
def _hit(disc: Disc, row: int, column: int) -> tuple[Number, Number]:
    """Return how far from a disc's middle a pixel sees it (squared share of its radius), and where.

    The disc holds the pixel where the share is 1 or less.
    """
    x, y, z, rise_across, rise_down, scale = disc
    across, down = np.float32(column) + HALF - x, np.float32(row) + HALF - y
    rise = rise_across * across + rise_down * down
    return (across * across + down * down + rise * rise) * scale, z + rise


@compiled_fused
def _tilt(normal: Float32Array, tilt: Float32Array) -> None:
    """Say how a disc rises away from the viewer, across and down, and how bright it is."""
    across, down, away = normal
    if not math.isfinite(across + down + away):
        tilt[:] = (0.0, 0.0, 1.0)
        return
    tilt[2] = AMBIENT + (1.0 - AMBIENT) * abs(across * LIGHT[0] + down * LIGHT[1] + away * LIGHT[2])
    if away > 0.0:
        tilt[2] *= INSIDE
    level = math.sqrt(across**2 + down**2)
    least = level / STEEPEST
    if abs(away) < least:
        away = least if away > 0.0 else -least
    tilt[0], tilt[1] = -across / away, -down / away


@compiled_fused
def _blended(sums: Float32Array) -> UInt8Array:
    height, width = sums.shape[:2]
    picture = np.zeros((height, width, 3), np.uint8)
    for row in range(height):
        for column in range(width):
            if sums[row, column, 3] > 0.0:
                for channel in range(3):
                    value = sums[row, column, channel] / sums[row, column, 3]
                    picture[row, column, channel] = np.uint8(min(value + 0.5, 255.0))
    return picture
