"""The parts of the search for names, each against another way to compute it."""

from itertools import permutations, product

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from scipy.stats import multivariate_normal

from adibas.shapes.assignment_kernels import assign
from adibas.shapes.labelling_exchange_kernels import weigh
from adibas.shapes.labelling_kernels import information, leave_one_out, marginal, pair_costs
from adibas.shapes.labelling_search_kernels import lay, turn_of
from adibas.shapes.tree_kernels import add_lengths, describe_pairs, direction_costs, min_marginals

N, D, Q = 5, 3, 4


def a_model(seed=0):
    rng = np.random.default_rng(seed)
    mean = rng.normal(size=(N, D))
    loadings = 0.4 * rng.normal(size=(N, D, Q))
    return mean, loadings, rng.uniform(0.01, 0.1, N), rng.normal(size=(N + 1, D))


def its_covariance(loadings, noise):
    rows = loadings.reshape(-1, Q)
    return rows @ rows.T + np.diag(np.repeat(noise, D))


@pytest.mark.parametrize("shape", [(6, 6), (4, 7), (7, 4), (1, 3)])
def test_assignment_is_as_cheap_as_scipys(shape):
    for seed in range(20):
        costs = np.random.default_rng(seed).normal(size=shape)
        partners = assign(costs)
        taken = partners[partners >= 0]
        assert len(set(taken)) == len(taken)
        ours = costs[np.flatnonzero(partners >= 0), taken].sum()
        rows, columns = linear_sum_assignment(np.minimum(costs, 0))
        assert ours == pytest.approx(np.minimum(costs, 0)[rows, columns].sum())


def test_a_pair_that_costs_more_than_being_alone_is_not_made():
    np.testing.assert_array_equal(assign(np.array([[1.0, 2.0], [3.0, -1.0]])), [-1, 1])


def test_the_energy_is_the_density_of_the_named_points():
    mean, loadings, noise, points = a_model()
    for partners in (np.array([3, 0, 5, 1, 2]), np.array([3, -1, 5, -1, 2])):
        lower = information(loadings, noise, partners)
        energy = marginal(points, mean, loadings, noise, partners, lower)
        kept = np.repeat(partners >= 0, D)
        covariance = its_covariance(loadings, noise)[np.ix_(kept, kept)]
        named = points[partners[partners >= 0]].ravel()
        peer = multivariate_normal(mean.ravel()[kept], covariance).logpdf(named)
        assert energy == pytest.approx(-peer)


def test_a_point_is_judged_by_all_others():
    mean, loadings, noise, points = a_model(1)
    partners = np.array([3, 0, -1, 1, 2])
    lower = information(loadings, noise, partners)
    places, covariances, _ = leave_one_out(points, mean, loadings, noise, partners, lower)
    full = its_covariance(loadings, noise)
    for i in range(N):
        own = np.repeat(np.arange(N) == i, D)
        rest = np.repeat((np.arange(N) != i) & (partners >= 0), D)
        others = points[partners[(np.arange(N) != i) & (partners >= 0)]].ravel()
        gain = full[np.ix_(own, rest)] @ np.linalg.inv(full[np.ix_(rest, rest)])
        expected = mean[i] + gain @ (others - mean.ravel()[rest])
        np.testing.assert_allclose(places[i], expected, atol=1e-9)
        conditional = full[np.ix_(own, own)] - gain @ full[np.ix_(rest, own)]
        np.testing.assert_allclose(covariances[i], conditional, atol=1e-9)


def test_pair_costs_are_densities_less_what_being_alone_costs():
    rng = np.random.default_rng(2)
    points, places = rng.normal(size=(4, 3)), rng.normal(size=(2, 3))
    factors = rng.normal(size=(2, 3, 3))
    covariances = factors @ np.swapaxes(factors, 1, 2) + 0.1 * np.eye(3)
    costs = pair_costs(points, places, covariances, 5.0, 2.0)
    for i, j in product(range(2), range(4)):
        peer = multivariate_normal(places[i], 2 * covariances[i]).logpdf(points[j])
        assert costs[i, j] == pytest.approx(-peer - 5.0)


def test_a_turn_is_right_handed():
    quarter = turn_of(np.array([0.0, np.pi / 2, 0.0]), 3)
    np.testing.assert_allclose(quarter @ [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], atol=1e-12)
    plane = turn_of(np.array([0.0, 0.0, np.pi / 2]), 2)
    np.testing.assert_allclose(plane @ [1.0, 0.0], [0.0, 1.0], atol=1e-12)


def test_the_pose_of_named_points_is_found():
    rng = np.random.default_rng(3)
    mean = rng.normal(size=(8, 3))
    mean -= mean.mean(axis=0)
    columns = [np.tile(axis, (8, 1)) for axis in np.eye(3)]
    columns += [np.cross(axis, mean) for axis in np.eye(3)] + [mean]
    pose_sd = np.array([0.4, 0.4, 0.4, 0.3, 0.3, 0.3, 0.15])
    loadings = np.stack([c * sd for c, sd in zip(columns, pose_sd, strict=True)], axis=-1)
    turned = turn_of(np.array([0.1, -0.3, 0.15]), 3)
    points = np.ascontiguousarray(1.1 * mean @ turned.T + [0.2, -0.1, 0.3])
    moved, turn, scale = lay(
        points, np.eye(3), 1.0, mean, loadings, np.full(8, 1e-6), pose_sd, np.arange(8), 8
    )
    np.testing.assert_allclose(moved, mean, atol=1e-3)
    np.testing.assert_allclose(turn @ turned, np.eye(3), atol=1e-3)
    assert scale == pytest.approx(1.1, rel=1e-3)


def test_messages_on_a_tree_find_what_trying_all_finds():
    rng = np.random.default_rng(4)
    edges = np.array([[1, 0], [1, 2], [2, 3]])
    n_labels, n_points, alone = 4, 4, 0.7
    costs = rng.normal(size=(3, n_points, n_points))
    ours = min_marginals(costs, edges, n_labels, alone)
    totals = {}
    for states in product(range(n_points + 1), repeat=n_labels):
        total = alone * states.count(n_points)
        for cost, (parent, child) in zip(costs, edges, strict=True):
            if n_points not in (states[parent], states[child]):
                total += cost[states[parent], states[child]]
        totals[states] = total
    for i in range(n_labels):
        without = min(t for s, t in totals.items() if s[i] == n_points)
        for j in range(n_points):
            best = min(t for s, t in totals.items() if s[i] == j)
            assert ours[i, j] == pytest.approx(best - without)


def test_directions_are_counted_from_x_towards_z_and_by_height():
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [0.1, 0.0, 1.0], [0.0, 2.0, 0.0]])
    logs, bands, sectors = describe_pairs(points, 12, 24)
    assert (sectors[0, 1], sectors[0, 2]) == (0, 5)
    assert (bands[0, 1], bands[0, 3], bands[3, 0]) == (6, 11, 0)
    assert logs[0, 3] == pytest.approx(np.log(2))
    costs = direction_costs(logs, bands, sectors, np.zeros((1, 12, 24)), 3, 0.0, 0)
    before = costs[0, 0, 3]
    add_lengths(costs, logs, np.array([np.log(2)]), np.array([0.1]))
    assert costs[0, 0, 3] == pytest.approx(before + np.log(0.1))


def test_probabilities_fall_with_energy():
    masses = np.zeros((2, 3))
    others = np.array([[0, 1], [1, 0], [0, -1]])
    weigh(masses, others, np.array([0.0, np.log(4), 1e9]), 0.0, 1.0)
    np.testing.assert_allclose(masses, [[1.0, 0.25, 0.0], [0.25, 1.0, 0.0]], atol=1e-12)


def test_every_order_of_points_gives_the_same_energy():
    mean, loadings, noise, points = a_model(5)
    energies = []
    for order in list(permutations(range(N)))[:10]:
        shuffled = np.ascontiguousarray(points[list(order)])
        partners = np.argsort(order)
        lower = information(loadings, noise, partners)
        energies.append(marginal(shuffled, mean, loadings, noise, partners, lower))
    np.testing.assert_allclose(energies, energies[0])
