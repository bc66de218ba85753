"""Who saves second is shown what the first one saved, and decides field by field."""

import json
from dataclasses import replace
from datetime import date

import pytest

from adibas.data.corrections import CorrectionHistory, MarkerCorrection
from adibas.data.patients import Identity
from adibas.sessions.conflicts import ConflictError, Decision
from tests.unit.store_samples import IDENTITY, NAME, add_capture, add_session, open_sample


@pytest.fixture
def store(tmp_path):
    with open_sample(tmp_path / "store") as opened:
        yield opened


@pytest.fixture
def session(store):
    return add_session(store)


@pytest.fixture
def capture(store):
    return add_capture(store)


def decided(error, **takes):
    """Decisions on all conflicts, by field."""
    return [Decision(one, takes[one.field.replace(".", "_")]) for one in error.conflicts]


def moved(capture, label, u, begin=None):
    history = capture.history if begin is None else begin
    marker = next(one for one in history.markers(capture.detected) if one.label == label)
    return history.after(MarkerCorrection(marker, replace(marker, u=u)))


def last_line(store):
    return store.audit.entries(1)[0]


def test_different_fields_of_a_session_come_together(store, session):
    store.operator = "Ana"
    store.sessions.change(session.session_id, notes="limps", seen=session)
    store.operator = "Bea"
    setup = replace(session.setup, rotation_deg=90)
    both = store.sessions.change(session.session_id, setup=setup, seen=session)
    assert (both.notes, both.setup) == ("limps", setup)
    third = replace(session.setup, protocol="sapo-1", wand={"format": "adibas-wand"})
    all_three = store.sessions.change(session.session_id, setup=third, seen=session)
    assert all_three.setup == replace(third, rotation_deg=90)
    assert last_line(store).detail == {"fields": ["setup"]}


def test_the_same_field_of_a_session_is_shown_with_who_and_when(store, session):
    store.operator = "Ana"
    first = store.sessions.change(session.session_id, notes="left", seen=session)
    changed_utc = last_line(store).time_utc
    store.operator = "Bea"
    setup = replace(session.setup, rotation_deg=90)
    with pytest.raises(ConflictError, match="Ana changed the same") as told:
        store.sessions.change(session.session_id, notes="right", setup=setup, seen=session)
    (conflict,) = told.value.conflicts
    assert (conflict.field, conflict.theirs, conflict.mine) == ("notes", "left", "right")
    assert (conflict.operator, conflict.changed_utc) == ("Ana", changed_utc)
    assert store.sessions.get(session.session_id) == first
    assert "left" not in str(told.value)


@pytest.mark.parametrize(
    ("choice", "notes", "word"),
    [("theirs", "left", "kept"), ("mine", "right", "over"), ("both", "left\nright", "both")],
)
def test_the_decision_holds_and_stands_in_the_log(store, session, choice, notes, word):
    store.sessions.change(session.session_id, notes="left", seen=session)
    wanted = {"notes": "right", "setup": replace(session.setup, rotation_deg=90), "seen": session}
    with pytest.raises(ConflictError) as told:
        store.sessions.change(session.session_id, **wanted)
    decisions = decided(told.value, notes=choice)
    now = store.sessions.change(session.session_id, **wanted, decisions=decisions)
    assert now.notes == notes
    assert now.setup.rotation_deg == 90
    fields = ["setup"] if choice == "theirs" else ["notes", "setup"]
    assert last_line(store).detail == {"fields": fields, word: ["notes"]}


def test_a_decision_on_what_is_not_there_any_more_is_asked_anew(store, session):
    store.sessions.change(session.session_id, notes="left", seen=session)
    with pytest.raises(ConflictError) as told:
        store.sessions.change(session.session_id, notes="right", seen=session)
    store.sessions.change(session.session_id, notes="both")
    decisions = decided(told.value, notes="mine")
    with pytest.raises(ConflictError) as again:
        store.sessions.change(session.session_id, notes="right", seen=session, decisions=decisions)
    assert again.value.conflicts[0].theirs == "both"
    assert store.sessions.get(session.session_id).notes == "both"


def test_what_was_saved_already_is_saved_again_without_harm(store, session):
    for _attempt in range(2):
        store.sessions.change(session.session_id, notes="limps", seen=session)
    lines = [one for one in store.audit.entries(50) if one.subject == session.session_id]
    assert [one.action for one in lines].count("change") == 1


def test_two_change_a_patient(store, session):
    seen = store.patients.get(session.patient)
    store.operator = "Ana"
    born = Identity(NAME, date(2014, 3, 28), IDENTITY.record_number)
    store.patients.change(session.patient, identity=born, sex="", notes="", seen=seen)
    store.operator = "Bea"
    renamed = Identity("Ximena Ñandú", IDENTITY.birth_date, IDENTITY.record_number)
    both = store.patients.change(
        session.patient, identity=renamed, sex="female", notes="x", seen=seen
    )
    assert both.identity == Identity("Ximena Ñandú", date(2014, 3, 28), IDENTITY.record_number)
    assert (both.sex, both.notes) == ("female", "x")
    assert store.patients.search("nandu")[0].pseudonym == session.patient
    with pytest.raises(ConflictError) as told:
        store.patients.change(
            session.patient, identity=Identity("Ximena Quetzal"), notes="y", seen=seen
        )
    fields = {one.field: one.operator for one in told.value.conflicts}
    assert fields == {"name": "Bea", "birth_date": "Bea", "notes": "Bea"}
    assert not set(str(told.value).split()) & {"Ximena", "Quetzal"}


def test_two_correct_different_markers_of_a_capture(store, capture):
    store.operator = "Ana"
    store.captures.correct(capture.capture_id, moved(capture, "m01", 31.0), seen=capture.history)
    store.operator = "Bea"
    both = store.captures.correct(
        capture.capture_id, moved(capture, "m02", 62.0), seen=capture.history
    )
    assert [one.u for one in both.markers()] == [31.0, 62.0, 90.0]
    assert both.history.n_done == 2
    undone = store.captures.correct(capture.capture_id, both.history.undone(), seen=both.history)
    assert [one.u for one in undone.markers()] == [31.0, 61.0, 90.0]


@pytest.mark.parametrize("choice", ["theirs", "mine"])
def test_two_correct_the_same_marker_and_both_versions_stay(store, capture, choice):
    store.operator = "Ana"
    store.captures.correct(capture.capture_id, moved(capture, "m01", 31.0), seen=capture.history)
    store.operator = "Bea"
    mine = moved(capture, "m03", 91.0, begin=moved(capture, "m01", 32.0))
    with pytest.raises(ConflictError) as told:
        store.captures.correct(capture.capture_id, mine, seen=capture.history)
    (conflict,) = told.value.conflicts
    assert (conflict.field, conflict.operator) == ("m01", "Ana")
    assert (conflict.theirs.u, conflict.mine.u) == (31.0, 32.0)
    assert next(one.u for one in store.captures.get(capture.capture_id).markers()) == 31.0
    now = store.captures.correct(
        capture.capture_id,
        mine,
        seen=capture.history,
        decisions=decided(told.value, m01=choice),
    )
    assert [one.u for one in now.markers()] == [32.0 if choice == "mine" else 31.0, 61.0, 91.0]
    kept = kept_places(store, capture, "m01")
    assert kept >= {31.0, 32.0}
    assert store.verify().is_sound


def kept_places(store, capture, label):
    """All places where somebody put a marker, as the table of corrections tells."""
    with store._database.reading() as transaction:
        rows = transaction.exec_driver_sql(
            "SELECT content FROM corrections WHERE capture_id = ?", (capture.capture_id,)
        ).scalars()
        after = [json.loads(row)["after"] for row in rows]
    return {one["u"] for one in after if one and one["label"] == label}


def test_whoever_did_not_say_what_he_saw_replaces_the_stack_as_before(store, capture):
    store.captures.correct(capture.capture_id, moved(capture, "m01", 31.0))
    now = store.captures.correct(capture.capture_id, CorrectionHistory())
    assert [one.u for one in now.markers()] == [30.25, 61.0, 90.0]
