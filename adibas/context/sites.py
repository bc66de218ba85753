"""Occupied cells of a picture, coarser and coarser, and which of them touch.

A network that works on these alone costs what the person takes up, and not what the box around the
person does. Source: Graham, Engelcke and van der Maaten, 3D Semantic Segmentation with Submanifold
Sparse Convolutional Networks, CVPR 2018, section 3.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, Int32Array, check_shape, read_only
from adibas.context.site_kernels import kin_of, neighbors_of, number_cells

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
    maps = [number_cells(level)]
    for _ in range(n_levels - 1):
        level = np.asarray(level.reshape(level.shape[0] // 2, 2, -1, 2).any(axis=(1, 3)))
        maps.append(number_cells(level))
    kin = [kin_of(*fine, *coarse) for fine, coarse in itertools.pairwise(maps)]
    parents = [*(one[0] for one in kin), np.zeros(0, np.int32)]
    children = [np.zeros((0, 4), np.int32), *(one[1] for one in kin)]
    return tuple(
        SiteLevel(neighbors_of(*one), above, below)
        for one, above, below in zip(maps, parents, children, strict=True)
    )
