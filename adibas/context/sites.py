"""Occupied cells of a picture, coarser and coarser, and which of them touch.

A network that works on these alone costs what the person takes up, and not what the box around the
person does. Source: Graham, Engelcke and van der Maaten, 3D Semantic Segmentation with Submanifold
Sparse Convolutional Networks, CVPR 2018, section 3.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from adibas.arrays import BoolArray, Int32Array, IntArray, check_shape, read_only

N_NEIGHBORS = 9
"""Of a cell, itself the fifth among them: rows from the upper one on, columns from the left."""


@dataclass(frozen=True, slots=True, eq=False)
class SiteLevel:
    """The N occupied cells of one level, row by row.

    Where no cell is, the number of cells stands: features have a row of zeros there.

    Attributes
    ----------
    neighbors : (N, 9) int32 array
        Cells that touch.
    parents : (N,) int32 array
        Cells of the next coarser level, each of 2 x 2; (0,) at the coarsest.
    children : (N, 4) int32 array
        Cells of the next finer level; (0, 4) at the finest.
    """

    neighbors: Int32Array
    parents: Int32Array
    children: Int32Array

    def __post_init__(self) -> None:
        check_shape("neighbors", self.neighbors, (None, N_NEIGHBORS))
        check_shape("children", self.children, (None, 4))
        for array in (self.neighbors, self.parents, self.children):
            read_only(array)

    def __len__(self) -> int:
        return len(self.neighbors)


def site_levels(occupied: BoolArray, n_levels: int) -> tuple[SiteLevel, ...]:
    """Return the levels of a picture's cells, the finest first.

    Parameters
    ----------
    occupied : (H, W) bool array
        Cells of the finest level.
    n_levels : int
        Each next one has cells twice as large.
    """
    size = 2 ** (n_levels - 1)
    height, width = (-(-n // size) * size for n in occupied.shape)
    level: BoolArray = np.zeros((height, width), bool)
    level[: occupied.shape[0], : occupied.shape[1]] = occupied
    maps = [_numbered(level)]
    for _ in range(n_levels - 1):
        level = np.asarray(level.reshape(level.shape[0] // 2, 2, -1, 2).any(axis=(1, 3)))
        maps.append(_numbered(level))
    no_parents, no_children = np.zeros(0, np.int32), np.zeros((0, 4), np.int32)
    return tuple(
        SiteLevel(
            _neighbors(one),
            _parents(one, maps[number + 1]) if number + 1 < n_levels else no_parents,
            _children(one, maps[number - 1]) if number else no_children,
        )
        for number, one in enumerate(maps)
    )


class _Numbered(NamedTuple):
    """Numbers of a level's cells, in a picture and as a list of places."""

    numbers: Int32Array
    """(H, W); where no cell is, how many there are."""
    rows: IntArray
    columns: IntArray


def _numbered(occupied: BoolArray) -> _Numbered:
    rows, columns = np.nonzero(occupied)
    numbers = np.full(occupied.shape, len(rows), np.int32)
    numbers[rows, columns] = np.arange(len(rows), dtype=np.int32)
    return _Numbered(numbers, rows, columns)


def _neighbors(level: _Numbered) -> Int32Array:
    framed = np.pad(level.numbers, 1, constant_values=len(level.rows))
    shifts = [(row, column) for row in range(3) for column in range(3)]
    return np.stack(
        [framed[level.rows + row, level.columns + column] for row, column in shifts], axis=1
    )


def _parents(level: _Numbered, coarser: _Numbered) -> Int32Array:
    return np.asarray(coarser.numbers[level.rows // 2, level.columns // 2])


def _children(level: _Numbered, finer: _Numbered) -> Int32Array:
    shifts = [(row, column) for row in range(2) for column in range(2)]
    return np.stack(
        [finer.numbers[2 * level.rows + row, 2 * level.columns + column] for row, column in shifts],
        axis=1,
    )
