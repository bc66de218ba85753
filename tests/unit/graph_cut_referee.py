"""Cuts and loops with PyMaxflow, and exhaustive search: what our own cuts are held against."""

import itertools

import maxflow
import numpy as np

from adibas.graphcut.energy import LabelEnergy, penalty_table
from adibas.graphcut.minimising import cheapest_labels
from adibas.graphcut.neighbors import connect_pixels


def random_energy(rng, shape=(6, 7), n_labels=4, table=None, connectivity=8, heaviest=60):
    """Return an energy on a random mask, small whole numbers: ties are frequent."""
    mask = rng.random(shape) < 0.8
    graph = connect_pixels(mask, connectivity)
    weights = np.zeros(graph.neighbors.shape, np.int32)
    for k in range(0, weights.shape[1], 2):
        has = graph.neighbors[:, k] >= 0
        weights[has, k] = rng.integers(0, heaviest, has.sum())
        weights[graph.neighbors[has, k], k + 1] = weights[has, k]
    costs = rng.integers(0, 100, (n_labels, graph.n_pixels)).astype(np.int32)
    penalties = penalty_table(n_labels, table or {})
    return LabelEnergy(graph, costs, weights, penalties)


def pairs_of(energy):
    """Return first pixel, second pixel and weight of each pair."""
    neighbors = energy.graph.neighbors
    first, second, weight = [], [], []
    for k in range(0, neighbors.shape[1], 2):
        has = np.flatnonzero(neighbors[:, k] >= 0)
        first.append(has)
        second.append(neighbors[has, k])
        weight.append(energy.weights[has, k])
    return tuple(np.concatenate(parts).astype(np.int64) for parts in (first, second, weight))


def plain_energy(energy, labels):
    """Return the energy of equation 6.19, term by term."""
    first, second, weight = pairs_of(energy)
    unary = energy.costs[labels, np.arange(len(labels))].astype(np.int64).sum()
    return int(unary + (energy.penalties[labels[first], labels[second]] * weight).sum())


def peer_cut(energy, pairs, stay, change):
    """Return the energy less that where all stay, and who changes, by PyMaxflow."""
    first, second, weight = pairs
    table, pixels = energy.penalties.astype(np.int64), np.arange(len(stay))
    both_stay = table[stay[first], stay[second]] * weight
    second_changes = table[stay[first], change[second]] * weight
    first_changes = table[change[first], stay[second]] * weight
    both_change = table[change[first], change[second]] * weight
    # The textbook's split of a pair, another than the one under test.
    terminal = (energy.costs[change, pixels] - energy.costs[stay, pixels]).astype(np.int64)
    np.add.at(terminal, first, first_changes - both_stay)
    np.add.at(terminal, second, both_change - first_changes)
    graph = maxflow.Graph[int](len(stay), len(first))
    graph.add_nodes(len(stay))
    capacity = second_changes + first_changes - both_stay - both_change
    can_choose = capacity > 0
    graph.add_edges(
        first[can_choose],
        second[can_choose],
        capacity[can_choose],
        np.zeros(can_choose.sum(), np.int64),
    )
    graph.add_grid_tedges(pixels, np.maximum(terminal, 0), np.maximum(-terminal, 0))
    flow = graph.maxflow()
    return int(flow + np.minimum(terminal, 0).sum()), graph.get_grid_segments(pixels)


def peer_expand(energy, start=None):
    """Return labels and number of cuts of alpha-expansion with PyMaxflow."""
    labels = (cheapest_labels(energy) if start is None else start).astype(np.int64)
    pairs, n_labels, n_idle, n_cuts = pairs_of(energy), len(energy.penalties), 0, 0
    while n_idle < n_labels:
        alpha = np.full_like(labels, n_cuts % n_labels)
        _, changes = peer_cut(energy, pairs, labels, alpha)
        after = np.where(changes, alpha, labels)
        n_idle = n_idle + 1 if (after == labels).all() else 1
        labels, n_cuts = after, n_cuts + 1
    return labels, n_cuts


def peer_swap(energy, start=None):
    """Return labels and number of cuts of alpha-beta swap with PyMaxflow."""
    labels = (cheapest_labels(energy) if start is None else start).astype(np.int64)
    pairs, n_cuts, has_changed = pairs_of(energy), 0, True
    least = plain_energy(energy, labels)
    while has_changed:
        has_changed = False
        for alpha, beta in itertools.combinations(range(len(energy.penalties)), 2):
            is_one = (labels == alpha) | (labels == beta)
            stay, change = np.where(is_one, alpha, labels), np.where(is_one, beta, labels)
            _, changes = peer_cut(energy, pairs, stay, change)
            after = np.where(changes, change, stay)
            n_cuts += 1
            if plain_energy(energy, after) < least:
                labels, least, has_changed = after, plain_energy(energy, after), True
    return labels, n_cuts


def least_energy(energy):
    """Return the least energy of all labellings."""
    n_labels, n_pixels = energy.costs.shape
    labels = np.array(list(itertools.product(range(n_labels), repeat=n_pixels)))
    first, second, weight = pairs_of(energy)
    unary = energy.costs[labels, np.arange(n_pixels)].sum(axis=1)
    pairs = energy.penalties[labels[:, first], labels[:, second]] * weight
    return int((unary + pairs.sum(axis=1)).min())
