"""The size of markers: a spot that is larger or smaller than all others is hardly one of them.

The appearance term of the thesis (section 6.1.2) for what a marker has beside its place. Nothing is
asked of what size markers have, nor that all have the same: one is compared with each of the others
(a kernel density that leaves out the point itself; Silverman, Density estimation, 1986, 2.4).
"""

import math

import numpy as np

from adibas.arrays import FloatArray, check_shape

SPREAD = 0.12
"""Standard deviation of the logarithm of a measured diameter.

Of 464 simulated stickers it is 0.10, however slantingly they are seen; none is off by more than
0.37.
"""
LOG_RANGE = math.log(60.0 / 4.0)
"""Chance spots have any size that a marker may have: 4 to 60 mm."""
ODD = 0.001
"""How often a marker is of a size that no other has."""
LEAST_KNOWN = 4
"""Fewer sizes tell nothing."""


def size_log_odds(diameters_m: FloatArray) -> FloatArray:
    """Return (M,) log odds that points are markers of one set and not chance spots.

    Parameters
    ----------
    diameters_m : (M,) array
        As measured; NaN where it is not known: such a point has 0.
    """
    known = np.flatnonzero(np.isfinite(diameters_m))
    odds = np.zeros(len(diameters_m))
    if len(known) < LEAST_KNOWN:
        return odds
    logs = np.log(diameters_m[known])
    spread = SPREAD * math.sqrt(2.0)
    kernels = np.exp(-0.5 * ((logs[:, None] - logs) / spread) ** 2)
    np.fill_diagonal(kernels, 0.0)
    density = kernels.sum(axis=1) / (len(known) - 1) / (spread * math.sqrt(2.0 * math.pi))
    odds[known] = np.log((1.0 - ODD) * density * LOG_RANGE + ODD)
    return odds


def with_sizes(masses: FloatArray, log_odds: FloatArray) -> FloatArray:
    """Return the (M, N + 1) probabilities of names, given also (M,) log odds of being a marker.

    The last is that of no name.
    """
    check_shape("log_odds", log_odds, (len(masses),))
    weighed = masses.copy()
    weighed[:, :-1] *= np.exp(log_odds)[:, None]
    return np.asarray(weighed / weighed.sum(axis=1, keepdims=True))
