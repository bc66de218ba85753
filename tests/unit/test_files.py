"""A file appears whole or not at all."""

import errno
import os

import pytest

from adibas.errors import FileError
from adibas.files import remove_file, remove_unfinished, written_whole


def test_a_written_file_appears_under_its_name_alone(tmp_path):
    path = tmp_path / "new" / "report.xlsx"
    with written_whole(path) as unfinished:
        unfinished.write_text("whole")
        assert not path.exists()
    assert path.read_text() == "whole"
    assert list(path.parent.iterdir()) == [path]


def test_content_and_name_are_on_the_disk_before_anybody_relies_on_them(tmp_path, monkeypatch):
    flushed = []
    monkeypatch.setattr(os, "fsync", lambda descriptor: flushed.append(os.fstat(descriptor).st_ino))
    with written_whole(tmp_path / "key.json") as unfinished:
        unfinished.write_text("whole")
    assert flushed == [(tmp_path / "key.json").stat().st_ino, tmp_path.stat().st_ino]


def test_what_a_crash_left_half_written_is_removed_and_nothing_else(tmp_path):
    kept = {tmp_path / name for name in (".bashrc", "a.json", f"{'0a' * 16}.json")}
    endings = ("", ".json", ".before-0002-from-0001")
    for path in (*kept, *(tmp_path / f".{'0a' * 16}{ending}" for ending in endings)):
        path.write_text("")
    assert remove_unfinished(tmp_path) == len(endings)
    assert set(tmp_path.iterdir()) == kept


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "report.xlsx"
    path.write_text("old")
    with pytest.raises(KeyboardInterrupt), written_whole(path) as unfinished:
        unfinished.write_text("half")
        raise KeyboardInterrupt
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_full_disk_is_told_in_words(tmp_path):
    with (
        pytest.raises(FileError, match=r"r\.csv cannot be written: the disk is full"),
        written_whole(tmp_path / "r.csv"),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_a_file_is_told_in_words(tmp_path):
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(FileError, match="Choose another folder"),
        written_whole(tmp_path / "file" / "r.csv"),
    ):
        raise AssertionError("nothing can be written there")


def test_a_new_file_may_be_read_by_whom_the_user_lets(tmp_path):
    ordinary = tmp_path / "ordinary"
    ordinary.write_text("")
    with written_whole(tmp_path / "ours") as unfinished:
        unfinished.write_text("")
    assert (tmp_path / "ours").stat().st_mode == ordinary.stat().st_mode


def test_what_cannot_be_removed_is_told_and_what_is_gone_is_no_mistake(tmp_path):
    (tmp_path / "old.json").write_text("")
    for _ in range(2):
        remove_file(tmp_path / "old.json")
    assert not (tmp_path / "old.json").exists()
    (tmp_path / "folder.json").mkdir()
    with pytest.raises(FileError, match=r"folder\.json cannot be removed: .*\. Close the program"):
        remove_file(tmp_path / "folder.json")
