"""Stores of every published version open with this program: one backup of each lies in the tests.

A new revision of the tables, or version of sealed recordings or of `key.json`, adds the backup of a
store that the program before it made; none is ever made anew. They are called after the revision,
and after what else is of a version of its own: in ``0001-people`` that is `key.json`.
"""

from pathlib import Path

import pytest

from adibas.errors import PassphraseError
from adibas.sessions import open_store
from adibas.sessions.backup_format import BackupReader
from adibas.sessions.key_file import write_key_file
from adibas.sessions.migrating import KNOWN
from adibas.sessions.restoring import extract, restore_into
from adibas.sessions.roles import Role
from adibas.sessions.trial_restore import verify_backup
from tests.unit.recorded_frames import assert_same_frame, make_frames
from tests.unit.store_samples import (
    IDENTITY,
    PASSPHRASE,
    all_bytes,
    open_sample,
    raw_connection,
    surface,
)

CORPUS = sorted((Path(__file__).parents[1] / "data" / "stores").glob("*.adibas-backup"))
PEOPLE = next(path for path in CORPUS if path.stem == "0001-people")


def test_each_version_of_the_tables_has_a_store_in_the_corpus():
    assert {path.stem.partition("-")[0] for path in CORPUS} == set(KNOWN)


def unpacked(backup, folder):
    """The store as the program of then left it, before this one has opened it."""
    folder.mkdir()
    with BackupReader(backup) as reader:
        extract(reader, reader.key(PASSPHRASE), folder)
        write_key_file(folder, reader.header.key_file)
    return folder


def rows_of(folder, columns_of=None):
    """Every row of every table as SQLCipher alone reads it; of an older store its columns."""
    connection = raw_connection(folder)
    try:
        kept = columns_of or {
            name: [column[1] for column in connection.execute(f"PRAGMA table_info({name})")]
            for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
        }
        return kept, {
            name: set(connection.execute(f"SELECT {', '.join(columns)} FROM {name}"))
            for name, columns in kept.items()
        }
    finally:
        connection.close()


@pytest.mark.parametrize("backup", CORPUS, ids=lambda path: path.stem)
def test_no_row_and_no_file_of_an_old_store_is_lost_when_it_is_opened(backup, tmp_path):
    folder = unpacked(backup, tmp_path / "store")
    columns, before = rows_of(folder)
    files = {name: data for name, data in all_bytes(folder).items() if name.endswith(".sealed")}
    open_sample(folder).close()
    _columns, after = rows_of(folder, columns)
    for name in before.keys() - {"alembic_version", "audit_head"}:
        assert before[name] <= after[name], name
        assert before[name] or name == "leftovers", f"{name} is empty: nothing is shown of it"
    now = all_bytes(folder)
    assert files
    assert {name: now[name] for name in files} == files
    with open_sample(folder) as store:
        assert store.verify().is_sound


def test_the_people_of_an_old_store_have_their_passphrases_and_roles(tmp_path):
    folder = unpacked(PEOPLE, tmp_path / "store")
    for passphrase, name, role in (
        (PASSPHRASE, "Anna Roca", Role.ADMINISTRATOR),
        ("boris likes numbers 7", "Boris Vila", Role.OPERATOR),
    ):
        with open_store(folder, passphrase) as store:
            assert (store.person.name, store.role) == (name, role)
    with pytest.raises(PassphraseError):
        open_store(folder, "somebody else's words")


@pytest.mark.parametrize("backup", CORPUS, ids=lambda path: path.stem)
def test_an_old_store_is_restored_with_all_that_it_held(backup, tmp_path):
    restore_into(backup, tmp_path / "store", PASSPHRASE)
    with open_sample(tmp_path / "store") as store:
        (row,) = store.patients.search("ximena")
        patient = store.patients.get(row.pseudonym)
        assert (patient.identity, patient.notes) == (IDENTITY, "the left knee")
        assert [one.given_by for one in patient.consents] == ["Rosalia Quetzal"]
        (session,) = store.sessions.of_patient(row.pseudonym)
        (capture,) = store.captures.of_session(session.session_id)
        assert [one.u for one in capture.markers()] == [33.0, 61.0, 90.0]
        assert (store.captures.picture(capture.capture_id) == 77).all()
        kept = store.captures.surface(capture.capture_id)
        assert (kept.n_readings == surface().n_readings).all()
        with store.recordings.open(capture.recording_id) as reader:
            for index, frame in enumerate(make_frames(3)):
                assert_same_frame(reader.read(index), frame)
        codings, key = store.recordings.codings, store.recordings.key(capture.recording_id)
        (coding,) = codings.ids()
        assert codings.read(coding, key) == b"what was coded"
        assert store.verify().is_sound


@pytest.mark.parametrize("backup", CORPUS, ids=lambda path: path.stem)
def test_an_old_store_is_merged_and_checked(backup, tmp_path):
    _columns, rows = rows_of(unpacked(backup, tmp_path / "old"))
    with open_sample(tmp_path / "used") as store:
        summary = store.backups.restore(backup, PASSPHRASE)
        assert summary.n_patients == len(rows["patients"])
        assert summary.n_captures == len(rows["captures"])
        assert summary.n_recordings == len(rows["recordings"])
        assert store.verify().is_sound
    assert verify_backup(backup, PASSPHRASE, room=tmp_path)[1].is_sound
