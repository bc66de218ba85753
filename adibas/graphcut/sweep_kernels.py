"""Debts passed on to neighbours, in sweeps over the image, before a tree looks for the rest.

Moving what a pixel owes to the sink over an arc leaves the cut's problem the same, whoever owes it
then; most of it meets a neighbour's excess and is gone. The tables are those of
`adibas.graphcut.pair_kernels`.
"""

from adibas.arrays import AnyArray, Int32Array
from adibas.graphcut.pair_kernels import EXCESS, IS_LAID, TO, lay_arcs
from adibas.kernels import compiled


@compiled
def settle(
    arcs: Int32Array,
    left: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    penalties: Int32Array,
    n_sweeps: int,
) -> None:
    """Pass debts to richer neighbours, then onwards: with the image's rows, and against them."""
    n_pixels = nodes.shape[1]
    for p in range(n_pixels):
        if nodes[EXCESS, p] < 0:
            _pass_on(arcs, left, nodes, marks, penalties, p, 0, 1, True)
    for sweep in range(n_sweeps):
        for i in range(n_pixels):
            p = n_pixels - 1 - i if sweep & 1 else i
            if nodes[EXCESS, p] < 0:
                _pass_on(arcs, left, nodes, marks, penalties, p, 0, 1, True)
                _pass_on(arcs, left, nodes, marks, penalties, p, sweep & 1, 2, False)


@compiled
def _pass_on(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    arcs: Int32Array,
    left: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    penalties: Int32Array,
    p: int,
    first_arc: int,
    arc_step: int,
    is_paid: bool,
) -> None:
    """Send the debt of `p` by every `arc_step`-th arc; `is_paid`: only what a neighbour can pay."""
    if not marks[IS_LAID, p]:
        lay_arcs(arcs, left, marks, penalties, p)
    for k in range(first_arc, arcs.shape[2], arc_step):
        q = arcs[TO, p, k]
        if q < 0 or nodes[EXCESS, p] == 0 or (is_paid and nodes[EXCESS, q] <= 0):
            continue
        if not marks[IS_LAID, q]:
            lay_arcs(arcs, left, marks, penalties, q)
        amount = min(-nodes[EXCESS, p], left[q, k ^ 1])
        if is_paid:
            amount = min(amount, nodes[EXCESS, q])
        left[q, k ^ 1] -= amount
        left[p, k] += amount
        nodes[EXCESS, p] += amount
        nodes[EXCESS, q] -= amount
