"""Exchanging the points of labels under both energies, and what that says of doubt."""

import math

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled
from adibas.shapes.labelling_kernels import information, marginal
from adibas.shapes.tree_kernels import describe_pairs, direction_costs

SIZE_SD = 0.15
NOTHING = 40.0
"""Gap of energy beyond which nothing counts: e^-40."""


@compiled
def tree_energy(
    lengths: FloatArray, costs: FloatArray, edges: IntArray, sds: FloatArray, partners: IntArray
) -> float:
    """Return the costs of the edges, with the size that suits the lengths best.

    Parameters
    ----------
    lengths : (E, M, M) array
        Log length of each pair less the edge's mean.
    costs : (E, M, M) array
        See `direction_costs`, with the logarithms of `sds`.
    """
    precision, pull, total = 1.0 / SIZE_SD**2, 0.0, 0.0
    for e in range(len(edges)):
        j, k = partners[edges[e, 0]], partners[edges[e, 1]]
        if j >= 0 and k >= 0:
            weight = 1.0 / sds[e] ** 2
            precision += weight
            pull += weight * lengths[e, j, k]
            total += costs[e, j, k] + 0.5 * weight * lengths[e, j, k] ** 2
    return total - 0.5 * pull**2 / precision


@compiled
def exchange(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray,
    mean: FloatArray,
    loadings: FloatArray,
    noise: FloatArray,
    partners: IntArray,
    moves: IntArray,
    edges: IntArray,
    log_lengths: FloatArray,
    sds: FloatArray,
    directions: FloatArray,
    log_room: float,
    lone: float,
    incomplete: float,
    tree_share: float,
    n_exchanges: int,
) -> tuple[IntArray, float, IntArray, FloatArray]:
    """Exchange the points of labels while that helps, and tell what else they could be.

    Parameters
    ----------
    points : (M, D) array
        In the model's frame.
    moves : (P, N) array
        Permutations of the labels to try: label i takes the point of label ``moves[p, i]``.
        Beside them each label may lose its point or take one that no label has.
    log_room, lone : float
        Log volume in which points may be; what a label without a point and a point without a
        label cost beside it.
    incomplete : float
        What it costs once that there are both.
    tree_share : float
        Weight of the tree's energy against the model's.

    Returns
    -------
    partners : (N,) array
    energy : float
    others : (A, N) array
    energies : (A,) array
        Infinite where there is no such exchange.
    """
    n_labels = len(partners)
    n_points = len(points)
    _, n_bands, n_sectors = directions.shape
    pairs, bands, sectors = describe_pairs(points, n_bands, n_sectors)
    costs = direction_costs(pairs, bands, sectors, directions, points.shape[1], log_room, 0)
    lengths = np.empty((len(edges), n_points, n_points))
    for e in range(len(edges)):
        costs[e] += math.log(sds[e])
        lengths[e] = pairs - log_lengths[e]
    most = len(moves) + n_labels * (1 + n_points)
    others = np.empty((most, n_labels), np.int64)
    energies = np.full(most, np.inf)
    current = partners.copy()
    lower = information(loadings, noise, current)
    energy = _energy(
        points, mean, loadings, noise, current, lower, lengths, costs, edges, sds, log_room, lone,
        incomplete, tree_share,
    )  # fmt: skip
    for _ in range(n_exchanges):
        count = _list_exchanges(current, moves, n_points, others)
        energies[count:] = np.inf
        lower = information(loadings, noise, current)
        for a in range(count):
            is_same_set = True
            for i in range(n_labels):
                is_same_set = is_same_set and (others[a, i] >= 0) == (current[i] >= 0)
            factor = lower if is_same_set else information(loadings, noise, others[a])
            energies[a] = _energy(
                points, mean, loadings, noise, others[a], factor, lengths, costs, edges, sds,
                log_room, lone, incomplete, tree_share,
            )  # fmt: skip
        best = np.argmin(energies[:count])
        if energies[best] >= energy - 1e-9:
            break
        current = others[best].copy()
        energy = energies[best]
    return current, energy, others, energies


@compiled
def _list_exchanges(partners: IntArray, moves: IntArray, n_points: int, others: IntArray) -> int:
    """Fill `others` with what differs from `partners` by one exchange; return how many."""
    n_labels = len(partners)
    free = _unnamed(partners, n_points)
    at = 0
    for p in range(len(moves)):
        is_other = False
        for i in range(n_labels):
            others[at, i] = partners[moves[p, i]]
            is_other = is_other or others[at, i] != partners[i]
        at += 1 if is_other else 0
    for i in range(n_labels):
        if partners[i] >= 0:
            others[at] = partners
            others[at, i] = -1
            at += 1
        for j in free:
            others[at] = partners
            others[at, i] = j
            at += 1
    return at


@compiled
def _unnamed(partners: IntArray, n_points: int) -> IntArray:
    """Return the points that no label has."""
    is_free = np.ones(n_points, np.bool_)
    for j in partners:
        if j >= 0:
            is_free[j] = False
    return np.flatnonzero(is_free)


@compiled
def _energy(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray,
    mean: FloatArray,
    loadings: FloatArray,
    noise: FloatArray,
    partners: IntArray,
    lower: FloatArray,
    lengths: FloatArray,
    costs: FloatArray,
    edges: IntArray,
    sds: FloatArray,
    log_room: float,
    lone: float,
    incomplete: float,
    tree_share: float,
) -> float:
    n_named = 0
    for i in range(len(partners)):
        n_named += 1 if partners[i] >= 0 else 0
    of_model = marginal(points, mean, loadings, noise, partners, lower) - log_room * n_named
    of_tree = tree_energy(lengths, costs, edges, sds, partners)
    energy = (1.0 - tree_share) * of_model + tree_share * of_tree - lone * n_named
    return energy + (incomplete if n_named < min(len(partners), len(points)) else 0.0)


@compiled
def add_masses(masses: FloatArray, partners: IntArray, probability: float) -> None:
    """Add the probability of one set of names to (M, N + 1) masses; the last: without a name."""
    n_labels = len(partners)
    masses[:, n_labels] += probability
    for i in range(n_labels):
        if partners[i] >= 0:
            masses[partners[i], i] += probability
            masses[partners[i], n_labels] -= probability


@compiled
def weigh(
    masses: FloatArray,
    others: IntArray,
    energies: FloatArray,
    lowest: float,
    temperature: float,
) -> None:
    """Add the probabilities of sets of names to the masses of each point's names."""
    for a in range(len(energies)):
        gap = (energies[a] - lowest) / temperature
        if gap < NOTHING:
            add_masses(masses, others[a], math.exp(-gap))
