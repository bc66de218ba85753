"""Loops over a picture of cells: their numbers, and whom each of them touches."""

import numpy as np

from adibas.arrays import BoolArray, Int32Array
from adibas.kernels import compiled


@compiled
def number_cells(occupied: BoolArray) -> tuple[Int32Array, int]:
    """Return the (H, W) numbers of cells, row by row, and the number of cells: where none is."""
    height, width = occupied.shape
    n_cells = int(np.count_nonzero(occupied))
    numbers = np.full((height, width), n_cells, np.int32)
    number = 0
    for row in range(height):
        for column in range(width):
            if occupied[row, column]:
                numbers[row, column] = number
                number += 1
    return numbers, n_cells


@compiled
def neighbors_of(numbers: Int32Array, n_cells: int) -> Int32Array:
    """Return the (N, 9) cells that touch each cell; N where none is."""
    height, width = numbers.shape
    neighbors = np.full((n_cells, 9), n_cells, np.int32)
    for row in range(height):
        for column in range(width):
            cell = numbers[row, column]
            if cell == n_cells:
                continue
            for down in range(3):
                for right in range(3):
                    r, c = row + down - 1, column + right - 1
                    if 0 <= r < height and 0 <= c < width:
                        neighbors[cell, 3 * down + right] = numbers[r, c]
    return neighbors


@compiled
def kin_of(
    numbers: Int32Array, n_cells: int, coarser: Int32Array, n_coarser: int
) -> tuple[Int32Array, Int32Array]:
    """Return the (N,) parents of cells, and the (M, 4) children of the coarser level's M cells.

    `coarser` (H / 2, W / 2) are the numbers of that level's cells, each of 2 x 2.
    """
    parents = np.empty(n_cells, np.int32)
    children = np.full((n_coarser, 4), n_cells, np.int32)
    for row in range(numbers.shape[0]):
        for column in range(numbers.shape[1]):
            cell = numbers[row, column]
            if cell < n_cells:
                parent = coarser[row // 2, column // 2]
                parents[cell] = parent
                children[parent, 2 * (row % 2) + column % 2] = cell
    return parents, children
