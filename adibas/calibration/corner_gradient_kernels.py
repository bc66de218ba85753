"""A corner as the point where the lines along all edges about it meet: Foerstner's operator.

The line along an edge through a pixel is normal to the brightness' gradient there; the corner is
the point from which they stray least, each weighed by its gradient's square. A sharp lens gives the
same corner as the model of `corner_fit_kernels`, three times and more as noisy. Under coma they
part: the gradient clings to the steep side of an edge.

What is left open there is done as in OpenCV's `cornerSubPix` and Bouguet's toolbox, so that in
their window corners are theirs, noise and all: a window of whole pixels about the corner, sampled
between the pixels by straight lines, and less weight towards its border.
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
def _sample(grey: UInt8Array, place: FloatArray, patch: FloatArray) -> None:
    """Fill the square `patch`, whose middle is `place`; beyond the image its border goes on."""
    height, width = grey.shape
    reach = patch.shape[0] // 2
    left, top = math.floor(place[0]), math.floor(place[1])
    right_share, down_share = place[0] - left, place[1] - top
    for i in range(patch.shape[0]):
        row = min(max(top + i - reach, 0), height - 1)
        below = min(max(top + i - reach + 1, 0), height - 1)
        for j in range(patch.shape[1]):
            column = min(max(left + j - reach, 0), width - 1)
            beside = min(max(left + j - reach + 1, 0), width - 1)
            above = (1.0 - right_share) * grey[row, column] + right_share * grey[row, beside]
            under = (1.0 - right_share) * grey[below, column] + right_share * grey[below, beside]
            patch[i, j] = (1.0 - down_share) * above + down_share * under


@compiled
def _add_lines(patch: FloatArray, shape: FloatArray, square_share: float, sums: FloatArray) -> None:
    """Fill `sums` with the normal equations of the way from the patch's middle to the corner."""
    sums[:] = 0.0
    area = shape[0] * shape[3] - shape[1] * shape[2]
    middle = patch.shape[0] // 2
    reach = middle - 1
    for i in range(1, patch.shape[0] - 1):
        for j in range(1, patch.shape[1] - 1):
            right, down = j - middle, i - middle
            along = (right * shape[3] - down * shape[2]) / area
            across = (down * shape[0] - right * shape[1]) / area
            if math.hypot(along, across) > square_share:
                continue
            weight = math.exp(-(right * right + down * down) / (reach * reach))
            by_u = 0.5 * (patch[i, j + 1] - patch[i, j - 1])
            by_v = 0.5 * (patch[i + 1, j] - patch[i - 1, j])
            stray = by_u * right + by_v * down
            sums[S_UU] += weight * by_u * by_u
            sums[S_UV] += weight * by_u * by_v
            sums[S_VV] += weight * by_v * by_v
            sums[S_U] += weight * by_u * stray
            sums[S_V] += weight * by_v * stray
            sums[S_SQUARES] += weight * stray * stray
            sums[S_PIXELS] += weight


@compiled
def _meet(grey: UInt8Array, place: FloatArray, shape: FloatArray, limits: FloatArray) -> float:
    """Move `place` (u, v) to the corner; return its standard deviation, NaN without a corner.

    The width of the edges counts as error: on clean images it is too large by half and more.
    """
    sums = np.empty(N_SUMS)
    side = 2 * int(limits[1]) + 3  # the window and the neighbours of its border
    patch = np.empty((side, side))
    for _ in range(MOST_ROUNDS):
        _sample(grey, place, patch)
        _add_lines(patch, shape, limits[0], sums)
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

    `shapes` (N, 16) as those of `corner_fit_kernels`; `limits`: radius in squares, pixels on each
    side of the corner. NaN where there is no corner, or none within a pixel of the start.
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
