"""Random energies, and exhaustive search: what our own cuts are held against."""

import itertools

import numpy as np

from adibas.graphcut.energy import LabelEnergy, penalty_table
from adibas.graphcut.neighbors import connect_pixels
from benchmarks import graph_cut_peer
from benchmarks.graph_cut_peer import pairs_of


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


def plain_energy(energy, labels):
    """Return the energy of equation 6.19, term by term."""
    return graph_cut_peer.plain_energy(energy, pairs_of(energy), labels)


def least_energy(energy):
    """Return the least energy of all labellings."""
    n_labels, n_pixels = energy.costs.shape
    labels = np.array(list(itertools.product(range(n_labels), repeat=n_pixels)))
    first, second, weight = pairs_of(energy)
    unary = energy.costs[labels, np.arange(n_pixels)].sum(axis=1)
    pairs = energy.penalties[labels[:, first], labels[:, second]] * weight
    return int((unary + pairs.sum(axis=1)).min())
