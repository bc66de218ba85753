"""A corner as the point where the lines along all edges about it meet: Foerstner's operator.

The line along an edge through a pixel is normal to the brightness' gradient there; the corner is
the point from which they stray least, each weighed by its gradient's square. A sharp lens gives the
same corner as the model of `corner_fit_kernels`, three times and more as noisy. Under coma they
part: the gradient clings to the steep side of an edge.
Source: Foerstner and Guelch, A fast operator for detection and precise location of distinct
points, corners and centres of circular features, ISPRS Intercommission Workshop 1987, section 3.
"""

import math

import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.kernels import compiled

N_SUMS = 7
S_UU, S_UV, S_VV, S_U, S_V, S_SQUARES, S_PIXELS = range(N_SUMS)
MOST_ROUNDS = 30
SMALL_STEP_PX = 1e-4
FEWEST_PIXELS = 9
SINGULAR = 1e-6
"""Of the smaller to the larger eigenvalue: one edge alone determines no corner."""


@compiled
def _add_lines(
    grey: UInt8Array, place: FloatArray, shape: FloatArray, limits: FloatArray, sums: FloatArray
) -> None:
    """Fill `sums` with the normal equations of the way from `place` to the corner."""
    sums[:] = 0.0
    area = shape[0] * shape[3] - shape[1] * shape[2]
    column, row, reach = round(place[0]), round(place[1]), int(limits[1] + 1.0)
    for i in range(max(row - reach, 1), min(row + reach + 1, grey.shape[0] - 1)):
        for j in range(max(column - reach, 1), min(column + reach + 1, grey.shape[1] - 1)):
            right, down = j - place[0], i - place[1]
            along = (right * shape[3] - down * shape[2]) / area
            across = (down * shape[0] - right * shape[1]) / area
            if max(abs(along), abs(across)) > limits[0] or math.hypot(right, down) > limits[1]:
                continue
            by_u = 0.5 * (float(grey[i, j + 1]) - float(grey[i, j - 1]))
            by_v = 0.5 * (float(grey[i + 1, j]) - float(grey[i - 1, j]))
            stray = by_u * right + by_v * down
            sums[S_UU] += by_u * by_u
            sums[S_UV] += by_u * by_v
            sums[S_VV] += by_v * by_v
            sums[S_U] += by_u * stray
            sums[S_V] += by_v * stray
            sums[S_SQUARES] += stray * stray
            sums[S_PIXELS] += 1.0


@compiled
def _meet(grey: UInt8Array, place: FloatArray, shape: FloatArray, limits: FloatArray) -> float:
    """Move `place` (u, v) to the corner; return its standard deviation, NaN without a corner.

    The width of the edges counts as error: on clean images it is too large by half and more.
    """
    sums = np.empty(N_SUMS)
    for _ in range(MOST_ROUNDS):
        _add_lines(grey, place, shape, limits, sums)
        uu, uv, vv = sums[S_UU], sums[S_UV], sums[S_VV]
        determinant = uu * vv - uv * uv
        if sums[S_PIXELS] < FEWEST_PIXELS or not determinant > SINGULAR * (uu + vv) ** 2:
            return np.nan
        right = (vv * sums[S_U] - uv * sums[S_V]) / determinant
        down = (uu * sums[S_V] - uv * sums[S_U]) / determinant
        place[0] += right
        place[1] += down
        if math.hypot(right, down) < SMALL_STEP_PX:
            break
    left = max(sums[S_SQUARES] - right * sums[S_U] - down * sums[S_V], 0.0)
    variance = left / (sums[S_PIXELS] - 2.0) * 0.5 * (uu + vv) / determinant
    return math.sqrt(variance)


@compiled
def meet_all(
    grey: UInt8Array, starts: FloatArray, shapes: FloatArray, limits: FloatArray
) -> FloatArray:
    """Return (N, 3) u, v and standard deviation of the corners near `starts` (N, 2).

    `shapes` (N, 16) as those of `corner_fit_kernels`; `limits`: share of a square, pixels from the
    corner. NaN where there is no corner, or none within a pixel of the start.
    """
    result = np.full((len(starts), 3), np.nan)
    for n in range(len(starts)):
        place = starts[n].copy()
        if shapes[n, 0] * shapes[n, 3] == shapes[n, 1] * shapes[n, 2]:
            continue
        deviation_px = _meet(grey, place, shapes[n], limits)
        if np.isnan(deviation_px) or np.abs(place - starts[n]).max() > 1.0:
            continue
        result[n, :2] = place
        result[n, 2] = deviation_px
    return result
