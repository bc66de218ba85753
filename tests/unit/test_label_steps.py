"""Steps back and forth over many frames: the last one first, wherever it was."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.limbs.label_steps import LabelSteps

EMPTY = np.zeros((2, 3), np.uint8)


def with_one(steps, frame, label):
    """Paint the first pixel of a frame, as one step."""
    labels = steps.labels(frame).copy()
    labels[0, 0] = label
    return steps.changed(frame, labels)


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(1, 9)), max_size=25), st.integers(1, 30))
def test_undoing_all_gives_what_was_there_before_and_redoing_all_what_came_of_it(plan, most):
    steps = LabelSteps(most_steps=most)
    kept = {}
    for frame, label in plan:
        steps = steps.begun(frame, kept.get(frame, EMPTY))
        steps = with_one(steps, frame, label)
        kept[frame] = steps.labels(frame)
    after = dict(kept)
    n_steps = len(steps.back)
    assert n_steps <= most
    for move, frame_of in (("undone", "undo_frame"), ("redone", "redo_frame")):
        for _ in range(n_steps):
            frame = getattr(steps, frame_of)
            steps = getattr(steps.begun(frame, kept[frame]), move)()
            kept[frame] = steps.labels(frame)
        assert getattr(steps, frame_of) is None
        assert getattr(steps, move)() is steps
        if move == "undone" and most > len(plan):
            assert not any(labels.any() for labels in kept.values())
    assert all(np.array_equal(kept[frame], after[frame]) for frame in after)


def test_steps_are_taken_back_in_the_order_in_which_they_were_made():
    steps = LabelSteps().begun(0, EMPTY)
    steps = with_one(steps, 0, 1)
    before = steps.labels(0)
    steps = with_one(steps.begun(5, EMPTY), 5, 2)
    steps = with_one(steps.begun(0, before), 0, 3)
    order = []
    while steps.undo_frame is not None:
        order.append(steps.undo_frame)
        steps = steps.begun(order[-1], steps.labels(order[-1])).undone()
    assert order == [0, 5, 0]


def test_a_new_step_in_any_frame_ends_what_could_be_done_again():
    steps = with_one(LabelSteps().begun(0, EMPTY), 0, 1).undone()
    steps = with_one(steps.begun(1, EMPTY), 1, 2)
    assert steps.redo_frame is None
    steps = steps.undone().begun(0, EMPTY)
    assert steps.undo_frame is None
    np.testing.assert_array_equal(steps.labels(0), EMPTY)


def test_steps_of_a_frame_that_somebody_else_changed_are_forgotten():
    steps = with_one(LabelSteps().begun(0, EMPTY), 0, 1)
    steps = with_one(steps.begun(1, EMPTY), 1, 2)
    other = np.full_like(EMPTY, 7)
    steps = steps.begun(0, other)
    assert steps.back == (1,)
    np.testing.assert_array_equal(steps.labels(0), other)


@pytest.mark.parametrize("most", [1, 3])
def test_the_oldest_step_of_all_frames_is_forgotten_first(most):
    steps = LabelSteps(most_steps=most)
    for frame in range(5):
        steps = with_one(steps.begun(frame, EMPTY), frame, 1)
    assert steps.back == tuple(range(5 - most, 5))


def test_labels_of_frames_without_a_step_are_not_held():
    steps = LabelSteps()
    for frame in range(50):
        steps = steps.begun(frame, EMPTY)
    assert set(steps.of_frame) == {49}
