"""The choices of all limbs at a core, of which the points where they begin may be missing.

Each component of the core says by itself where a missing one is, and how surely.
"""

import math
from typing import NamedTuple

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.kernels import compiled
from adibas.shapes.parts_bone_kernels import MOST_ALIKE, add_bones, measure_bones
from adibas.shapes.parts_core_kernels import NEVER, core_numbers, expected_core, mirrored_spread
from adibas.shapes.parts_limb_kernels import MOST_CHOICES, N_KEPT, keep_best, list_choices
from adibas.shapes.parts_types import Core, Limbs, Odds

COMPONENT_GAP = 6.0
"""Components of the core that are less likely than the best one by more nats are left out."""
ALIKE_M = 0.06
"""Components that place all missing roots as near to each other as this are asked together."""
ROOTLESS_GAIN = 14.0
"""About at most what places gain by a limb of which it is not seen where it begins.

A component that cannot reach the best way even so is not asked: of 460 pictures (seed 6030) no name
is another one for it, in a third less time.
"""


class LimbLists(NamedTuple):
    """The most likely choices of each of L limbs, Q kinds of posture.

    Attributes
    ----------
    pairs : (L, N_KEPT, 2) int array
        Points; -1 for none.
    by_kind : (L, N_KEPT, Q) array
        Log odds.
    gains : (L, N_KEPT) array
        At most what each gains.
    bones : (L, N_KEPT, 2) array
        Logarithms of their lengths; NaN where they are not seen.
    """

    pairs: IntArray
    by_kind: FloatArray
    gains: FloatArray
    bones: FloatArray


@compiled
def taken_by(own: IntArray, n_points: int) -> BoolArray:
    """Return which points a core has."""
    is_taken = np.zeros(n_points, np.bool_)
    for j in own:
        if j >= 0:
            is_taken[j] = True
    return is_taken


@compiled
def alike_components(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    rows: IntArray, values: FloatArray, own: IntArray, logs: FloatArray, order: IntArray,
    core: Core, limbs: Limbs, odds: Odds,
) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Put together the components that say nearly the same of where limbs begin.

    Returns
    -------
    wholes, all_spreads : (G, C, 3) and (G, C, 3, 3) arrays
        The core by the likeliest component of each group, see `expected_core`.
    by_kinds : (G, kinds) array
        Log densities of the group, by kind of posture.
    """
    wholes = np.empty((len(order), *core.mean.shape))
    all_spreads = np.empty((len(order), len(own), 3, 3))
    by_kinds = np.full((len(order), odds.n_kinds), NEVER)
    n = 0
    for component in order:
        if logs[component] < logs[order[0]] - COMPONENT_GAP:
            break
        whole, spreads = expected_core(rows, values, own, core, component)
        group = 0
        while group < n and _farthest_root_m(whole, wholes[group], own, limbs) > ALIKE_M:
            group += 1
        if group == n:
            wholes[n], all_spreads[n] = whole, spreads
            n += 1
        kind = core.kinds[component]
        by_kinds[group, kind] = np.logaddexp(by_kinds[group, kind], logs[component])
    return wholes[:n], all_spreads[:n], by_kinds[:n]


@compiled
def _farthest_root_m(one: FloatArray, other: FloatArray, own: IntArray, limbs: Limbs) -> float:
    """Return how far two cores lie apart at most where limbs begin at a missing point."""
    farthest_m = 0.0
    for root in limbs.roots:
        if own[root] < 0:
            farthest_m = max(farthest_m, math.sqrt(((one[root] - other[root]) ** 2).sum()))
    return farthest_m


@compiled
def regain(of_core: FloatArray, lists: LimbLists) -> None:
    """Fill at most what choices gain, for other log densities of the core."""
    highest = of_core.max()
    for limb in range(len(lists.gains)):
        for c in range(N_KEPT):
            gain = NEVER
            for q in range(len(of_core)):
                gain = max(gain, lists.by_kind[limb, c, q] + of_core[q] - highest)
            lists.gains[limb, c] = max(gain, NEVER)


@compiled
def hope_of_rootless(own: IntArray, limbs: Limbs, odds: Odds) -> float:
    """Return at most what the limbs gain that begin at a missing point of the core; 0: none do."""
    hope = 0.0
    for limb in range(len(limbs.roots)):
        if own[limbs.roots[limb]] < 0:
            hope += ROOTLESS_GAIN
            for d in range(2):
                hope += max(0.0, odds.label_odds[:, limbs.labels[limb, d]].max())
    return hope


@compiled
def most_of_rooted(own: IntArray, limbs: Limbs, lists: LimbLists) -> float:
    """Return at most what the limbs gain that begin at a point of the core."""
    most = 0.0
    for limb in range(len(limbs.roots)):
        if own[limbs.roots[limb]] >= 0:
            most += lists.gains[limb].max() + MOST_ALIKE * (limb % 2)
    return most


@compiled
def list_limbs(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    moved: FloatArray,
    whole: FloatArray,
    spreads: FloatArray,
    own: IntArray,
    is_taken: BoolArray,
    of_core: FloatArray,
    alone: FloatArray,
    has_root: bool,
    core: Core,
    limbs: Limbs,
    odds: Odds,
    lists: LimbLists,
) -> None:
    """Fill the choices of the limbs that begin at a point of the core, or of those that do not.

    `whole` and `spreads` (C, 3) and (C, 3, 3) are the core, see `expected_core`.
    """
    plain, mirrored, size_m = core_numbers(whole, core)
    all_pairs = np.empty((MOST_CHOICES, 2), np.int64)
    all_logs = np.empty((MOST_CHOICES, odds.n_kinds))
    for limb in range(len(limbs.roots)):
        root, sign = limbs.roots[limb], limbs.signs[limb]
        if (own[root] >= 0) != has_root:
            continue
        ways = (moved - whole[root]) / size_m
        ways[:, 0] *= sign
        unit = odds.log_room - 3.0 * math.log(size_m)
        of_root = mirrored_spread(spreads[root], sign) / size_m**2
        n = list_choices(ways, is_taken, plain if sign > 0 else mirrored, of_core, limbs, limb,
                         unit, of_root, odds, all_pairs, all_logs)  # fmt: skip
        add_bones(ways, all_pairs[:n], all_logs[:n], has_root, limbs, limb)
        kept = keep_best(all_pairs[:n], all_logs[:n], alone, limb, odds)
        n = len(kept[2])
        lists.pairs[limb] = -1
        lists.by_kind[limb], lists.gains[limb], lists.bones[limb] = NEVER, NEVER, math.nan
        lists.pairs[limb, :n], lists.by_kind[limb, :n], lists.gains[limb, :n] = kept
        for c in range(n):
            pair = lists.pairs[limb, c]
            bones = measure_bones(ways, pair, has_root)
            lists.bones[limb, c, 0], lists.bones[limb, c, 1] = bones
