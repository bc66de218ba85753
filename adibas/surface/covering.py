"""How large discs at the points of a surface must be to leave no gap."""

import numpy as np
from scipy.spatial import cKDTree

from adibas.arrays import Float32Array, FloatArray
from adibas.data.discs import HALF_DIAGONAL

N_BESIDE = 4
"""Neighbours of a point of a square grid, all as far away."""
MOST_M = 0.01
"""Of the radius: a gap that is wider is a place that nobody saw."""


def covering_radii_m(points_m: FloatArray) -> Float32Array:
    """Return the radii (N,) of discs at the points (N, 3) of a surface.

    Points lie as in a grid of squares about each of them, whose side is the way to the fourth
    neighbour.
    """
    if len(points_m) <= N_BESIDE:
        return np.full(len(points_m), MOST_M, np.float32)
    beside = [N_BESIDE + 1]  # the first is the point itself
    away_m = np.asarray(cKDTree(points_m).query(points_m, beside)[0])[:, 0]
    return np.minimum(HALF_DIAGONAL * away_m, MOST_M).astype(np.float32)
