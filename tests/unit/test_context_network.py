"""A network on occupied cells is the usual one with zeros elsewhere; its derivatives are right."""

import itertools

import numpy as np
import pytest
from scipy.signal import correlate

from adibas.arrays import AnyArray, BoolArray, Float32Array, FloatArray, IntArray
from adibas.context.examples import ContextExample, batch_of
from adibas.context.kernels import AS_IT_IS, RECTIFIED, convolved, risen
from adibas.context.layers import NormalizedConvolution
from adibas.context.network import NetworkShape, with_nothing
from adibas.context.sites import SiteLevel, site_levels
from adibas.context.training import (
    ContextTrainer,
    ContextTraining,
    LearningNetwork,
    label_shares,
    label_weights,
    loss_and_slope,
)
from adibas.even_blocks import even_blocks

SHAPE = NetworkShape(n_inputs=5, n_labels=4, widths=(6, 7, 8))
NO_MIRROR = np.arange(4)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(8)


@pytest.fixture
def occupied(rng: np.random.Generator) -> BoolArray:
    return np.asarray(rng.random((13, 11)) < 0.6)


@pytest.fixture
def levels(occupied: BoolArray) -> tuple[SiteLevel, ...]:
    return site_levels(occupied, len(SHAPE.widths))


@pytest.fixture
def network(rng: np.random.Generator) -> LearningNetwork:
    return LearningNetwork(SHAPE, rng)


def _inputs(rng: np.random.Generator, n_cells: int) -> Float32Array:
    return rng.normal(size=(n_cells, SHAPE.n_inputs)).astype(np.float32)


def _picture(features: Float32Array, occupied: BoolArray) -> FloatArray:
    picture = np.zeros((*occupied.shape, features.shape[1]))
    picture[occupied] = features
    return picture


class TestSites:
    def test_neighbors_are_the_cells_that_touch(self, occupied: BoolArray) -> None:
        level = site_levels(occupied, 1)[0]
        places = np.argwhere(occupied).tolist()
        for site, (row, column) in enumerate(places):
            around = itertools.product(range(row - 1, row + 2), range(column - 1, column + 2))
            expected = [
                places.index(list(one)) if list(one) in places else len(places) for one in around
            ]
            assert level.neighbors[site].tolist() == expected

    def test_parents_and_children_agree(self, levels: tuple[SiteLevel, ...]) -> None:
        for finer, coarser in itertools.pairwise(levels):
            of_children = [
                sorted(int(child) for child in row if child < len(finer))
                for row in coarser.children
            ]
            of_parents = [
                np.flatnonzero(finer.parents == site).tolist() for site in range(len(coarser))
            ]
            assert of_children == of_parents

    def test_a_coarser_cell_is_occupied_where_one_of_four_is(
        self, occupied: BoolArray, levels: tuple[SiteLevel, ...]
    ) -> None:
        expected = {(row // 2, column // 2) for row, column in np.argwhere(occupied).tolist()}
        assert len(levels[1]) == len(expected)

    def test_a_picture_without_cells_has_none_at_any_level(self) -> None:
        assert [len(level) for level in site_levels(np.zeros((5, 3), bool), 3)] == [0, 0, 0]


class TestRising:
    def test_a_cell_has_the_features_of_its_parent_then_its_own(
        self, rng: np.random.Generator, levels: tuple[SiteLevel, ...]
    ) -> None:
        fine, coarse = levels[:2]
        features = with_nothing(rng.normal(size=(len(coarse), 7)).astype(np.float32))
        skipped = with_nothing(rng.normal(size=(len(fine), 6)).astype(np.float32))
        expected = with_nothing(np.hstack([features[fine.parents], skipped[:-1]]))
        np.testing.assert_array_equal(risen(features, fine.parents, skipped), expected)


@pytest.mark.parametrize("n_all", [0, 1, 49, 128, 129, 137, 450, 1546, 4096])
def test_blocks_are_even_and_cover_everything_once(n_all: int) -> None:
    n_blocks, size = even_blocks(n_all, 128)
    ends = [min(block * size, n_all) for block in range(n_blocks + 1)]
    sizes = np.diff(ends)
    assert sizes.sum() == n_all
    assert (sizes[:-1] == size).sum() >= n_blocks - 2
    assert size <= 128
    assert n_blocks <= 1 or n_blocks % 2 == 0


class TestConvolution:
    def test_it_is_that_of_a_picture_with_zeros_where_no_cell_is(
        self, rng: np.random.Generator
    ) -> None:
        occupied = np.asarray(rng.random((40, 30)) < 0.7)  # more cells than one block holds
        level = site_levels(occupied, 1)[0]
        features = rng.normal(size=(len(level), 5)).astype(np.float32)
        weights = rng.normal(size=(9 * 5, 6)).astype(np.float32)
        bias = rng.normal(size=6).astype(np.float32)
        made = convolved(with_nothing(features), level.neighbors, weights, bias, AS_IT_IS)
        picture, kernel = _picture(features, occupied), weights.reshape(3, 3, 5, 6)
        for feature in range(6):
            dense = sum(
                correlate(picture[..., one], kernel[..., one, feature].astype(float), "same")
                for one in range(5)
            )
            np.testing.assert_allclose(
                made[:-1, feature], dense[occupied] + bias[feature], atol=1e-4
            )
        assert not made[-1].any()
        rectified = convolved(with_nothing(features), level.neighbors, weights, bias, RECTIFIED)
        np.testing.assert_array_equal(rectified, np.maximum(made, 0))

    def test_gradients_are_the_same_with_any_number_of_cores(
        self, rng: np.random.Generator
    ) -> None:
        import numba

        level = site_levels(np.ones((50, 40), bool), 1)[0]
        features = with_nothing(rng.normal(size=(len(level), 5)).astype(np.float32))
        by_made = with_nothing(rng.normal(size=(len(level), 6)).astype(np.float32))
        layer = NormalizedConvolution(5, 6, rng)
        found = []
        cores = numba.get_num_threads()
        try:
            for n_cores in (1, cores):
                numba.set_num_threads(n_cores)
                made, back = layer.forward(features, level)
                found.append({"made": made, "by_features": back(by_made), **layer.gradients})
        finally:
            numba.set_num_threads(cores)
        for name, value in found[0].items():
            np.testing.assert_array_equal(value, found[1][name], err_msg=name)

    def test_a_batch_has_mean_0_and_variance_1_before_it_is_rectified(
        self, rng: np.random.Generator
    ) -> None:
        level = site_levels(np.ones((30, 20), bool), 1)[0]
        features = with_nothing(rng.normal(size=(len(level), 5)).astype(np.float32))
        layer = NormalizedConvolution(5, 6, rng)
        layer.values["shift"][:] = 20.0  # nothing is below zero
        layer.values["scale"][:] = 3.0
        made, _ = layer.forward(features, level)
        np.testing.assert_allclose(made[:-1].mean(axis=0), 20.0, atol=1e-4)
        np.testing.assert_allclose(made[:-1].std(axis=0), 3.0, rtol=1e-3)
        assert not made[-1].any()


class TestDerivatives:
    def test_every_layer_has_those_of_finite_differences(
        self,
        rng: np.random.Generator,
        levels: tuple[SiteLevel, ...],
        network: LearningNetwork,
    ) -> None:
        inputs = _inputs(rng, len(levels[0]))
        labels = rng.integers(-1, 4, len(inputs))
        weights = np.array([1, 2, 0.5, 1], np.float32)

        def loss() -> float:
            return loss_and_slope(network.forward(inputs, levels)[0], labels, weights)[0]

        log_odds, back = network.forward(inputs, levels)
        by_inputs = back(loss_and_slope(log_odds, labels, weights)[1])
        told = [
            (layer.values[name], layer.gradients[name].copy())
            for layer in network.layers
            for name in layer.values
        ]
        for values, slopes in [*told, (inputs, by_inputs)]:
            place = np.unravel_index(np.abs(slopes).argmax(), slopes.shape)
            measured = _slope(values, place, loss)
            assert slopes[place] == pytest.approx(measured, rel=0.12, abs=2e-3)

    def test_the_loss_is_the_mean_logarithm_by_weight(self, rng: np.random.Generator) -> None:
        log_odds = rng.normal(size=(7, 4)).astype(np.float32)
        labels = np.array([0, 1, 2, 3, -1, 1, 0])
        weights = np.array([1, 2, 0.5, 1], np.float32)
        shares = np.exp(log_odds) / np.exp(log_odds).sum(axis=1, keepdims=True)
        known = labels >= 0
        expected = np.average(-np.log(shares[known, labels[known]]), weights=weights[labels[known]])
        assert loss_and_slope(log_odds, labels, weights)[0] == pytest.approx(expected, rel=1e-5)


def _slope(values: Float32Array, place: tuple[np.intp, ...], loss: object) -> float:
    assert callable(loss)
    before, step = values[place], 2e-3
    values[place] = before + step
    above = loss()
    values[place] = before - step
    below = loss()
    values[place] = before
    return float(above - below) / (2 * step)


class TestNetwork:
    def test_what_was_learned_says_what_the_learning_network_says(
        self,
        rng: np.random.Generator,
        levels: tuple[SiteLevel, ...],
        network: LearningNetwork,
    ) -> None:
        inputs = _inputs(rng, len(levels[0]))
        for _ in range(400):  # until the running values are those of these inputs
            log_odds, _ = network.forward(inputs, levels)
        np.testing.assert_allclose(network.learned().log_odds(inputs, levels), log_odds, atol=2e-2)

    def test_one_that_takes_over_what_was_learned_says_the_same(
        self, rng: np.random.Generator, network: LearningNetwork, levels: tuple[SiteLevel, ...]
    ) -> None:
        inputs = _inputs(rng, len(levels[0]))
        for _ in range(3):  # running means are no longer those of one batch
            network.forward(inputs + rng.normal(size=SHAPE.n_inputs).astype(np.float32), levels)
        taught = network.learned()
        other = LearningNetwork(SHAPE, np.random.default_rng(9))
        other.take_over(taught, inputs, levels)
        expected = taught.log_odds(inputs, levels)
        np.testing.assert_allclose(other.forward(inputs, levels)[0], expected, atol=2e-4)
        np.testing.assert_allclose(other.learned().log_odds(inputs, levels), expected, atol=2e-4)
        lengths = np.linalg.norm(other.layers[0].values["weights"], axis=0)
        np.testing.assert_allclose(lengths, np.sqrt(2.0), rtol=1e-5)

    def test_people_of_one_batch_do_not_touch(
        self, rng: np.random.Generator, network: LearningNetwork
    ) -> None:
        examples = [_checkered(rng) for _ in range(3)]
        learned = network.learned()
        together = batch_of(examples, NO_MIRROR, len(SHAPE.widths), np.random.default_rng(3))
        found = learned.log_odds(together.inputs, together.levels)
        alone_rng = np.random.default_rng(3)
        for number, one in enumerate(examples):
            alone = batch_of([one], NO_MIRROR, len(SHAPE.widths), alone_rng)
            first = sum(len(before.rows) for before in examples[:number])
            np.testing.assert_allclose(
                found[first : first + len(one.rows)],
                learned.log_odds(alone.inputs, alone.levels),
                atol=1e-5,
            )


def _checkered(rng: np.random.Generator) -> ContextExample:
    """Return cells whose label is the quarter of the picture that they are in."""
    rows, columns = np.nonzero(rng.random((16, 16)) < 0.8)
    labels = 2 * (rows >= 8) + (columns >= 8)
    features = np.zeros((len(rows), SHAPE.n_inputs), np.float16)
    features[:, 4] = 1.0
    return _example(rows, columns, features, labels)


def _example(
    rows: IntArray,
    columns: IntArray,
    features: AnyArray,
    labels: IntArray,
    second_share: float = 0.0,
) -> ContextExample:
    """Return cells whose second label is the next one."""
    return ContextExample(
        rows.astype(np.int16),
        columns.astype(np.int16),
        features,
        labels.astype(np.int8),
        (labels + 1).astype(np.int8),
        np.full(len(labels), second_share, np.float16),
    )


def _nobody_waits(_done: int, _all: int) -> None:
    """Take progress."""


def _trained(
    examples: list[ContextExample], mirror_order: IntArray, params: ContextTraining
) -> ContextTrainer:
    trainer = ContextTrainer(examples, mirror_order, params)
    for _ in range(params.n_passes):
        trainer.run_pass(_nobody_waits)
    return trainer


class TestTraining:
    def test_it_learns_what_only_the_surroundings_tell(self, rng: np.random.Generator) -> None:
        examples = [_checkered(rng) for _ in range(64)]
        params = ContextTraining(widths=(12, 12, 16), n_passes=12, batch_size=8, rate=5e-3)
        quarters_beside = np.array([1, 0, 3, 2])
        network = _trained(examples, quarters_beside, params).learned()
        unseen = batch_of(
            [_checkered(rng) for _ in range(8)], quarters_beside, 3, np.random.default_rng(5)
        )
        right = network.log_odds(unseen.inputs, unseen.levels).argmax(axis=1) == unseen.labels
        assert right.mean() > 0.9

    def test_after_a_break_it_goes_on_as_if_there_had_been_none(
        self, rng: np.random.Generator
    ) -> None:
        examples = [_checkered(rng) for _ in range(6)]
        params = ContextTraining(widths=(4, 4), n_passes=3, batch_size=2)
        whole = _trained(examples, NO_MIRROR, params)
        first = ContextTrainer(examples, NO_MIRROR, params)
        first.run_pass(_nobody_waits)
        second = ContextTrainer(examples, NO_MIRROR, params)
        second.go_on(first.kept())
        assert second.n_done == 1
        for _ in range(2):
            second.run_pass(_nobody_waits)
        for name, value in whole.kept().items():
            np.testing.assert_array_equal(value, second.kept()[name], err_msg=name)

    def test_a_label_is_drawn_as_often_as_it_has_of_the_cell(
        self, rng: np.random.Generator
    ) -> None:
        places = np.arange(10_000)
        features = np.zeros((len(places), SHAPE.n_inputs), np.float16)
        example = _example(places, places, features, np.full(len(places), 1), 0.25)
        drawn = example.drawn_labels(rng)
        assert set(drawn.tolist()) == {1, 2}
        assert (drawn == 2).mean() == pytest.approx(0.25, abs=0.02)

    def test_labels_of_all_sizes_weigh_the_same_in_sum(self) -> None:
        labels = np.array([0, 0, 0, 1, 2, 2, 3, 3, 3, 3, -1])
        places = np.arange(len(labels))
        features = np.zeros((len(labels), SHAPE.n_inputs), np.float16)
        example = _example(places, places, features, labels)
        weights = label_weights(label_shares([example], 4), evenness=1.0)
        np.testing.assert_allclose(weights * np.array([3, 1, 2, 4]), 2.5)
