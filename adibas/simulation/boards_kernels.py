"""Painting boards and shapes, row by row: which pixels lie within one shade, which see a border."""

import math
from typing import NamedTuple

import numpy as np

from adibas.arrays import Float32Array, FloatArray, IntArray
from adibas.kernels import compiled
from adibas.simulation.boards_integral_kernels import Sheet, seen_shares

BLOCK = 12
"""Pixels each way that are looked at together."""

BEFORE, AFTER = -3, 1000
STRIDE = 4096
HALF = STRIDE * 2048
MARGIN, OUTSIDE, NOWHERE = 4 * HALF, 8 * HALF, 12 * HALF
"""Numbers of regions: column * `STRIDE` + row in the pattern, more than those outside it."""


class Shapes(NamedTuple):
    """Rounded strokes on a plane, such as hands on a board; lengths in the plane's unit.

    Attributes
    ----------
    plane : (3, 3) float64 array
        As of `Sheet`.
    strokes : (N, 5) float64 array
        Both ends (X, Y) and the radius; a later stroke lies over an earlier one.
    shades : (N, C) float64 array
        What each gives back, in every channel.
    """

    plane: FloatArray
    strokes: FloatArray
    shades: FloatArray


@compiled
def meet_row(rays: FloatArray, v: int, box: IntArray, plane: FloatArray, met: FloatArray) -> None:
    """Write X and Y (2, n) where the rays of row `v` of the pixels' corners meet the plane.

    Both are NaN where a ray does not meet it in front of the camera.
    """
    for i in range(met.shape[1]):
        x, y = rays[v, box[2] + i, 0], rays[v, box[2] + i, 1]
        inverse_z = plane[2, 0] * x + plane[2, 1] * y + plane[2, 2]
        z = 1.0 / inverse_z if inverse_z > 0.0 else math.nan
        met[0, i] = (plane[0, 0] * x + plane[0, 1] * y + plane[0, 2]) * z
        met[1, i] = (plane[1, 0] * x + plane[1, 1] * y + plane[1, 2]) * z


@compiled
def _zone(x: float, last: float, margin: float) -> int:
    """Return the square along one axis, or one of the four zones before and after the pattern."""
    if x < -1.0:
        return BEFORE if x < -1.0 - margin else BEFORE + 1
    if x >= last:
        return AFTER if x >= last + margin else AFTER - 1
    return math.floor(x)


@compiled
def _find_regions(met: FloatArray, sheet: Sheet, regions: IntArray) -> None:
    """Write in which region of one shade the points of a row lie; each region is convex."""
    for i in range(regions.shape[0]):
        x, y = met[0, i], met[1, i]
        if math.isnan(x):
            regions[i] = NOWHERE
            continue
        column = _zone(x, sheet.last[0], sheet.margin)
        row = _zone(y, sheet.last[1], sheet.margin)
        is_pattern = -1 <= column < AFTER - 1 and -1 <= row < AFTER - 1
        if is_pattern:
            regions[i] = column * STRIDE + row
        elif column in (BEFORE, AFTER) or row in (BEFORE, AFTER):
            regions[i] = OUTSIDE + (row if column not in (BEFORE, AFTER) else column * STRIDE)
        else:
            in_columns = -1 <= column < AFTER - 1
            regions[i] = MARGIN + (row if in_columns else column * STRIDE)


@compiled
def _ink_of(region: int, sheet: Sheet) -> float:
    """Return ink (1) or paper (0) of a whole region; NaN where that is not all: a dot is in it."""
    if region >= MARGIN - HALF:
        return 0.0
    column = (region + STRIDE // 2) // STRIDE
    row = region - column * STRIDE
    for i in range(sheet.dots.shape[0]):
        if math.floor(sheet.dots[i, 0]) == column and math.floor(sheet.dots[i, 1]) == row:
            return math.nan
    return 1.0 if (column + row) % 2 == 0 else 0.0


@compiled
def _corners_of(above: FloatArray, below: FloatArray, i: int, corners: FloatArray) -> None:
    """Gather a pixel's corners, in turn."""
    for axis in range(2):
        corners[0, axis] = above[axis, i]
        corners[1, axis] = above[axis, i + 1]
        corners[2, axis] = below[axis, i + 1]
        corners[3, axis] = below[axis, i]


@compiled
def _lay(covered: float, ink: float, shades: FloatArray, pixel: Float32Array) -> None:
    for channel in range(pixel.shape[0]):
        paint = (covered - ink) * shades[0, channel] + ink * shades[1, channel]
        pixel[channel] = (1.0 - covered) * pixel[channel] + paint


@compiled
def _paint_part(rays: FloatArray, sheet: Sheet, box: IntArray, canvas: Float32Array) -> None:
    """Lay a board over a part of the canvas, pixel by pixel; see `paint_sheet`."""
    corners = np.empty((4, 2))
    above, below = np.empty((2, 2, box[3] - box[2] + 1))
    over, under = np.empty((2, box[3] - box[2] + 1), np.int64)
    meet_row(rays, box[0], box, sheet.plane, above)
    _find_regions(above, sheet, over)
    known, ink_of_known = NOWHERE, 0.0
    for v in range(box[0], box[1]):
        meet_row(rays, v + 1, box, sheet.plane, below)
        _find_regions(below, sheet, under)
        for i in range(box[3] - box[2]):
            region = over[i]
            is_one = region == over[i + 1] and region == under[i] and region == under[i + 1]
            if is_one and region >= OUTSIDE - HALF:
                continue
            if max(region, over[i + 1], under[i], under[i + 1]) == NOWHERE:
                continue
            if is_one and region != known:
                known, ink_of_known = region, _ink_of(region, sheet)
            covered, ink = 1.0, ink_of_known
            if not is_one or math.isnan(ink):
                _corners_of(above, below, i, corners)
                covered, ink = seen_shares(corners, sheet)
            _lay(covered, ink, sheet.shades, canvas[v, box[2] + i])
        above, below = below, above
        over, under = under, over


@compiled
def _steps(first: int, last: int) -> IntArray:
    """Return where blocks begin from `first` on, and `last`."""
    n = (last - first + BLOCK - 1) // BLOCK
    steps = np.empty(n + 1, np.int64)
    for i in range(n):
        steps[i] = first + i * BLOCK
    steps[n] = last
    return steps


@compiled
def paint_sheet(rays: FloatArray, sheet: Sheet, box: IntArray, canvas: Float32Array) -> None:
    """Lay a board over the (H, W, C) `canvas`.

    `rays` are those of the pixels' corners, (H + 1, W + 1, 2); `box` is the first row, the row
    after the last, and the same of columns, of what may show it. Regions are convex: a block of
    pixels whose corners lie in one region lies in it as a whole.
    """
    rows, columns = _steps(box[0], box[1]), _steps(box[2], box[3])
    knots = np.empty((len(rows), len(columns), 2))
    for i in range(len(rows)):
        for k in range(len(columns)):
            knots[i, k] = rays[rows[i], columns[k]]
    met = np.empty((2, len(columns)))
    regions = np.empty((len(rows), len(columns)), np.int64)
    whole = np.array([0, len(rows) - 1, 0, len(columns) - 1])
    for i in range(len(rows)):
        meet_row(knots, i, whole, sheet.plane, met)
        _find_regions(met, sheet, regions[i])
    for i in range(len(rows) - 1):
        for k in range(len(columns) - 1):
            block = np.array([rows[i], rows[i + 1], columns[k], columns[k + 1]])
            _paint_block(rays, sheet, block, regions[i : i + 2, k : k + 2], canvas)


@compiled
def _paint_block(
    rays: FloatArray, sheet: Sheet, box: IntArray, regions: IntArray, canvas: Float32Array
) -> None:
    """Lay a board over one block whose (2, 2) corners lie in `regions`."""
    region = regions[0, 0]
    is_one = region == regions[0, 1] and region == regions[1, 0] and region == regions[1, 1]
    ink = _ink_of(region, sheet) if is_one and region < OUTSIDE - HALF else math.nan
    if math.isnan(ink):
        _paint_part(rays, sheet, box, canvas)
        return
    for v in range(box[0], box[1]):
        for u in range(box[2], box[3]):
            _lay(1.0, ink, sheet.shades, canvas[v, u])


@compiled
def stroke_distance(x: float, y: float, stroke: FloatArray) -> float:
    """Return how far (x, y) lies outside a rounded stroke; negative inside."""
    along_x, along_y = stroke[2] - stroke[0], stroke[3] - stroke[1]
    length2 = along_x * along_x + along_y * along_y
    share = 0.0
    if length2 > 0.0:
        share = ((x - stroke[0]) * along_x + (y - stroke[1]) * along_y) / length2
        share = min(max(share, 0.0), 1.0)
    distance = math.hypot(x - stroke[0] - share * along_x, y - stroke[1] - share * along_y)
    return float(distance - stroke[4])


@compiled
def paint_shapes(rays: FloatArray, shapes: Shapes, box: IntArray, canvas: Float32Array) -> None:
    """Lay strokes over the (H, W, C) `canvas`, their borders smoothed over a pixel."""
    n_columns = box[3] - box[2]
    if n_columns <= 0:
        return
    above, below = np.empty((2, 2, n_columns + 1))
    meet_row(rays, box[0], box, shapes.plane, above)
    for v in range(box[0], box[1]):
        meet_row(rays, v + 1, box, shapes.plane, below)
        middle = n_columns // 2
        # One size of pixels for a whole row: a soft border needs no more.
        across = below[0, middle + 1] - above[0, middle]
        down = below[1, middle + 1] - above[1, middle]
        pixel = max(math.hypot(across, down) / math.sqrt(2.0), 1e-12)
        for i in range(n_columns):
            x, y = 0.5 * (above[0, i] + below[0, i + 1]), 0.5 * (above[1, i] + below[1, i + 1])
            for k in range(shapes.strokes.shape[0]):
                outside = stroke_distance(x, y, shapes.strokes[k])
                if not outside < 0.5 * pixel:
                    continue
                covered = min(0.5 - outside / pixel, 1.0)
                for channel in range(canvas.shape[2]):
                    before = canvas[v, box[2] + i, channel]
                    after = shapes.shades[k, channel]
                    canvas[v, box[2] + i, channel] = before + covered * (after - before)
        above, below = below, above


@compiled
def expose_gray(
    linear: Float32Array,
    camera: FloatArray,
    noise: Float32Array,
    offsets: IntArray,
    image: Float32Array,
) -> None:
    """Turn (H, W) light, 1 = full scale, into the signal of a camera without colour filter.

    `camera` holds full well and read noise in electrons and the share of light lost in the
    corners. Each row takes its normal numbers out of `noise` from its own of `offsets` on.
    """
    height, width = image.shape
    full_well, read = camera[0], camera[1]
    loss = 4.0 * camera[2] / (width * width + height * height)
    for v in range(height):
        start = offsets[v]
        down = (v - 0.5 * (height - 1)) ** 2
        for u in range(width):
            across = (u - 0.5 * (width - 1)) ** 2
            signal = linear[v, u] * (1.0 - loss * (across + down))
            electrons = full_well * min(max(signal, 0.0), 1.2)
            noisy = electrons + math.sqrt(electrons + read * read) * noise[start + u]
            image[v, u] = noisy / full_well
