"""Neighbours, boundaries and energies, against slow and plain versions."""

import math

import numpy as np
import pytest

from adibas.graphcut.boundary import boundary_weights, depth_and_color
from adibas.graphcut.energy import (
    EnergyParams,
    LabelEnergy,
    equal_penalties,
    label_energy,
    penalty_table,
)
from adibas.graphcut.in_time import follow, ties_in_time
from adibas.graphcut.minimising import minimise
from adibas.graphcut.neighbors import connect_pixels
from tests.unit.graph_cut_referee import plain_energy

RNG = np.random.default_rng(1)
MASK = RNG.random((7, 9)) < 0.7


def places(graph):
    return np.stack(np.unravel_index(graph.pixels, graph.shape), axis=1)


@pytest.mark.parametrize(("connectivity", "reach"), [(4, 1.0), (8, math.sqrt(2))])
@pytest.mark.parametrize("mask", [MASK, RNG.random((3, 5, 6)) < 0.7])
def test_neighbors_are_all_pixels_of_the_mask_that_are_near(mask, connectivity, reach):
    graph = connect_pixels(mask, connectivity)
    at = places(graph)
    assert [tuple(place) for place in at] == [tuple(place) for place in np.argwhere(mask)]
    step = at[:, None] - at[None]
    near = np.abs(step).sum(-1) > 0
    near &= np.linalg.norm(step[..., -2:], axis=-1) <= reach
    if mask.ndim == 3:
        in_time = np.abs(step[..., 0])
        near &= (in_time == 0) | ((in_time == 1) & (step[..., -2:] == 0).all(-1))
    for pixel, row in enumerate(graph.neighbors):
        assert sorted(row[row >= 0]) == list(np.flatnonzero(near[pixel]))


def test_every_arc_has_its_return_and_its_distance():
    graph = connect_pixels(MASK, 8)
    at = places(graph)
    for pixel, k in np.argwhere(graph.neighbors >= 0):
        other = graph.neighbors[pixel, k]
        assert graph.neighbors[other, k ^ 1] == pixel
        assert graph.distances[k] == pytest.approx(np.linalg.norm(at[pixel] - at[other]))


def test_masks_of_other_dimensions_and_connectivities_are_refused():
    with pytest.raises(ValueError, match="2 or 3 dimensions"):
        connect_pixels(np.ones(4, bool))
    with pytest.raises(ValueError, match="4 or 8"):
        connect_pixels(MASK, 6)


def test_weights_are_those_of_equation_6_23():
    color = RNG.integers(0, 255, (*MASK.shape, 3)).astype(np.float64)
    graph = connect_pixels(MASK, 8)
    values = color[MASK]
    squares = {
        (p, q): ((values[p] - values[q]) ** 2).sum()
        for p, row in enumerate(graph.neighbors)
        for q in row[row >= 0]
    }
    beta = 1 / (2 * np.mean(list(squares.values())))
    weights = boundary_weights(graph, color)
    for p, k in np.argwhere(graph.neighbors >= 0):
        square = squares[p, graph.neighbors[p, k]]
        assert weights[p, k] == pytest.approx(math.exp(-beta * square) / graph.distances[k])
    assert (weights[graph.neighbors < 0] == 0).all()


def test_where_nothing_differs_only_the_distance_counts():
    graph = connect_pixels(MASK, 8)
    weights = boundary_weights(graph, np.ones(MASK.shape, np.float32))
    np.testing.assert_allclose(weights, (graph.neighbors >= 0) / graph.distances)


def test_unmeasured_pixels_hold_as_average_ones():
    depth_m = RNG.random(MASK.shape)
    depth_m[3, 4] = np.nan
    mask = np.ones(MASK.shape, bool)
    graph = connect_pixels(mask, 4)
    weights = boundary_weights(graph, depth_m)
    hole = 3 * MASK.shape[1] + 4
    np.testing.assert_allclose(weights[hole], math.exp(-0.5))
    assert np.isfinite(weights).all()


def test_a_picture_of_another_size_is_refused():
    with pytest.raises(ValueError, match="shape"):
        boundary_weights(connect_pixels(MASK), np.ones((3, 3)))


def test_depth_spreads_over_the_range_of_colors():
    depth_m = np.array([[1.0, 2.0], [np.nan, 1.5]])
    color = np.full((2, 2, 3), 7, np.uint8)
    picture = depth_and_color(depth_m, color)
    np.testing.assert_allclose(picture[..., 0], [[0, 255], [np.nan, 127.5]])
    assert (picture[..., 1:] == 7).all()
    assert np.isnan(depth_and_color(np.full((2, 2), np.nan), color)[..., 0]).all()


def test_the_energy_is_that_of_equations_6_19_to_6_23():
    graph = connect_pixels(MASK, 8)
    probabilities = RNG.dirichlet(np.ones(3), graph.n_pixels)
    probabilities[0] = (1, 0, 0)
    boundary = boundary_weights(graph, RNG.random(MASK.shape))
    table = penalty_table(3, {(0, 2): 10})
    energy = label_energy(graph, probabilities, boundary, table, EnergyParams(smoothness=7))
    labels = RNG.integers(0, 3, graph.n_pixels)
    unary = -np.log(np.maximum(probabilities, 1e-5))[np.arange(len(labels)), labels].sum()
    pairs = sum(
        7 * boundary[p, k] * table[labels[p], labels[graph.neighbors[p, k]]]
        for p, k in np.argwhere(graph.neighbors >= 0)
    )
    n_terms = graph.n_pixels + 10 * (graph.neighbors >= 0).sum() / 2
    assert abs(energy.of(labels) / 1000 - (unary + pairs / 2)) < 0.0005 * n_terms
    assert energy.of(labels) == plain_energy(energy, labels)


def test_the_tables_are_those_of_the_thesis():
    assert (equal_penalties(4) == 1 - np.eye(4)).all()
    table = penalty_table(4, {(0, 3): 10, (2, 1): 5})
    assert table[3, 0] == table[0, 3] == 10
    assert table[1, 2] == 5
    assert table[0, 1] == 1
    assert not table.diagonal().any()


def test_penalties_are_symmetric_and_never_negative():
    graph = connect_pixels(np.ones((1, 2), bool))
    costs, weights = np.zeros((2, 2), np.int32), np.zeros((2, 8), np.int32)
    for table in ([[0, 1], [2, 0]], [[1, 1], [1, 0]], [[0, -1], [-1, 0]]):
        with pytest.raises(ValueError, match="symmetric"):
            LabelEnergy(graph, costs, weights, np.array(table, np.int32))
    with pytest.raises(ValueError, match="1 to 127"):
        penalty_table(128, {})


def test_what_32_bits_cannot_hold_is_refused():
    graph = connect_pixels(np.ones((2, 2), bool))
    probabilities, boundary = np.full((4, 2), 0.5), np.ones((4, 8))
    for smoothness in (1e5, 1e7):
        with pytest.raises(ValueError, match="32 bits"):
            params = EnergyParams(smoothness=smoothness)
            label_energy(graph, probabilities, boundary, equal_penalties(2), params)
    with pytest.raises(ValueError, match="NaN"):
        label_energy(graph, np.full((4, 2), np.nan), boundary, equal_penalties(2))


@pytest.mark.parametrize(
    "wrong", [{"smoothness": -1.0}, {"least_probability": 0.0}, {"units_per_nat": 0}]
)
def test_senseless_parameters_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        EnergyParams(**wrong)


def test_the_frame_before_holds_labels_where_nothing_else_decides():
    graph = connect_pixels(np.ones((4, 6), bool), 4)
    even = np.full((graph.n_pixels, 3), 1 / 3)
    energy = label_energy(graph, even, np.zeros(graph.neighbors.shape), equal_penalties(3))
    previous = RNG.integers(0, 3, graph.n_pixels)
    tied = follow(energy, previous, np.full(graph.n_pixels, 20.0))
    np.testing.assert_array_equal(minimise(tied).labels, previous)
    unknown = follow(energy, np.full(graph.n_pixels, -1), np.full(graph.n_pixels, 20.0))
    np.testing.assert_array_equal(unknown.costs, energy.costs)


def test_ties_in_time_fall_with_the_depth_that_changed_as_equation_6_23_says():
    now, before = RNG.normal(2.0, 0.01, (2, 50))
    now[3], before[7] = np.nan, np.nan
    known = np.isfinite(now) & np.isfinite(before)
    squares = [(a - b) ** 2 for a, b in zip(now[known], before[known], strict=True)]
    beta = 1 / (2 * sum(squares) / len(squares))
    ties = ties_in_time(now, before)
    assert ties[known] == pytest.approx([math.exp(-beta * square) for square in squares])
    assert not ties[~known].any()
    np.testing.assert_array_equal(ties_in_time(now[known], now[known]), 1.0)
    np.testing.assert_array_equal(ties_in_time(np.full(2, np.nan), np.ones(2)), 0.0)
