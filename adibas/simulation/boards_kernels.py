"""How much ink and paper of a board each pixel sees, as exact integrals over the pixel.

A pixel is a small quadrangle on the board. What a board shows is a sum of products s(x) s(y) of
step functions, and of such a product Green's theorem makes an integral along the quadrangle's
sides: the sum of T(x) s(y) dy with T' = s. T is linear and s constant between the lines of the
board, so each side is cut at those lines and every piece is integrated without error.
"""

import math
from typing import NamedTuple

import numpy as np

from adibas.arrays import Float32Array, FloatArray, IntArray
from adibas.kernels import compiled

DOT_SAMPLES = 8
"""Samples of a pixel each way, where it sees the rim of a dot."""

BLOCK = 12
"""Pixels each way that are looked at together."""

BEFORE, AFTER = -3, 1000
STRIDE = 4096
HALF = STRIDE * 2048
MARGIN, OUTSIDE, NOWHERE = 4 * HALF, 8 * HALF, 12 * HALF
"""Numbers of regions: column * `STRIDE` + row in the pattern, more than those outside it."""


class Sheet(NamedTuple):
    """A board before a camera; lengths in squares, from the first inner corner.

    Attributes
    ----------
    plane : (3, 3) float64 array
        Turns a ray (x/z, y/z, 1) into (X/z, Y/z, 1/z) of the point of the sheet that it meets.
    last : (2,) float64 array
        Where the pattern ends along X and Y; it begins at -1.
    margin : float
        White paper around the pattern.
    dots : (N, 3) float64 array
        Centre and radius of dots, each within a square.
    shades : (2, C) float64 array
        What paper and ink give back, in every channel.
    """

    plane: FloatArray
    last: FloatArray
    margin: float
    dots: FloatArray
    shades: FloatArray


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
def _sign(x: float, last: float) -> float:
    """Return s: +1 and -1 in turn from -1 on, 0 outside the pattern."""
    if x <= -1.0 or x >= last:
        return 0.0
    return 1.0 if math.floor(x) % 2 else -1.0


@compiled
def _sign_integral(x: float, last: float) -> float:
    """Return T, the integral of s from -1 to x."""
    x = min(max(x, -1.0), last)
    cell = math.floor(x)
    return x - cell if cell % 2 else 1.0 - (x - cell)


@compiled
def _side_checker(x0: float, y0: float, x1: float, y1: float, last: FloatArray) -> float:
    """Integrate T(x) s(y) dy from (x0, y0) to (x1, y1)."""
    dx, dy = x1 - x0, y1 - y0
    step_x, step_y = (1.0 if dx > 0.0 else -1.0), (1.0 if dy > 0.0 else -1.0)
    line_x = max(math.floor(x0) + 1.0, -1.0) if dx > 0.0 else min(math.ceil(x0) - 1.0, last[0])
    line_y = max(math.floor(y0) + 1.0, -1.0) if dy > 0.0 else min(math.ceil(y0) - 1.0, last[1])
    total, done = 0.0, 0.0
    while done < 1.0:
        to_x = (line_x - x0) / dx if dx != 0.0 and -1.0 <= line_x <= last[0] else 2.0
        to_y = (line_y - y0) / dy if dy != 0.0 and -1.0 <= line_y <= last[1] else 2.0
        to = min(to_x, to_y, 1.0)
        middle = 0.5 * (done + to)
        value = _sign_integral(x0 + middle * dx, last[0])
        total += value * _sign(y0 + middle * dy, last[1]) * (to - done) * dy
        done = to
        if to_x <= to:
            line_x += step_x
        if to_y <= to:
            line_y += step_y
    return total


@compiled
def _side_rectangle(  # noqa: PLR0913, PLR0917  (kernel: numbers, not boxes)
    x0: float, y0: float, x1: float, y1: float, first: float, last_x: float, last_y: float
) -> float:
    """Integrate min(max(x, first), last) dy over the part of a side with y inside."""
    dy = y1 - y0
    if dy == 0.0:
        return 0.0
    t0, t1 = (first - y0) / dy, (last_y - y0) / dy
    begin, end = max(min(t0, t1), 0.0), min(max(t0, t1), 1.0)
    dx = x1 - x0
    total = 0.0
    while begin < end:
        to = end
        if dx != 0.0:
            for line in (first, last_x):
                t = (line - x0) / dx
                if begin < t < to:
                    to = t
        x = x0 + 0.5 * (begin + to) * dx
        total += min(max(x, first), last_x) * (to - begin) * dy
        begin = to
    return total


@compiled
def _shares(corners: FloatArray, sheet: Sheet) -> tuple[float, float]:
    """Return which share of a pixel is sheet, and which is pattern ink without the dots."""
    area = checker = pattern = paper = 0.0
    last_x, last_y, margin = sheet.last[0], sheet.last[1], sheet.margin
    for i in range(4):
        x0, y0 = corners[i, 0], corners[i, 1]
        x1, y1 = corners[(i + 1) % 4, 0], corners[(i + 1) % 4, 1]
        area += 0.5 * (x0 + x1) * (y1 - y0)
        checker += _side_checker(x0, y0, x1, y1, sheet.last)
        pattern += _side_rectangle(x0, y0, x1, y1, -1.0, last_x, last_y)
        paper += _side_rectangle(x0, y0, x1, y1, -1.0 - margin, last_x + margin, last_y + margin)
    return paper / area, 0.5 * (pattern + checker) / area


@compiled
def _dot_share(corners: FloatArray, dot: FloatArray) -> float:
    """Return which share of a pixel lies within a dot."""
    nearest, farthest = math.inf, 0.0
    for i in range(4):
        distance = math.hypot(corners[i, 0] - dot[0], corners[i, 1] - dot[1])
        nearest, farthest = min(nearest, distance), max(farthest, distance)
    across = math.hypot(corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1])
    if nearest > dot[2] + across:
        return 0.0
    if farthest < dot[2]:
        return 1.0
    inside = 0
    for row in range(DOT_SAMPLES):
        b = (row + 0.5) / DOT_SAMPLES
        for column in range(DOT_SAMPLES):
            a = (column + 0.5) / DOT_SAMPLES
            weights = (1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b
            x, y = -dot[0], -dot[1]
            for i in range(4):
                x += weights[i] * corners[i, 0]
                y += weights[i] * corners[i, 1]
            inside += x * x + y * y <= dot[2] * dot[2]
    return inside / DOT_SAMPLES**2


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
def _seen(corners: FloatArray, sheet: Sheet) -> tuple[float, float]:
    """Return which share of a pixel is sheet, and which is ink."""
    covered, ink = _shares(corners, sheet)
    for i in range(sheet.dots.shape[0]):
        share = _dot_share(corners, sheet.dots[i])
        if share > 0.0:
            is_dark = (math.floor(sheet.dots[i, 0]) + math.floor(sheet.dots[i, 1])) % 2 == 0
            ink += -share if is_dark else share
    return covered, ink


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
                covered, ink = _seen(corners, sheet)
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
