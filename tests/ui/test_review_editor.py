"""Corrections of a capture: whatever is done can be undone and done again, after a restart too."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from adibas.data.corrections import FreeMeasure
from adibas.data.markers import AutomaticName
from adibas.errors import MarkerError, StoreError
from adibas.sessions import open_store
from tests.ui.conftest import CHEAP, PASSPHRASE
from tests.ui.review_scene import plain_marker, saved_session
from ui.review.editor import CaptureEditor

BY_MODEL = AutomaticName("shipped, 2024-01-01", 0.98)
numbers = st.integers(0, 30)
edits = st.lists(
    st.tuples(
        st.sampled_from(
            ("move", "add", "delete", "rename", "measure", "unmeasure", "model", "undo", "redo")
        ),
        numbers,
        numbers,
    ),
    max_size=15,
)


def do(editor, edit):
    """Do one edit on whatever marker the numbers fall on."""
    kind, first, second = edit
    labels = list(editor.saved())
    if kind == "add":
        editor.add(plain_marker(editor.free_label(), first, second))
    elif kind in ("undo", "redo"):
        getattr(editor, kind)()
    elif labels:
        DOERS[kind](editor, labels, first, second)


def move(editor, labels, first, second):
    marker = editor.saved()[labels[first % len(labels)]]
    editor.move(replace(marker, u=float(first), v=float(second)))


def delete(editor, labels, first, _second):
    editor.delete(labels[first % len(labels)])


def rename(editor, labels, first, second):
    if f"name {second}" not in labels:
        editor.rename(labels[first % len(labels)], f"name {second}")


def measure(editor, labels, first, second):
    chosen = dict.fromkeys(labels[(first + step) % len(labels)] for step in range(3))
    if len(chosen) > 1:
        editor.add_measure(tuple(chosen)[: 2 + second % 2])


def name_by_model(editor, labels, first, second):
    """As many as there are places for in a name."""
    saved = editor.saved()
    chosen = dict.fromkeys(labels[(first + step) % len(labels)] for step in range(second % 3))
    editor.take_names(
        {
            label: replace(saved[label], label=f"name {second + i}", named_by=BY_MODEL)
            for i, label in enumerate(chosen)
        }
    )


def unmeasure(editor, _labels, _first, _second):
    for one in editor.history.measures()[:1]:
        editor.remove_measure(one.labels)


DOERS = {
    "move": move,
    "delete": delete,
    "rename": rename,
    "measure": measure,
    "model": name_by_model,
    "unmeasure": unmeasure,
}


def seen(capture):
    """Return all that a user sees of a capture's corrections, with nothing rounded."""
    markers = [
        (one.label, one.u, one.v, one.radius_px, one.covariance_px2.tolist())
        + ((None,) if one.position_m is None else (tuple(one.position_m),))
        for one in capture.markers()
    ]
    return markers, capture.history.measures(), capture.history.placed_by_hand()


def editor_of(store, capture):
    return CaptureEditor(capture, lambda _seen, h: store.captures.correct(capture.capture_id, h))


def undo_all(editor):
    while editor.history.can_undo:
        editor.undo()


def redo_all(editor):
    while editor.history.can_redo:
        editor.redo()


@settings(max_examples=12, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(edits)
def test_all_undone_is_the_start_and_all_redone_the_end(tmp_path, edits):
    folder = tmp_path / "edited"
    with open_store(folder, PASSPHRASE, key_params=CHEAP) as store:
        capture = saved_session(store, surface=None)[2][0]
        start = seen(capture)

        editor = editor_of(store, capture)
        for edit in edits:
            do(editor, edit)
        redo_all(editor)
        end = seen(editor.capture)
    with open_store(folder, PASSPHRASE) as store:
        again = editor_of(store, store.captures.get(capture.capture_id))
        assert seen(again.capture) == end
        undo_all(again)
        assert seen(store.captures.get(capture.capture_id)) == start
        again = editor_of(store, store.captures.get(capture.capture_id))
        redo_all(again)
        assert seen(store.captures.get(capture.capture_id)) == end


def test_corrections_survive_the_end_of_the_program(tmp_path):
    folder = tmp_path / "kept"
    with open_store(folder, PASSPHRASE, key_params=CHEAP) as store:
        capture = saved_session(store)[2][0]
        editor = editor_of(store, capture)
        editor.rename("m01", "C7")
        editor.add_measure(("C7", "m02"))
        editor.delete("m03")
        editor.undo()
    with open_store(folder, PASSPHRASE) as store:
        capture = store.captures.get(capture.capture_id)
        assert [one.label for one in capture.markers()] == ["C7", "m02", "m03"]
        assert capture.history.measures() == (FreeMeasure(("C7", "m02")),)
        assert capture.history.can_redo
        editor = editor_of(store, capture)
        editor.redo()
        undo_all(editor)
        assert [one.label for one in editor.capture.markers()] == ["m01", "m02", "m03"]


@pytest.fixture
def editor(store):
    capture = saved_session(store)[2][0]
    return editor_of(store, capture)


@pytest.mark.parametrize("wanted", ["", "   ", "x" * 41])
def test_a_name_is_neither_empty_nor_longer_than_forty_letters(editor, wanted):
    with pytest.raises(MarkerError, match="1 to 40"):
        editor.rename("m01", wanted)
    assert not editor.history.can_undo


def test_two_markers_cannot_have_one_name(editor):
    with pytest.raises(MarkerError, match="m02"):
        editor.rename("m01", " m02 ")
    assert list(editor.saved()) == ["m01", "m02", "m03"]


def test_a_name_has_no_spaces_around_and_one_between(editor):
    assert editor.rename("m01", "  left   ear ") == "left ear"
    assert editor.rename("left ear", " left ear") == "left ear"
    assert len(editor.history.corrections) == 1


def test_a_marker_that_is_held_is_seen_there_and_saved_nowhere(editor):
    held = replace(editor.saved()["m02"], u=5.0)
    editor.hold(held)
    assert editor.markers()[1] is held
    assert editor.saved()["m02"].u == 240.0
    assert not editor.history.can_undo
    editor.hold(None)
    assert editor.markers()[1].u == 240.0


def test_a_marker_dropped_where_it_was_leaves_no_trace(editor):
    editor.move(editor.saved()["m02"])
    assert not editor.history.can_undo


def test_the_same_measure_is_asked_for_once(editor):
    editor.add_measure(("m01", "m02"))
    editor.add_measure(("m02", "m01"))
    editor.add_measure(("m01", "m02", "m03"))
    editor.add_measure(("m03", "m02", "m01"))
    editor.add_measure(("m02", "m01", "m03"))
    assert [one.labels for one in editor.history.measures()] == [
        ("m01", "m02"),
        ("m01", "m02", "m03"),
        ("m02", "m01", "m03"),
    ]
    editor.remove_measure(("m02", "m01"))
    assert len(editor.history.measures()) == 2


def test_names_of_a_model_are_one_step_that_tells_who_gave_them(editor):
    editor.rename("m01", "neck")
    before = editor.saved()
    found = {
        label: replace(before[label], label=name, named_by=BY_MODEL)
        for label, name in (("m02", "left_hand"), ("m03", "right_hand"))
    }
    assert editor.take_names(found) == 2
    named = {label: one.named_by for label, one in editor.saved().items()}
    assert named == {"neck": None, "left_hand": BY_MODEL, "right_hand": BY_MODEL}
    editor.undo()
    assert list(editor.saved()) == ["neck", "m02", "m03"]
    editor.redo()
    assert {label: one.named_by for label, one in editor.saved().items()} == named
    editor.rename("left_hand", "left_elbow")
    assert editor.saved()["left_elbow"].named_by is None
    editor.undo()
    assert editor.saved()["left_hand"].named_by == BY_MODEL
    editor.undo()
    editor.undo()
    assert list(editor.saved()) == ["m01", "m02", "m03"]
    assert not editor.history.can_undo


def test_a_name_of_a_model_that_came_too_late_is_passed_over(editor):
    before = editor.saved()
    found = {
        label: replace(before[label], label=name, named_by=BY_MODEL)
        for label, name in (("m01", "head"), ("m02", "neck"), ("m03", "torso"))
    }
    editor.move(replace(before["m01"], u=9.0))
    editor.rename("m02", "torso")
    n_steps = len(editor.history.corrections)
    assert editor.take_names(found) == 0
    assert len(editor.history.corrections) == n_steps
    assert list(editor.saved()) == ["m01", "torso", "m03"]


def test_undo_and_redo_at_their_ends_do_nothing(editor):
    editor.undo()
    editor.redo()
    assert editor.history.corrections == ()


def test_new_markers_get_the_next_number(editor):
    assert editor.free_label() == "m04"
    editor.rename("m03", "C7")
    assert editor.free_label() == "m03"


def test_what_cannot_be_saved_does_not_happen(store):
    capture = saved_session(store)[2][0]

    def fail(_seen, _history):
        raise StoreError("The disk is full.")

    editor = CaptureEditor(capture, fail)
    with pytest.raises(StoreError):
        editor.delete("m01")
    assert list(editor.saved()) == ["m01", "m02", "m03"]
    np.testing.assert_array_equal(editor.history.corrections, ())
