"""Labels to begin with: each pixel in turn takes the best label beside its neighbours'.

Source: Besag, On the statistical analysis of dirty pictures (iterated conditional modes), 1986.
"""

import numpy as np

from adibas.arrays import AnyArray, Int32Array
from adibas.graphcut.move_kernels import find_border
from adibas.graphcut.pair_kernels import TO, WEIGHT
from adibas.kernels import compiled


@compiled
def settle_labels(
    arcs: Int32Array, penalties: Int32Array, costs: Int32Array, labels: AnyArray, max_sweeps: int
) -> int:
    """Lower the energy of `labels` in place, pixel by pixel; return the number of sweeps.

    `labels` begin as the cheapest of each pixel: within a region of one label none is better.
    Every other sweep runs against the image's rows, so that no direction is favoured.
    """
    n_labels, n_pixels = costs.shape
    is_waiting = np.zeros(n_pixels, np.int8)
    for p in range(n_pixels):
        find_border(arcs, labels, is_waiting, p)
    price = np.empty(n_labels, np.int64)
    for sweep in range(max_sweeps):
        n_changed = 0
        for i in range(n_pixels):
            p = n_pixels - 1 - i if sweep & 1 else i
            if not is_waiting[p]:
                continue
            is_waiting[p] = 0
            best = _best_label(arcs, penalties, costs, labels, price, p)
            if best != labels[p]:
                labels[p] = best
                n_changed += 1
                _wake_neighbors(arcs, is_waiting, p)
        if n_changed == 0:
            return sweep
    return max_sweeps


@compiled
def _wake_neighbors(arcs: Int32Array, is_waiting: AnyArray, p: int) -> None:
    for k in range(arcs.shape[2]):
        if arcs[TO, p, k] >= 0:
            is_waiting[arcs[TO, p, k]] = 1


@compiled
def _best_label(
    arcs: Int32Array,
    penalties: Int32Array,
    costs: Int32Array,
    labels: AnyArray,
    price: AnyArray,
    p: int,
) -> int:
    """Return the label with the least energy at `p`; its own where that is as good."""
    for label in range(price.size):
        price[label] = costs[label, p]
    for k in range(arcs.shape[2]):
        q = arcs[TO, p, k]
        if q >= 0:
            for label in range(price.size):
                price[label] += arcs[WEIGHT, p, k] * penalties[labels[q], label]
    best = labels[p]
    for label in range(price.size):
        if price[label] < price[best]:
            best = label
    return int(best)
