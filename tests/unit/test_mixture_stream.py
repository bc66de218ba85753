"""Mixtures in place of examples: against densities of SciPy, and against plain alignment."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from adibas.gestures.mixtures import MixtureParams, aligned_examples, mixture_model, mixtures_of
from adibas.timeseries.mixture_stream import MixtureModel, MixtureStream
from adibas.timeseries.stream import StreamAligner


def model_of(frames, sd=1.0):
    """Return a model with one component a frame, alike in all numbers."""
    means = np.asarray(frames, float)[:, None]
    return MixtureModel(np.ones(means.shape[:2]), means, np.full(means.shape, sd**2))


def walk(seed, n, d=6):
    return np.cumsum(np.random.default_rng(seed).normal(0, 0.3, (n, d)), axis=0)


def test_one_component_of_variance_1_is_plain_alignment():
    models, stream = [walk(1, 12), walk(2, 7)], walk(3, 90)
    costs, starts = MixtureStream([model_of(one) for one in models]).feed(stream)
    plain, begins = StreamAligner(models).feed(stream)
    np.testing.assert_allclose(costs, plain / np.sqrt(6), atol=1e-6)
    np.testing.assert_array_equal(starts, begins)


def test_a_stream_in_parts_gives_the_same():
    models, stream = [model_of(walk(1, 12))], walk(3, 90)
    whole = MixtureStream(models).feed(stream)
    aligner = MixtureStream(models)
    parts = [aligner.feed(stream[:31]), aligner.feed(stream[31:32]), aligner.feed(stream[32:])]
    np.testing.assert_array_equal(np.concatenate([part[0] for part in parts]), whole[0])
    aligner.reset()
    np.testing.assert_array_equal(aligner.feed(stream)[1], whole[1])


def test_costs_are_those_of_the_density():
    rng = np.random.default_rng(0)
    means, variances = rng.normal(0, 1, (3, 2, 4)), rng.uniform(0.2, 2.0, (3, 2, 4))
    shares = np.array([[0.3, 0.7], [0.5, 0.5], [1.0, 0.0]])
    frames = rng.normal(0, 1, (5, 4))
    found = MixtureStream([MixtureModel(shares, means, variances)]).local_costs(frames)
    used = variances[shares > 0]
    highest = max(multivariate_normal(np.zeros(4), np.diag(one)).pdf(np.zeros(4)) for one in used)
    for t, frame in enumerate(frames):
        for i in range(3):
            total = 0.0
            for k in range(2):
                normal = multivariate_normal(means[i, k], np.diag(variances[i, k]))
                total += shares[i, k] * normal.pdf(frame) / highest
            assert found[t, i] == pytest.approx(np.sqrt(-2 * np.log(total) / 4), rel=1e-6)


def test_what_was_not_seen_is_left_out_and_scaled_up():
    model = model_of(np.zeros((3, 4)))
    frames = np.array([[1.0, 1, 1, 1], [1, 1, np.nan, 1], [1, np.nan, np.nan, np.nan]])
    found = MixtureStream([model]).local_costs(frames)
    np.testing.assert_allclose(found[:2], 1.0)
    assert np.isinf(found[2]).all()


def test_where_examples_vary_a_frame_may():
    """One number is the same in all examples, the other anything."""
    rng = np.random.default_rng(4)
    examples = [
        np.column_stack([np.linspace(0, 2, 20), np.full(20, rng.normal(0, 1.0))]) for _ in range(30)
    ]
    model = mixture_model(examples, rng, MixtureParams(n_components=1))
    middle = model.means[10, 0]
    off_first, off_second = middle + np.array([0.3, 0.0]), middle + np.array([0.0, 0.3])
    costs = MixtureStream([model]).local_costs(np.array([middle, off_first, off_second]))[:, 10]
    assert costs[1] ** 2 - costs[0] ** 2 > 6 * (costs[2] ** 2 - costs[0] ** 2) > 0
    np.testing.assert_allclose(model.shares.sum(axis=1), 1.0)


def test_two_styles_are_two_components():
    rng = np.random.default_rng(5)
    examples = [
        np.full((10, 2), 3.0 * (number % 2)) + rng.normal(0, 0.05, (10, 2)) for number in range(20)
    ]
    model = mixture_model(examples, rng, MixtureParams(pooled=0.0))
    centres = np.sort(model.means[:, :, 0], axis=1)
    np.testing.assert_allclose(centres, np.tile([0.0, 3.0], (len(centres), 1)), atol=0.1)
    np.testing.assert_allclose(model.shares, 0.5, atol=0.01)


def test_examples_are_aligned_with_the_one_of_median_length():
    slow, fast = np.repeat(np.arange(8.0), 2)[:, None], np.arange(8.0)[:, None]
    hidden = np.where(np.arange(8)[:, None] < 2, np.nan, fast)
    aligned = aligned_examples([slow, fast, fast])
    assert aligned.shape == (3, 8, 1)
    np.testing.assert_allclose(aligned[:, :, 0], np.tile(np.arange(8.0), (3, 1)), atol=0.51)
    model = mixture_model([fast, hidden, fast], np.random.default_rng(0), MixtureParams())
    assert np.isfinite(model.means).all()


def test_labels_without_examples_have_no_model():
    found = mixtures_of([walk(1, 5), walk(2, 6)], np.array([0, 2]), 3, np.random.default_rng(0))
    assert len(found) == 2


def test_models_that_cannot_be_are_refused():
    with pytest.raises(ValueError, match="above zero"):
        model_of(walk(1, 5), 0.0)
    with pytest.raises(ValueError, match="two frames"):
        MixtureStream([model_of(walk(1, 1))])
    with pytest.raises(ValueError, match="two frames"):
        MixtureStream([])


def test_models_may_have_different_numbers_of_components():
    one = model_of(walk(1, 5))
    two = MixtureModel(
        np.full((6, 2), 0.5), np.repeat(walk(2, 6)[:, None], 2, axis=1), np.ones((6, 2, 6))
    )
    stream = walk(3, 40)
    together = MixtureStream([one, two]).feed(stream)[0]
    np.testing.assert_allclose(together[:, 0], MixtureStream([one]).feed(stream)[0][:, 0])
    np.testing.assert_allclose(together[:, 1], MixtureStream([two]).feed(stream)[0][:, 0])


def test_an_example_that_was_hardly_seen_is_aligned():
    hidden = walk(4, 9)
    hidden[:, :5] = np.nan
    assert np.isfinite(aligned_examples([walk(5, 8), hidden, walk(6, 8)])[0]).all()
