"""A withdrawal finds everything: held against a search of all tables and files on its own."""

import json
from datetime import UTC, date, datetime, timedelta

import pytest

from adibas.data.corrections import MarkerCorrection
from adibas.errors import StoreError
from adibas.sessions import open_store
from adibas.sessions.backup_schedule import BackupPlan
from adibas.sessions.coding_drafts import InStore
from adibas.sessions.holdings_words import holdings_sections, plain_spelling
from adibas.sessions.roles import Role
from adibas.sessions.schema import METADATA
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import (
    CHEAP,
    IDENTITY,
    NAME,
    add_capture,
    add_patient,
    add_session,
    consent,
    marker,
    minutes_clock,
    new_capture,
    open_sample,
    picture,
    raw_connection,
)

LATER = datetime(2026, 11, 22, 9, 0, tzinfo=UTC)
ANNA, CARLA = "anna has four words", "carla has four words"


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


def fill(store):
    """One of everything that a patient can have, hidden things too; somebody else besides."""
    session = add_session(store)
    pseudonym = session.patient
    store.patients.change(pseudonym, notes="the left knee")
    store.patients.give_consent(pseudonym, consent("research", given_utc=LATER))
    for _number in range(2):
        with store.recordings.create(session.session_id, INFO) as writer:
            for frame in make_frames(3):
                writer.write(frame)
    for observer in ("", "EV"):
        InStore(store.recordings, writer.recording_id, observer).write("coding", "{}")
    capture = add_capture(store, session, recording_id=writer.recording_id)
    moved = capture.history.after(MarkerCorrection(marker(), marker("m01", 33.0)))
    store.captures.correct(capture.capture_id, moved)
    store.captures.correct(capture.capture_id, capture.history)
    bare = store.captures.add(session.session_id, new_capture("posterior"), picture(1))
    store.captures.delete(bare.capture_id)
    second = store.sessions.start(pseudonym, session.setup)
    add_capture(store, second)
    store.sessions.change(second.session_id, notes="tired")
    store.sessions.delete(second.session_id)
    other = add_capture(store, add_session(store))
    store.captures.correct(
        other.capture_id, other.history.after(MarkerCorrection(marker(), marker("m01", 35.0)))
    )
    return session


def send_out(store, session, folder):
    """Let something leave in every way that there is."""
    folder.mkdir()
    capture = store.captures.of_session(session.session_id)[0]
    recording = store.recordings.of_session(session.session_id)[0]
    store.recordings.export(recording.recording_id, folder / "r.mcap")
    store.note_export("report", session.session_id)
    store.note_export("dicom server, with identity", session.session_id, receiver="PACS (archive)")
    store.note_export("limb labels", capture.capture_id)
    store.note_export("training of names", session.patient)
    store.note_export("audit log", "store")
    store.patients.delete(session.patient)


def rows_of(folder, pseudonym):
    """Every row that belongs to a patient, by table: what refers to a row that does, does, too."""
    connection = raw_connection(folder)
    tables = {}
    for name in METADATA.tables:
        cursor = connection.execute(f"SELECT * FROM {name}")
        names = [one[0] for one in cursor.description]
        tables[name] = [dict(zip(names, row, strict=True)) for row in cursor]
    connection.close()
    theirs = {("patients", "pseudonym", pseudonym)}
    found = {name: [] for name in tables}
    has_grown = True
    while has_grown:
        has_grown = False
        for name, rows in tables.items():
            for row in rows:
                if row not in found[name] and any(
                    (key.column.table.name, key.column.name, row[key.parent.name]) in theirs
                    for key in METADATA.tables[name].foreign_keys
                    if key.column.table.name != "files"
                ):
                    found[name].append(row)
                    theirs |= {(name, column, value) for column, value in row.items()}
                    has_grown = True
    found["patients"] = [one for one in tables["patients"] if one["pseudonym"] == pseudonym]
    used = {one[k] for one in found["captures"] for k in ("picture_id", "surface_id")}
    found["files"] = [one for one in tables["files"] if one["file_id"] in used]
    ids = {pseudonym} | {
        value
        for name in ("sessions", "captures", "recordings")
        for row in found[name]
        for column, value in row.items()
        if column in ("session_id", "capture_id", "recording_id") and value
    }
    found["audit"] = [
        one
        for one in tables["audit"]
        if one["subject"] in ids or any(word in one["detail"] for word in ids)
    ]
    return found


def test_the_list_misses_no_row_no_file_and_no_line_of_the_log(folder, tmp_path):
    with open_sample(folder) as store:
        session = fill(store)
        send_out(store, session, tmp_path / "out")
        held = store.holdings.of(session.patient)
    rows = rows_of(folder, session.patient)
    assert {name for name, found in rows.items() if not found} == {"leftovers", "audit_head"}, (
        "the sample has one of everything; another table needs a place in the list"
    )
    assert held.pseudonym == session.patient
    assert held.is_deleted
    assert (held.has_identity, held.has_notes) == (True, True)
    assert len(rows["identities"]) == 1
    assert [one.purposes for one in held.consents] == [("treatment",), ("research",)]
    assert len(held.consents) == len(rows["consents"]) == len(rows["signers"])
    for name, mine in (
        ("session_id", held.sessions),
        ("capture_id", held.captures),
        ("recording_id", held.recordings),
    ):
        table = f"{name.removesuffix('_id')}s"
        assert {getattr(one, name) for one in mine} == {row[name] for row in rows[table]}
        assert len(mine) == len(rows[table])
    assert [one.is_deleted for one in held.sessions] == [False, True]
    assert sorted(one.is_deleted for one in held.captures) == [False, False, True]
    assert sum(one.n_corrections for one in held.captures) == len(rows["corrections"])
    pictures = {one.name for one in held.files if one.name.startswith("pictures/")}
    assert pictures == {f"pictures/{row['file_id']}" for row in rows["files"]}
    *log, look = rows["audit"]
    assert (look["action"], look["subject"]) == ("view", session.patient), "this very look"
    assert held.n_log_lines == len(log)
    exports = [row for row in log if row["action"] == "export"]
    assert [(one.kind, one.subject) for one in held.left] == [
        *((json.loads(row["detail"])["kind"], row["subject"]) for row in exports),
        ("audit log", "store"),
    ]
    assert [one.receiver for one in held.left if one.receiver] == ["PACS (archive)"]


def test_with_the_only_patient_the_list_names_every_sealed_file_and_its_size(folder):
    with open_sample(folder) as store:
        session = fill(store)
        for row in store.patients.search(""):
            if row.pseudonym != session.patient:
                store.patients.purge(row.pseudonym)
        held = store.holdings.of(session.patient)
    on_disk = {
        f"{path.parent.parent.name}/{path.stem}": path.stat().st_size
        for path in folder.rglob("*")
        if path.is_file() and path.parent.parent.parent == folder
    }
    assert len(on_disk) == 2 + 2 + 5, "recordings, codings, and pictures with their surfaces"
    assert {one.name: one.size_bytes for one in held.files} == on_disk
    assert held.size_bytes == sum(on_disk.values())


def test_somebody_elses_things_are_not_in_it(folder, tmp_path):
    with open_sample(folder) as store:
        session = fill(store)
        send_out(store, session, tmp_path / "out")
        pseudonym = add_patient(store).pseudonym
        held = store.holdings.of(pseudonym)
        assert (held.sessions, held.files, held.left) == ((), (), ())
        assert held.n_log_lines == 2


def test_a_file_that_is_gone_is_listed_as_missing(folder):
    with open_sample(folder) as store:
        capture = add_capture(store)
        session = store.sessions.get(capture.session_id)
        for path in (folder / "pictures").rglob("*.sealed"):
            path.unlink()
        held = store.holdings.of(session.patient)
    (only,) = held.captures
    assert (only.picture.size_bytes, only.surface.size_bytes) == (None, None)
    assert "(missing)" in repr(holdings_sections(held, plain_spelling()))


def test_backups_of_the_patients_time_are_listed_with_how_long_they_stay(folder, tmp_path):
    plan = BackupPlan(tmp_path / "backups", every_days=7, keep=3)
    plan.folder.mkdir()
    days = [datetime(2026, 11, day, 9, tzinfo=UTC) for day in (1, 8, 15)]
    with open_sample(folder, clock=minutes_clock(days[0])) as store:
        store.backups.write_planned(plan)
    with open_sample(folder, clock=minutes_clock(days[1] - timedelta(hours=2))) as store:
        patient = add_patient(store).pseudonym
    for day in days[1:]:
        with open_sample(folder, clock=minutes_clock(day)) as store:
            store.backups.write_planned(plan)
            held = store.holdings.of(patient, plan)
    assert [one.created_utc.date() for one in held.backups] == [date(2026, 11, 15), days[1].date()]
    assert [one.until for one in held.backups] == [date(2026, 12, 6), date(2026, 11, 29)]
    assert [one.date() for one in held.backups_made] == [days[1].date(), days[2].date()]
    with open_sample(folder, clock=minutes_clock(days[2] + timedelta(days=1))) as store:
        assert store.holdings.of(patient).backups == ()
        store.patients.purge(patient)
        store.backups.write(tmp_path / "after.adibas-backup")
        gone = store.holdings.of(patient, plan)
    assert (gone.sessions, gone.has_identity) == ((), False)
    assert gone.gone_utc.date() == date(2026, 11, 16)
    assert gone.backups == held.backups, "they still hold who was removed"
    assert gone.backups_made == held.backups_made


def test_a_folder_of_backups_that_cannot_be_read_is_told_and_the_rest_is_listed(folder, tmp_path):
    place = tmp_path / "no-folder"
    with open_sample(folder) as store:
        session = fill(store)
        held = store.holdings.of(session.patient, BackupPlan(place))
        assert held.backups == ()
        place.mkdir()
        (place / "adibas-broken.adibas-backup").write_bytes(b"no backup")
        held = store.holdings.of(session.patient, BackupPlan(place))
    assert held.backups == ()
    assert len(held.sessions) == 2


def test_copies_of_the_database_are_listed(folder):
    with open_sample(folder) as store:
        patient = add_patient(store).pseudonym
        (folder / "adibas.db.before-0002-from-0001").write_bytes(b"x")
        held = store.holdings.of(patient)
    assert held.copies == ("adibas.db.before-0002-from-0001",)


def test_who_may_not_read_the_log_is_told_whom_to_ask(folder):
    with open_sample(folder) as store:
        session = fill(store)
        store.people.add("Anna Puig", Role.ADMINISTRATOR, ANNA, CHEAP)
        store.people.add("Carla Roca", Role.OPERATOR, CARLA, CHEAP)
    with open_store(folder, CARLA, clock=minutes_clock()) as store:
        held = store.holdings.of(session.patient)
        text = repr(holdings_sections(held, plain_spelling()))
    assert (held.left, held.n_log_lines, held.backups_made) == (None, None, None)
    assert len(held.sessions) == 2
    assert "ask one of them for this list" in text
    with open_store(folder, ANNA, clock=minutes_clock()) as store:
        assert store.holdings.of(session.patient).left == ()


def test_nobody_of_that_pseudonym_is_a_sentence(folder):
    with open_sample(folder) as store, pytest.raises(StoreError, match="no patient P-NOBODY"):
        store.holdings.of("P-NOBODY")


def test_the_words_tell_all_of_it_without_the_name(folder, tmp_path):
    with open_sample(folder) as store:
        session = fill(store)
        send_out(store, session, tmp_path / "out")
        held = store.holdings.of(session.patient)
    sections = {one.title: one.lines for one in holdings_sections(held, plain_spelling())}
    assert list(sections) == [
        "The patient",
        "Sessions",
        "Kept for learning",
        "What left the store",
        "Backups and copies",
        "What can be done",
        "What the program cannot reach",
    ]
    text = "\n".join(line for lines in sections.values() for line in lines)
    assert not set(NAME.split()) & set(text.split())
    assert IDENTITY.record_number not in text
    assert "Hidden, not removed." in sections["The patient"]
    assert sum("recording:" in line for line in sections["Sessions"]) == 2
    assert any("2 files of codings" in line for line in sections["Sessions"])
    left = sections["What left the store"]
    assert any("DICOM files to a server, with identity" in one for one in left)
    assert "PACS (archive)" in text
