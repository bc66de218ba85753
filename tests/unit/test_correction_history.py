"""Steps of a correction history: one by hand is one step, names of a model are one together."""

from dataclasses import replace

from adibas.data.corrections import CorrectionHistory, MarkerCorrection
from adibas.data.markers import AutomaticName
from tests.unit.store_samples import marker

WORD = AutomaticName("shipped, 2024-01-01", 0.98)
DETECTED = tuple(marker(f"m0{i}", 10.0 * i) for i in range(1, 5))


def renamed(history, old, new, named_by=None):
    before = next(one for one in history.markers(DETECTED) if one.label == old)
    return history.after(
        MarkerCorrection(before, replace(before, label=new, named_by=named_by or before.named_by))
    )


def labels(history):
    return [one.label for one in history.markers(DETECTED)]


def test_names_of_a_model_are_undone_and_done_again_together_and_others_one_by_one():
    history = renamed(CorrectionHistory(), "m01", "head")
    for old, new in (("m02", "neck"), ("m03", "torso")):
        history = renamed(history, old, new, WORD)
    history = renamed(history, "m04", "left_foot")
    states = [
        ["m01", "m02", "m03", "m04"],
        ["head", "m02", "m03", "m04"],
        ["head", "neck", "torso", "m04"],
        ["head", "neck", "torso", "left_foot"],
    ]
    for state in reversed(states[:-1]):
        history = history.undone()
        assert labels(history) == state
    assert not history.can_undo
    for state in states[1:]:
        history = history.redone()
        assert labels(history) == state
    assert not history.can_redo


def test_names_of_a_model_at_either_end_are_one_step():
    history = CorrectionHistory()
    for old, new in (("m01", "head"), ("m02", "neck")):
        history = renamed(history, old, new, WORD)
    undone = history.undone()
    assert labels(undone) == ["m01", "m02", "m03", "m04"]
    assert undone.redone().n_done == 2


def test_who_renames_by_hand_is_the_one_who_named_also_where_older_files_kept_the_model():
    """Files of earlier versions hold the model's word behind a name that a hand gave."""
    history = renamed(CorrectionHistory(), "m01", "head", WORD)
    assert history.markers(DETECTED)[0].named_by == WORD
    history = renamed(history, "head", "neck")
    assert history.markers(DETECTED)[0].named_by is None
    assert [one.is_by_program for one in history.corrections] == [True, False]
    assert labels(history.undone()) == ["head", "m02", "m03", "m04"]
