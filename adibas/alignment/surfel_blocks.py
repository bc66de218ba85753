"""Surfels side by side in blocks, so that blocks beside a picture need not be asked one by one.

A block is 256 rows of the map, and has a box that holds their places. Rows are put in the order of
cubes of space now and then; those that were added since lie behind them as frames brought them.
"""

import numpy as np

from adibas.alignment.surfel_kernels import BLOCK
from adibas.arrays import Float32Array, IntArray

CUBE_M = 0.25
"""Some hundred surfels of a surface two metres before a sensor."""
MOST_CUBES = 1 << 16
NOTHING = (np.inf, np.inf, np.inf, -np.inf, -np.inf, -np.inf)
"""The box of a block without surfels."""


def order_by_place(places_m: Float32Array) -> IntArray:
    """Return the numbers of (N, 3) places, cube by cube; in a cube they keep their order.

    Where the space is so wide that cubes could not be counted in 16 bits, which are sorted in no
    time, cubes are larger.
    """
    if not len(places_m):
        return np.empty(0, np.int64)
    least, most = places_m.min(axis=0), places_m.max(axis=0)
    cube_m = CUBE_M
    while (n_cubes := np.floor((most - least) / cube_m) + 1).prod() > MOST_CUBES:
        cube_m *= 1.25
    numbers = np.zeros(len(places_m), np.uint16)
    for axis in range(3):
        numbers *= np.uint16(n_cubes[axis])
        numbers += np.floor((places_m[:, axis] - least[axis]) / np.float32(cube_m)).astype(
            np.uint16
        )
    return np.argsort(numbers, kind="stable")


def boxes_of(places_m: Float32Array, n_rows: int) -> Float32Array:
    """Return the boxes (M, 6) of all blocks of a map with room for `n_rows`.

    A row has the least x, y, z of the block's places, and the largest; `NOTHING` where it has none.
    """
    boxes = np.tile(np.array(NOTHING, np.float32), (-(-n_rows // BLOCK), 1))
    if len(places_m):
        begins = np.arange(0, len(places_m), BLOCK)
        boxes[: len(begins), :3] = np.minimum.reduceat(places_m, begins)
        boxes[: len(begins), 3:] = np.maximum.reduceat(places_m, begins)
    return boxes
