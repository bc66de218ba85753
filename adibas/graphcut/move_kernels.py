"""One move: the pixels that change their label to the energy's best advantage, all at once.

The tables are those of `adibas.graphcut.pair_kernels`; beside them ``labels`` (N,) int8 and
``costs`` (L, N) int32, of each label at each pixel.
"""

from adibas.arrays import AnyArray, Int32Array, IntArray
from adibas.graphcut.flow_kernels import maximise_flow
from adibas.graphcut.pair_kernels import (
    CHANGE,
    EXCESS,
    FREE,
    IS_LAID,
    ORPHANS,
    PARENT,
    STAY,
    TO,
    WEIGHT,
    price_of_change,
)
from adibas.graphcut.renewal_kernels import renew
from adibas.graphcut.sweep_kernels import settle
from adibas.kernels import compiled

N_SWEEPS = 4
"""Of debts, before the tree grows: more gain nothing (measured with 7 and 15 labels)."""


@compiled
def find_border(arcs: Int32Array, labels: AnyArray, is_border: AnyArray, p: int) -> None:
    """Note whether pixel `p` has a neighbour of another label."""
    has_other = False
    for k in range(arcs.shape[2]):
        q = arcs[TO, p, k]
        has_other |= q >= 0 and labels[q] != labels[p]
    is_border[p] = has_other


@compiled
def find_borders(arcs: Int32Array, labels: AnyArray, is_border: AnyArray) -> None:
    """Note for each pixel whether a neighbour has another label."""
    for p in range(labels.size):
        find_border(arcs, labels, is_border, p)


@compiled
def make_move(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    arcs: Int32Array,
    left: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    counters: IntArray,
    penalties: Int32Array,
    costs: Int32Array,
    labels: AnyArray,
    is_border: AnyArray,
    is_touched: AnyArray,
    is_renewed: bool,
) -> tuple[int, int]:
    """Change `labels` in place: each pixel takes what `marks` have for its change, or stays.

    Parameters
    ----------
    is_touched : (L,) int8 array
        Becomes 1 for the labels of pixels that change, and of their neighbours.
    is_renewed : bool
        The tables are what the last expansion of the same label left; else the cut begins anew.

    Returns
    -------
    value : int
        Of the cut: the energy it reaches less the energy where all stay.
    gain : int
        By how much the energy rises: 0 or less.
    """
    if is_renewed:
        renew(arcs, left, nodes, marks, penalties, costs, labels)
    else:
        _begin(arcs, nodes, marks, penalties, costs, is_border)
    marks[PARENT] = FREE
    settle(arcs, left, nodes, marks, penalties, N_SWEEPS)
    maximise_flow(arcs, left, nodes, marks, counters, penalties)
    value = 0
    for p in range(nodes.shape[1]):
        value += min(nodes[EXCESS, p], 0)
    gain = _carry_out(arcs, nodes, marks, penalties, costs, labels, is_border, is_touched)
    return value, gain


@compiled
def begin_expansion(marks: AnyArray, labels: AnyArray, alpha: int) -> None:
    """Let every pixel choose between its label and `alpha`."""
    marks[STAY] = labels
    marks[CHANGE] = alpha


@compiled
def begin_swap(marks: AnyArray, labels: AnyArray, alpha: int, beta: int) -> None:
    """Let pixels of either label choose between `alpha` (stay) and `beta`."""
    marks[STAY] = labels
    marks[CHANGE] = labels
    for p in range(labels.size):
        if labels[p] == beta:
            marks[STAY, p] = alpha
        elif labels[p] == alpha:
            marks[CHANGE, p] = beta


@compiled
def _begin(
    arcs: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    penalties: Int32Array,
    costs: Int32Array,
    is_border: AnyArray,
) -> None:
    """Work out what each pixel owes to the sink, or has from the source; no arc is laid yet."""
    marks[IS_LAID] = 0
    for p in range(nodes.shape[1]):
        excess = costs[marks[CHANGE, p], p] - costs[marks[STAY, p], p]
        # Within a region of one label the pairs' shares are 0.
        if is_border[p] and marks[STAY, p] != marks[CHANGE, p]:
            excess += price_of_change(arcs, marks, penalties, p)
        nodes[EXCESS, p] = excess


@compiled
def _label_after(marks: AnyArray, p: int) -> int:
    return int(marks[STAY, p] if marks[PARENT, p] == FREE else marks[CHANGE, p])


@compiled
def _carry_out(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    arcs: Int32Array,
    nodes: Int32Array,
    marks: AnyArray,
    penalties: Int32Array,
    costs: Int32Array,
    labels: AnyArray,
    is_border: AnyArray,
    is_touched: AnyArray,
) -> int:
    """Give the labels of a cut unless that gains nothing; return the gain (0 or less)."""
    changed = nodes[ORPHANS]
    n_changed = 0
    for p in range(labels.size):
        if _label_after(marks, p) != labels[p]:
            changed[n_changed] = p
            n_changed += 1
    gain = 0
    for i in range(n_changed):
        gain += _gain_at(arcs, marks, penalties, costs, labels, changed[i])
    if gain >= 0:
        return 0
    for i in range(n_changed):
        is_touched[labels[changed[i]]] = 1
        labels[changed[i]] = _label_after(marks, changed[i])
    for i in range(n_changed):
        _note_change(arcs, labels, is_border, is_touched, changed[i])
    return gain


@compiled
def _gain_at(
    arcs: Int32Array,
    marks: AnyArray,
    penalties: Int32Array,
    costs: Int32Array,
    labels: AnyArray,
    p: int,
) -> int:
    """Return what the change of `p` adds to the energy; the first of two counts their pair."""
    before, after = labels[p], _label_after(marks, p)
    gain = costs[after, p] - costs[before, p]
    for k in range(arcs.shape[2]):
        q = arcs[TO, p, k]
        if q < 0:
            continue
        other_before, other_after = labels[q], _label_after(marks, q)
        if p < q or other_before == other_after:
            price = penalties[after, other_after] - penalties[before, other_before]
            gain += arcs[WEIGHT, p, k] * price
    return int(gain)


@compiled
def _note_change(
    arcs: Int32Array, labels: AnyArray, is_border: AnyArray, is_touched: AnyArray, p: int
) -> None:
    """Renew what is known of the borders about `p`, and which labels the change concerns."""
    is_touched[labels[p]] = 1
    find_border(arcs, labels, is_border, p)
    for k in range(arcs.shape[2]):
        q = arcs[TO, p, k]
        if q >= 0:
            is_touched[labels[q]] = 1
            find_border(arcs, labels, is_border, q)


@compiled
def energy_of(arcs: Int32Array, penalties: Int32Array, costs: Int32Array, labels: AnyArray) -> int:
    """Return the energy of the labels (equation 6.19)."""
    energy = 0
    for p in range(labels.size):
        energy += costs[labels[p], p]
        for k in range(0, arcs.shape[2], 2):
            q = arcs[TO, p, k]
            if q >= 0:
                energy += arcs[WEIGHT, p, k] * penalties[labels[p], labels[q]]
    return energy
