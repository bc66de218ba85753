"""A backup is tried out in the folder of the store, and nothing of it stays, however it ends."""

import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from adibas.cli import main
from adibas.errors import PassphraseError, StoreError
from adibas.sessions import default_store_folder
from adibas.sessions.lock import StoreLock
from adibas.sessions.trial_restore import TRIAL, remove_trial, verify_backup
from tests.unit.store_samples import NAME, PASSPHRASE, add_session, all_bytes, open_sample
from tests.unit.test_sessions_purge import filled

ROOM = f".restoring-{TRIAL}"
VICTIM = """
import sys, time
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from tests.unit.store_samples import open_sample
def wait(done, total):
    print("half", flush=True)
    time.sleep(60)
open_sample(Path(sys.argv[2])).backups.verify(Path(sys.argv[3]), None, wait)
"""


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def backup(folder, tmp_path):
    path = tmp_path / "kept" / "a.adibas-backup"
    with open_sample(folder) as store:
        filled(store)
        store.backups.write(path)
    return path


@pytest.fixture
def system(tmp_path, monkeypatch):
    """The system's folder for temporary files, empty."""
    folder = tmp_path / "system"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def names_in(folder):
    return {path.name for path in folder.iterdir()}


def test_a_trial_lies_in_the_folder_of_the_store_and_never_in_the_systems(folder, backup, system):
    before, seen = names_in(folder) | {"lock"}, []

    def look(_done, _total):
        seen.append((names_in(system), ROOM in names_in(folder), all_bytes(folder / ROOM)))

    with open_sample(folder) as store:
        _header, report = store.backups.verify(backup, progress=look)
        assert report.is_sound
        assert ROOM not in names_in(folder)
    assert names_in(folder) <= before
    assert all(of_system == set() and is_in_store for of_system, is_in_store, _files in seen)
    assert any(
        name.endswith("adibas.db") for _system, _is_in_store, files in seen for name in files
    )
    assert not any(NAME.encode() in data for *_where, files in seen for data in files.values())
    assert names_in(system) == set()


class StoppedError(Exception):
    """Somebody pressed Cancel."""


@pytest.mark.parametrize("step", [1, 4])
def test_a_trial_that_is_stopped_leaves_nothing(folder, backup, step):
    steps = []

    def stop(_done, _total):
        steps.append(ROOM in names_in(folder))
        if len(steps) == step:
            raise StoppedError

    with open_sample(folder) as store, pytest.raises(StoppedError):
        store.backups.verify(backup, progress=stop)
    assert steps == [True] * step
    assert ROOM not in names_in(folder)


def test_a_trial_of_a_damaged_backup_leaves_nothing(folder, backup):
    whole = backup.read_bytes()
    backup.write_bytes(whole[: len(whole) - 40] + bytes(40))
    with open_sample(folder) as store, pytest.raises(StoreError, match="damaged"):
        store.backups.verify(backup)
    assert ROOM not in names_in(folder)


def test_a_trial_that_has_no_room_leaves_nothing(folder, backup, monkeypatch):
    usage = type("Usage", (), {"free": 1000})
    with open_sample(folder) as store:
        monkeypatch.setattr("shutil.disk_usage", lambda _path: usage)
        with pytest.raises(StoreError, match="disk is full"):
            store.backups.verify(backup)
    assert ROOM not in names_in(folder)


def test_what_a_killed_trial_leaves_goes_when_the_store_is_opened(folder, backup):
    project = str(Path(__file__).parents[2])
    words = [VICTIM, project, str(folder), str(backup)]
    with subprocess.Popen(
        [sys.executable, "-c", *words], stdout=subprocess.PIPE, cwd=project
    ) as victim:
        assert victim.stdout.readline() == b"half\n"
        victim.kill()
    assert (folder / ROOM / "store").is_dir()
    with open_sample(folder) as store:
        assert ROOM not in names_in(folder)
        assert store.verify().is_sound
        assert store.backups.verify(backup)[1].is_sound


def test_a_trial_that_another_window_makes_is_not_disturbed(folder, backup):
    (folder / ROOM / "store").mkdir(parents=True)
    other = StoreLock(folder / ROOM)
    with open_sample(folder) as store:
        add_session(store)
        with pytest.raises(StoreError, match="Another program is just restoring"):
            store.backups.verify(backup)
    assert (folder / ROOM / "store").is_dir()
    other.release()
    remove_trial(folder)
    assert ROOM not in names_in(folder)


def test_the_command_tries_a_backup_out_beside_this_users_store(
    backup, system, tmp_path, monkeypatch, capsys
):
    monkeypatch.setenv("ADIBAS_PASSPHRASE", PASSPHRASE)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    seen = []
    monkeypatch.setattr(
        "shutil.disk_usage",
        lambda path: seen.append(path) or type("Usage", (), {"free": 10**9}),
    )
    assert main(["sessions", "verify-backup", str(backup)]) == 0
    assert "all is well" in capsys.readouterr().out
    assert seen == [default_store_folder().parent / ROOM / "store"]
    assert names_in(default_store_folder().parent) == set()
    assert names_in(system) == set()


def test_a_room_that_is_not_there_and_a_wrong_passphrase_are_told(backup, tmp_path):
    with pytest.raises(StoreError, match=r"no folder .*missing"):
        verify_backup(backup, PASSPHRASE, room=tmp_path / "missing")
    with pytest.raises(PassphraseError):
        verify_backup(backup, "a wrong guess", room=tmp_path)
    assert names_in(tmp_path) == {"kept", "store"}
