"""Whatever an observer does, his coding can be saved, and every step can be taken back."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.behaviour.editing import (
    Draft,
    History,
    accepted,
    added,
    begun_of,
    changed,
    pressed,
    released,
    removed,
    with_detected,
    with_ethogram,
    with_section,
    with_subject,
    without_section,
)
from adibas.data.coding import Coding, Occurrence, Section
from adibas.data.ethogram import Behaviour, Ethogram, Subject
from adibas.errors import BehaviourError
from tests.unit.coding_samples import ETHOGRAM, coding

OPEN = replace(ETHOGRAM, is_locked=False)


def draft_of(*occurrences, **more):
    made = coding(*occurrences, **more)
    return Draft(replace(made, ethogram=OPEN))


def spans(draft):
    return [(one.behaviour, one.begin_ms, one.end_ms) for one in draft.coding.occurrences]


def test_a_state_lasts_from_one_press_to_the_next():
    draft = pressed(draft_of(), "seated", "child", 1000)
    assert spans(draft) == []
    assert begun_of(draft, "seated", "child") == Occurrence("seated", 1000, 1000, "child")
    draft = pressed(draft, "seated", "child", 3000)
    assert spans(draft) == [("seated", 1000, 3000)]
    assert draft.begun == ()


def test_a_point_event_is_noted_at_once():
    assert spans(pressed(draft_of(), "nods", "", 700)) == [("nods", 700, 700)]


def test_what_excludes_a_state_ends_it():
    draft = pressed(pressed(draft_of(), "seated", "child", 1000), "up", "child", 4000)
    assert spans(draft) == [("seated", 1000, 4000)]
    assert [one.behaviour for one in draft.begun] == ["up"]


def test_others_go_on_with_what_they_do():
    draft = pressed(pressed(draft_of(), "seated", "child", 1000), "up", "peer", 4000)
    assert len(draft.begun) == 2


def test_two_presses_on_one_frame_note_nothing():
    draft = pressed(pressed(draft_of(), "seated", "child", 1000), "seated", "child", 1000)
    assert draft == draft_of()


def test_a_state_cannot_end_before_it_begins():
    draft = pressed(draft_of(), "seated", "", 2000)
    with pytest.raises(BehaviourError, match="ends before it begins"):
        released(draft, "seated", "", 1000)


def test_a_state_cannot_begin_within_what_excludes_it():
    with pytest.raises(BehaviourError, match="still lasts"):
        pressed(draft_of(("seated", 1, 5, "child")), "up", "child", 3000)


def test_releasing_what_was_not_begun_changes_nothing():
    assert released(draft_of(), "seated", "", 1000) == draft_of()


def test_what_is_being_coded_is_saved_up_to_now():
    draft = pressed(draft_of(), "seated", "child", 1000)
    assert draft.settled(9000).occurrences == (Occurrence("seated", 1000, 9000, "child"),)
    assert draft.settled(0).occurrences == (Occurrence("seated", 1000, 1000, "child"),)
    assert draft.settled(99_000).occurrences[0].end_ms == 60_000


def test_what_is_being_coded_is_saved_up_to_what_excludes_it():
    draft = pressed(draft_of(("up", 5, 6, "child"), ("up", 2, 3)), "seated", "child", 1000)
    assert Occurrence("seated", 1000, 5000, "child") in draft.settled(9000).occurrences


def test_events_move_and_go():
    draft = draft_of(("seated", 1, 5))
    (one,) = draft.coding.occurrences
    moved = changed(draft, one, replace(one, end_ms=8000))
    assert spans(moved) == [("seated", 1000, 8000)]
    assert spans(removed(moved, moved.coding.occurrences[0])) == []


def test_an_event_is_not_moved_into_what_excludes_it():
    draft = draft_of(("seated", 1, 5), ("up", 6, 7))
    with pytest.raises(BehaviourError, match="still lasts"):
        changed(draft, draft.coding.occurrences[0], Occurrence("seated", 1000, 6500))


def test_nothing_is_moved_over_the_beginning_of_what_lasts():
    draft = pressed(draft_of(("seated", 1, 5)), "up", "", 6000)
    with pytest.raises(BehaviourError, match="still lasts"):
        changed(draft, draft.coding.occurrences[0], Occurrence("seated", 1000, 6500))


def test_what_was_begun_takes_modifiers_and_goes():
    draft = pressed(draft_of(), "fidgets", "", 2000)
    (one,) = draft.begun
    draft = changed(draft, one, replace(one, begin_ms=1500, modifiers=("pen",)))
    assert draft.begun == (Occurrence("fidgets", 1500, 1500, "", ("pen",)),)
    assert removed(draft, draft.begun[0]).begun == ()


def test_a_modifier_that_nobody_knows_is_refused():
    draft = draft_of(("fidgets", 1, 2))
    with pytest.raises(BehaviourError, match="car"):
        changed(draft, draft.coding.occurrences[0], Occurrence("fidgets", 1000, 2000, "", ("car",)))


FOUND = Occurrence("nods", 2000, 2000, "person 1")
SEEN = Ethogram(
    "program",
    (Behaviour("nods", "point"), Behaviour("waves")),
    (Subject("person 1"), Subject("person 2")),
)


def proposing(draft, *found):
    return with_detected(draft, Coding("session 1", SEEN, 0, 60_000, found, "program"))


def test_an_accepted_event_is_coded_for_the_one_who_is_meant():
    draft = accepted(proposing(draft_of(), FOUND), FOUND, "child")
    assert draft.coding.occurrences == (Occurrence("nods", 2000, 2000, "child"),)
    assert draft.proposed == ()
    known = with_subject(proposing(draft_of(), FOUND), "person 1")
    assert accepted(known, FOUND, "child").coding.occurrences == (FOUND,)


def test_an_accepted_event_that_the_ethogram_lacks_comes_into_it():
    found = Occurrence("waves", 2000, 3000, "person 1")
    draft = accepted(proposing(draft_of(), found), found, "child")
    assert draft.coding.occurrences == (Occurrence("waves", 2000, 3000, "child"),)
    assert draft.coding.ethogram.behaviours == (*OPEN.behaviours, Behaviour("waves"))


def test_a_locked_ethogram_takes_no_event_that_it_lacks():
    found = Occurrence("waves", 2000, 3000, "person 1")
    with pytest.raises(BehaviourError, match="waves"):
        accepted(proposing(Draft(coding()), found), found, "child")


def test_a_rejected_event_is_gone_and_a_moved_one_still_waits():
    draft = proposing(draft_of(), FOUND)
    assert removed(draft, FOUND).proposed == ()
    later = replace(FOUND, begin_ms=2500, end_ms=2500)
    assert changed(draft, FOUND, later).proposed == (later,)
    with pytest.raises(BehaviourError, match="point event"):
        changed(draft, FOUND, replace(FOUND, end_ms=3000))


def test_what_is_coded_is_not_proposed_again():
    draft = accepted(proposing(draft_of(), FOUND), FOUND, "child")
    assert proposing(draft, FOUND).proposed == ()
    assert draft_of().proposed == ()


def test_what_is_not_there_cannot_go():
    assert removed(draft_of(), FOUND) == draft_of()


def test_a_scheme_must_know_what_is_coded():
    draft = draft_of(("seated", 1, 2))
    with pytest.raises(BehaviourError, match="seated"):
        with_ethogram(draft, replace(OPEN, behaviours=(Behaviour("up"),)))
    wider = replace(OPEN, behaviours=(*OPEN.behaviours, Behaviour("sleeps")))
    assert with_ethogram(draft, wider).coding.ethogram == wider


def test_a_locked_scheme_stays():
    with pytest.raises(BehaviourError, match="locked"):
        with_ethogram(Draft(coding()), OPEN)
    assert with_subject(Draft(coding()), "child") == Draft(coding())


def test_a_new_name_is_taken_everywhere():
    draft = pressed(draft_of(("up", 1, 2)), "fidgets", "", 3000)
    scheme = replace(OPEN, behaviours=(Behaviour("stands"), Behaviour("fidgets")))
    draft = with_ethogram(draft, scheme, {"up": "stands", "fidgets": "fidgets"})
    assert spans(draft) == [("stands", 1000, 2000)]
    assert draft.begun[0].behaviour == "fidgets"


def test_what_is_coded_does_not_become_another_behaviour_of_the_same_name():
    draft = draft_of(("up", 1, 2))
    scheme = replace(OPEN, behaviours=(Behaviour("up"),))
    with pytest.raises(BehaviourError, match="up is coded"):
        with_ethogram(draft, scheme, {"seated": "up"})


def test_a_new_section_takes_the_place_of_what_it_covers():
    draft = draft_of(sections=(Section("task", 0, 60_000),))
    cut = with_section(draft, Section("game", 10_000, 20_000))
    assert cut.coding.sections == (
        Section("task", 0, 10_000),
        Section("game", 10_000, 20_000),
        Section("task", 20_000, 60_000),
    )
    assert without_section(cut, Section("game", 10_000, 20_000)).coding.sections == (
        Section("task", 0, 10_000),
        Section("task", 20_000, 60_000),
    )


@pytest.mark.parametrize(("begin_ms", "end_ms"), [(5, 5), (9, 5), (-1, 5), (5, 60_001)])
def test_a_section_lasts_and_lies_within_the_session(begin_ms, end_ms):
    with pytest.raises(BehaviourError, match="section"):
        with_section(draft_of(), Section("game", begin_ms, end_ms))


actions = st.tuples(
    st.sampled_from(["press", "release", "move", "remove", "add"]),
    st.sampled_from(["seated", "up", "fidgets", "nods"]),
    st.sampled_from(["", "child"]),
    st.integers(0, 50),
    st.integers(0, 50),
)


def act(draft, action):
    what, behaviour, subject, first, second = action
    if what == "press":
        return pressed(draft, behaviour, subject, first)
    if what == "release":
        return released(draft, behaviour, subject, first)
    if what == "add":
        return added(draft, Occurrence(behaviour, first, second, subject))
    events = (*draft.coding.occurrences, *draft.begun)
    if not events:
        return draft
    one = events[first % len(events)]
    if what == "remove":
        return removed(draft, one)
    return changed(draft, one, replace(one, begin_ms=first, end_ms=second, subject=subject))


@given(st.lists(actions, max_size=25), st.integers(0, 60))
def test_whatever_was_done_the_coding_can_be_saved_and_taken_back(some, at_ms):
    history = History(draft_of(end_ms=60))
    steps = [history.now]
    for action in some:
        try:
            history = history.changed(act(history.now, action))
        except BehaviourError:
            continue
        steps.append(history.now)
        saved = history.now.settled(at_ms)
        n_events = len(history.now.coding.occurrences) + len(history.now.begun)
        assert isinstance(saved, Coding)
        assert len(saved.occurrences) == n_events
    for step in reversed(steps):
        assert history.now == step
        history = history.undone()
    for step in steps:
        assert history.now == step
        history = history.redone()
