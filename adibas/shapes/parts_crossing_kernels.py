"""Legs do not go through each other: a way to name points in which they do is hardly the right one.

The limbs of a way are rated one by one, so that two feet could be exchanged for nearly nothing
where somebody stands with the feet close together. How near the bones of both legs come tells that
apart. Arms are not asked: hands and forearms do lie on one another.

Source of the distance: Ericson, Real-time collision detection (2005), section 5.1.9.
"""

import math

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled

TINY = 1e-12


@compiled
def segments_apart(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> float:
    """Return the least distance between the segments from (3,) a to b and from c to d."""
    of_first, of_second, across = b - a, d - c, a - c
    first_m2, second_m2 = (of_first**2).sum(), max((of_second**2).sum(), TINY)
    along_first, along_second = (of_first * across).sum(), (of_second * across).sum()
    shared = (of_first * of_second).sum()
    determinant = first_m2 * second_m2 - shared * shared
    s = 0.0
    if determinant > TINY:
        s = min(max((shared * along_second - along_first * second_m2) / determinant, 0.0), 1.0)
    t = min(max((shared * s + along_second) / second_m2, 0.0), 1.0)
    s = min(max((t * shared - along_first) / max(first_m2, TINY), 0.0), 1.0)
    return float(math.sqrt(((across + s * of_first - t * of_second) ** 2).sum()))


@compiled
def rate_crossings(
    points: FloatArray,
    partners: IntArray,
    legs: IntArray,
    apart_m: float,
    spread_m: float,
    strange: float,
) -> FloatArray:
    """Return by how many nats each of P ways is less likely as its legs go through each other.

    Parameters
    ----------
    points : (M, 3) array
        Metres.
    partners : (P, N) int array
        Of each way the point of each label, -1 for none.
    legs : (2, 3) int array
        The labels of each leg from the hip to the foot.
    apart_m, spread_m : float
        How near the bones may come, and how surely that is known.
    strange : float
        How often they come as near as they like: places are wrong at times.
    """
    nats = np.zeros(len(partners))
    for w in range(len(partners)):
        nearest_m = math.inf
        for i in range(2):
            for j in range(2):
                a, b = partners[w, legs[0, i]], partners[w, legs[0, i + 1]]
                c, d = partners[w, legs[1, j]], partners[w, legs[1, j + 1]]
                # Both thighs begin at the pelvis, as far apart as that is wide.
                if i + j > 0 and min(a, b, c, d) >= 0:
                    away_m = segments_apart(points[a], points[b], points[c], points[d])
                    nearest_m = min(nearest_m, away_m)
        if nearest_m < math.inf:
            is_free = 0.5 * math.erfc((apart_m - nearest_m) / (spread_m * math.sqrt(2.0)))
            nats[w] = -math.log((1.0 - strange) * is_free + strange)
    return nats
