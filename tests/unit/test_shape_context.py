"""Shape contexts tell which point is which, and how much two shapes differ."""

import math

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator
from scipy.stats import chisquare

from adibas.shapes import context_kernels as kernels
from adibas.shapes.shape_context import (
    ContextParams,
    match_shapes,
    mean_distance,
    nearest_shape,
    shape_contexts,
)
from adibas.shapes.thin_plate import fit_warp

# A standing person from the front, in centimetres: x to the image's right, y down.
STANDING = np.array(
    [[0, 10], [0, 30], [18, 35], [-18, 35], [25, 62], [-25, 62], [28, 88], [-28, 88],
     [0, 60], [10, 92], [-10, 92], [11, 132], [-11, 132], [12, 172], [-12, 172]], float,
)  # fmt: skip


def a_person(seed, sd=2.0, scale=3.0):
    rng = np.random.default_rng(seed)
    return scale * (STANDING + sd * rng.normal(size=STANDING.shape)) + [200.0, 40.0]


@pytest.mark.parametrize("n_dimensions", [2, 3])
def test_the_spline_is_that_of_scipy(n_dimensions):
    rng = np.random.default_rng(1)
    source, target, others = rng.normal(size=(3, 12, n_dimensions))
    warp = fit_warp(target, source)
    kernel = "thin_plate_spline" if n_dimensions == 2 else "linear"
    peer = RBFInterpolator(source, target, kernel=kernel, degree=1)
    np.testing.assert_allclose(warp.apply(others), peer(others), atol=1e-7)
    np.testing.assert_allclose(warp.apply(source), target, atol=1e-9)


@pytest.mark.parametrize("smoothing", [0.0, 0.3, math.inf])
def test_an_affine_change_bends_nothing(smoothing):
    rng = np.random.default_rng(2)
    source = rng.normal(size=(9, 2))
    matrix, shift = np.array([[1.3, 0.2], [-0.4, 0.9]]), np.array([3.0, -2.0])
    warp = fit_warp(source @ matrix + shift, source, smoothing)
    assert warp.bending_energy == pytest.approx(0, abs=1e-12)
    others = rng.normal(size=(5, 2))
    np.testing.assert_allclose(warp.apply(others), others @ matrix + shift, atol=1e-9)


def test_more_bending_costs_more_and_size_does_not_matter():
    rng = np.random.default_rng(3)
    source, off = rng.normal(size=(2, 10, 2))
    energies = [fit_warp(source + share * off, source).bending_energy for share in (0.1, 0.2, 0.4)]
    assert energies[0] < energies[1] < energies[2]
    assert energies[1] == pytest.approx(4 * energies[0])
    larger = fit_warp(100 * (source + 0.1 * off), 100 * source).bending_energy
    assert larger == pytest.approx(energies[0])


def test_smoothing_bends_less_and_passes_by():
    rng = np.random.default_rng(4)
    source, off = rng.normal(size=(2, 10, 2))
    target = source + 0.2 * off
    energies = [fit_warp(target, source, one).bending_energy for one in (0, 0.1, 1, 10, math.inf)]
    assert energies == sorted(energies, reverse=True)
    assert energies[-1] == 0


def test_points_on_a_line_bend_into_nothing():
    line = np.outer(np.arange(6.0), [1, 2])
    assert fit_warp(line, line) is None
    assert fit_warp(line[:2], line[:2], math.inf) is None


def test_a_context_counts_every_other_point_once():
    contexts = shape_contexts(STANDING, ContextParams(outer=10.0))
    assert contexts.shape == (15, 60)
    np.testing.assert_allclose(contexts.sum(axis=1), 1)


def test_a_context_counts_by_distance_and_direction():
    # Brute force: one neighbour to the right in the last ring, one below in the first.
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 0.1]])
    counts = kernels.count_contexts(points, np.array([0.2, 0.5, 2.0]), 4)
    expected = np.zeros((3, 4))
    expected[2, [3, 0]] = 0.5  # the direction 0 lies between the last angle and the first
    expected[0, [0, 1]] = 0.5  # and a right angle, downwards, between the first two
    np.testing.assert_allclose(counts[0], expected)


def test_contexts_know_neither_place_nor_size():
    np.testing.assert_allclose(
        shape_contexts(7 * STANDING + [100.0, -50.0]), shape_contexts(STANDING), atol=1e-9
    )
    assert mean_distance(7 * STANDING) == pytest.approx(7 * mean_distance(STANDING))


def test_costs_are_chi_square_distances():
    rng = np.random.default_rng(5)
    first, second = rng.random((4, 30)), rng.random((6, 30))
    first /= first.sum(axis=1, keepdims=True)
    second /= second.sum(axis=1, keepdims=True)
    costs = kernels.compare_contexts(first, second)
    # Half the statistic of each against their mean, both halves added: (g - h)^2 / (2 (g + h)).
    both = (first[1] + second[2]) / 2
    statistic = chisquare(first[1], both).statistic + chisquare(second[2], both).statistic
    assert costs[1, 2] == pytest.approx(statistic / 2)
    assert costs.shape == (4, 6)
    assert kernels.compare_contexts(first, first).diagonal() == pytest.approx(0)


@pytest.mark.parametrize("seed", range(20))
def test_another_person_s_joints_find_their_partners(seed):
    order = np.random.default_rng(seed).permutation(15)
    match = match_shapes(STANDING, a_person(seed)[order])
    np.testing.assert_array_equal(order[match.partners], np.arange(15))
    assert len(match.rounds) == 3
    assert match.distance < 0.5


@pytest.mark.parametrize("seed", range(10))
def test_missing_and_additional_points_stay_alone(seed):
    person = a_person(seed, sd=1.0)
    wall = person.mean(axis=0) + np.array([[330.0, -150.0]])
    points = np.concatenate([np.delete(person, [6, 14], axis=0), wall])
    match = match_shapes(STANDING, points)
    truth = np.delete(np.arange(15), [6, 14])
    for point, partner in enumerate(match.partners):
        if partner >= 0:
            assert partner < 13
            assert truth[partner] == point
    assert np.isnan(match.costs[match.partners < 0]).all()
    assert np.count_nonzero(match.partners >= 0) >= 11


def test_what_looks_otherwise_is_no_partner():
    # Two pairs of points that stand alike; the colour tells which is which.
    first = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 3.0]])
    second = first[[1, 0, 3, 2, 4]] + 0.01
    appearance = (np.array([0, 1, 0, 1, 0])[:, None] != np.array([0, 1, 0, 1, 0])) * 1.0
    swapped = match_shapes(first, second, appearance, ContextParams(position_weight=0.0))
    plain = match_shapes(first, second)
    assert plain.partners[0] == 1
    assert swapped.partners[0] == 0


def test_the_nearest_posture_is_named():
    arms_up = STANDING.copy()
    arms_up[[4, 5, 6, 7]] = [[32, 12], [-32, 12], [36, -15], [-36, -15]]
    sitting = STANDING.copy()
    sitting[11:] = [[25, 96], [-25, 96], [26, 136], [-26, 136]]
    known = [STANDING, arms_up, sitting]
    for index, posture in enumerate(known):
        noise = np.random.default_rng(index).normal(size=posture.shape)
        found, distance = nearest_shape(2 * posture + 2 * noise, known)
        assert found == index
        assert distance >= 0


@pytest.mark.parametrize("points", [np.zeros((0, 2)), np.zeros((1, 2)), np.zeros((5, 2))])
def test_nothing_is_matched_to_no_shape(points):
    match = match_shapes(STANDING, points)
    assert (match.partners == -1).all()
    assert match.warp is None
    assert match.distance == math.inf


def test_three_points_are_matched_without_a_spline():
    match = match_shapes(STANDING[:3], 2 * STANDING[:3])
    assert match.warp is None
    assert match.partners.tolist() == [0, 1, 2]
    assert len(match.rounds) == 1
