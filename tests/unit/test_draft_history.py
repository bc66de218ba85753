"""Every step of a coding comes back on another day, and can be taken back then."""

import json
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from adibas.behaviour.editing import (
    Draft,
    History,
    accepted,
    added,
    changed,
    pressed,
    removed,
    with_detected,
    with_ethogram,
    with_section,
)
from adibas.data.coding import Coding, Occurrence, Section
from adibas.data.ethogram import Behaviour, Ethogram
from adibas.errors import BehaviourError
from adibas.pipeline.coding_drafts import BesideRecording, write_draft
from adibas.pipeline.draft_history import (
    MOST_STEPS,
    blind_observer,
    note_blind,
    read_history,
    write_history,
)
from tests.unit.coding_samples import ETHOGRAM, coding

FREE = replace(ETHOGRAM, is_locked=False)
SEEN = Ethogram("program", (Behaviour("waves"),))
FOUND = Coding(
    "session 1", SEEN, 0, 60_000, (Occurrence("waves", 1, 2), Occurrence("waves", 3, 4)), "program"
)


class InMemory:
    """A place that is gone with the test."""

    def __init__(self):
        self.parts = {}

    def read(self, part):
        return self.parts.get(part)

    def write(self, part, text):
        self.parts[part] = text


@pytest.fixture
def place():
    return InMemory()


def kept(place, history, at_ms=60_000):
    write_history(place, history, at_ms)
    found = read_history(place)
    assert found.notice is None
    return found.history


def steps(*functions):
    history = History(Draft(replace(coding(), ethogram=FREE)))
    for function in functions:
        history = history.changed(function(history.now))
    return history


EVERY_KIND = steps(
    lambda old: added(old, Occurrence("nods", 5000, 5000, "child", ("7",), "=a", "b\nc")),
    lambda old: with_detected(old, FOUND),
    lambda old: accepted(old, old.proposed[0], "child"),
    lambda old: removed(old, old.proposed[0]),
    lambda old: with_section(old, Section("game", 0, 30_000)),
    lambda old: with_ethogram(old, replace(old.coding.ethogram, name="other")),
    lambda old: changed(old, old.coding.occurrences[-1], Occurrence("nods", 7000, 7000, "child")),
    lambda old: removed(old, old.coding.occurrences[-1]),
)


def test_every_kind_of_step_comes_back(place):
    assert kept(place, EVERY_KIND) == EVERY_KIND
    half = EVERY_KIND.undone().undone().undone()
    assert kept(place, half) == half
    assert kept(place, half).redone().redone().redone() == EVERY_KIND


def test_steps_with_half_a_character_come_back_with_a_box(tmp_path):
    place = BesideRecording(tmp_path / "visit.mcap")
    named = replace(coding(), ethogram=FREE, name="caf\udce9", media=("caf\udce9.mcap",))
    start = Draft(named)
    nods = Occurrence("nods", 5000, 5000, "child", (), "said \ud83d")
    history = History(start).changed(added(start, nods))
    found = kept(place, history)
    assert found.now.coding.name == "caf\N{WHITE SQUARE}"
    boxed = replace(nods, comment="said \N{WHITE SQUARE}")
    assert found.now.coding.occurrences == (boxed,)
    assert found.undone().now.coding.occurrences == ()
    assert found.undone().redone().now.coding.occurrences == (boxed,)
    undone = kept(place, history.undone())
    assert undone.redone().now.coding.occurrences == (boxed,)


def test_a_state_that_lasted_is_ended_and_lasts_again_when_that_is_undone(place):
    history = steps(lambda old: pressed(old, "seated", "child", 1000))
    found = kept(place, history, 9000)
    assert found.now.coding.occurrences == (Occurrence("seated", 1000, 9000, "child"),)
    assert found.undone().now == history.now
    assert found.undone().undone().now == history.undone().now


def test_a_coding_that_another_program_changed_is_one_step_more(place):
    write_history(place, EVERY_KIND, 0)
    mine = EVERY_KIND.now
    theirs = added(mine, Occurrence("nods", 100, 100, "child"))
    write_draft(place, theirs, 0)
    found = read_history(place).history
    assert (found.now, found.undone().now) == (theirs, mine)
    assert found.before[:-1] == EVERY_KIND.before


def test_a_coding_without_steps_opens_as_before(place):
    assert read_history(place) is None
    write_draft(place, EVERY_KIND.now, 0)
    assert read_history(place).history == History(EVERY_KIND.now)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text[:-5],
        lambda _text: "[]",
        lambda text: text.replace('"version": 1', '"version": 2'),
        lambda text: text.replace('"back"', '"front"'),
        lambda text: json.dumps({**json.loads(text), "back": [{"events": [0, 1, [[1]]]}]}),
        lambda text: json.dumps({**json.loads(text), "base": {"coding": "x", "detected": None}}),
    ],
)
def test_damaged_steps_are_told_and_the_coding_is_there(place, change):
    write_history(place, EVERY_KIND, 0)
    place.write("steps", change(place.read("steps")))
    found = read_history(place)
    assert "cannot be undone step by step" in found.notice.text
    assert found.history == History(EVERY_KIND.now)


def test_a_damaged_coding_is_told_as_before(place):
    write_history(place, EVERY_KIND, 0)
    place.write("coding", "nonsense")
    with pytest.raises(BehaviourError):
        read_history(place)


def test_so_many_steps_are_kept_as_it_says(place):
    history = steps(
        *(
            lambda old, at_ms=at_ms: added(old, Occurrence("nods", at_ms, at_ms, "child"))
            for at_ms in range(MOST_STEPS + 20)
        )
    )
    found = kept(place, history)
    assert len(found.before) == MOST_STEPS
    assert found.before == history.before[-MOST_STEPS:]


@given(st.lists(st.tuples(st.integers(0, 59), st.booleans()), max_size=12), st.integers(0, 12))
@settings(max_examples=25, deadline=None)
def test_any_steps_come_back(moves, n_undone):
    history = steps()
    for second, is_removed in moves:
        events = history.now.coding.occurrences
        if is_removed and events:
            draft = removed(history.now, events[second % len(events)])
        else:
            draft = added(history.now, Occurrence("nods", second, second, "peer"))
        history = history.changed(draft)
    for _step in range(n_undone):
        history = history.undone()
    place = InMemory()
    assert kept(place, history) == history


def test_who_codes_blind_is_noted_beside_the_recording(tmp_path):
    place = BesideRecording(tmp_path / "child.mcap")
    assert blind_observer(place) == ""
    note_blind(place, "MP")
    assert blind_observer(place) == "MP"
    note_blind(place, "")
    assert blind_observer(place) == ""
    assert place.path("blind").name == "child.blind.txt"
    assert place.path("steps").name == "child.steps.json"
