"""A cut that was made before, carried over to labels of which some have changed since.

What flows stays, as far as the new arcs can carry it, and only what is left is looked for anew.
Source: Alahari, Kohli and Torr, Dynamic hybrid algorithms for MAP inference in discrete MRFs, PAMI
32 (2010), section 3 (recycling). The tables are those of `adibas.graphcut.pair_kernels`.
"""

from adibas.arrays import AnyArray, Int32Array
from adibas.graphcut.pair_kernels import EXCESS, IS_LAID, STAY, TO, WEIGHT, terms_at
from adibas.kernels import compiled


@compiled
def renew(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    arcs: Int32Array,
    left: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    penalties: Int32Array,
    costs: Int32Array,
    labels: AnyArray,
) -> None:
    """Let the label with which each pixel stays be that of `labels`."""
    for p in range(labels.size):
        before, now = marks[STAY, p], labels[p]
        if before != now:
            nodes[EXCESS, p] += costs[before, p] - costs[now, p]
            for k in range(arcs.shape[2]):
                if arcs[TO, p, k] >= 0:
                    _renew_pair(arcs, left, nodes, marks, penalties, p, k, now)
            marks[STAY, p] = now


@compiled
def _renew_pair(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    arcs: Int32Array,
    left: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    penalties: Int32Array,
    p: int,
    k: int,
    now: int,
) -> None:
    """Carry over what flows between `p` and its neighbour at arc `k`, as far as it can."""
    q, weight = arcs[TO, p, k], arcs[WEIGHT, p, k]
    before = marks[STAY, p]
    first, second, forth, _ = terms_at(arcs, marks, penalties, p, k)
    marks[STAY, p] = now
    new_first, new_second, new_forth, new_back = terms_at(arcs, marks, penalties, p, k)
    marks[STAY, p] = before
    # Nothing flows by an arc that nobody has looked at.
    is_flowing = marks[IS_LAID, p] and marks[IS_LAID, q]
    flow = weight * forth - left[p, k] if is_flowing else 0
    kept = min(max(flow, -weight * new_back), weight * new_forth)
    if marks[IS_LAID, p]:
        left[p, k] = weight * new_forth - kept
    if marks[IS_LAID, q]:
        left[q, k ^ 1] = weight * new_back + kept
    nodes[EXCESS, p] += weight * (new_first - first) + flow - kept
    nodes[EXCESS, q] += weight * (new_second - second) - flow + kept
