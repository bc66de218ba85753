"""The loops of a blob beside a border: the two colours about it, and the core's share against both.

Near a collar or a sleeve one colour of the surround is wrong on one side of the marker: cloth that
is not like it is taken for a part of the marker, and the centre moves there by up to a pixel.
"""

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.kernels import compiled
from adibas.markers.quantile_kernels import quantile

FARTHEST = 0.85
"""The search begins at one of the colours beyond this quantile of the distances to the median."""
N_ROUNDS = 5
LEAST_SHARE_OF_RING = 0.12
"""Less of it is no side, but a crease, or another marker."""
LEAST_GAP_LAB = 10.0
LEAST_GAP_IN_SPREADS = 4.0
"""Of the two colours, over the median distance of the ring to them: shading has no two sides."""
LEAST_SINE_SQUARED = 0.1
"""Of the angle at a side between the core and the other side: a marker whose colour is a mixture of
the two sides cannot be told from their border."""


@compiled
def median_color(colors: FloatArray, is_wanted: BoolArray) -> FloatArray:
    """Return the (C,) median of the wanted of (C, N) colours, each channel by itself."""
    median, wanted = np.empty(len(colors)), np.empty(colors.shape[1])
    for channel in range(len(colors)):
        n_wanted = 0
        for i in range(colors.shape[1]):
            if is_wanted[i]:
                wanted[n_wanted] = colors[channel, i]
                n_wanted += 1
        median[channel] = quantile(wanted[:n_wanted], 0.5)
    return median


@compiled
def two_sides(ring: FloatArray, surround: FloatArray, core: FloatArray) -> tuple[FloatArray, bool]:
    """Return the (2, C) colours of the two sides of a border, and whether there are two.

    Parameters
    ----------
    ring : (C, N) array
        Colours about the blob.
    surround, core : (C,) arrays
        Median of the ring, and the blob's own colour.
    """
    sides = np.empty((2, len(ring)))
    if len(ring) == 1 or ring.shape[1] == 0:  # of brightness alone all mixtures look alike
        return sides, False
    sides[1] = ring[:, _is_far(ring, surround).argmax()]
    sides[0] = median_color(ring, _is_far(ring, sides[1]))
    first, second = _squared_distances(ring, sides[0]), _squared_distances(ring, sides[1])
    for _ in range(N_ROUNDS):
        is_second = second < first
        n_second = is_second.sum()
        if min(n_second, len(is_second) - n_second) < LEAST_SHARE_OF_RING * len(is_second):
            return sides, False
        sides[0], sides[1] = median_color(ring, ~is_second), median_color(ring, is_second)
        first, second = _squared_distances(ring, sides[0]), _squared_distances(ring, sides[1])
    spread_squared = quantile(np.minimum(first, second), 0.5)
    return sides, _are_apart(sides, core, spread_squared)


@compiled
def _is_far(colors: FloatArray, color: FloatArray) -> BoolArray:
    """Say which of (C, N) colours are the farthest from one."""
    squared = _squared_distances(colors, color)
    is_far: BoolArray = squared >= quantile(squared.copy(), FARTHEST)
    return is_far


@compiled
def _squared_distances(colors: FloatArray, color: FloatArray) -> FloatArray:
    squared = np.zeros(colors.shape[1])
    for channel in range(len(color)):
        squared += (colors[channel] - color[channel]) ** 2
    return squared


@compiled
def _are_apart(sides: FloatArray, core: FloatArray, spread_squared: float) -> bool:
    to_core, apart = core - sides[0], sides[1] - sides[0]
    gap_squared, reach_squared = (apart * apart).sum(), (to_core * to_core).sum()
    along = (to_core * apart).sum()
    least = max(LEAST_GAP_LAB**2, LEAST_GAP_IN_SPREADS**2 * spread_squared)
    across = gap_squared * reach_squared - along**2
    return bool(gap_squared > least and across > LEAST_SINE_SQUARED * gap_squared * reach_squared)


@compiled
def shares_beside_two(local: Float32Array, sides: FloatArray, core: FloatArray) -> FloatArray:
    """Return the core's share in every pixel of (H, W, C), a mixture of it with both sides.

    By least squares; where that asks for less than nothing of a side, the pixel is a mixture of
    the core with the other side alone.

    Source: Heinz & Chang, Fully constrained least squares linear spectral mixture analysis, 2001.
    """
    first, second, apart = core - sides[0], core - sides[1], sides[1] - sides[0]
    aa, ab, bb = (first * first).sum(), (first * apart).sum(), (apart * apart).sum()
    cc, determinant = (second * second).sum(), aa * bb - ab * ab
    shares = np.empty(local.shape[:2])
    for row in range(local.shape[0]):
        for column in range(local.shape[1]):
            along_first = along_apart = along_second = 0.0
            for channel in range(len(core)):
                value = local[row, column, channel]
                along_first += (value - sides[0, channel]) * first[channel]
                along_apart += (value - sides[0, channel]) * apart[channel]
                along_second += (value - sides[1, channel]) * second[channel]
            share = (along_first * bb - along_apart * ab) / determinant
            of_second = (along_apart * aa - along_first * ab) / determinant
            if of_second < 0.0:
                share = along_first / aa
            elif share < 1.0 < share + of_second:
                share = along_second / cc
            shares[row, column] = share
    return shares


@compiled
def unexplained(ring: FloatArray, surround: FloatArray, core: FloatArray) -> float:
    """Return how much of the core's contrast is no mixture of the surround with a ring's colour.

    A bright wall seen between two fingers ends in a spot, of which all colours lie between the
    skin's and the wall's; and the wall is in the ring.

    Parameters
    ----------
    ring : (C, N) array
        Colours about the blob.
    surround, core : (C,) arrays
        Median of the ring, and the blob's own colour.

    Returns
    -------
    float
        0: all; 1: nothing in the ring is on the way to the core. 1 for brightness alone, of which
        all mixtures look alike.
    """
    contrast_squared = ((core - surround) ** 2).sum()
    if len(core) == 1 or contrast_squared == 0.0:
        return 1.0
    least_squared = contrast_squared
    for i in range(ring.shape[1]):
        length_squared = along = 0.0
        for channel in range(len(core)):
            difference = ring[channel, i] - surround[channel]
            length_squared += difference**2
            along += difference * (core[channel] - surround[channel])
        share = min(max(along / max(length_squared, 1e-9), 0.0), 1.0)
        left_squared = contrast_squared - 2.0 * share * along + share**2 * length_squared
        least_squared = min(least_squared, left_squared)
    return float(np.sqrt(max(least_squared, 0.0) / contrast_squared))
