"""Where a grid expects its corners, from those around: a quadratic surface over rows and columns.

Perspective and lens are smooth over a few squares, so no model of either is needed.
"""

import math

import numpy as np

from adibas.arrays import FloatArray, Int32Array
from adibas.calibration.corner_saddle_kernels import FIRST_RAD, SECOND_RAD, U, V
from adibas.geometry.cholesky_kernels import factorise, solve_factorised
from adibas.kernels import compiled

REACH = 2
N_TERMS = 6
STIFFNESS = 0.1
"""Ridge on the bend and the twist; few neighbours on one side would leave them free."""
FEWEST = 4
ASIDE_RAD = math.radians(25.0)


@compiled
def expect(pixels: FloatArray, row: int, column: int, expected: FloatArray) -> bool:
    """Fill `expected` (6,) with u, v, its change per column and per row at a cell; False: unknown.

    From the cells within `REACH`, NaN where not known, without the cell itself.
    """
    normal = np.zeros((N_TERMS, N_TERMS))
    right = np.zeros((2, N_TERMS))
    n_known = 0
    for i in range(max(row - REACH, 0), min(row + REACH + 1, pixels.shape[0])):
        for j in range(max(column - REACH, 0), min(column + REACH + 1, pixels.shape[1])):
            if not ((i == row and j == column) or np.isnan(pixels[i, j, 0])):
                n_known += 1
                _add_cell(normal, right, (i - row, j - column), pixels[i, j])
    return n_known >= FEWEST and _solve(normal, right, expected)


@compiled
def _solve(normal: FloatArray, right: FloatArray, expected: FloatArray) -> bool:
    for k in range(3, N_TERMS):
        normal[k, k] += STIFFNESS
    if not factorise(normal):
        return False
    for axis in range(2):
        solve_factorised(normal, right[axis])
        for k in range(3):
            expected[2 * k + axis] = right[axis, k]
    return True


@compiled
def _add_cell(
    normal: FloatArray, right: FloatArray, offset: tuple[int, int], pixel: FloatArray
) -> None:
    down, along = float(offset[0]), float(offset[1])
    terms = (1.0, along, down, along * along, along * down, down * down)
    weight = 1.0 / (along * along + down * down)
    for i in range(N_TERMS):
        for j in range(N_TERMS):
            normal[i, j] += weight * terms[i] * terms[j]
        right[0, i] += weight * terms[i] * pixel[0]
        right[1, i] += weight * terms[i] * pixel[1]


@compiled
def step_px(expected: FloatArray) -> float:
    """Return how wide a square is there: the lesser height of the parallelogram."""
    right = math.hypot(expected[2], expected[3])
    down = math.hypot(expected[4], expected[5])
    area = abs(expected[2] * expected[5] - expected[3] * expected[4])
    return float(area / max(right, down, 1e-9))


@compiled
def strays(pixels: FloatArray, largest: FloatArray) -> FloatArray:
    """Return (R, C) how far each corner lies from where it is expected, in squares.

    NaN where none is known, infinite where the others do not tell or where that is more than
    `largest` (R, C) and more than at any neighbour.
    """
    rows, columns = pixels.shape[:2]
    result = np.full((rows, columns), np.nan)
    expected = np.empty(6)
    for row in range(rows):
        for column in range(columns):
            if np.isnan(pixels[row, column, 0]):
                continue
            result[row, column] = np.inf
            if expect(pixels, row, column, expected):
                away = math.hypot(
                    pixels[row, column, 0] - expected[0], pixels[row, column, 1] - expected[1]
                )
                result[row, column] = away / max(step_px(expected), 1e-9)
    worst = result.copy()
    for row in range(rows):
        for column in range(columns):
            if largest[row, column] < result[row, column] < np.inf and _is_worst(
                result, row, column
            ):
                worst[row, column] = np.inf
    return worst


@compiled
def _is_worst(result: FloatArray, row: int, column: int) -> bool:
    for i in range(max(row - 1, 0), min(row + 2, result.shape[0])):
        for j in range(max(column - 1, 0), min(column + 2, result.shape[1])):
            if result[row, column] < result[i, j] < np.inf:
                return False
    return True


@compiled
def frontier(pixels: FloatArray, spacious: float) -> tuple[Int32Array, FloatArray]:
    """Return (N, 2) unknown cells beside known ones, and (N, 6) what `expect` says of them.

    Only where a square is at least `spacious` pixels wide.
    """
    rows, columns = pixels.shape[:2]
    cells = np.empty((rows * columns, 2), np.int32)
    expectations = np.empty((rows * columns, 6))
    n = 0
    for row in range(rows):
        for column in range(columns):
            if not np.isnan(pixels[row, column, 0]):
                continue
            if _n_beside(pixels, row, column) == 0:
                continue
            is_told = expect(pixels, row, column, expectations[n])
            if is_told and step_px(expectations[n]) >= spacious:
                cells[n] = row, column
                n += 1
    return cells[:n].copy(), expectations[:n].copy()


@compiled
def _n_beside(pixels: FloatArray, row: int, column: int) -> int:
    n = 0
    for i, j in ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)):
        if 0 <= i < pixels.shape[0] and 0 <= j < pixels.shape[1]:
            n += 0 if np.isnan(pixels[i, j, 0]) else 1
    return n


@compiled
def fits(corner: FloatArray, expected: FloatArray, is_first_along: bool, away: float) -> bool:
    """Return whether `corner` lies within `away` squares of the place, its edges along the grid."""
    distance = math.hypot(corner[U] - expected[0], corner[V] - expected[1])
    if not distance <= away * step_px(expected):
        return False
    along = math.atan2(expected[3], expected[2])
    down = math.atan2(expected[5], expected[4])
    first, second = (along, down) if is_first_along else (down, along)
    return (
        _between_lines(corner[FIRST_RAD], first) <= ASIDE_RAD
        and _between_lines(corner[SECOND_RAD], second) <= ASIDE_RAD
    )


@compiled
def _between_lines(first_rad: float, second_rad: float) -> float:
    half = 0.5 * math.pi
    return abs((first_rad - second_rad + half) % math.pi - half)


@compiled
def choose(
    corners: FloatArray, expectations: FloatArray, is_first_along: Int32Array, away: float
) -> Int32Array:
    """Return (N,) which corner lies nearest to each expectation and fits it; -1: none."""
    chosen = np.full(len(expectations), -1, np.int32)
    for i in range(len(expectations)):
        best = np.inf
        for j in range(len(corners)):
            distance = abs(corners[j, U] - expectations[i, 0])
            distance += abs(corners[j, V] - expectations[i, 1])
            if distance < best and fits(corners[j], expectations[i], is_first_along[i] == 1, away):
                best = distance
                chosen[i] = j
    return chosen
