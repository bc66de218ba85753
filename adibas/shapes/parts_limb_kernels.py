"""The limbs at a core: which two points each could be, and how likely that is."""

import math

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.kernels import compiled
from adibas.shapes.labelling_kernels import LOG_2PI, factor_rows
from adibas.shapes.parts_core_kernels import NEVER, sum_by_kind
from adibas.shapes.parts_types import Limbs, Odds

MOST_CHOICES, N_KEPT = 96, 14
FAR = 12.0
"""Of a component against the best one, in nats: what it says of the outer point counts no more."""
LIKELY = 14.0
"""Components that the core makes less likely than the best one by more nats are left out."""
HARDLY = 25.0
"""How much less likely a kind of posture is of which no component was looked at."""
LEAST_GAIN = -6.0
"""A point that is less likely than a chance one by so much is not looked at."""


@compiled
def place_limb(
    numbers: FloatArray, limbs: Limbs, limb: int, n_kinds: int
) -> tuple[FloatArray, FloatArray]:
    """Return the (K,) log weights of components, each kind's summing to 1, and (K, 6) places."""
    n_components, n_numbers = limbs.core_means.shape[1:]
    weights = np.empty(n_components)
    places = np.empty((n_components, 6))
    off, white = np.empty(n_numbers), np.empty(n_numbers)
    for k in range(n_components):
        weights[k] = limbs.log_weights[limb, k]
        lower = limbs.core_factors[limb, k]
        diagonal = 1.0
        for i in range(n_numbers):
            off[i] = numbers[i] - limbs.core_means[limb, k, i]
            rest = off[i]
            for j in range(i):
                rest -= lower[i, j] * white[j]
            white[i] = rest / lower[i, i]
            weights[k] -= 0.5 * white[i] * white[i]
            diagonal *= lower[i, i]
        weights[k] -= math.log(diagonal)
        for i in range(6):
            places[k, i] = limbs.means[limb, k, i]
            for j in range(n_numbers):
                places[k, i] += limbs.slopes[limb, k, i, j] * off[j]
    totals = np.empty(n_kinds)
    sum_by_kind(weights, limbs.kinds[limb], totals)
    for k in range(n_components):
        weights[k] -= totals[limbs.kinds[limb, k]]
    return weights, places


@compiled
def whiten(point: FloatArray, place: FloatArray, lower: FloatArray, white: FloatArray) -> float:
    """Fill the (3,) whitened offset; return minus the log density, but for its constant."""
    total = 0.0
    for d in range(3):
        off = point[d] - place[d]
        for e in range(d):
            off -= lower[d, e] * white[e]
        white[d] = off / lower[d, d]
        total += 0.5 * white[d] * white[d]
    return float(total + math.log(lower[0, 0] * lower[1, 1] * lower[2, 2]))


@compiled
def whiten_outer(
    point: FloatArray, place: FloatArray, lower: FloatArray, white: FloatArray
) -> float:
    """Return minus the log density of the outer point, given the (3,) whitened inner one."""
    total = 0.0
    a, b = 0.0, 0.0
    for d in range(3, 6):
        off = point[d - 3] - place[d]
        for e in range(3):
            off -= lower[d, e] * white[e]
        if d > 3:  # noqa: PLR2004  (the first of the outer point's coordinates)
            off -= lower[d, 3] * a
        if d > 4:  # noqa: PLR2004
            off -= lower[d, 4] * b
        off /= lower[d, d]
        total += 0.5 * off * off
        if d == 3:  # noqa: PLR2004
            a = off
        else:
            b = off
    return float(total + math.log(lower[3, 3] * lower[4, 4] * lower[5, 5]))


@compiled
def _note(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    logs: FloatArray, kinds: IntArray, first: int, second: int, pairs: IntArray,
    by_kind: FloatArray, count: int,
) -> int:  # fmt: skip
    """Add a choice of points with its (K,) log densities; return how many there are now."""
    best = logs.max()
    if best < LEAST_GAIN or count == len(pairs):
        return count
    sums = np.zeros(by_kind.shape[1])
    for k in range(len(logs)):
        if logs[k] > best - HARDLY:
            sums[kinds[k]] += math.exp(logs[k] - best)
    for q in range(len(sums)):
        by_kind[count, q] = best + math.log(max(sums[q], math.exp(-HARDLY)))
    pairs[count, 0], pairs[count, 1] = first, second
    return count + 1


@compiled
def with_root(lower: FloatArray, of_root: FloatArray, covariance: FloatArray) -> None:
    """Fill the (6, 6) covariance of a factor, where the root is only known so surely (3, 3)."""
    for i in range(6):
        for j in range(i + 1):
            total = of_root[i % 3, j % 3]
            for e in range(j + 1):
                total += lower[i, e] * lower[j, e]
            covariance[i, j], covariance[j, i] = total, total


@compiled
def _widened(
    limbs: Limbs, limb: int, chosen: IntArray, of_root: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the factors of some components, for a root that is only known so surely."""
    factors = limbs.factors[limb][chosen]
    outer_factors = limbs.outer_factors[limb][chosen]
    if of_root[0, 0] == 0.0:
        return factors, outer_factors
    covariance, all_rows = np.empty((6, 6)), np.arange(6)
    for k in range(len(chosen)):
        with_root(factors[k], of_root, covariance)
        factor_rows(covariance, all_rows, factors[k])
        factor_rows(covariance, all_rows[3:], outer_factors[k])
    return factors, outer_factors


@compiled
def list_choices(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    ways: FloatArray,
    is_taken: BoolArray,
    numbers: FloatArray,
    of_core: FloatArray,
    limbs: Limbs,
    limb: int,
    log_unit: float,
    of_root: FloatArray,
    odds: Odds,
    pairs: IntArray,
    by_kind: FloatArray,
) -> int:
    """Fill what a limb's two points could be, and the log odds of each kind; return how many.

    Parameters
    ----------
    ways : (M, 3) array
        From the limb's root, in sizes of the core, mirrored for a right limb.
    is_taken : (M,) bool array
        Points of the core.
    numbers, of_core : (B,) and (kinds,) arrays
        What the limb depends on, and the core's log densities.
    log_unit : float
        Log volume of the room in the core's unit.
    of_root : (3, 3) array
        Covariance of a root without a point, in the unit and mirrored as the ways are; else 0.
    odds : Odds
        For what is known of points beside their places.
    pairs, by_kind : (P, 2) and (P, kinds) arrays
        To fill; -1 for no point.
    """
    weights, places = place_limb(numbers, limbs, limb, len(of_core))
    hopes = weights + of_core[limbs.kinds[limb]]
    chosen = np.flatnonzero(hopes > hopes.max() - LIKELY)
    weights, places = weights[chosen], places[chosen]
    kinds = limbs.kinds[limb][chosen]
    factors, outer_factors = _widened(limbs, limb, chosen, of_root)
    unit = log_unit - 1.5 * LOG_2PI
    n_components = len(weights)
    inner, outer = np.empty(n_components), np.empty(n_components)
    white = np.empty((n_components, 3))
    scratch = np.empty(3)
    pairs[0], by_kind[0] = -1, 0.0
    count = 1
    for j in range(len(ways)):
        if is_taken[j]:
            continue
        for k in range(n_components):
            near = whiten(ways[j], places[k], factors[k], white[k])
            inner[k] = weights[k] + unit - near + odds.label_odds[j, limbs.labels[limb, 0]]
            alone = whiten(ways[j], places[k, 3:], outer_factors[k], scratch)
            outer[k] = weights[k] + unit - alone + odds.label_odds[j, limbs.labels[limb, 1]]
        count = _note(outer, kinds, -1, j, pairs, by_kind, count)
        before = count
        count = _note(inner, kinds, j, -1, pairs, by_kind, count)
        if count > before:
            count = _beyond(
                j,
                inner,
                white,
                ways,
                is_taken,
                places,
                factors,
                kinds,
                unit,
                odds.label_odds[:, limbs.labels[limb, 1]],
                pairs,
                by_kind,
                count,
            )
    return count


@compiled
def _beyond(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    j: int,
    inner: FloatArray,
    white: FloatArray,
    ways: FloatArray,
    is_taken: BoolArray,
    places: FloatArray,
    factors: FloatArray,
    kinds: IntArray,
    unit: float,
    outer_odds: FloatArray,
    pairs: IntArray,
    by_kind: FloatArray,
    count: int,
) -> int:
    """Add the choices in which point j is the inner one and another the outer one.

    `outer_odds` are the (M,) log odds of the outer label beside places.
    """
    logs = np.empty(len(inner))
    best = inner.max()
    for i in range(len(ways)):
        if i == j or is_taken[i]:
            continue
        for k in range(len(inner)):
            logs[k] = NEVER
            if inner[k] > best - FAR:
                cost = whiten_outer(ways[i], places[k], factors[k], white[k])
                logs[k] = inner[k] + unit - cost + outer_odds[i]
        count = _note(logs, kinds, j, i, pairs, by_kind, count)
    return count


@compiled
def mix_kinds(by_kind: FloatArray, share: float) -> None:
    """Give of each choice's (P, kinds) log odds this share to the mean of all kinds.

    Who stands with straight legs may hold the arms as nobody of the training who stood did.
    """
    if share == 0.0:
        return
    n_kinds = by_kind.shape[1]
    for c in range(len(by_kind)):
        highest = by_kind[c].max()
        of_any = 0.0
        for q in range(n_kinds):
            of_any += math.exp(by_kind[c, q] - highest) / n_kinds
        for q in range(n_kinds):
            own = math.exp(by_kind[c, q] - highest)
            by_kind[c, q] = highest + math.log((1.0 - share) * own + share * of_any)


@compiled
def keep_best(
    pairs: IntArray, by_kind: FloatArray, of_core: FloatArray, limb: int, odds: Odds
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the most likely choices, their mixed log odds by kind, and at most what each gains."""
    mix_kinds(by_kind, odds.mixed[limb])
    gains = np.empty(len(pairs))
    likely = np.empty(len(pairs))
    highest = of_core.max()
    for i in range(len(pairs)):
        gains[i] = NEVER
        for q in range(len(of_core)):
            gains[i] = max(gains[i], by_kind[i, q] + of_core[q] - highest)
        likely[i] = -gains[i]
        for d in range(2):
            likely[i] += odds.lone if pairs[i, d] < 0 else 0.0
    order = np.argsort(likely)[:N_KEPT]
    return pairs[order], by_kind[order], gains[order]
