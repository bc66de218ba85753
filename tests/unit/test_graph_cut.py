"""Cuts are exact: PyMaxflow and exhaustive search find the same values."""

import itertools
import threading

import numpy as np
import pytest

from adibas.graphcut.energy import LabelEnergy, penalty_table
from adibas.graphcut.minimising import (
    STRONG_BORDERS,
    cheapest_labels,
    expand,
    minimise,
    move,
    start_labels,
    swap,
)
from adibas.graphcut.neighbors import connect_pixels
from benchmarks.graph_cut_peer import pairs_of, peer_cut, peer_expand, peer_swap
from tests.unit.graph_cut_referee import least_energy, plain_energy, random_energy

OMEGA_2 = {(0, 1): 10, (2, 3): 10, (0, 3): 5}
N_CASES = 120


def energies(table=None, n_cases=N_CASES, **kwargs):
    for seed in range(n_cases):
        rng = np.random.default_rng(seed)
        # From loose pixels to whole regions that hold together.
        heaviest = (3, 12, 60, 400)[seed % 4]
        connectivity = (4, 8)[seed // 4 % 2]
        yield (
            rng,
            random_energy(rng, table=table, connectivity=connectivity, heaviest=heaviest, **kwargs),
        )


def random_labels(rng, energy):
    return rng.integers(0, len(energy.penalties), energy.graph.n_pixels).astype(np.int8)


def test_the_value_of_every_expansion_is_that_of_pymaxflow():
    for rng, energy in energies():
        labels, pairs = random_labels(rng, energy), pairs_of(energy)
        for alpha in range(len(energy.penalties)):
            before = labels.astype(np.int64)
            value, changes = peer_cut(energy, pairs, before, np.full_like(before, alpha))
            labels, ours = move(energy, labels, alpha)
            assert ours.value == ours.gain == value
            np.testing.assert_array_equal(labels, np.where(changes, alpha, before))


def test_the_value_of_every_swap_is_that_of_pymaxflow():
    for rng, energy in energies(OMEGA_2):
        labels, pairs = random_labels(rng, energy), pairs_of(energy)
        for alpha, beta in itertools.combinations(range(len(energy.penalties)), 2):
            before = labels.astype(np.int64)
            is_one = (before == alpha) | (before == beta)
            stay = np.where(is_one, alpha, before)
            value, _ = peer_cut(energy, pairs, stay, np.where(is_one, beta, before))
            labels, ours = move(energy, labels, alpha, beta)
            assert ours.value == value
            assert plain_energy(energy, labels) == plain_energy(energy, stay) + value
            assert ours.gain == plain_energy(energy, labels) - plain_energy(energy, before)


def test_expansion_ends_where_a_loop_with_pymaxflow_does():
    for rng, energy in energies(shape=(9, 11), n_labels=5):
        for start in (cheapest_labels(energy), random_labels(rng, energy)):
            ours = expand(energy, start)
            labels, n_cuts = peer_expand(energy, start)
            np.testing.assert_array_equal(ours.labels, labels)
            assert ours.energy == plain_energy(energy, labels)
            assert ours.n_cuts == n_cuts


@pytest.mark.parametrize("table", [None, {(0, 1): 2, (2, 3): 2, (0, 3): 2}])
def test_an_expansion_that_goes_on_from_an_earlier_one_finds_what_one_from_nothing_does(table):
    for rng, energy in energies(table, n_cases=40, shape=(9, 11)):
        labels = start = random_labels(rng, energy)
        for n_cycles in (1, 2, 3):
            for alpha in range(len(energy.penalties)):
                labels, _ = move(energy, labels, alpha)
            ours = expand(energy, start, n_cycles)
            np.testing.assert_array_equal(ours.labels, labels)
            assert ours.energy == plain_energy(energy, labels)


def test_swap_ends_where_a_loop_with_pymaxflow_does_with_fewer_cuts():
    for rng, energy in energies(OMEGA_2, n_cases=60, shape=(9, 11)):
        for start in (cheapest_labels(energy), random_labels(rng, energy)):
            ours = swap(energy, start)
            labels, n_cuts = peer_swap(energy, start)
            np.testing.assert_array_equal(ours.labels, labels)
            assert ours.energy == plain_energy(energy, labels)
            assert ours.n_cuts <= n_cuts


def test_on_tiny_grids_expansion_is_within_its_bound_of_the_best_of_all():
    n_best = 0
    for seed in range(30):
        energy = random_energy(np.random.default_rng(seed), shape=(3, 3), n_labels=3)
        best, ours = least_energy(energy), minimise(energy).energy
        assert best <= ours <= 2 * best  # the bound for penalties that are all equal
        n_best += ours == best
    assert n_best >= 27


def test_with_two_labels_one_cut_finds_the_best_of_all():
    for seed in range(40):
        energy = random_energy(np.random.default_rng(seed), shape=(3, 3), n_labels=2)
        assert swap(energy).energy == expand(energy).energy == least_energy(energy)


def test_a_swap_on_tiny_grids_is_the_best_of_all_that_two_labels_can_do():
    for seed in range(30):
        rng = np.random.default_rng(seed)
        energy = random_energy(rng, shape=(3, 3), n_labels=4, table=OMEGA_2)
        labels = random_labels(rng, energy)
        ours = swap(energy, labels)
        for alpha, beta in itertools.combinations(range(4), 2):
            is_one = np.flatnonzero((ours.labels == alpha) | (ours.labels == beta))
            for choice in itertools.product((alpha, beta), repeat=len(is_one)):
                other = ours.labels.astype(np.int64)
                other[is_one] = choice
                assert plain_energy(energy, other) >= ours.energy


def test_a_stack_of_images_is_cut_as_a_whole():
    for seed in range(20):
        energy = random_energy(np.random.default_rng(seed), shape=(3, 5, 6))
        labels, _ = peer_expand(energy, cheapest_labels(energy))
        assert expand(energy, cheapest_labels(energy)).energy == plain_energy(energy, labels)


@pytest.mark.parametrize("table", [None, OMEGA_2])
def test_the_start_is_never_worse_than_the_likeliest_labels(table):
    for _, energy in energies(table, n_cases=40):
        assert energy.of(start_labels(energy)) <= energy.of(cheapest_labels(energy))


def border_share(energy):
    """Return what the borders of the likeliest labels cost, in costs of the labels."""
    labels = cheapest_labels(energy)
    of_labels = sum(int(energy.costs[label, p]) for p, label in enumerate(labels))
    return (plain_energy(energy, labels) - of_labels) / of_labels


def can_be_better_at_one_pixel(energy, labels):
    return any(
        plain_energy(energy, np.where(np.arange(labels.size) == p, other, labels))
        < plain_energy(energy, labels)
        for p in range(labels.size)
        for other in range(len(energy.penalties))
    )


def test_where_borders_cost_most_of_it_the_start_is_settled_pixel_by_pixel():
    n_settled = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        energy = random_energy(rng, heaviest=(60, 300, 500, 1000)[seed % 4])
        start = start_labels(energy)
        if border_share(energy) > STRONG_BORDERS:
            assert not can_be_better_at_one_pixel(energy, start)
            assert plain_energy(energy, start) < plain_energy(energy, cheapest_labels(energy))
            n_settled += 1
        else:
            np.testing.assert_array_equal(start, cheapest_labels(energy))
    assert 10 <= n_settled <= 30


def test_expansions_begin_from_the_start_labels():
    for _, energy in energies(n_cases=40):
        labels, _ = peer_expand(energy, start_labels(energy))
        np.testing.assert_array_equal(minimise(energy).labels, labels)


def test_swaps_begin_from_the_likeliest_labels():
    for _, energy in energies(OMEGA_2, n_cases=40):
        labels, _ = peer_swap(energy, cheapest_labels(energy))
        np.testing.assert_array_equal(minimise(energy).labels, labels)


def test_omega_2_is_swapped_and_never_expanded():
    energy = random_energy(np.random.default_rng(0), table=OMEGA_2)
    assert not energy.is_metric
    assert minimise(energy).energy == swap(energy).energy
    with pytest.raises(ValueError, match="metric"):
        expand(energy)


def test_a_metric_that_is_not_flat_is_expanded():
    for _, energy in energies({(0, 1): 2, (1, 2): 2}, n_cases=40):
        assert energy.is_metric
        labels, _ = peer_expand(energy, cheapest_labels(energy))
        assert minimise(energy, cheapest_labels(energy)).energy == plain_energy(energy, labels)


def test_threads_that_share_an_energy_find_the_same_labels():
    energy = random_energy(np.random.default_rng(3), shape=(60, 70), n_labels=6)
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(minimise(energy).labels)) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for labels in found:
        np.testing.assert_array_equal(labels, found[0])


def test_nobody_in_the_picture_has_no_labels():
    graph = connect_pixels(np.zeros((4, 5), bool))
    nobody = LabelEnergy(
        graph, np.zeros((3, 0), np.int32), np.zeros((0, 8), np.int32), penalty_table(3, {})
    )
    assert minimise(nobody).energy == 0
    assert minimise(nobody).labels.shape == (0,)


@pytest.mark.parametrize("start", [np.full(5, 9), np.full(5, -1)])
def test_labels_to_begin_with_must_exist(start):
    graph = connect_pixels(np.ones((1, 5), bool))
    energy = LabelEnergy(
        graph, np.zeros((3, 5), np.int32), np.zeros((5, 8), np.int32), penalty_table(3, {})
    )
    with pytest.raises(ValueError, match="labels 0 to 2"):
        expand(energy, start)
