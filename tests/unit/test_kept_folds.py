"""An evaluation that was interrupted goes on where it was, and finds the same."""

import numpy as np
import pytest

from adibas.gestures.descriptor import DescriptorParams
from adibas.gestures.evaluation import leave_one_out
from adibas.gestures.training import TrainingParams
from adibas.pipeline.gesture_examples import examples_of
from benchmarks import kept_folds
from benchmarks.kept_folds import kept_leave_one_out
from tests.unit.gesture_examples import streams

DESCRIPTOR, PARAMS = DescriptorParams(), TrainingParams(method="dtw")


@pytest.fixture(scope="module")
def examples():
    return examples_of(*streams(3, ("wave", "bend", "wave")), DESCRIPTOR)[0]


def test_an_interrupted_evaluation_goes_on_and_finds_what_an_uninterrupted_one_does(
    examples, tmp_path, monkeypatch
):
    file, asked = tmp_path / "kept.jsonl", []
    whole = kept_folds.one_left_out

    def interrupted(found, group, *told):
        if group == 1:
            raise KeyboardInterrupt
        return whole(found, group, *told)

    def counted(found, group, *told):
        asked.append(group)
        return whole(found, group, *told)

    monkeypatch.setattr(kept_folds, "one_left_out", interrupted)
    with pytest.raises(KeyboardInterrupt):
        kept_leave_one_out("sticks", 3, lambda: examples, DESCRIPTOR, PARAMS, file)
    monkeypatch.setattr(kept_folds, "one_left_out", counted)
    found = kept_leave_one_out("sticks", 3, lambda: examples, DESCRIPTOR, PARAMS, file)
    assert asked == [1, 2]
    straight = leave_one_out(examples, DESCRIPTOR, PARAMS)
    for name in straight.__slots__:
        np.testing.assert_array_equal(getattr(found, name), getattr(straight, name))
    again = kept_leave_one_out("sticks", 3, pytest.fail, DESCRIPTOR, PARAMS, file)
    assert again.accuracy_7_7 == found.accuracy_7_7


def test_what_is_kept_of_another_method_or_set_is_not_taken(examples, tmp_path):
    file = tmp_path / "kept.jsonl"
    kept_leave_one_out("sticks", 1, lambda: examples, DESCRIPTOR, PARAMS, file)
    for called, params in (("stones", PARAMS), ("sticks", TrainingParams(method="table-7.1"))):
        kept_leave_one_out(called, 1, lambda: examples, DESCRIPTOR, params, file)
    assert len(file.read_text("utf-8").splitlines()) == 3
