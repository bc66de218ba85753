"""The last hundredths of a pixel of a grid's corners, each in a window shaped by its neighbours."""

import numpy as np

from adibas.arrays import BoolArray, FloatArray, UInt8Array
from adibas.calibration.corner_fit_kernels import BENDS, DOTS, GAPS, N_UNKNOWNS, P_BLUR1, P_BLUR2
from adibas.calibration.corner_saddle_kernels import CONTRAST, MEAN, SCALE, U, V
from adibas.calibration.corners import CornerMethod, FitParams, fit_corners, meet_corners
from adibas.calibration.grid_growth import Lattice
from adibas.calibration.grid_growth_kernels import expect

FIRST_BLUR = 0.9
"""Of a crossing, in pixels of the level that shows it best; the fit finds the rest."""
NOTICEABLE_PX = 0.0001
"""A curved edge moves the corner less than that: no second fit. A lens bends the edges of all
boards alike, so that even a tenth of a corner's noise would add up to a wrong lens."""
FEWEST_FOR_LIGHT = 6
BLURRED_SHARE = 0.15
"""A blur of so much of a square makes the places of the neighbours matter: a second fit."""


def fit_lattice(
    lattice: Lattice, gray: UInt8Array, dots: BoolArray, params: FitParams
) -> FloatArray:
    """Return (R, C, 3) u, v and standard deviation of the corners; NaN where none is sure.

    `dots` (R - 1, C - 1) are the squares with a dot.
    Curvature from unfitted corners would carry their error into the fit: straight edges first.
    """
    known = ~np.isnan(lattice.fields[..., U])
    lattice = _away_from_dots(lattice, dots)
    light = _light(lattice, dots)
    shapes = _shapes(lattice.pixels, light, known, dots)
    bends = slice(BENDS, BENDS + 2)
    shapes[:, bends] = 0.0
    fitted = fit_corners(gray, _starts(lattice, known, shapes), shapes, params)
    pixels = np.full((*known.shape, 2), np.nan)
    pixels[known] = fitted[:, [U, V]]
    better = _shapes(pixels, light, known, dots)
    reach_px = np.minimum(params.longest_px, params.square_share * _lengths(better))
    needs_more = np.abs(better[:, bends]).max(axis=1) * reach_px**2 / 6.0 > NOTICEABLE_PX
    blur_px = fitted[:, [P_BLUR1, P_BLUR2]].max(axis=1)
    needs_more |= blur_px > BLURRED_SHARE * better[:, GAPS:DOTS].min(axis=1)
    needs_more &= ~np.isnan(fitted[:, U])
    again = fit_corners(gray, fitted[needs_more, :N_UNKNOWNS], better[needs_more], params)
    fitted[needs_more] = again
    places = fitted[:, [U, V, N_UNKNOWNS]]
    if params.method is CornerMethod.GRADIENT:
        is_good = ~np.isnan(places[:, 0])
        places[is_good] = meet_corners(gray, places[is_good, :2], better[is_good], params)
    result = np.full((*known.shape, 3), np.nan)
    result[known] = places
    return result


def _away_from_dots(lattice: Lattice, dots: BoolArray) -> Lattice:
    """Return the lattice with the corners of dotted squares where the others expect them.

    A blurred dot pulls the saddle towards itself, out of reach of the fit.
    """
    is_near = _beside_dots(dots)
    fields = lattice.fields.copy()
    others = lattice.pixels
    others[is_near] = np.nan
    expected = np.empty(6)
    for row, column in np.argwhere(is_near & ~np.isnan(fields[..., U])):
        if expect(others, row, column, expected):
            fields[row, column, [U, V]] = expected[:2]
    return Lattice(fields, lattice.parity)


def _starts(lattice: Lattice, known: BoolArray, shapes: FloatArray) -> FloatArray:
    """Return (N, 9) what `corner_fit_kernels` begins with."""
    fields = lattice.fields[known]
    sign = 1.0 - 2.0 * lattice.is_first_along(np.argwhere(known).astype(np.int32))
    blur_px = FIRST_BLUR * fields[:, SCALE]
    return np.column_stack(
        [
            fields[:, [U, V]],
            np.arctan2(shapes[:, 1], shapes[:, 0]),
            np.arctan2(shapes[:, 3], shapes[:, 2]),
            blur_px,
            blur_px,
            fields[:, MEAN],
            0.5 * sign * fields[:, CONTRAST],
            np.zeros(len(fields)),
        ]
    )


def _shapes(pixels: FloatArray, light: FloatArray, known: BoolArray, dots: BoolArray) -> FloatArray:
    """Return (N, 16) the windows of the known corners by where their neighbours are."""
    (along, along_bend, *along_sides) = _change(pixels, known, axis=1)
    (down, down_bend, *down_sides) = _change(pixels, known, axis=0)
    bends = np.stack(
        [_curvature(along, along_bend, axis=1), _curvature(down, down_bend, axis=0)], axis=-1
    )
    gaps = [_height(side, along) for side in down_sides]
    # Left of an edge that runs down is the previous column.
    gaps += [_height(side, down) for side in reversed(along_sides)]
    wide = np.pad(dots, 1).astype(float)
    around = [wide[:-1, :-1], wide[:-1, 1:], wide[1:, :-1], wide[1:, 1:]]
    area = along[..., 0] * down[..., 1] - along[..., 1] * down[..., 0]
    slopes = [
        (light[..., 0] * down[..., 1] - light[..., 1] * along[..., 1]) / area,
        (light[..., 1] * along[..., 0] - light[..., 0] * down[..., 0]) / area,
    ]
    rest = np.stack(gaps + around + slopes, axis=-1)
    return np.concatenate([along, down, bends, rest], axis=-1)[known]


def _light(lattice: Lattice, dots: BoolArray) -> FloatArray:
    """Return (R, C, 2) the relative change of the light per column and per row.

    That of a plane through the logarithm of the corners' means: bent surfaces follow the dots.
    """
    known = ~np.isnan(lattice.fields[..., MEAN])
    plain = known & ~_beside_dots(dots)
    if np.count_nonzero(plain) >= FEWEST_FOR_LIGHT:
        known = plain
    rows, columns = np.nonzero(known)
    terms = np.column_stack([np.ones(len(rows)), columns, rows])
    values = np.log(np.maximum(lattice.fields[known][:, MEAN], 1.0))
    slopes = np.linalg.lstsq(terms, values, rcond=None)[0][1:]
    return np.broadcast_to(slopes, (*known.shape, 2))


def _beside_dots(dots: BoolArray) -> BoolArray:
    """Return (R, C) which corners belong to a dotted square."""
    wide = np.pad(dots, 1)
    beside: BoolArray = wide[:-1, :-1] | wide[:-1, 1:] | wide[1:, :-1] | wide[1:, 1:]
    return beside


def _height(side: FloatArray, edge: FloatArray) -> FloatArray:
    """Return how far the end of `side` lies from a line along `edge`."""
    area = np.abs(side[..., 0] * edge[..., 1] - side[..., 1] * edge[..., 0])
    height: FloatArray = area / np.linalg.norm(edge, axis=-1)
    return height


def _lengths(shapes: FloatArray) -> FloatArray:
    """Return (N,) the longer side of a square."""
    lengths: FloatArray = np.maximum(
        np.hypot(shapes[:, 0], shapes[:, 1]), np.hypot(shapes[:, 2], shapes[:, 3])
    )
    return lengths


def _change(
    pixels: FloatArray, known: BoolArray, *, axis: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return first and second differences along an axis, the ways to the next, from the previous.

    Without a neighbour the first difference is that of the other side, else the grid's mean, and
    the second is NaN.
    """
    widths = [(1, 1) if axis == n else (0, 0) for n in range(3)]
    wide = np.moveaxis(np.pad(pixels, widths, constant_values=np.nan), axis, 0)
    before, here, after = wide[:-2], wide[1:-1], wide[2:]
    to_next, from_previous = after - here, here - before
    first = 0.5 * (after - before)
    for one_sided in (to_next, from_previous):
        first = np.where(np.isnan(first), one_sided, first)
    has_none = np.isnan(first[..., 0]) & np.moveaxis(known, axis, 0)
    if has_none.any():
        first[has_none] = np.nanmean(first.reshape(-1, 2), axis=0)
    sides = [np.where(np.isnan(side), first, side) for side in (to_next, from_previous)]
    second = to_next - from_previous
    changes = [np.moveaxis(change, 0, axis) for change in (first, second, *sides)]
    return changes[0], changes[1], changes[2], changes[3]


def _curvature(change: FloatArray, bend: FloatArray, *, axis: int) -> FloatArray:
    """Return how fast an edge turns per pixel.

    Where only one neighbour is seen it turns as at that; 0 where that has none either.
    """
    length = np.linalg.norm(change, axis=-1)
    across = change[..., 0] * bend[..., 1] - change[..., 1] * bend[..., 0]
    curvature = np.moveaxis(across / length**3, axis, 0)
    wide = np.pad(curvature, ((1, 1), (0, 0)), constant_values=np.nan)
    for beside in (wide[:-2], wide[2:]):
        curvature = np.where(np.isnan(curvature), beside, curvature)
    filled: FloatArray = np.moveaxis(np.nan_to_num(curvature), 0, axis)
    return filled
