"""A backup is one file that gives back everything, or says in words why it does not."""

import errno
import io
import itertools
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import pytest

from adibas.cli import main
from adibas.errors import FileError, PassphraseError, StoreError
from adibas.sessions import open_store
from adibas.sessions.backup_format import LENGTH, MAGIC, BackupReader, BackupWriter, header_of
from adibas.sessions.backup_schedule import BackupPlan
from adibas.sessions.database import Database
from adibas.sessions.key_file import read_key_file
from adibas.sessions.keys import load_key
from adibas.sessions.restoring import restore_into
from adibas.sessions.sqlite_file import SqliteFile
from adibas.sessions.trial_restore import verify_backup
from tests.unit.recorded_frames import assert_same_frame, make_frames
from tests.unit.store_samples import (
    CHEAP,
    NAME,
    PASSPHRASE,
    MemoryKeyring,
    all_bytes,
    open_sample,
    picture,
    use_keyring,
)
from tests.unit.test_sessions_purge import SECRETS, filled

VICTIM = """
import sys, time
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from tests.unit.store_samples import PASSPHRASE, open_sample
from adibas.sessions.restoring import restore_into
what, store, file, new = sys.argv[2], *map(Path, sys.argv[3:])
def wait(done, total):
    if done > total // 3:
        print("half", flush=True)
        time.sleep(60)
if what == "backup":
    open_sample(store).backups.write(file, progress=wait)
elif what == "merge":
    open_sample(new).backups.restore(file, PASSPHRASE, wait)
else:
    restore_into(file, new, PASSPHRASE, wait)
"""


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def session(folder):
    with open_sample(folder) as store:
        session = filled(store)
        (facts,) = store.recordings.of_session(session.session_id)
        coding = facts.recording_id + "-0a0b"
        key = store.recordings.key(facts.recording_id)
        store.recordings.codings.write(coding, key, b"what was coded")
        return session


@pytest.fixture
def backup(folder, session, tmp_path):
    assert session
    path = tmp_path / "kept" / "a.adibas-backup"
    with open_sample(folder) as store:
        store.backups.write(path)
    return path


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_backup_becomes_the_same_store_again(folder, session, backup, tmp_path):
    restore_into(backup, tmp_path / "new", PASSPHRASE)
    sealed, restored = (
        {k: v for k, v in all_bytes(one).items() if k.endswith(".sealed")}
        for one in (folder, tmp_path / "new")
    )
    assert restored == sealed
    assert len(sealed) == 4
    with open_sample(tmp_path / "new") as store:
        assert store.patients.get(session.patient).identity.name == NAME
        (capture,) = store.captures.of_session(session.session_id)
        assert (store.captures.picture(capture.capture_id) == picture()).all()
        (facts,) = store.recordings.of_session(session.session_id)
        with store.recordings.open(facts.recording_id) as reader:
            for index, frame in enumerate(make_frames(3)):
                assert_same_frame(reader.read(index), frame)
        assert store.verify().is_sound
        assert [line.action for line in store.audit.entries(100)].count("backup") == 1
    assert names_in(backup.parent) == [backup.name]
    assert names_in(tmp_path) == ["kept", "new", "store"]


def test_a_backup_tells_nothing_of_anybody(backup, session):
    data = backup.read_bytes()
    for secret in (*SECRETS, session.patient, session.session_id):
        assert secret.encode() not in data


def test_a_backup_is_checked_by_a_restore_that_leaves_nothing(backup, tmp_path):
    room = tmp_path / "room"
    room.mkdir()
    header, report = verify_backup(backup, PASSPHRASE, room=room)
    assert report.is_sound
    assert (report.n_files, report.n_recordings) == (2, 1)
    assert header.created_utc.startswith("2026-11-21")
    assert names_in(room) == []


def test_a_wrong_or_missing_passphrase_is_told(backup, tmp_path):
    with pytest.raises(PassphraseError, match="not the passphrase of"):
        restore_into(backup, tmp_path / "new", "a wrong guess")
    with pytest.raises(PassphraseError, match="is locked"):
        restore_into(backup, tmp_path / "new", None)
    assert names_in(tmp_path) == ["kept", "store"]


def test_a_cut_or_changed_backup_is_refused_wherever_it_is(backup, tmp_path):
    whole = backup.read_bytes()
    (header,) = LENGTH.unpack(whole[len(MAGIC) :][: LENGTH.size])
    begin = len(MAGIC) + LENGTH.size + header
    cuts = [whole[:n] for n in (len(MAGIC) + 2, begin - 5, begin, begin + 2, len(whole) - 1)]
    flipped = [
        whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :]
        for at in (len(MAGIC) + 40, begin + 1, begin + 30, len(whole) // 2, len(whole) - 3)
    ]
    pieces = list(split(whole[begin:]))
    swapped = whole[:begin] + b"".join([pieces[1], pieces[0], *pieces[2:]])
    without = whole[:begin] + b"".join(pieces[:3] + pieces[4:])
    for data in (*cuts, *flipped, swapped, without, whole + b"x", b"", b"\x8aADIBAK"):
        backup.write_bytes(data)
        with pytest.raises(StoreError) as told:
            restore_into(backup, tmp_path / "new", PASSPHRASE)
        assert str(told.value)
        assert names_in(tmp_path) == ["kept", "store"]
    backup.write_bytes(MAGIC[:-1] + b"\x02" + whole[8:])
    with pytest.raises(StoreError, match="later version"):
        restore_into(backup, tmp_path / "new", PASSPHRASE)


def split(data):
    stream = io.BytesIO(data)
    while head := stream.read(LENGTH.size):
        yield head + stream.read(*LENGTH.unpack(head))


def test_a_header_that_was_changed_opens_nothing(backup, tmp_path):
    whole = backup.read_bytes()
    (length,) = LENGTH.unpack(whole[8:12])
    document = json.loads(whole[12 : 12 + length])
    for change in (
        {"created_utc": "2030-01-01"},
        {"salt": "00" * 16},
        {"n_bytes": "many"},
        {"store_id": 3},
        {"wrapped": {}},
        {"format": "x"},
        {"version": 2},
    ):
        line = json.dumps(document | change).encode()
        backup.write_bytes(MAGIC + LENGTH.pack(len(line)) + line + whole[12 + length :])
        with pytest.raises(StoreError):
            restore_into(backup, tmp_path / "new", PASSPHRASE)
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("name", ["../outside", "/outside", "later/aabbccdd", "pictures/../key"])
def test_no_file_of_another_name_is_written(name, folder, session, tmp_path):
    assert session
    path = tmp_path / "b.adibas-backup"
    with path.open("wb") as file:
        header = header_of(read_key_file(folder), "2026-11-21T09:00:00+00:00", 1)
        writer = BackupWriter(file, header, load_key(folder, PASSPHRASE))
        writer.begin_file(name)
        writer.write(b"x")
        writer.finish()
    with pytest.raises(StoreError, match="later version"):
        restore_into(path, tmp_path / "new", PASSPHRASE)
    with open_sample(folder) as store, pytest.raises(StoreError, match="later version"):
        store.backups.restore(path)
    assert names_in(tmp_path) == ["b.adibas-backup", "store"]


def test_nothing_is_restored_over_something(backup, folder, tmp_path):
    before = all_bytes(folder)
    with pytest.raises(StoreError, match="is not empty"):
        restore_into(backup, folder, PASSPHRASE)
    assert all_bytes(folder) == before
    (tmp_path / "empty").mkdir()
    restore_into(backup, tmp_path / "empty", PASSPHRASE)
    open_sample(tmp_path / "empty").close()


def test_a_restore_through_a_link_goes_where_it_leads(backup, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "empty")
    restore_into(backup, tmp_path / "link", PASSPHRASE)
    open_sample(tmp_path / "empty").close()
    assert names_in(tmp_path) == ["empty", "kept", "link", "store"]


def test_only_one_restores_into_a_folder(backup, tmp_path):
    new = tmp_path / "new"

    def try_too(_done, _total):
        with pytest.raises(StoreError, match="Another program"):
            restore_into(backup, new, PASSPHRASE)

    restore_into(backup, new, PASSPHRASE, try_too)
    open_sample(new).close()
    assert names_in(tmp_path) == ["kept", "new", "store"]


@pytest.mark.parametrize("work", ["backup", "restore"])
def test_who_stops_it_finds_nothing_half_done(folder, backup, tmp_path, work):
    counted = itertools.count()

    def stop(_done, _total):
        if next(counted) == 2:
            raise KeyboardInterrupt

    old = backup.read_bytes()
    with open_sample(folder) as store, pytest.raises(KeyboardInterrupt):
        if work == "backup":
            store.backups.write(backup, progress=stop)
        else:
            restore_into(backup, tmp_path / "new", PASSPHRASE, stop)
    assert backup.read_bytes() == old
    assert names_in(backup.parent) == [backup.name]
    assert names_in(tmp_path) == ["kept", "store"]


def test_no_backup_lies_in_the_store_or_takes_the_place_of_its_files(folder, session, tmp_path):
    (tmp_path / "link").symlink_to(folder)
    before = names_in(folder)
    with open_sample(folder) as store:
        for place in (folder / "adibas.db", folder / "pictures" / "b.x", tmp_path / "link" / "b.x"):
            with pytest.raises(FileError, match="in the folder of the store"):
                store.backups.write(place)
        with pytest.raises(FileError, match="in the folder of the store"):
            store.backups.write_planned(BackupPlan(folder, 1, 1))
    assert names_in(folder) == before
    with open_sample(folder) as store:
        assert store.sessions.get(session.session_id).session_id == session.session_id


def test_a_full_disk_is_told_before_anything_is_written(folder, backup, tmp_path, monkeypatch):
    usage = type("Usage", (), {"free": 1000})
    monkeypatch.setattr("shutil.disk_usage", lambda _path: usage)
    old = backup.read_bytes()
    with open_sample(folder) as store, pytest.raises(FileError, match="disk is full"):
        store.backups.write(backup)
    with pytest.raises(StoreError, match="disk is full"):
        restore_into(backup, tmp_path / "new", PASSPHRASE)
    assert backup.read_bytes() == old
    assert names_in(tmp_path) == ["kept", "store"]
    assert names_in(backup.parent) == [backup.name]


@pytest.mark.parametrize("work", ["backup", "restore"])
def test_a_kill_harms_nothing_and_the_next_try_cleans_up(folder, backup, tmp_path, work):
    project = str(Path(__file__).parents[2])
    old, new = backup.read_bytes(), tmp_path / "new"
    words = [VICTIM, project, work, str(folder), str(backup), str(new)]
    with subprocess.Popen(
        [sys.executable, "-c", *words], stdout=subprocess.PIPE, cwd=project
    ) as victim:
        assert victim.stdout.readline() == b"half\n"
        victim.kill()
    assert backup.read_bytes() == old
    assert not new.exists()
    restore_into(backup, new, PASSPHRASE)
    for litter in backup.parent.glob(".*"):
        os.utime(litter, (time.time() - 2e5,) * 2)
    with open_sample(folder) as store:
        store.backups.write(backup)
        assert store.verify().is_sound
    assert names_in(backup.parent) == [backup.name]
    assert names_in(tmp_path) == ["kept", "new", "store"]


def test_a_kill_while_a_used_store_is_restored_harms_nothing(folder, backup, tmp_path):
    project, used = str(Path(__file__).parents[2]), tmp_path / "used"
    with open_sample(used) as store:
        filled(store)
    words = [VICTIM, project, "merge", str(folder), str(backup), str(used)]
    with subprocess.Popen(
        [sys.executable, "-c", *words], stdout=subprocess.PIPE, cwd=project
    ) as victim:
        assert victim.stdout.readline() == b"half\n"
        victim.kill()
    assert (used / "restoring").exists()
    with open_sample(used) as store:
        assert not (used / "restoring").exists()
        assert len(store.patients.search("")) == 1
        assert store.verify().is_sound
        assert store.backups.restore(backup, PASSPHRASE).n_captures == 1


def test_a_damaged_file_of_the_store_is_told_and_the_rest_is_kept(folder, backup, tmp_path):
    changed, missing, *_ = sorted((folder / "pictures").rglob("*.sealed"))
    changed.write_bytes(b"x" + changed.read_bytes())
    missing.unlink()
    with open_sample(folder) as store:
        summary = store.backups.write(backup)
    assert set(summary.damaged) == {f"pictures/{changed.stem}", f"pictures/{missing.stem}"}
    _, report = verify_backup(backup, PASSPHRASE, room=tmp_path)
    assert {(f.kind, f.subject) for f in report.findings} == {
        ("changed", changed.stem),
        ("missing", missing.stem),
    }


class FailingFile(io.BytesIO):
    """A file on a disk that fails after the first block."""

    def read(self, n_bytes=-1):
        if self.tell():
            raise OSError(errno.EIO, "Input/output error")
        return super().read(min(n_bytes, 10))


@pytest.fixture
def fail_reading(monkeypatch):
    """Let files of some name fail in the middle."""
    really_open = Path.open

    def fail(ending):
        def opened(path, mode="r", *words, **more):
            file = really_open(path, mode, *words, **more)
            if mode != "rb" or not str(path).endswith(ending):
                return file
            with file:
                return FailingFile(file.read())

        monkeypatch.setattr(Path, "open", opened)

    return fail


def test_a_file_that_fails_in_the_middle_is_told_also_without_a_checksum(
    folder, backup, fail_reading
):
    (coding,) = (folder / "codings").rglob("*.sealed")
    fail_reading(coding.name)
    with open_sample(folder) as store:
        assert store.backups.write(backup).damaged == (f"codings/{coding.stem}",)


def test_there_is_no_backup_without_the_database(folder, backup, fail_reading):
    old = backup.read_bytes()
    fail_reading(".db")
    with open_sample(folder) as store, pytest.raises(FileError, match="cannot be read"):
        store.backups.write(backup)
    assert backup.read_bytes() == old
    assert names_in(backup.parent) == [backup.name]


def test_a_disk_without_room_for_the_database_is_told_in_a_sentence(folder, session, tmp_path):
    assert session
    key = load_key(folder, PASSPHRASE)
    database = Database(SqliteFile(folder, key), is_read_only=True)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, hard))
    try:
        with pytest.raises(StoreError):
            database.copy_to(tmp_path / "copy.db", key)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        database.close()


def test_litter_that_cannot_be_removed_stops_no_backup(folder, backup):
    litter = backup.parent / f".{'a' * 32}.db"
    litter.mkdir()
    os.utime(litter, (time.time() - 2e5,) * 2)
    with open_sample(folder) as store:
        store.backups.write(backup)
    assert litter.exists()


def test_a_store_of_the_keyring_needs_a_passphrase_for_its_backup(folder, tmp_path, monkeypatch):
    use_keyring(monkeypatch, MemoryKeyring())
    path = tmp_path / "b.adibas-backup"
    with open_store(folder) as store:
        patient = filled(store).patient
        with pytest.raises(PassphraseError, match="keyring, which a backup does not have"):
            store.backups.write(path)
        with pytest.raises(PassphraseError, match="characters at least"):
            store.backups.write(path, "short")
        store.backups.write(path, PASSPHRASE, params=CHEAP)
    restore_into(path, tmp_path / "new", PASSPHRASE)
    with open_sample(tmp_path / "new") as store:
        assert store.patients.get(patient).identity.name == NAME


def test_a_backup_is_made_while_a_recording_is(folder, session, tmp_path):
    from tests.unit.recorded_frames import INFO

    path = tmp_path / "b.adibas-backup"
    with (
        open_sample(folder) as store,
        store.recordings.create(session.session_id, INFO) as writer,
    ):
        writer.write(make_frames(1)[0])
        store.backups.write(path)
    restore_into(path, tmp_path / "new", PASSPHRASE)
    with open_sample(tmp_path / "new") as store:
        assert len(store.recordings.of_session(session.session_id)) == 1
        assert store.verify().is_sound


def test_one_key_seals_one_backup_alone(folder, backup):
    first = backup.read_bytes()
    with BackupReader(backup) as reader:
        key = reader.key(PASSPHRASE)
    with open_sample(folder) as store:
        store.backups.write(backup)
    with BackupReader(backup) as reader:
        assert reader.key(PASSPHRASE) == key
        second = reader.header
    backup.write_bytes(first)
    with BackupReader(backup) as reader:
        assert reader.header.salt != second.salt


def test_the_commands_back_up_check_and_restore(folder, session, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    out, new = tmp_path / "b.adibas-backup", tmp_path / "new"
    make = ["sessions", "backup", "--store", str(folder), "--out", str(out)]
    assert main([*make, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["damaged"] == []
    assert main(make) == 1
    assert "--overwrite" in capsys.readouterr().err
    assert main([*make, "--overwrite"]) == 0
    assert main(["sessions", "verify-backup", str(out)]) == 0
    assert "all is well" in capsys.readouterr().out
    assert main(["sessions", "restore", str(out), "--into", str(new)]) == 0
    assert "opens with the backup's passphrase" in capsys.readouterr().out
    assert main(["sessions", "list", "--store", str(new)]) == 0
    assert session.patient in capsys.readouterr().out
    out.write_bytes(out.read_bytes()[:-9])
    assert main(["sessions", "verify-backup", str(out)]) == 1
    assert "cut off, changed or damaged" in capsys.readouterr().err
    assert main(["sessions", "verify-backup", str(tmp_path / "none")]) == 1
    assert "cannot be read" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("action", "option"),
    [
        (["verify-backup"], "--passphrase-file"),
        (["restore", "--into", "new"], "--backup-passphrase-file"),
        (["restore", "--store", "of-the-keyring"], "--backup-passphrase-file"),
    ],
    ids=["check", "new", "used"],
)
def test_who_gives_no_passphrase_of_a_backup_is_told_how_to_give_it(
    backup, tmp_path, monkeypatch, capsys, action, option
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("ADIBAS_PASSPHRASE", raising=False)
    use_keyring(monkeypatch, MemoryKeyring())
    open_store(tmp_path / "of-the-keyring").close()
    command = ["sessions", action[0], str(backup), *action[1:]]
    assert main(command) == 1
    told = capsys.readouterr().err
    assert f" {option} FILE" in told
    assert "ADIBAS_PASSPHRASE" in told
    (tmp_path / "words").write_text(PASSPHRASE, "utf-8")
    assert main([*command, option, "words"]) == 0
