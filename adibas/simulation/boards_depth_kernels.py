"""Boards and strokes in the ideal depth image; pixels are seen at their centres."""

import math

from adibas.arrays import Float32Array, FloatArray
from adibas.kernels import compiled
from adibas.simulation.boards_integral_kernels import Sheet
from adibas.simulation.boards_kernels import Shapes, stroke_distance


@compiled
def see_sheet(
    rays: FloatArray,
    sheet: Sheet,
    inverse_depth: Float32Array,
    infrared: Float32Array,
) -> None:
    """Put a board before what is farther, in 1/z and reflectance (H, W).

    `rays` are those of the pixels' centres, (H, W, 2); `Sheet.shades` has one channel.
    """
    plane, last, margin = sheet.plane, sheet.last, sheet.margin
    first = -1.0 - margin
    for v in range(inverse_depth.shape[0]):
        for u in range(inverse_depth.shape[1]):
            x, y = rays[v, u, 0], rays[v, u, 1]
            inverse_m = plane[2, 0] * x + plane[2, 1] * y + plane[2, 2]
            if not inverse_m > inverse_depth[v, u]:
                continue
            column = (plane[0, 0] * x + plane[0, 1] * y + plane[0, 2]) / inverse_m
            row = (plane[1, 0] * x + plane[1, 1] * y + plane[1, 2]) / inverse_m
            if min(column, row) < first or column > last[0] + margin or row > last[1] + margin:
                continue
            in_pattern = min(column, row) > -1.0 and column < last[0] and row < last[1]
            is_dark = in_pattern and (math.floor(column) + math.floor(row)) % 2 == 0
            inverse_depth[v, u] = inverse_m
            infrared[v, u] = sheet.shades[1 if is_dark else 0, 0]


@compiled
def see_shapes(
    rays: FloatArray,
    shapes: Shapes,
    inverse_depth: Float32Array,
    infrared: Float32Array,
) -> None:
    """Put flat strokes before what is farther; `Shapes.shades` has one channel."""
    plane, strokes = shapes.plane, shapes.strokes
    for i in range(strokes.shape[0]):
        x0, y0, x1, y1, radius = strokes[i]
        left, right = min(x0, x1) - radius, max(x0, x1) + radius
        top, bottom = min(y0, y1) - radius, max(y0, y1) + radius
        for v in range(inverse_depth.shape[0]):
            for u in range(inverse_depth.shape[1]):
                x, y = rays[v, u, 0], rays[v, u, 1]
                inverse_m = plane[2, 0] * x + plane[2, 1] * y + plane[2, 2]
                across = plane[0, 0] * x + plane[0, 1] * y + plane[0, 2]
                if not inverse_m > inverse_depth[v, u]:
                    continue
                if across < left * inverse_m or across > right * inverse_m:
                    continue
                down = plane[1, 0] * x + plane[1, 1] * y + plane[1, 2]
                if down < top * inverse_m or down > bottom * inverse_m:
                    continue
                if stroke_distance(across / inverse_m, down / inverse_m, strokes[i]) < 0.0:
                    inverse_depth[v, u] = inverse_m
                    infrared[v, u] = shapes.shades[i, 0]
