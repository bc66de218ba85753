"""Opening a store: made once, migrated with a copy, refused with a sentence, one writer."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory

from adibas.data.sessions import SessionSetup
from adibas.errors import PassphraseError, StoreError
from adibas.recordings.seal import SealError
from adibas.sessions import default_store_folder, key_state, migrating, open_store
from adibas.sessions.database import Database
from adibas.sessions.keys import load_key
from adibas.sessions.schema import METADATA
from adibas.sessions.sqlite_file import SqliteFile
from tests.unit.recorded_frames import INFO
from tests.unit.store_samples import (
    IDENTITY,
    NAME,
    PASSPHRASE,
    add_capture,
    add_session,
    all_bytes,
    new_capture,
    open_sample,
    picture,
    raw_connection,
)

HOLDER = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from tests.unit.store_samples import open_sample
with open_sample(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""

NEXT_REVISION = '''
"""A column more."""
import sqlalchemy as sa
from alembic import op
revision = "0002"
down_revision = "0001"
def upgrade() -> None:
    op.add_column("patients", sa.Column("shoe_size", sa.Integer(), nullable=True))
    {more}
'''


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def pseudonym(folder):
    with open_sample(folder) as store:
        return store.patients.add(IDENTITY).pseudonym


@pytest.fixture
def next_version(tmp_path, monkeypatch):
    """Make the program one with a further revision; `more` is what that does besides."""

    def make(more="pass"):
        revisions = tmp_path / "migrations"
        shutil.copytree(migrating.REVISIONS, revisions)
        (revisions / "versions" / "r0002_next.py").write_text(NEXT_REVISION.format(more=more))
        monkeypatch.setattr(migrating, "REVISIONS", revisions)
        monkeypatch.setattr(migrating, "HEAD", "0002")
        monkeypatch.setattr(migrating, "KNOWN", ("0001", "0002"))

    return make


def test_the_revisions_lead_to_the_tables_of_the_program(folder, pseudonym):
    assert pseudonym
    database = Database(SqliteFile(folder, load_key(folder, PASSPHRASE)), is_read_only=True)
    with database.reading() as transaction:
        context = MigrationContext.configure(transaction)
        assert compare_metadata(context, METADATA) == []
    database.close()


def test_the_program_knows_its_last_revision():
    config = Config()
    config.set_main_option("script_location", str(migrating.REVISIONS))
    script = ScriptDirectory.from_config(config)
    assert script.get_current_head() == migrating.HEAD
    assert sorted(one.revision for one in script.walk_revisions()) == sorted(migrating.KNOWN)


def test_an_older_store_is_migrated_and_a_copy_is_kept(folder, pseudonym, next_version):
    next_version()
    with open_sample(folder) as store:
        assert store.patients.get(pseudonym).identity == IDENTITY
        assert store.verify().is_sound
    connection = raw_connection(folder)
    columns = [row[1] for row in connection.execute("PRAGMA table_info(patients)")]
    connection.close()
    assert "shoe_size" in columns
    (copy,) = migrating.copies(folder)
    old = folder.parent / "old"
    old.mkdir()
    shutil.copy(copy, old / "adibas.db")
    shutil.copy(folder / "key.json", old / "key.json")
    connection = raw_connection(old)
    assert connection.execute("SELECT version_num FROM alembic_version").fetchall() == [("0001",)]
    assert connection.execute("SELECT name FROM identities").fetchall() == [(NAME,)]
    connection.close()
    assert NAME.encode() not in copy.read_bytes()
    with open_sample(folder) as store:
        store.patients.purge(pseudonym)
    assert migrating.copies(folder) == []


def test_a_migration_that_fails_changes_nothing(folder, pseudonym, next_version, monkeypatch):
    next_version("raise RuntimeError('power cut')")
    with pytest.raises(RuntimeError, match="power cut"):
        open_sample(folder)
    monkeypatch.undo()
    with open_sample(folder) as store:
        assert store.patients.get(pseudonym).identity == IDENTITY


def test_a_database_of_a_later_version_is_refused_untouched(folder, pseudonym):
    assert pseudonym
    connection = raw_connection(folder)
    connection.execute("UPDATE alembic_version SET version_num = '0099'")
    connection.close()
    before = all_bytes(folder)
    with pytest.raises(StoreError, match="later version of ADiBAS") as told:
        open_sample(folder)
    assert "0099" in str(told.value)
    after = all_bytes(folder)
    assert after["adibas.db"] == before["adibas.db"]


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"x" * 5000,  # noqa: ARG005
        lambda data: b"SQLite format 3\0" + data[16:],
        lambda data: data[:100],
        lambda data: bytes([data[40] ^ 1]) + data[1:],
    ],
)
def test_a_damaged_database_is_one_sentence_and_stays_as_it_is(folder, pseudonym, damage):
    assert pseudonym
    path = folder / "adibas.db"
    path.write_bytes(damage(path.read_bytes()))
    before = path.read_bytes()
    with pytest.raises(StoreError, match="damaged, or is no database"):
        open_sample(folder)
    assert path.read_bytes() == before


@pytest.mark.parametrize("leave", [lambda path: path.unlink(), lambda path: path.write_bytes(b"")])
def test_a_database_that_vanished_is_missed_and_no_empty_one_is_made(folder, pseudonym, leave):
    assert pseudonym
    leave(folder / "adibas.db")
    before = all_bytes(folder)
    with pytest.raises(StoreError, match="is missing"):
        open_sample(folder)
    assert all_bytes(folder) == before


def test_another_database_of_the_same_key_is_refused(folder, pseudonym):
    assert pseudonym
    connection = raw_connection(folder)
    connection.execute("DROP TABLE alembic_version")
    connection.close()
    with pytest.raises(StoreError, match="no database of ADiBAS"):
        open_sample(folder)


def test_a_folder_that_cannot_be_made_is_one_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StoreError, match="cannot be used"):
        open_sample(tmp_path / "file" / "store")


def test_a_second_opener_in_another_process_reads_only(folder, pseudonym):
    project = Path(__file__).parents[2]
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(folder), str(project)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        cwd=project,
    ) as holder:
        assert holder.stdout.readline() == b"held\n"
        with open_sample(folder, operator="second") as store:
            assert store.is_read_only
            assert store.patients.get(pseudonym).identity == IDENTITY
            assert_refuses_changes(store, pseudonym)
            views = [(e.operator, e.action, e.subject) for e in store.audit.entries(2)]
            assert views[0] == ("second", "view", pseudonym)
        holder.stdin.close()
        assert holder.wait() == 0
    with open_sample(folder) as store:
        assert not store.is_read_only
        assert store.verify().is_sound


def assert_refuses_changes(store, pseudonym):
    actions = (
        lambda: store.patients.add(IDENTITY),
        lambda: store.patients.change(pseudonym, notes="x"),
        lambda: store.patients.delete(pseudonym),
        lambda: store.patients.purge(pseudonym),
        lambda: store.sessions.start(pseudonym, SessionSetup()),
        lambda: store.sessions.delete("ab"),
        lambda: store.recordings.create("ab", INFO),
        lambda: store.captures.delete("ab"),
    )
    for action in actions:
        with pytest.raises(StoreError, match="open in another window"):
            action()


def test_a_second_opener_in_the_same_process_reads_what_the_first_writes(folder):
    with open_sample(folder) as first, open_sample(folder) as second:
        assert (first.is_read_only, second.is_read_only) == (False, True)
        capture = add_capture(first)
        np_picture = second.captures.picture(capture.capture_id)
        assert np_picture.shape == picture().shape
        with pytest.raises(StoreError, match="another window"):
            second.captures.add(capture.session_id, new_capture(), picture())
        assert second.verify().is_sound
        assert first.verify().is_sound


def test_the_lock_ends_with_a_failed_opening(folder, pseudonym):
    assert pseudonym
    with pytest.raises(PassphraseError):
        open_store(folder, "a wrong guess")
    with open_sample(folder) as store:
        assert not store.is_read_only


def test_a_closed_store_says_so(folder):
    store = open_sample(folder)
    store.close()
    store.close()
    with pytest.raises(StoreError, match="is closed"):
        store.patients.search("")


def test_a_full_disk_is_told_and_what_was_saved_stays(folder):
    with open_sample(folder) as store:
        session = add_session(store)
        with store._database._kind.engine.connect() as connection:
            pages = connection.exec_driver_sql("PRAGMA page_count").scalar_one()
            connection.exec_driver_sql(f"PRAGMA max_page_count = {pages + 2}")
        with pytest.raises(StoreError, match="disk is full"):
            store.sessions.change(session.session_id, notes="x" * 100_000)
        assert store.sessions.get(session.session_id).notes == ""
        store.sessions.change(session.session_id, notes="short")
        assert store.verify().is_sound
    with open_sample(folder) as store:
        assert store.sessions.get(session.session_id).notes == "short"


def test_failures_of_the_database_name_nobody(folder):
    with open_sample(folder) as store:
        with store._database._kind.engine.connect() as connection:
            pages = connection.exec_driver_sql("PRAGMA page_count").scalar_one()
            connection.exec_driver_sql(f"PRAGMA max_page_count = {pages + 1}")
        with pytest.raises(StoreError) as told:
            store.patients.add(IDENTITY, notes=NAME * 10_000)
    error = told.value
    while error is not None:
        assert NAME not in repr(error)
        assert NAME not in str(error)
        error = error.__cause__


def test_what_is_written_is_on_the_disk_before_the_call_returns(folder):
    with open_sample(folder) as store, store._database._kind.engine.connect() as connection:
        settings = {
            name: connection.exec_driver_sql(f"PRAGMA {name}").scalar_one()
            for name in ("journal_mode", "synchronous", "foreign_keys", "secure_delete")
        }
    assert settings == {
        "journal_mode": "wal",
        "synchronous": 2,
        "foreign_keys": 1,
        "secure_delete": 1,
    }


def test_the_store_of_a_user_is_in_the_users_own_folder(monkeypatch):
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    assert Path.home() in default_store_folder().parents


def test_a_store_that_is_a_file_is_one_sentence_and_nothing_is_called_damaged(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    for place in (tmp_path / "file", tmp_path / "file" / "store"):
        with pytest.raises(StoreError, match="cannot be used: Not a directory"):
            key_state(place)


def test_a_journal_that_finds_no_room_is_a_full_disk(folder, pseudonym, monkeypatch):
    assert pseudonym
    (folder / "adibas.db-wal").mkdir()
    with pytest.raises(StoreError, match="cannot be used"):
        open_store(folder, PASSPHRASE)
    usage = shutil.disk_usage(folder)._replace(free=0)
    monkeypatch.setattr(shutil, "disk_usage", lambda _folder: usage)
    with pytest.raises(StoreError, match="disk is full"):
        open_store(folder, PASSPHRASE)


def test_a_draft_is_read_by_its_own_store_opened_again_and_by_no_other(folder, tmp_path):
    draft = NAME.encode()
    with open_sample(folder) as store:
        sealed = store.drafts.seal("form", draft)
    assert draft not in sealed
    with open_sample(folder) as store:
        assert store.drafts.open("form", sealed) == draft
        with pytest.raises(SealError):
            store.drafts.open("notes", sealed)
    with open_sample(tmp_path / "other") as other, pytest.raises(SealError):
        other.drafts.open("form", sealed)
