"""All ways to give a core its limbs, no point twice: each is one way to name the points.

Limb after limb the ways so far are continued by each of the limb's choices, unless even the best
choices for the limbs still open would leave them too far above the best energy known.
"""

import math

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled
from adibas.shapes.parts_bone_kernels import MOST_ALIKE, rate_sides
from adibas.shapes.parts_core_kernels import (
    NEVER,
    count_named,
    expected_core,
    heading_energy,
    known_rows,
    label_odds_of,
    rate_components,
    sum_by_kind,
    turned_to_mean,
)
from adibas.shapes.parts_limb_kernels import N_KEPT
from adibas.shapes.parts_rootless_kernels import (
    LimbLists,
    alike_components,
    hope_of_rootless,
    list_limbs,
    most_of_rooted,
    regain,
    taken_by,
)
from adibas.shapes.parts_types import Core, Limbs, Odds, Pool

MOST_WAYS = 1000


@compiled
def judge_core(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray, own: IntArray, core: Core, limbs: Limbs, odds: Odds, best: float, pool: Pool
) -> float:  # fmt: skip
    """Add the ways to name the points with this core to the pool; return the lowest energy.

    Where limbs begin at points of the core that are missing, each component says on its own where
    those are: the same way may be there more than once then, and its odds are the sum.

    Parameters
    ----------
    own : (C,) int array
        Point of each label of the core, -1 for none.
    best : float
        Lowest energy that is known.
    """
    moved, angle_rad = turned_to_mean(points, own, core.mean, odds)
    rows, values = known_rows(moved, own)
    logs = rate_components(rows, values, core, odds) + label_odds_of(own, core.labels, odds)
    of_core = np.empty(odds.n_kinds)
    sum_by_kind(logs, core.kinds, of_core)
    offset = heading_energy(-angle_rad, odds)
    is_taken = taken_by(own, len(points))
    n_limbs = len(limbs.roots)
    lists = LimbLists(
        np.full((n_limbs, N_KEPT, 2), -1),
        np.full((n_limbs, N_KEPT, odds.n_kinds), NEVER),
        np.full((n_limbs, N_KEPT), NEVER),
        np.full((n_limbs, N_KEPT, 2), math.nan),
    )
    order = np.argsort(-logs)
    whole, spreads = expected_core(rows, values, own, core, order[0])
    list_limbs(moved, whole, spreads, own, is_taken, of_core, of_core, True, core, limbs, odds,
               lists)  # fmt: skip
    hope = hope_of_rootless(own, limbs, odds)
    if hope == 0.0:
        return _combine(own, of_core, offset, -angle_rad, lists, core, limbs, odds, best, pool)
    least = offset + odds.least_counts[len(own) - count_named(own)] - hope
    lowest = -NEVER
    wholes, all_spreads, by_kinds = alike_components(rows, values, own, logs, order, core, limbs,
                                                     odds)  # fmt: skip
    for group in range(len(wholes)):
        together = by_kinds[group]
        regain(together, lists)
        most = together.max() + most_of_rooted(own, limbs, lists)
        if least - most > min(best, lowest) + odds.gap:
            continue
        list_limbs(moved, wholes[group], all_spreads[group], own, is_taken, of_core, together,
                   False, core, limbs, odds, lists)  # fmt: skip
        low = _combine(own, together, offset, -angle_rad, lists, core, limbs, odds,
                       min(best, lowest), pool)  # fmt: skip
        lowest = min(lowest, low)
    return lowest


@compiled
def _combine(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    own: IntArray,
    of_core: FloatArray,
    offset: float,
    heading_rad: float,
    lists: LimbLists,
    core: Core,
    limbs: Limbs,
    odds: Odds,
    best: float,
    pool: Pool,
) -> float:
    """Continue limb by limb, and put the ways that are left into the pool."""
    pairs, by_kind, gains, bones = lists
    n_limbs = len(pairs)
    chosen = np.full((1, n_limbs), -1)
    sums = of_core.copy().reshape(1, -1)
    hopes = np.full(1, offset - of_core.max())
    misses = np.full(1, len(own) - count_named(own))
    rest = np.zeros(n_limbs + 1)
    for limb in range(n_limbs - 1, -1, -1):
        rest[limb] = rest[limb + 1] + gains[limb].max() + MOST_ALIKE * (limb % 2)
    greedy = _greedy(own, of_core, offset, pairs, by_kind, gains, bones, limbs, odds)
    limit = min(best, greedy) + odds.gap
    for limb in range(n_limbs):
        chosen, sums, hopes, misses = _continued(
            chosen,
            sums,
            hopes,
            misses,
            limb,
            pairs,
            by_kind[limb],
            gains[limb],
            bones,
            limbs,
            odds.least_counts,
            limit + rest[limb + 1],
        )
    lowest = -NEVER
    for w in range(len(chosen)):
        energy = _energy(own, chosen[w], sums[w], offset, pairs, odds)
        lowest = min(lowest, energy)
        if energy < limit:
            _put(own, chosen[w], pairs, energy, heading_rad, min(best, lowest) + odds.gap, core,
                 limbs, pool)  # fmt: skip
    return lowest


@compiled
def _put(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    own: IntArray, chosen: IntArray, pairs: IntArray, energy: float, heading_rad: float,
    limit: float, core: Core, limbs: Limbs, pool: Pool,
) -> None:  # fmt: skip
    """Put a way into the pool; one that is full leaves out what is above the limit by now."""
    if pool.n_filled[0] == len(pool.energies):
        _make_room(pool, limit)
    at = pool.n_filled[0]
    if at == len(pool.energies):
        return
    pool.energies[at], pool.headings[at] = energy, heading_rad
    pool.partners[at] = -1
    for i in range(len(own)):
        pool.partners[at, core.labels[i]] = own[i]
    for limb in range(len(pairs)):
        for d in range(2):
            pool.partners[at, limbs.labels[limb, d]] = pairs[limb, chosen[limb], d]
    pool.n_filled[0] = at + 1


@compiled
def _make_room(pool: Pool, limit: float) -> None:
    """Leave out ways of a full pool that better ones make too unlikely to count."""
    n = 0
    for at in range(pool.n_filled[0]):
        if pool.energies[at] < limit:
            pool.energies[n], pool.headings[n] = pool.energies[at], pool.headings[at]
            pool.partners[n] = pool.partners[at]
            n += 1
    pool.n_filled[0] = n


@compiled
def _collides(pairs: IntArray, chosen: IntArray, limb: int, c: int) -> bool:
    """Say whether a choice takes a point that a limb before has."""
    for before in range(limb):
        for d in range(2):
            j = pairs[before, chosen[before], d]
            if j >= 0 and (j == pairs[limb, c, 0] or j == pairs[limb, c, 1]):
                return True
    return False


@compiled
def _continued(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    chosen: IntArray,
    sums: FloatArray,
    hopes: FloatArray,
    misses: IntArray,
    limb: int,
    pairs: IntArray,
    by_kind: FloatArray,
    gains: FloatArray,
    bones: FloatArray,
    limbs: Limbs,
    counts: FloatArray,
    limit: float,
) -> tuple[IntArray, FloatArray, FloatArray, IntArray]:
    """Return the ways so far with one limb more."""
    n_before, n_kinds = chosen.shape[1], sums.shape[1]
    new_chosen = np.empty((MOST_WAYS, n_before), np.int64)
    new_sums = np.empty((MOST_WAYS, n_kinds))
    new_hopes = np.empty(MOST_WAYS)
    new_misses = np.empty(MOST_WAYS, np.int64)
    alike = np.zeros(n_kinds)
    most_alike = MOST_ALIKE * (limb % 2)
    n = 0
    for w in range(len(chosen)):
        for c in range(len(gains)):
            n_missing = misses[w] + (pairs[limb, c, 0] < 0) + (pairs[limb, c, 1] < 0)
            hope = hopes[w] - gains[c]
            is_hopeless = hope - most_alike + counts[n_missing] > limit or n == MOST_WAYS
            if is_hopeless or _collides(pairs, chosen[w], limb, c):
                continue
            if limb % 2:
                theirs = bones[limb - 1, chosen[w, limb - 1]]
                rate_sides(bones[limb, c], theirs, limbs, limb, alike)
                hope -= alike.max()
                if hope + counts[n_missing] > limit:
                    continue
            for before in range(limb):
                new_chosen[n, before] = chosen[w, before]
            new_chosen[n, limb] = c
            for q in range(n_kinds):
                new_sums[n, q] = sums[w, q] + by_kind[c, q] + alike[q]
            new_hopes[n] = hope
            new_misses[n] = n_missing
            n += 1
    return new_chosen[:n], new_sums[:n], new_hopes[:n], new_misses[:n]


@compiled
def _greedy(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    own: IntArray,
    of_core: FloatArray,
    offset: float,
    pairs: IntArray,
    by_kind: FloatArray,
    gains: FloatArray,
    bones: FloatArray,
    limbs: Limbs,
    odds: Odds,
) -> float:
    """Return the energy of giving each limb in turn the best of what is left."""
    n_limbs = len(pairs)
    chosen = np.zeros(n_limbs, np.int64)
    sums = of_core.copy()
    alike = np.zeros(len(sums))
    for limb in range(n_limbs):
        c = 0
        while c < N_KEPT - 1 and (gains[limb, c] <= NEVER or _collides(pairs, chosen, limb, c)):
            c += 1
        if _collides(pairs, chosen, limb, c):
            return -NEVER
        chosen[limb] = c
        sums += by_kind[limb, c]
        if limb % 2:
            theirs = bones[limb - 1, chosen[limb - 1]]
            rate_sides(bones[limb, c], theirs, limbs, limb, alike)
            sums += alike
    return _energy(own, chosen, sums, offset, pairs, odds)


@compiled
def _energy(
    own: IntArray,
    chosen: IntArray,
    sums: FloatArray,
    offset: float,
    pairs: IntArray,
    odds: Odds,
) -> float:
    """Return minus the log of the odds of one way, summed over the kinds of posture."""
    n_missing = len(own) - count_named(own)
    for limb in range(len(pairs)):
        for d in range(2):
            n_missing += 1 if pairs[limb, chosen[limb], d] < 0 else 0
    highest = sums.max()
    total = 0.0
    for q in range(len(sums)):
        total += math.exp(sums[q] - highest)
    return float(offset + odds.counts[n_missing] - highest - math.log(total))
