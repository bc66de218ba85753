"""Where a picture has spots, and how they look from near.

A spot is full in the middle, and nothing about it goes the other way.
"""

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray, IntArray, UInt8Array
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


@compiled
def grow_spots(
    rise: Float32Array, least_rise: Float32Array, free: BoolArray, share: float, reach: int
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the pixels about every peak, as `adibas.markers.blobs.connected_groups` does.

    The highest peak comes first; what belongs to one is no peak of its own.

    Parameters
    ----------
    rise : (H, W) array
        By how much each pixel is nearer to the model than what is on all sides of it.
    least_rise : (H, W) array
        Of a peak there.
    free : (H, W) array
        Pixels that may belong to a spot; those on the border of the picture are no peak.
    share : float
        Of the peak's rise: what hangs together with it and has more belongs to it.
    reach : int
        As far as that, in rows and columns.
    """
    peaks = _peaks(rise, least_rise, free)
    is_own = np.zeros(rise.shape, np.bool_)
    rows, columns = np.empty(rise.size, np.int64), np.empty(rise.size, np.int64)
    starts = np.zeros(len(peaks) + 1, np.int64)
    n_spots, n_pixels = 0, 0
    depths = np.empty(len(peaks))
    for i in range(len(peaks)):
        depths[i] = -rise[peaks[i, 0], peaks[i, 1]]
    for i in np.argsort(depths, kind="mergesort"):
        peak = peaks[i, 0], peaks[i, 1]
        if is_own[peak]:
            continue
        into = rows, columns, n_pixels
        n_pixels = _grow(rise, free, is_own, peak, (share, reach), into)
        n_spots += 1
        starts[n_spots] = n_pixels
    return rows[:n_pixels].copy(), columns[:n_pixels].copy(), starts[: n_spots + 1].copy()


@compiled
def _peaks(rise: Float32Array, least_rise: Float32Array, free: BoolArray) -> IntArray:
    """Return (N, 2) rows and columns of what no neighbour is above; the first of equal ones."""
    found = np.empty((rise.size, 2), np.int64)
    n_found = 0
    for row in range(1, rise.shape[0] - 1):
        for column in range(1, rise.shape[1] - 1):
            height = rise[row, column]
            if height <= least_rise[row, column] or not free[row, column]:
                continue
            is_peak = True
            for i in range(row - 1, row + 2):
                for j in range(column - 1, column + 2):
                    is_before = i < row or (i == row and j < column)
                    if rise[i, j] > height or (is_before and rise[i, j] == height):
                        is_peak = False
            if is_peak:
                found[n_found, 0], found[n_found, 1] = row, column
                n_found += 1
    return found[:n_found].copy()


@compiled
def _grow(
    rise: Float32Array,
    free: BoolArray,
    is_own: BoolArray,
    peak: tuple[int, int],
    limits: tuple[float, int],
    into: tuple[IntArray, IntArray, int],
) -> int:
    """Add the pixels of one spot to the lists of rows and columns; return how many there are."""
    (rows, columns, n_pixels), (share, reach) = into, limits
    least = share * rise[peak]
    rows[n_pixels], columns[n_pixels] = peak
    is_own[peak] = True
    next_one, n_pixels = n_pixels, n_pixels + 1
    while next_one < n_pixels:
        row, column = rows[next_one], columns[next_one]
        next_one += 1
        top, left = max(row - 1, peak[0] - reach, 0), max(column - 1, peak[1] - reach, 0)
        bottom = min(row + 2, peak[0] + reach + 1, rise.shape[0])
        right = min(column + 2, peak[1] + reach + 1, rise.shape[1])
        for i in range(top, bottom):
            for j in range(left, right):
                if free[i, j] and not is_own[i, j] and rise[i, j] > least:
                    is_own[i, j] = True
                    rows[n_pixels], columns[n_pixels] = i, j
                    n_pixels += 1
    return n_pixels
