"""The size of markers: a spot that is larger or smaller than all others is hardly one of them.

The appearance term of the thesis (section 6.1.2) for what a marker has beside its place. Nothing is
asked of what size markers have, nor surely that all have the same. Either they are of one size, and
each is compared with the middle of the others; or of several, and each is compared with each of the
others (a kernel density that leaves out the point itself; Silverman, Density estimation, 1986,
2.4). How likely either is, the sizes tell (Hoeting et al., Bayesian model averaging, Statistical
Science 14, 1999).
"""

import math

import numpy as np

from adibas.arrays import FloatArray

SPREAD = 0.10
"""Standard deviation of the logarithm of a measured diameter.

Of simulated stickers it is 0.07 to 0.09, of LEDs 0.05 (`adibas benchmark accuracy sizes`).
"""
LOG_RANGE = math.log(60.0 / 4.0)
"""Chance spots have any size that a marker may have: 4 to 60 mm."""
ODD = 0.001
"""How often a marker is of a size that no other has: of 909 simulated ones one was."""
ONE_SIZE = 0.8
"""How often all markers of a set are of one size."""
CHANCE = 0.1
"""How many of the spots are none of the markers, while it is asked whether all have one size."""
WINDOW = 1.5
"""How far beside the middle a size still tells where it is, in `SPREAD`."""
LEAST_OTHERS = 1e-9
N_ROUNDS = 20
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
    one, several = _of_one_size(logs), _of_several(logs)
    lead = _evidence(one) - _evidence(several) + math.log(ONE_SIZE / (1.0 - ONE_SIZE))
    share = 0.5 * (1.0 + math.tanh(0.5 * lead))
    density = share * one + (1.0 - share) * several
    odds[known] = np.log((1.0 - ODD) * density * LOG_RANGE + ODD)
    return odds


def _of_one_size(logs: FloatArray) -> FloatArray:
    """Return the (M,) densities of sizes about the middle of the others."""
    middle = float(np.median(logs))
    for _ in range(N_ROUNDS):
        weights = np.exp(-0.5 * ((logs - middle) / (WINDOW * SPREAD)) ** 2)
        middle = float(weights @ logs / weights.sum())
    n_others = np.maximum(weights.sum() - weights, LEAST_OTHERS)
    middles = (weights @ logs - weights * logs) / n_others
    spreads = SPREAD * np.sqrt(1.0 + 1.0 / n_others)
    density = np.exp(-0.5 * ((logs - middles) / spreads) ** 2)
    return np.asarray(density / (spreads * math.sqrt(2.0 * math.pi)))


def _of_several(logs: FloatArray) -> FloatArray:
    """Return the (M,) densities of sizes that each of the others may have."""
    spread = SPREAD * math.sqrt(2.0)
    kernels = np.exp(-0.5 * ((logs[:, None] - logs) / spread) ** 2)
    np.fill_diagonal(kernels, 0.0)
    density = kernels.sum(axis=1) / (len(logs) - 1)
    return np.asarray(density / (spread * math.sqrt(2.0 * math.pi)))


def _evidence(densities: FloatArray) -> float:
    return float(np.log((1.0 - CHANCE) * densities + CHANCE / LOG_RANGE).sum())
