"""How much ink and paper of a board each pixel sees, as exact integrals over the pixel.

A pixel is a small quadrangle on the board. What a board shows is a sum of products s(x) s(y) of
step functions, and of such a product Green's theorem makes an integral along the quadrangle's
sides: the sum of T(x) s(y) dy with T' = s. T is linear and s constant between the lines of the
board, so each side is cut at those lines and every piece is integrated without error.
"""

import math
from typing import NamedTuple

from adibas.arrays import FloatArray
from adibas.kernels import compiled

DOT_SAMPLES = 8
"""Samples of a pixel each way, where it sees the rim of a dot."""


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
def seen_shares(corners: FloatArray, sheet: Sheet) -> tuple[float, float]:
    """Return which share of a pixel is sheet, and which is ink."""
    covered, ink = _shares(corners, sheet)
    for i in range(sheet.dots.shape[0]):
        share = _dot_share(corners, sheet.dots[i])
        if share > 0.0:
            is_dark = (math.floor(sheet.dots[i, 0]) + math.floor(sheet.dots[i, 1])) % 2 == 0
            ink += -share if is_dark else share
    return covered, ink
