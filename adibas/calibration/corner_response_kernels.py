"""Pyramid levels of a grey image, and where they look like a saddle.

A pixel (column, row) of level n lies at 2^n times that in the image: every second pixel is kept,
so no half pixels arise between the levels.
"""

import numpy as np

from adibas.arrays import Float32Array, UInt8Array
from adibas.kernels import compiled

REACH = 2
"""Half the span of a second difference, and the border without a response."""


@compiled
def grey_of(color_rgb: UInt8Array) -> UInt8Array:
    """Return the (H, W) luma of an (H, W, 3) image. Source: ITU-R BT.601, section 2.5.1."""
    height, width = color_rgb.shape[:2]
    grey = np.empty((height, width), np.uint8)
    for row in range(height):
        for column in range(width):
            red = np.uint32(color_rgb[row, column, 0])
            green = np.uint32(color_rgb[row, column, 1])
            blue = np.uint32(color_rgb[row, column, 2])
            grey[row, column] = (19595 * red + 38470 * green + 7471 * blue + 32768) >> 16
    return grey


@compiled
def as_level(grey: UInt8Array) -> Float32Array:
    """Return the image as floats."""
    level = np.empty(grey.shape, np.float32)
    for row in range(grey.shape[0]):
        for column in range(grey.shape[1]):
            level[row, column] = np.float32(grey[row, column])
    return level


@compiled
def smoothed(level: Float32Array) -> Float32Array:
    """Return `level` after the binomial filter 1 4 6 4 1 both ways: a Gaussian of 1 pixel."""
    height, width = level.shape
    result = np.empty((height, width), np.float32)
    line = np.empty(width + 4, np.float32)
    four, six, scale = np.float32(4), np.float32(6), np.float32(1 / 256)
    for row in range(height):
        first, second = level[max(row - 2, 0)], level[max(row - 1, 0)]
        third, here = level[min(row + 2, height - 1)], level[row]
        fourth = level[min(row + 1, height - 1)]
        inner = line[2 : width + 2]
        for column in range(width):
            inner[column] = (
                first[column]
                + third[column]
                + four * (second[column] + fourth[column])
                + six * here[column]
            )
        line[0] = line[1] = line[2]
        line[width + 2] = line[width + 3] = line[width + 1]
        target = result[row]
        for column in range(width):
            target[column] = scale * (
                line[column]
                + line[column + 4]
                + four * (line[column + 1] + line[column + 3])
                + six * line[column + 2]
            )
    return result


@compiled
def halved(level: Float32Array) -> Float32Array:
    """Keep every second pixel both ways."""
    height, width = (level.shape[0] + 1) // 2, (level.shape[1] + 1) // 2
    result = np.empty((height, width), np.float32)
    for row in range(height):
        for column in range(width):
            result[row, column] = level[2 * row, 2 * column]
    return result


@compiled
def saddle_response(level: Float32Array) -> Float32Array:
    """Return minus the Hessian's determinant: positive where the surface is a saddle.

    Second differences over `REACH` pixels; 0 at the border. Source: Beaudet, Rotationally
    invariant image operators, ICPR 1978, equation for DET.
    """
    height, width = level.shape
    response = np.zeros((height, width), np.float32)
    two, quarter = np.float32(2), np.float32(0.25)
    n_columns = width - 2 * REACH
    for row in range(REACH, height - REACH):
        above, here, below = level[row - REACH], level[row], level[row + REACH]
        target = response[row, REACH : width - REACH]
        for i in range(n_columns):
            centre = two * here[i + 2]
            along_u = here[i] + here[i + 4] - centre
            along_v = above[i + 2] + below[i + 2] - centre
            mixed = quarter * (above[i] + below[i + 4] - above[i + 4] - below[i])
            target[i] = mixed * mixed - along_u * along_v
    return response


@compiled
def peaks(response: Float32Array, least: float, largest_number: int) -> Float32Array:
    """Return (N, 2) pixels (u, v) above `least` that no pixel of the 5 x 5 around exceeds.

    Of equals the first; of all the first `largest_number`, row by row.
    """
    height, width = response.shape
    found = np.empty((largest_number, 2), np.float32)
    n_found = 0
    bar = np.float32(least)
    n_columns = width - 2 * REACH
    tops, highest = np.empty(width, np.float32), np.empty(max(n_columns, 0), np.float32)
    for row in range(REACH, height - REACH):
        _highest_around(response, row, tops, highest)
        line = response[row, REACH : width - REACH]
        for i in range(n_columns):
            if line[i] < highest[i] or line[i] <= bar:
                continue
            # Only equals are left to be told apart.
            if not _is_peak(response, row, i + REACH):
                continue
            if n_found == largest_number:
                return found
            found[n_found, 0], found[n_found, 1] = i + REACH, row
            n_found += 1
    return found[:n_found].copy()


@compiled
def _highest_around(
    response: Float32Array, row: int, tops: Float32Array, highest: Float32Array
) -> None:
    """Fill `highest` with the largest of the 5 x 5 around each inner pixel of a row.

    `tops` takes the largest of each column. Comparisons without branches: noise has no pattern
    that a processor could guess.
    """
    first, second, third = response[row - 2], response[row - 1], response[row]
    fourth, fifth = response[row + 1], response[row + 2]
    for column in range(len(tops)):
        upper = max(first[column], second[column], third[column])
        tops[column] = max(fourth[column], fifth[column], upper)
    for i in range(len(highest)):
        left = max(tops[i], tops[i + 1], tops[i + 2])
        highest[i] = max(tops[i + 3], tops[i + 4], left)


@compiled
def _is_peak(response: Float32Array, row: int, column: int) -> bool:
    value = response[row, column]
    for i in range(row - REACH, row + REACH + 1):
        for j in range(column - REACH, column + REACH + 1):
            other = response[i, j]
            is_earlier = i < row or (i == row and j < column)
            if other > value or (other == value and is_earlier):
                return False
    return True
