"""Maximum flow on the pixels of a mask, grown from the sink alone.

Boykov & Kolmogorov's search trees with re-use, An experimental comparison of min-cut/max-flow
algorithms for energy minimization in vision, PAMI 26 (2004), with one difference: only the tree of
the sink is grown; a pixel with flow left from the source is a path's end as soon as the tree
reaches it. In moves that few pixels want to make nearly all pixels are never looked at, and the
arcs of a pixel are worked out when it is first reached.

What the tree holds at the end is the smallest sink side of all minimum cuts. The tables are those
of `adibas.graphcut.pair_kernels`.
"""

from adibas.arrays import AnyArray, Int32Array, IntArray
from adibas.graphcut.pair_kernels import (
    ACTIVE,
    CLOCK,
    DISTANCE,
    EXCESS,
    FIRST_ACTIVE,
    FIRST_ORPHAN,
    FREE,
    IS_ACTIVE,
    IS_LAID,
    N_ACTIVE,
    N_ORPHANS,
    ORPHAN,
    ORPHANS,
    PARENT,
    SEEN_AT,
    TERMINAL,
    TO,
    lay_arcs,
)
from adibas.kernels import compiled

NO_DISTANCE = 1 << 30


@compiled
def maximise_flow(
    arcs: Int32Array,
    left: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    counters: IntArray,
    penalties: Int32Array,
) -> None:
    """Push all the flow there can be; the tree then is the sink's side of the cut."""
    n_pixels = nodes.shape[1]
    for p in range(n_pixels):
        if nodes[EXCESS, p] < 0:
            marks[PARENT, p] = TERMINAL
            nodes[DISTANCE, p] = 1
            nodes[SEEN_AT, p] = counters[CLOCK]
            activate(nodes, marks, counters, p)
    while counters[N_ACTIVE] > 0:
        first = counters[FIRST_ACTIVE]
        p = nodes[ACTIVE, first]
        counters[FIRST_ACTIVE] = first + 1 if first + 1 < n_pixels else 0
        counters[N_ACTIVE] -= 1
        marks[IS_ACTIVE, p] = 0
        if marks[PARENT, p] != FREE:
            if not marks[IS_LAID, p]:
                lay_arcs(arcs, left, marks, penalties, p)
            _grow(arcs, left, nodes, marks, counters, penalties, p)


@compiled
def activate(nodes: Int32Array, marks: AnyArray, counters: IntArray, p: int) -> None:
    """Let pixel `p` of the tree look for more."""
    if marks[IS_ACTIVE, p] == 0:
        marks[IS_ACTIVE, p] = 1
        place = counters[FIRST_ACTIVE] + counters[N_ACTIVE]
        n_pixels = nodes.shape[1]
        nodes[ACTIVE, place if place < n_pixels else place - n_pixels] = p
        counters[N_ACTIVE] += 1


@compiled
def _grow(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    arcs: Int32Array,
    left: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    counters: IntArray,
    penalties: Int32Array,
    p: int,
) -> None:
    """Take in the neighbours of `p` that can send to it; drain those that have flow."""
    for k in range(arcs.shape[2]):
        q = arcs[TO, p, k]
        if q < 0 or marks[PARENT, q] != FREE:
            continue
        if not marks[IS_LAID, q]:
            lay_arcs(arcs, left, marks, penalties, q)
        while left[q, k ^ 1] > 0 and nodes[EXCESS, q] > 0:
            if _drain(arcs, left, nodes, marks, counters, q, k ^ 1):
                _mend(arcs, left, nodes, marks, counters, penalties)
            if marks[PARENT, p] == FREE:
                return
        if left[q, k ^ 1] > 0 and marks[PARENT, q] == FREE:
            marks[PARENT, q] = k ^ 1
            nodes[DISTANCE, q] = nodes[DISTANCE, p] + 1
            nodes[SEEN_AT, q] = nodes[SEEN_AT, p]
            activate(nodes, marks, counters, q)


@compiled
def _drain(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    arcs: Int32Array,
    left: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    counters: IntArray,
    q: int,
    k: int,
) -> bool:
    """Send flow from `q` by its arc `k` down the tree to the sink; say whether that cut it."""
    amount = min(nodes[EXCESS, q], left[q, k])
    first = arcs[TO, q, k]
    p = first
    up = marks[PARENT, p]
    while up != TERMINAL:
        amount = min(amount, left[p, up])
        p = arcs[TO, p, up]
        up = marks[PARENT, p]
    amount = min(amount, -nodes[EXCESS, p])
    nodes[EXCESS, q] -= amount
    left[q, k] -= amount
    left[first, k ^ 1] += amount
    p = first
    up = marks[PARENT, p]
    while up != TERMINAL:
        above = arcs[TO, p, up]
        left[above, up ^ 1] += amount
        left[p, up] -= amount
        if left[p, up] == 0:
            _orphan(nodes, marks, counters, p)
        p = above
        up = marks[PARENT, p]
    nodes[EXCESS, p] += amount
    if nodes[EXCESS, p] == 0:
        _orphan(nodes, marks, counters, p)
    return bool(counters[N_ORPHANS] > 0)


@compiled
def _orphan(nodes: Int32Array, marks: AnyArray, counters: IntArray, p: int) -> None:
    marks[PARENT, p] = ORPHAN
    place = counters[FIRST_ORPHAN] + counters[N_ORPHANS]
    n_pixels = nodes.shape[1]
    nodes[ORPHANS, place if place < n_pixels else place - n_pixels] = p
    counters[N_ORPHANS] += 1


@compiled
def _mend(
    arcs: Int32Array,
    left: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    counters: IntArray,
    penalties: Int32Array,
) -> None:
    """Find a new parent for each orphan, the nearest to the sink, or let it go."""
    counters[CLOCK] += 1
    while counters[N_ORPHANS] > 0:
        first = counters[FIRST_ORPHAN]
        p = nodes[ORPHANS, first]
        counters[FIRST_ORPHAN] = first + 1 if first + 1 < nodes.shape[1] else 0
        counters[N_ORPHANS] -= 1
        best, shortest = FREE, NO_DISTANCE
        for k in range(arcs.shape[2]):
            if left[p, k] > 0 and marks[PARENT, arcs[TO, p, k]] != FREE:
                distance = _distance(arcs, nodes, marks, counters[CLOCK], arcs[TO, p, k])
                if distance < shortest:
                    best, shortest = k, distance
        marks[PARENT, p] = best
        if best == FREE:
            _let_go(arcs, left, nodes, marks, counters, p)
            continue
        nodes[DISTANCE, p] = shortest + 1
        nodes[SEEN_AT, p] = counters[CLOCK]
        if not marks[IS_LAID, arcs[TO, p, best]]:
            lay_arcs(arcs, left, marks, penalties, arcs[TO, p, best])


@compiled
def _distance(arcs: Int32Array, nodes: Int32Array, marks: AnyArray, now: int, q: int) -> int:
    """Return the arcs from `q` to the sink; `NO_DISTANCE` where its tree hangs on an orphan."""
    p, distance = q, 0
    while nodes[SEEN_AT, p] != now:
        up = marks[PARENT, p]
        if up == ORPHAN:
            return NO_DISTANCE
        distance += 1
        if up == TERMINAL:
            nodes[SEEN_AT, p] = now
            nodes[DISTANCE, p] = 1
            break
        p = arcs[TO, p, up]
    else:
        distance += nodes[DISTANCE, p]
    p, left = q, distance
    while nodes[SEEN_AT, p] != now:
        nodes[SEEN_AT, p] = now
        nodes[DISTANCE, p] = left
        left -= 1
        p = arcs[TO, p, marks[PARENT, p]]
    return distance


@compiled
def _let_go(
    arcs: Int32Array,
    left: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    counters: IntArray,
    p: int,
) -> None:
    """Leave `p` out of the tree: its children are orphans, and whom it can reach looks again."""
    for k in range(arcs.shape[2]):
        q = arcs[TO, p, k]
        if q < 0 or marks[PARENT, q] == FREE:
            continue
        if left[p, k] > 0:
            activate(nodes, marks, counters, q)
        if marks[PARENT, q] == k ^ 1:
            _orphan(nodes, marks, counters, q)
