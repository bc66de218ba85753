"""Dots in the squares of a grid: the centre has the other colour than what is around it."""

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray

CENTRE = ((0.5, 0.5), (0.42, 0.5), (0.58, 0.5), (0.5, 0.42), (0.5, 0.58))
AROUND = ((0.2, 0.2), (0.2, 0.8), (0.8, 0.2), (0.8, 0.8))
"""Places in a square, inside a dot of a fifth of its side and well outside."""
LEAST_SHARE = 0.25
"""Of the contrast of the board; a blurred dot of few pixels has that."""


def find_dots(
    level: Float32Array, pixels: FloatArray, contrast: float, *, is_origin_dark: bool
) -> BoolArray:
    """Return (R - 1, C - 1) squares with a dot, False where a corner is not known.

    `pixels` (R, C, 2) are corners on `level`, the smoothed image; `contrast` is the board's;
    `is_origin_dark` tells the colour of the square outside the first corner.
    """
    inner = np.stack([_values(level, _at(pixels, place)) for place in CENTRE]).mean(axis=0)
    around = np.stack([_values(level, _at(pixels, place)) for place in AROUND])
    # A dot stands out on every side; an edge or a shadow through the square does not.
    # The square has the colour of the one outside the first corner where row + column is even.
    turn = np.add(*np.indices(inner.shape)) % 2
    to_other_color = np.where(turn == (0 if is_origin_dark else 1), 1.0, -1.0)
    standing_out = (to_other_color * (inner - around)).min(axis=0)
    known: BoolArray = ~np.isnan(standing_out)
    if not known.any():
        return known
    # Blur draws a square's centre out and its corners in; so it does in those without a dot.
    usual = min(float(np.median(standing_out[known])), 0.0)
    has_dot: BoolArray = standing_out > usual + LEAST_SHARE * contrast
    return has_dot


def _at(pixels: FloatArray, place: tuple[float, float]) -> FloatArray:
    """Return (R - 1, C - 1, 2) the place in each square, under its own perspective."""
    down, right = place
    # A square's image is a quadrilateral; the plane's map onto it is known by its four corners.
    first, second = pixels[:-1, :-1], pixels[:-1, 1:]
    third, fourth = pixels[1:, :-1], pixels[1:, 1:]
    a, b, rest = second - fourth, third - fourth, first - second - third + fourth
    area = _cross(a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        g, h = _cross(rest, b) / area, _cross(a, rest) / area
    weight = g * right + h * down + 1.0
    along = (second - first + g[..., None] * second) * right
    below = (third - first + h[..., None] * third) * down
    place_px: FloatArray = (along + below + first) / weight[..., None]
    return place_px


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def _values(level: Float32Array, places: FloatArray) -> FloatArray:
    """Return the level between its pixels at (..., 2) places; NaN outside or unknown."""
    height, width = level.shape
    u, v = places[..., 0], places[..., 1]
    inside = (u >= 0) & (u < width - 1) & (v >= 0) & (v < height - 1)
    u, v = np.where(inside, u, 0.0), np.where(inside, v, 0.0)
    column, row = u.astype(int), v.astype(int)
    right, down = u - column, v - row
    above = level[row, column] * (1 - right) + level[row, column + 1] * right
    below = level[row + 1, column] * (1 - right) + level[row + 1, column + 1] * right
    values: FloatArray = np.where(inside, above * (1 - down) + below * down, np.nan)
    return values
