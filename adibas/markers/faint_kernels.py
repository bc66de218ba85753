"""How a spot looks from near: full in the middle, and nothing about it goes the other way."""

from adibas.arrays import Float32Array, FloatArray, UInt8Array
from adibas.kernels import compiled

NOTHING, RING, NEAR, GROUP = 0, 1, 2, 3
"""Zones about a group of pixels: far from it, about it, beside it, and itself."""


@compiled
def middle_and_about(
    local: Float32Array,
    zones: UInt8Array,
    at: tuple[int, int],
    surround: FloatArray,
    core: FloatArray,
    weights: FloatArray,
) -> tuple[float, float]:
    """Return how much of its core a spot's middle holds, and how far its ring goes the other way.

    Dots that the mosaic of the camera makes of a seam have the opposite colour beside them, and
    noise is no disc.

    Parameters
    ----------
    local : (H, W, C) array
        Colours about the spot.
    zones : (H, W) array
        `RING` about the spot.
    at : tuple of int
        Row and column of the middle.
    surround, core : (C,) arrays
        0 and 1 of a pixel's share of the core.
    weights : (C,) array
        Of squared differences.

    Returns
    -------
    tuple of float
        Mean share of the nine pixels about the middle; and minus the least share in the ring, at
        least 0.
    """
    axis = weights * (core - surround)
    axis /= max((axis * (core - surround)).sum(), 1e-6)
    total, n_middle, least = 0.0, 0, 0.0
    for row in range(local.shape[0]):
        for column in range(local.shape[1]):
            is_middle = abs(row - at[0]) <= 1 and abs(column - at[1]) <= 1
            if not is_middle and zones[row, column] != RING:
                continue
            share = 0.0
            for channel in range(len(axis)):
                share += (local[row, column, channel] - surround[channel]) * axis[channel]
            if is_middle:
                total += share
                n_middle += 1
            else:
                least = min(least, share)
    return total / max(n_middle, 1), -least
