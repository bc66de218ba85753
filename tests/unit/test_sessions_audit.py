"""The audit log: complete, in order, and every tampering is found."""

import csv
import json
from datetime import datetime, timedelta
from typing import get_args

import pytest
import sqlcipher3.dbapi2 as sqlcipher

from adibas.data.corrections import MarkerCorrection
from adibas.reports.audit_csv import write_audit_csv
from adibas.sessions.audit import Action
from adibas.sessions.audit_words import ACTION_WORDS, action_text, subject_text
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import (
    IDENTITY,
    NAME,
    START,
    add_capture,
    add_session,
    marker,
    open_sample,
    raw_connection,
)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


def written(store):
    return [(entry.action, entry.subject) for entry in reversed(store.audit.entries())]


def findings(folder):
    with open_sample(folder) as store:
        return [(finding.kind, finding.subject) for finding in store.verify().findings]


def test_everything_that_is_done_is_a_line(folder, tmp_path):
    with open_sample(folder, operator="Berta") as store:
        session = add_session(store)
        patient = session.patient
        with store.recordings.create(session.session_id, INFO) as writer:
            writer.write(make_frames(1)[0])
        capture = add_capture(store, session, recording_id=writer.recording_id)
        store.patients.change(patient, notes="x")
        store.patients.get(patient)
        store.sessions.change(session.session_id, notes="x")
        correction = MarkerCorrection(marker(), marker("m01", 33.0))
        store.captures.correct(capture.capture_id, capture.history.after(correction))
        store.operator = "Carles"
        store.recordings.export(writer.recording_id, tmp_path / "out.mcap")
        store.note_export("excel", session.session_id)
        for part, subject in (
            (store.captures, capture.capture_id),
            (store.sessions, session.session_id),
            (store.patients, patient),
        ):
            part.delete(subject)
            part.delete(subject)
            part.restore(subject)
        store.sessions.purge(session.session_id)
        lines = written(store)
        who = [entry.operator for entry in reversed(store.audit.entries())]
        texts = repr(store.audit.entries())
    both = [("delete", ""), ("restore", "")]
    hidden = [
        (action, subject)
        for subject in (capture.capture_id, session.session_id, patient)
        for action, _ in both
    ]
    assert lines == [
        ("open", "store"),
        ("create", patient),
        ("change", patient),
        ("create", session.session_id),
        ("create", writer.recording_id),
        ("create", capture.capture_id),
        ("change", patient),
        ("view", patient),
        ("change", session.session_id),
        ("change", capture.capture_id),
        ("export", writer.recording_id),
        ("export", session.session_id),
        *hidden,
        ("purge", session.session_id),
    ]
    assert who == ["Berta"] * 10 + ["Carles"] * 9
    assert NAME not in texts


def test_looking_again_within_a_minute_is_one_line_for_one_operator(folder):
    times = [START]
    with open_sample(folder, clock=lambda: times[-1]) as store:
        pseudonym = store.patients.add(IDENTITY).pseudonym
        for seconds in (0, 30, 70, 80):
            times.append(START + timedelta(seconds=seconds))
            store.patients.get(pseudonym)
        assert written(store).count(("view", pseudonym)) == 2
        store.operator = "another"
        store.patients.get(pseudonym)
        assert written(store).count(("view", pseudonym)) == 3


def test_a_look_at_the_list_of_names_is_a_line(folder):
    with open_sample(folder) as store:
        store.patients.search("")
        assert ("view", "patients") not in written(store)
        store.patients.add(IDENTITY)
        store.patients.search("")
        assert ("view", "patients") in written(store)


def test_a_clock_that_goes_backwards_does_not_turn_the_order(folder):
    times = [START + timedelta(days=2), START, START + timedelta(days=1), START - timedelta(days=9)]
    with open_sample(folder, clock=lambda: times[0]) as store:
        for _ in range(3):
            times.pop(0)
            store.patients.add(IDENTITY)
        entries = store.audit.entries()
        assert store.verify().is_sound
    assert [entry.sequence for entry in entries] == [4, 3, 2, 1]
    assert {entry.time_utc for entry in entries} == {START + timedelta(days=2)}


def test_the_log_goes_on_over_openings(folder):
    for _ in range(3):
        with open_sample(folder) as store:
            store.patients.add(IDENTITY)
    with open_sample(folder) as store:
        assert [entry.sequence for entry in store.audit.entries()] == [7, 6, 5, 4, 3, 2, 1]
        assert store.verify().is_sound
        assert len(store.audit.entries(2)) == 2


@pytest.mark.parametrize("statement", ["UPDATE audit SET operator = 'x'", "DELETE FROM audit"])
def test_the_database_itself_refuses_to_change_the_log(folder, statement):
    with open_sample(folder) as store:
        store.patients.add(IDENTITY)
    connection = raw_connection(folder)
    with pytest.raises(sqlcipher.IntegrityError, match="append-only"):
        connection.execute(statement)
    connection.close()
    assert findings(folder) == []


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("UPDATE audit SET operator = 'x' WHERE sequence = 3", [("audit", "3")]),
        ("UPDATE audit SET time_utc = '2020' WHERE sequence = 3", [("audit", "3")]),
        ("UPDATE audit SET detail = '{\"a\": 1}' WHERE sequence = 3", [("audit", "3")]),
        ("DELETE FROM audit WHERE sequence = 3", [("audit", "3")]),
        ("UPDATE audit SET sequence = -1 WHERE sequence = 1", None),
    ],
)
def test_who_goes_round_the_triggers_is_found(folder, statement, expected):
    with open_sample(folder) as store:
        for _ in range(5):
            store.patients.add(IDENTITY)
    connection = raw_connection(folder)
    for verb in ("UPDATE", "DELETE"):
        connection.execute(f"DROP TRIGGER audit_{verb}")
    connection.execute(statement)
    connection.close()
    found = findings(folder)
    assert found
    assert expected is None or found == expected


def test_lines_missing_at_the_end_are_found(folder):
    with open_sample(folder) as store:
        for _ in range(5):
            store.patients.add(IDENTITY)
    connection = raw_connection(folder)
    connection.execute("DROP TRIGGER audit_DELETE")
    connection.execute("DELETE FROM audit WHERE sequence > 4")
    connection.close()
    assert ("audit", "5") in findings(folder)


def test_the_lines_on_a_patient_are_those_on_sessions_captures_and_recordings_too(folder, tmp_path):
    with open_sample(folder) as store:
        session = add_session(store)
        with store.recordings.create(session.session_id, INFO) as writer:
            writer.write(make_frames(1)[0])
        capture = add_capture(store, session, recording_id=writer.recording_id)
        store.captures.delete(capture.capture_id)
        store.recordings.export(writer.recording_id, tmp_path / "out.mcap")
        other = store.patients.add(IDENTITY).pseudonym
        store.patients.search("")
        store.sessions.purge(session.session_id)
        store.patients.purge(session.patient)
        every = store.audit.entries()
        own = store.audit.entries(patients={session.patient})
        assert own == tuple(entry for entry in every if entry.patient == session.patient)
        assert [(entry.action, entry.subject) for entry in reversed(own)] == [
            ("create", session.patient),
            ("change", session.patient),
            ("create", session.session_id),
            ("create", writer.recording_id),
            ("create", capture.capture_id),
            ("delete", capture.capture_id),
            ("export", writer.recording_id),
            ("purge", session.session_id),
            ("purge", session.patient),
        ]
        assert store.audit.entries(2, patients={session.patient}) == own[:2]
        assert {entry.patient for entry in every} == {session.patient, other, ""}
        assert len(store.audit.entries(patients={session.patient, other})) == len(own) + 1
        assert store.audit.entries(patients=()) == ()


def test_the_log_is_written_as_a_table_that_is_no_formula(folder, tmp_path):
    with open_sample(folder, operator="=Berta") as store:
        session = add_session(store)
        store.patients.change(session.patient, notes="x")
        entries = store.audit.entries()
    write_audit_csv(entries, tmp_path / "audit.csv")
    with (tmp_path / "audit.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["sequence"]) for row in rows] == [5, 4, 3, 2, 1]
    assert [row["operator"] for row in rows] == ["'=Berta"] * 5
    assert rows[0]["action"] == "change"
    assert rows[0]["subject"] == rows[0]["patient"] == session.patient
    assert json.loads(rows[0]["detail"]) == {"fields": ["notes"]}
    assert rows[4]["patient"] == ""
    assert datetime.fromisoformat(rows[4]["time_utc"]) == entries[4].time_utc
    assert NAME not in (tmp_path / "audit.csv").read_text(encoding="utf-8")


def test_every_action_has_words_and_an_unknown_one_stays_as_it_is():
    assert set(ACTION_WORDS) == set(get_args(Action))
    assert (action_text("purge"), action_text("sing")) == ("removed for good", "sing")
    assert (subject_text("store"), subject_text("P-7")) == ("the patient store", "P-7")
