"""Joints weigh something else for each gesture, and a model keeps it."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.gestures.descriptor import DESCRIBED_JOINTS, DescriptorParams
from adibas.gestures.model_file import read_model, write_model
from adibas.gestures.proposals import ClassAligner
from adibas.gestures.training import TrainingParams, train
from adibas.gestures.weighting import spread, weights_of_gestures
from adibas.pipeline.gesture_examples import examples_of
from tests.unit.gesture_examples import streams


@pytest.fixture(scope="module")
def weighed():
    """A model with weights of its own for waving, and the tracks of its streams."""
    found, _rule, _notices = examples_of(*streams(3), DescriptorParams())
    model = train(found, DescriptorParams(), TrainingParams(method="dtw"))
    weights = model.weights.copy()
    weights[1] = np.linspace(0.0, 1.0, len(DESCRIBED_JOINTS))
    return replace(model, weights=weights / weights.sum(axis=1, keepdims=True)), found.streams


def test_each_gesture_is_aligned_with_its_own_weights(weighed):
    model, (track, *_others) = weighed
    costs, starts = model.aligner().curves(track.frames)
    for label, row in enumerate(model.weights):
        mine = np.flatnonzero(model.owners == label)
        alike = spread(np.tile(row, (2, 1)), model.descriptor.n_numbers)
        alone = ClassAligner([model.examples[k] for k in mine], model.owners[mine], alike)
        only, begun = alone.curves(track.frames)
        np.testing.assert_array_equal(costs[:, label], only[:, label])
        np.testing.assert_array_equal(starts[:, label], begun[:, label])


def test_a_gesture_that_one_person_alone_shows_is_learned_with_weights():
    tracks, events = streams(3)
    alone = [one for one in events if one.label == "wave" or one.subject == "s0"]
    found, _rule, _notices = examples_of(tracks, alone, DescriptorParams())
    model = train(found, DescriptorParams(), TrainingParams(method="weighted-dtw"))
    assert model.labels == ("bend", "wave")
    np.testing.assert_allclose(model.weights.sum(axis=1), 1.0)
    bend, wave = weights_of_gestures(found.without(found.groups == 0))
    assert np.ptp(bend) == 0.0
    assert np.ptp(wave) > 0.0


def test_a_model_file_keeps_the_weights_of_each_gesture(tmp_path, weighed):
    model, _streams = weighed
    for one in (model, replace(model, weights=np.full_like(model.weights, 1 / 14))):
        write_model(tmp_path / "model.json", one)
        np.testing.assert_array_equal(read_model(tmp_path / "model.json").weights, one.weights)
