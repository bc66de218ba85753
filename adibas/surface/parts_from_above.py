"""What of a horizontal slice hangs together when it is seen from above."""

import numpy as np
from scipy.ndimage import binary_dilation, label

from adibas.arrays import FloatArray, IntArray

ALL_NEIGHBOURS = np.ones((3, 3), np.bool_)


def parts_from_above(flat_m: FloatArray, cell_m: float, n_grown: int) -> IntArray:
    """Return the number of the part of each point (N, 2), from 0 on.

    Parameters
    ----------
    cell_m : float
        Of the picture in which the slice falls apart.
    n_grown : int
        Cells by which points are made larger: those as far apart as twice that, and one, hang
        together.
    """
    cells = np.floor((flat_m - flat_m.min(axis=0)) / cell_m).astype(int) + n_grown
    picture = np.zeros(cells.max(axis=0) + n_grown + 1, np.bool_)
    places = tuple(cells.T)
    picture[places] = True
    numbers, _ = label(binary_dilation(picture, ALL_NEIGHBOURS, n_grown), ALL_NEIGHBOURS)
    return np.asarray(numbers[places] - 1, np.int64)
