"""Alignments equal brute force over every path, whole and in a stream."""

import functools

import numpy as np
import pytest
from dtaidistance import dtw_ndim
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from adibas.timeseries.dtw import (
    alignment_cost,
    alignment_sum,
    cross_costs,
    pairwise_costs,
    warping_path,
)
from adibas.timeseries.stream import StreamAligner

numbers = st.floats(-3, 3).map(lambda x: round(x, 3))


def sequences(dimension, longest):
    return st.integers(2, longest).flatmap(
        lambda n: arrays(np.float64, (n, dimension), elements=numbers)
    )


def distance(p, q):
    """Euclidean over what both show, scaled up; infinite where less than half is shown."""
    known = np.isfinite(p - q)
    if known.mean() < 0.5:
        return np.inf
    return float(np.sqrt(((p - q)[known] ** 2).sum() / known.mean()))


def best_whole(a, b):
    """Return the least sum of distances by trying every path."""

    @functools.cache
    def to(i, j):
        if i < 0 or j < 0:
            return 0.0 if i == j == -1 else np.inf
        return distance(a[i], b[j]) + min(to(i - 1, j - 1), to(i - 1, j), to(i, j - 1))

    return to(len(a) - 1, len(b) - 1)


def every_end(model, stream, steps):
    """Return the least (cost, start) of every end in `stream`, path by path."""
    d = [[distance(c, q) for q in stream] for c in model]

    @functools.cache
    def to(i, j):
        if i == -1:
            return (0.0, j + 1) if j >= -1 else (np.inf, 0)
        if j < 0:
            return (np.inf, 0)
        if steps == "free":
            if i == 0:
                return (d[0][j], j)
            ways = [(to(i - 1, j - 1), 0.0), (to(i - 1, j), 0.0), (to(i, j - 1), 0.0)]
            return min((w[0] + d[i][j], w[1]) for w, _ in ways)
        ways = [(*to(i - 1, j - 1), d[i][j])]
        if j >= 1:
            ways.append((*to(i - 1, j - 2), 0.5 * (d[i][j - 1] + d[i][j])))
        if i >= 1:
            ways.append((*to(i - 2, j - 1), d[i - 1][j] + d[i][j]))
        return min((cost + more, start) for cost, start, more in ways)

    return [to(len(model) - 1, j) for j in range(len(stream))]


@given(sequences(2, 7), sequences(2, 7))
def test_whole_alignment_equals_the_best_of_all_paths(a, b):
    assert alignment_sum(a, b) == pytest.approx(best_whole(a, b), abs=1e-9)


@given(sequences(3, 9))
def test_a_sequence_aligns_with_itself_for_nothing(a):
    assert alignment_cost(a, a) == 0.0
    assert alignment_cost(a, np.repeat(a, 2, axis=0)) == 0.0


@given(sequences(2, 8), sequences(2, 8))
def test_the_path_has_the_cost_it_claims(a, b):
    cost, path = warping_path(a, b)
    along = sum(distance(a[i], b[j]) for i, j in path)
    assert cost == pytest.approx(along / (len(a) + len(b)), abs=1e-9)
    assert cost == pytest.approx(alignment_cost(a, b), abs=1e-9)
    assert path[0].tolist() == [0, 0]
    assert path[-1].tolist() == [len(a) - 1, len(b) - 1]
    assert set(map(tuple, np.diff(path, axis=0))) <= {(0, 1), (1, 0), (1, 1)}


@pytest.mark.parametrize("steps", ["sloped", "free"])
@settings(max_examples=60)
@given(sequences(2, 6), sequences(2, 14))
def test_every_end_in_a_stream_equals_the_best_of_all_paths(steps, model, stream):
    costs, starts = StreamAligner([model], steps=steps).feed(stream)
    expected = every_end(model, stream, steps)
    for cost, start, (best, began) in zip(
        costs[:, 0] * len(model), starts[:, 0], expected, strict=True
    ):
        assert cost == pytest.approx(best, abs=1e-9)
        if np.isfinite(best) and start != began:  # paths of equal cost: check the other one, too
            part = stream[start:]
            again = every_end(model, part, steps)
            assert any(again_cost == pytest.approx(best, abs=1e-9) for again_cost, _ in again)


@pytest.mark.parametrize("steps", ["sloped", "free"])
def test_several_models_frame_by_frame_equal_each_alone_at_once(steps):
    rng = np.random.default_rng(1)
    models = [rng.normal(0, 1, (n, 5)) for n in (2, 7, 3)]
    stream = rng.normal(0, 1, (41, 5))
    weights = np.array([1.0, 0.5, 0.0, 2.0, 1.0])
    together = StreamAligner(models, weights, steps)
    by_frame = [together.feed(frame[None]) for frame in stream]
    for k, model in enumerate(models):
        costs, starts = StreamAligner([model * weights], steps=steps).feed(stream * weights)
        np.testing.assert_allclose([c[0, k] for c, _ in by_frame], costs[:, 0], rtol=1e-12)
        np.testing.assert_array_equal([s[0, k] for _, s in by_frame], starts[:, 0])


@pytest.mark.parametrize("steps", ["sloped", "free"])
def test_a_planted_model_is_found_where_it_was_planted(steps):
    rng = np.random.default_rng(2)
    model = np.cumsum(rng.normal(0, 1, (12, 4)), axis=0)
    stream = rng.normal(0, 9, (80, 4))
    stream[30:42] = model
    costs, starts = StreamAligner([model], steps=steps).feed(stream)
    assert int(np.argmin(costs[:, 0])) == 41
    assert costs[41, 0] == pytest.approx(0.0, abs=1e-9)
    assert starts[41, 0] == 30


def test_limited_slope_takes_half_to_twice_as_long_and_no_other():
    model = np.arange(12.0)[:, None] * 10
    for factor, is_found in ((0.5, True), (1.0, True), (2.0, True), (4.0, False)):
        times = np.linspace(0, 11, max(2, round(12 * factor)))
        stream = np.full((80, 1), 1000.0)
        stream[10 : 10 + len(times), 0] = times * 10
        costs, _ = StreamAligner([model]).feed(stream)
        assert (costs.min() < 6.0) == is_found, factor


@pytest.mark.parametrize("steps", ["sloped", "free"])
def test_what_was_not_seen_is_left_out_and_not_taken_for_zero(steps):
    rng = np.random.default_rng(3)
    model, stream = rng.normal(5, 1, (5, 4)), rng.normal(5, 1, (11, 4))
    stream[3, 1] = model[2, 0] = np.nan
    stream[7, :3] = np.nan
    costs, _ = StreamAligner([model], steps=steps).feed(stream)
    expected = [cost for cost, _ in every_end(model, stream, steps)]
    np.testing.assert_allclose(costs[:, 0] * 5, expected, atol=1e-9)
    assert np.isinf(costs[7, 0])


def test_pairs_equal_single_alignments_with_gaps_and_weights():
    rng = np.random.default_rng(4)
    series = [rng.normal(0, 1, (int(n), 6)) for n in rng.integers(1, 13, 9)]
    series[2][0, 3] = np.nan
    weights = rng.uniform(0.1, 1, 6)
    matrix = pairwise_costs(series, weights)
    crossed = cross_costs(series[:4], series[4:], weights)
    for i, a in enumerate(series):
        for j, b in enumerate(series):
            if i != j:
                assert matrix[i, j] == pytest.approx(alignment_cost(a, b, weights), abs=1e-12)
    np.testing.assert_allclose(crossed, matrix[:4, 4:], atol=1e-12)


def test_squared_distances_sum_like_the_textbook():
    rng = np.random.default_rng(5)
    a, b, c = rng.normal(0, 1, (9, 1)), rng.normal(0, 1, (6, 1)), rng.normal(0, 1, (5, 1))
    sums = np.full((10, 7), np.inf)
    sums[0, 0] = 0
    for i in range(9):
        for j in range(6):
            sums[i + 1, j + 1] = (a[i, 0] - b[j, 0]) ** 2 + sums[i : i + 2, j : j + 2].min()
    costs = pairwise_costs([a, b, c], is_squared=True)
    assert costs[0, 1] == pytest.approx(np.sqrt(sums[9, 6]), abs=1e-12)


def test_alignments_are_those_of_dtaidistance():
    rng = np.random.default_rng(1)
    series = [rng.normal(0, 1, (n, 6)) for n in (20, 31, 17, 25)]
    theirs = dtw_ndim.distance_matrix_fast(series)
    np.testing.assert_allclose(pairwise_costs(series, is_squared=True), theirs, atol=1e-12)
    model, stream = rng.normal(0, 1, (12, 6)), rng.normal(0, 1, (80, 6))
    anywhere = {"psi": [0, 0, 80, 80], "psi_neg": False}
    _best, sums = dtw_ndim.warping_paths(model, stream, inner_dist="euclidean", **anywhere)
    costs, _starts = StreamAligner([model], steps="free").feed(stream)
    np.testing.assert_allclose(len(model) * costs[:, 0], sums[-1, 1:], atol=1e-12)


def test_wrong_input_is_refused():
    with pytest.raises(ValueError, match="one frame"):
        StreamAligner([])
    with pytest.raises(ValueError, match="2 frames"):
        StreamAligner([np.zeros((1, 3))])
    with pytest.raises(ValueError, match="weights"):
        StreamAligner([np.zeros((3, 3))], np.zeros(3))
    with pytest.raises(ValueError, match="numbers a frame"):
        StreamAligner([np.zeros((3, 3)), np.zeros((3, 4))])
    with pytest.raises(ValueError, match="without gaps"):
        pairwise_costs([np.full((3, 1), np.nan), np.zeros((2, 1))], is_squared=True)


def test_a_path_stays_inside_where_nothing_can_be_compared():
    cost, path = warping_path(np.full((4, 2), np.nan), np.zeros((6, 2)))
    assert cost == np.inf
    assert path.min() == 0
    assert path[-1].tolist() == [3, 5]
    assert (np.diff(path, axis=0) >= 0).all()
