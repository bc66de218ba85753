"""How a faint spot looks from near: full in the middle, and nothing goes the other way."""

import math

from adibas.arrays import Float32Array, FloatArray
from adibas.kernels import compiled

LEAST_RING_PX = 3
MOST_INNER_PX, FARTHEST_PX = 6, 10
"""Of the square ring about a spot, from its centre."""
NEAR_PX = 2
"""Beside the spot: pixels that may hold some of it."""


@compiled
def middle_and_about(
    values: Float32Array,
    at: tuple[int, int],
    n_pixels: int,
    surround: FloatArray,
    core: FloatArray,
    weights: FloatArray,
) -> tuple[float, float]:
    """Return how much of its core a spot's middle holds, and how far its ring goes the other way.

    Dots that the mosaic of the camera makes of a seam have the opposite colour beside them, and
    noise is no disc.

    Parameters
    ----------
    values : (H, W, C) array
        CIELAB.
    at : tuple of int
        Row and column of the spot's centre.
    n_pixels : int
        Of the spot.
    surround, core : (C,) arrays
        0 and 1 of a pixel's share of the core.
    weights : (C,) array
        Of squared differences.

    Returns
    -------
    tuple of float
        Mean share of the nine pixels about the centre; and minus the least share in the ring, at
        least 0.
    """
    axis = weights * (core - surround)
    scale = 1.0 / max((axis * (core - surround)).sum(), 1e-6)
    side = math.sqrt(n_pixels)
    inner = min(0.5 * side, MOST_INNER_PX - NEAR_PX) + NEAR_PX
    outer = min(inner + max(LEAST_RING_PX, round(0.8 * side)), FARTHEST_PX)
    reach = math.floor(outer)
    total, n_middle, least = 0.0, 0, 0.0
    for row in range(max(at[0] - reach, 0), min(at[0] + reach + 1, values.shape[0])):
        for column in range(max(at[1] - reach, 0), min(at[1] + reach + 1, values.shape[1])):
            away = max(abs(row - at[0]), abs(column - at[1]))
            if 1 < away <= inner:
                continue
            share = 0.0
            for channel in range(len(axis)):
                share += (values[row, column, channel] - surround[channel]) * axis[channel] * scale
            if away <= 1:
                total += share
                n_middle += 1
            else:
                least = min(least, share)
    return total / max(n_middle, 1), -least
