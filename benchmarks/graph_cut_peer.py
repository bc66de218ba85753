"""Alpha-expansion and alpha-beta swap as one writes them with PyMaxflow and NumPy."""

import itertools
from typing import Any

import maxflow
import numpy as np

from adibas.arrays import AnyArray, BoolArray, IntArray
from adibas.graphcut.energy import LabelEnergy

Pairs = tuple[IntArray, IntArray, IntArray]


def pairs_of(energy: LabelEnergy) -> Pairs:
    """Return first pixel, second pixel and weight of each pair."""
    neighbors = energy.graph.neighbors
    first, second, weight = [], [], []
    for k in range(0, neighbors.shape[1], 2):
        has = np.flatnonzero(neighbors[:, k] >= 0)
        first.append(has)
        second.append(neighbors[has, k])
        weight.append(energy.weights[has, k])
    return (
        np.concatenate(first).astype(np.int64),
        np.concatenate(second).astype(np.int64),
        np.concatenate(weight).astype(np.int64),
    )


def plain_energy(energy: LabelEnergy, pairs: Pairs, labels: AnyArray) -> int:
    """Return the energy of equation 6.19, term by term."""
    first, second, weight = pairs
    unary = energy.costs[labels, np.arange(len(labels))].astype(np.int64).sum()
    return int(unary + (energy.penalties[labels[first], labels[second]] * weight).sum())


def peer_cut(
    energy: LabelEnergy, pairs: Pairs, stay: AnyArray, change: AnyArray
) -> tuple[int, BoolArray]:
    """Return the energy less that where all stay, and who changes.

    A pair is split as in the textbook (Kolmogorov & Zabih 2004): one arc carries it.
    """
    first, second, weight = pairs
    # Pairs between pixels that have no choice are no part of the graph.
    has_choice = stay != change
    matters = has_choice[first] | has_choice[second]
    first, second, weight = first[matters], second[matters], weight[matters]
    table, pixels = energy.penalties, np.arange(len(stay))
    both_stay = table[stay[first], stay[second]] * weight
    first_changes = table[change[first], stay[second]] * weight
    both_change = table[change[first], change[second]] * weight
    capacity = table[stay[first], change[second]] * weight + first_changes
    capacity -= both_stay + both_change
    terminal = energy.costs[change, pixels].astype(np.int64) - energy.costs[stay, pixels]
    n_pixels = len(stay)
    terminal += np.bincount(first, first_changes - both_stay, n_pixels).astype(np.int64)
    terminal += np.bincount(second, both_change - first_changes, n_pixels).astype(np.int64)
    graph: Any = maxflow.Graph[int](n_pixels, len(first))
    graph.add_nodes(n_pixels)
    carries = np.flatnonzero(capacity)
    none = np.zeros(len(carries), np.int64)
    graph.add_edges(first[carries], second[carries], capacity[carries], none)
    graph.add_grid_tedges(pixels, np.maximum(terminal, 0), np.maximum(-terminal, 0))
    flow = graph.maxflow()
    return int(flow + np.minimum(terminal, 0).sum()), graph.get_grid_segments(pixels)


def peer_expand(energy: LabelEnergy, start: AnyArray) -> tuple[AnyArray, int]:
    """Return labels and number of cuts of alpha-expansion."""
    labels = start.astype(np.int64)
    pairs, n_labels, n_idle, n_cuts = pairs_of(energy), len(energy.penalties), 0, 0
    while n_idle < n_labels:
        alpha = np.full_like(labels, n_cuts % n_labels)
        _, changes = peer_cut(energy, pairs, labels, alpha)
        after = np.where(changes, alpha, labels)
        n_idle = n_idle + 1 if (after == labels).all() else 1
        labels, n_cuts = after, n_cuts + 1
    return labels, n_cuts


def peer_swap(energy: LabelEnergy, start: AnyArray) -> tuple[AnyArray, int]:
    """Return labels and number of cuts of alpha-beta swap."""
    labels = start.astype(np.int64)
    pairs, n_cuts, has_changed = pairs_of(energy), 0, True
    least = plain_energy(energy, pairs, labels)
    while has_changed:
        has_changed = False
        for pair in itertools.combinations(range(len(energy.penalties)), 2):
            # Ties go to the label with more pixels, as ours do, so that both end at one place.
            alpha, beta = sorted(pair, key=lambda label: -np.count_nonzero(labels == label))
            is_one = (labels == alpha) | (labels == beta)
            stay, change = np.where(is_one, alpha, labels), np.where(is_one, beta, labels)
            _, changes = peer_cut(energy, pairs, stay, change)
            after = np.where(changes, change, stay)
            reached = plain_energy(energy, pairs, after)
            n_cuts += 1
            if reached < least:
                labels, least, has_changed = after, reached, True
    return labels, n_cuts
