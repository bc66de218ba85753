"""The search for the core of a body among points, and all that they could be.

Cores come from messages on the tree of neighbours and from laying the mean core upon single points;
each is improved by giving every label the point that suits all others best. The most likely ones
get their limbs; of the best, the cores that differ by one point or by an exchange are judged, too.
"""

import math

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.kernels import compiled
from adibas.shapes.assignment_kernels import assign
from adibas.shapes.labelling_kernels import pair_costs
from adibas.shapes.parts_choice_kernels import judge_core
from adibas.shapes.parts_core_kernels import (
    LEAST_CORE,
    count_named,
    heading_energy,
    known_rows,
    label_odds_of,
    leave_one_out_core,
    rate_core,
    turned_to_mean,
)
from adibas.shapes.parts_types import Anchors, Core, Limbs, Odds, Pool

MOST_CORES = 2000
"""A list that is full loses what is found later: of up to 40 points the thorough search finds 700
cores of a view, and twice as many where none is told, each one's mirror image behind all others."""
LEAST_JUDGED = 2
N_IMPROVEMENTS = 4
VARIED_GAP = 6.0
ALONE_SLACK = 3.0
"""More than a label without a point costs: while a core is improved, better a doubtful point."""
SLACK, EXCHANGE_SLACK = 6.0, 14.0
"""By which a change of one point, or an exchange, may look worse than it is: the others move."""


@compiled
def lay_anchors(
    points: FloatArray, headings_rad: FloatArray, anchors: Anchors, log_room: float, n_kept: int
) -> IntArray:
    """Return the (n_kept, C) cores that fit best where one point is taken for an anchor.

    Every label takes the point nearest to its mean place, if that is likelier than none.
    """
    n_core = anchors.means.shape[1]
    best = np.full(n_kept, np.inf)
    cores = np.full((n_kept, n_core), -1)
    own = np.empty(n_core, np.int64)
    for heading_rad in headings_rad:
        cos, sin = math.cos(heading_rad), math.sin(heading_rad)
        turned = points.copy()
        turned[:, 0] = cos * points[:, 0] - sin * points[:, 2]
        turned[:, 2] = sin * points[:, 0] + cos * points[:, 2]
        for a in range(len(anchors.costs)):
            for p in range(len(anchors.points)):
                for j in range(len(points)):
                    energy = _lay_anchor(turned, anchors, a, p, j, log_room, own)
                    if energy < best[n_kept - 1]:
                        _insert(energy, own, best, cores)
    return cores


@compiled
def _lay_anchor(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    turned: FloatArray, anchors: Anchors, a: int, p: int, j: int, log_room: float, own: IntArray
) -> float:
    """Fill the core with point j for anchor p; return its energy, points taken twice or not."""
    anchor = anchors.points[p]
    energy = anchors.costs[a]
    for i in range(len(own)):
        own[i] = j if i == anchor else -1
        if i == anchor:
            continue
        gain = anchors.constants[a, p, i] + log_room
        white = anchors.whiteners[a, p, i]
        way = anchors.means[a, i] - anchors.means[a, anchor] + turned[j]
        least = 0.0
        for k in range(len(turned)):
            if k == j:
                continue
            x, y, z = turned[k, 0] - way[0], turned[k, 1] - way[1], turned[k, 2] - way[2]
            cost = (white[0, 0] * x) ** 2
            cost += (white[1, 0] * x + white[1, 1] * y) ** 2
            cost += (white[2, 0] * x + white[2, 1] * y + white[2, 2] * z) ** 2
            if 0.5 * cost - gain < least:
                least = 0.5 * cost - gain
                own[i] = k
        energy += least
    return float(energy)


@compiled
def _insert(energy: float, own: IntArray, best: FloatArray, cores: IntArray) -> None:
    """Put a core among the best ones, once; of a point taken twice the first label keeps it."""
    for i in range(len(own)):
        for k in range(i):
            if own[i] == own[k]:
                own[i] = -1
    for p in range(len(best)):
        if (cores[p] == own).all():
            best[p] = min(best[p], energy)
            return
    p = len(best) - 1
    while p > 0 and best[p - 1] > energy:
        best[p] = best[p - 1]
        cores[p] = cores[p - 1]
        p -= 1
    best[p] = energy
    cores[p] = own


@compiled
def _is_known(cores: IntArray, n_cores: int, own: IntArray) -> bool:
    for c in range(n_cores):
        is_same = True
        for i in range(len(own)):
            is_same = is_same and cores[c, i] == own[i]
        if is_same:
            return True
    return False


@compiled
def _hope(points: FloatArray, own: IntArray, core: Core, odds: Odds) -> float:
    """Return the energy of a core, as if the points it leaves were of limbs.

    Each is worth then what a label without a point costs, so that a core does not gain by taking
    points that a limb could have.
    """
    moved, angle_rad = turned_to_mean(points, own, core.mean, odds)
    rows, values = known_rows(moved, own)
    by_kind = np.empty(odds.n_kinds)
    rate_core(rows, values, core, odds, by_kind)
    n_limb_labels = len(odds.counts) - 1 - len(own)
    n_left = min(len(points) - count_named(own), n_limb_labels)
    likely = by_kind.max() + label_odds_of(own, core.labels, odds)
    return float(heading_energy(-angle_rad, odds) - likely - odds.lone * n_left)


@compiled
def _add(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray, own: IntArray, core: Core, odds: Odds, cores: IntArray,
    hopes: FloatArray, n_cores: int,
) -> int:  # fmt: skip
    """Add a core that is not yet known; return how many there are now."""
    if n_cores == len(cores) or count_named(own) < LEAST_CORE or _is_known(cores, n_cores, own):
        return n_cores
    cores[n_cores] = own
    hopes[n_cores] = _hope(points, own, core, odds)
    return n_cores + 1


@compiled
def _costs(
    points: FloatArray, own: IntArray, core: Core, odds: Odds, alone: float, widening: float
) -> FloatArray:
    """Return (C, M) costs of each point for each label by all other points, and beside places."""
    moved, _ = turned_to_mean(points, own, core.mean, odds)
    rows, values = known_rows(moved, own)
    component = rate_core(rows, values, core, odds, np.empty(odds.n_kinds))
    places, spreads = leave_one_out_core(rows, values, own, core, component)
    costs = pair_costs(moved, places, spreads, alone, widening)
    for i in range(len(own)):
        costs[i] -= odds.label_odds[:, core.labels[i]]
    return costs


@compiled
def _improved(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray, own: IntArray, core: Core, odds: Odds, cores: IntArray,
    hopes: FloatArray, n_cores: int,
) -> int:  # fmt: skip
    """Add a core and what becomes of it where each label takes the point that suits the others."""
    for done in range(N_IMPROVEMENTS):
        is_followed = done > 0 and _is_known(cores, n_cores, own)
        if is_followed or count_named(own) < LEAST_CORE:
            break
        n_cores = _add(points, own, core, odds, cores, hopes, n_cores)
        alone = odds.lone + odds.log_room + ALONE_SLACK
        new = assign(_costs(points, own, core, odds, alone, 2.0 if done == 0 else 1.0))
        if (new == own).all():
            break
        own = new
    return n_cores


@compiled
def _gathered(
    points: FloatArray,
    starts: IntArray,
    core: Core,
    odds: Odds,
    cores: IntArray,
    hopes: FloatArray,
) -> int:
    """Fill the cores that starts lead to, and where no view is told their mirror images."""
    n_cores = 0
    for s in range(len(starts)):
        if not _is_known(starts, s, starts[s]):
            n_cores = _improved(points, starts[s].copy(), core, odds, cores, hopes, n_cores)
    if math.isnan(odds.heading_rad):
        for c in range(n_cores):
            n_cores = _add(points, cores[c][core.mirror], core, odds, cores, hopes, n_cores)
    return n_cores


@compiled
def search_parts(
    points: FloatArray, starts: IntArray, core: Core, limbs: Limbs, odds: Odds, pool: Pool
) -> float:
    """Fill the pool with ways to name (M, 3) points from (S, C) cores; return the lowest energy."""
    n_core = len(core.labels)
    cores = np.empty((MOST_CORES, n_core), np.int64)
    hopes = np.empty(MOST_CORES)
    lows = np.full(MOST_CORES, np.inf)
    n_cores = _gathered(points, starts, core, odds, cores, hopes)
    best = _judge(points, np.argsort(hopes[:n_cores]), core, limbs, odds, cores, hopes, lows, pool)
    is_varied = np.zeros(MOST_CORES, np.bool_)
    for done in range(2 * odds.n_varied):
        c = _next(lows[:n_cores], is_varied)
        if c < 0 or lows[c] > best + VARIED_GAP or (done >= odds.n_varied and lows[c] > best):
            break
        is_varied[c] = True
        before = n_cores
        n_cores = _vary(points, c, core, odds, cores, hopes, n_cores)
        for new in range(before, n_cores):
            if hopes[new] < hopes[c] + odds.gap + SLACK:
                lows[new] = judge_core(points, cores[new], core, limbs, odds, best, pool)
                best = min(best, lows[new])
    return best


@compiled
def _judge(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray,
    order: IntArray,
    core: Core,
    limbs: Limbs,
    odds: Odds,
    cores: IntArray,
    hopes: FloatArray,
    lows: FloatArray,
    pool: Pool,
) -> float:
    """Give the most likely cores their limbs; return the lowest energy."""
    best = np.inf
    for n in range(min(len(order), odds.n_judged)):
        c = order[n]
        if n >= LEAST_JUDGED and hopes[c] > hopes[order[0]] + odds.too_unlikely:
            break
        lows[c] = judge_core(points, cores[c], core, limbs, odds, best, pool)
        best = min(best, lows[c])
    return best


@compiled
def _next(lows: FloatArray, is_varied: BoolArray) -> int:
    """Return the best core that was not yet varied, -1 if there is none."""
    found = -1
    for c in range(len(lows)):
        if not is_varied[c] and lows[c] < np.inf and (found < 0 or lows[c] < lows[found]):
            found = c
    return found


@compiled
def _vary(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray, c: int, core: Core, odds: Odds, cores: IntArray, hopes: FloatArray,
    n_cores: int,
) -> int:  # fmt: skip
    """Add the cores that differ from core c by one point or one exchange and may be as likely."""
    own = cores[c].copy()
    costs = _costs(points, own, core, odds, odds.log_room, 1.0)
    n_missing = len(own) - count_named(own)
    least = max(n_missing, len(odds.counts) - 1 - len(points))
    alone = odds.counts[least + 1] - odds.counts[least]
    for i in range(len(own)):
        for j in range(-1, len(points)):
            if j == own[i]:
                continue
            other = _label_of(own, j)
            change = _cost(costs, i, j, alone) - _cost(costs, i, own[i], alone)
            slack = SLACK if j >= 0 else 0.0
            if other >= 0:
                change += _cost(costs, other, own[i], alone) - _cost(costs, other, j, alone)
                slack = EXCHANGE_SLACK
            if change < odds.gap + slack:
                new = own.copy()
                new[i] = j
                if other >= 0:
                    new[other] = own[i]
                n_cores = _add(points, new, core, odds, cores, hopes, n_cores)
    return n_cores


@compiled
def _label_of(own: IntArray, j: int) -> int:
    """Return the label that has point j, -1 if none has it."""
    for k in range(len(own)):
        if j >= 0 and own[k] == j:
            return k
    return -1


@compiled
def _cost(costs: FloatArray, i: int, j: int, alone: float) -> float:
    return costs[i, j] if j >= 0 else alone
