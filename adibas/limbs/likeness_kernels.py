"""Loops over labelled pixels: where limbs border on each other, and into what they fall."""

import numpy as np

from adibas.arrays import AnyArray, BoolArray, IntArray
from adibas.kernels import compiled


@compiled
def count_borders(labels: AnyArray, is_usual: BoolArray) -> tuple[int, int, int]:
    """Count pairs of 4-neighbours: with a label each, with two labels, with two unusual ones.

    Parameters
    ----------
    labels : (H, W) integer array
        Negative where there is none.
    is_usual : (L, L) bool array
        Which labels lie side by side on a body.
    """
    height, width = labels.shape
    n_pairs = n_borders = n_odd = 0
    for row in range(height):
        for column in range(width):
            here = labels[row, column]
            if here < 0:
                continue
            for other_row, other_column in ((row, column - 1), (row - 1, column)):
                if other_row < 0 or other_column < 0 or labels[other_row, other_column] < 0:
                    continue
                other = labels[other_row, other_column]
                n_pairs += 1
                n_borders += here != other
                n_odd += not is_usual[here, other]
    return n_pairs, n_borders, n_odd


@compiled
def find_pieces(labels: AnyArray) -> tuple[IntArray, IntArray]:
    """Return the (P,) labels and (P,) pixels of all 8-connected pieces of one label.

    `labels` is an (H, W) integer array, negative where there is none.
    """
    height, width = labels.shape
    is_left = labels >= 0
    waiting = np.empty(labels.size, np.int64)
    of_piece, sizes = np.empty(labels.size, np.int64), np.empty(labels.size, np.int64)
    n_pieces = 0
    for start in range(labels.size):
        if not is_left[start // width, start % width]:
            continue
        label, size = labels[start // width, start % width], 0
        waiting[0], n_waiting = start, 1
        is_left[start // width, start % width] = False
        while n_waiting > 0:
            n_waiting -= 1
            row, column = waiting[n_waiting] // width, waiting[n_waiting] % width
            size += 1
            for i in range(max(row - 1, 0), min(row + 2, height)):
                for j in range(max(column - 1, 0), min(column + 2, width)):
                    if is_left[i, j] and labels[i, j] == label:
                        is_left[i, j] = False
                        waiting[n_waiting] = i * width + j
                        n_waiting += 1
        of_piece[n_pieces], sizes[n_pieces] = label, size
        n_pieces += 1
    return of_piece[:n_pieces].copy(), sizes[:n_pieces].copy()
