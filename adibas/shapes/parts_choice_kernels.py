"""All ways to give a core its limbs, no point twice: each is one way to name the points.

Limb after limb the ways so far are continued by each of the limb's choices, unless even the best
choices for the limbs still open would leave them too far above the best energy known.
"""

import math

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.kernels import compiled
from adibas.shapes.parts_bone_kernels import MOST_ALIKE, add_bones, measure_bones, rate_sides
from adibas.shapes.parts_core_kernels import (
    NEVER,
    core_numbers,
    count_named,
    heading_energy,
    known_rows,
    label_odds_of,
    rate_core,
    spread_of_missing,
    turned_to_mean,
    whole_core,
)
from adibas.shapes.parts_limb_kernels import MOST_CHOICES, N_KEPT, keep_best, list_choices
from adibas.shapes.parts_types import Core, Limbs, Odds, Pool

MOST_WAYS = 1000


@compiled
def _taken(own: IntArray, n_points: int) -> BoolArray:
    """Return which points a core has."""
    is_taken = np.zeros(n_points, np.bool_)
    for j in own:
        if j >= 0:
            is_taken[j] = True
    return is_taken


@compiled
def judge_core(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray, own: IntArray, core: Core, limbs: Limbs, odds: Odds, best: float, pool: Pool
) -> float:  # fmt: skip
    """Add the ways to name the points with this core to the pool; return the lowest energy.

    Parameters
    ----------
    own : (C,) int array
        Point of each label of the core, -1 for none.
    best : float
        Lowest energy that is known.
    """
    moved, angle_rad = turned_to_mean(points, own, core.mean, odds)
    rows, values = known_rows(moved, own)
    of_core = np.empty(odds.n_kinds)
    component = rate_core(rows, values, core, odds, of_core)
    of_core += label_odds_of(own, core.labels, odds)
    whole = whole_core(rows, values, core, component)
    plain, mirrored, size_m = core_numbers(whole, core)
    is_taken = _taken(own, len(points))
    n_limbs = len(limbs.roots)
    pairs = np.full((n_limbs, N_KEPT, 2), -1)
    by_kind = np.full((n_limbs, N_KEPT, odds.n_kinds), NEVER)
    gains = np.full((n_limbs, N_KEPT), NEVER)
    bones = np.full((n_limbs, N_KEPT, 2), math.nan)
    all_pairs = np.empty((MOST_CHOICES, 2), np.int64)
    all_logs = np.empty((MOST_CHOICES, odds.n_kinds))
    for limb in range(n_limbs):
        root, sign = limbs.roots[limb], limbs.signs[limb]
        ways = (moved - whole[root]) / size_m
        ways[:, 0] *= sign
        unit = odds.log_room - 3.0 * math.log(size_m)
        of_root = spread_of_missing(rows, own, root, sign, core, component) / size_m**2
        n = list_choices(ways, is_taken, plain if sign > 0 else mirrored, of_core, limbs, limb,
                         unit, of_root, odds, all_pairs, all_logs)  # fmt: skip
        has_root = own[root] >= 0
        add_bones(ways, all_pairs[:n], all_logs[:n], has_root, limbs, limb)
        kept = keep_best(all_pairs[:n], all_logs[:n], of_core, limb, odds)
        n = len(kept[2])
        pairs[limb, :n], by_kind[limb, :n], gains[limb, :n] = kept
        for c in range(n):
            bones[limb, c, 0], bones[limb, c, 1] = measure_bones(ways, pairs[limb, c], has_root)
    offset = heading_energy(-angle_rad, odds)
    return _combine(own, of_core, offset, -angle_rad, pairs, by_kind, gains, bones, core, limbs,
                    odds, best, pool)  # fmt: skip


@compiled
def _combine(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    own: IntArray,
    of_core: FloatArray,
    offset: float,
    heading_rad: float,
    pairs: IntArray,
    by_kind: FloatArray,
    gains: FloatArray,
    bones: FloatArray,
    core: Core,
    limbs: Limbs,
    odds: Odds,
    best: float,
    pool: Pool,
) -> float:
    """Continue limb by limb, and put the ways that are left into the pool."""
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
        at = pool.n_filled[0]
        if energy < limit and at < len(pool.energies):
            pool.energies[at], pool.headings[at] = energy, heading_rad
            pool.partners[at] = -1
            for i in range(len(own)):
                pool.partners[at, core.labels[i]] = own[i]
            for limb in range(n_limbs):
                for d in range(2):
                    pool.partners[at, limbs.labels[limb, d]] = pairs[limb, chosen[w, limb], d]
            pool.n_filled[0] = at + 1
    return lowest


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
