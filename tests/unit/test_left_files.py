"""What a crash left is told from what is being written by the disk alone."""

import os
import time

import pytest

from adibas.sessions import left_files
from adibas.sessions.left_files import files_at_rest

LONG_AGO = time.time() - 3600


@pytest.fixture
def path(tmp_path):
    """A file that nobody has written to for an hour."""
    path = tmp_path / "half.part"
    path.write_bytes(b"half")
    os.utime(path, (LONG_AGO, LONG_AGO))
    return path


def test_a_file_rests_when_nobody_wrote_to_it_for_minutes(path, tmp_path):
    new = tmp_path / "new.part"
    new.write_bytes(b"half")
    assert files_at_rest([path, new, tmp_path / "gone"]) == {path}
    assert sorted(tmp_path.iterdir()) == [path, new]


def test_a_file_that_grows_is_being_written_whatever_time_the_disk_tells(path, monkeypatch):
    def grow(_seconds):
        path.write_bytes(b"more than half")
        os.utime(path, (LONG_AGO, LONG_AGO))

    monkeypatch.setattr(left_files.time, "sleep", grow)
    assert files_at_rest([path]) == set()


def test_the_clock_of_this_computer_does_not_matter(path, monkeypatch):
    path.write_bytes(b"just now")
    monkeypatch.setattr(left_files.time, "time", lambda: time.time_ns() / 1e9 + 86_400)
    assert files_at_rest([path]) == set()


def test_a_disk_that_cannot_be_asked_leaves_everything_as_it_is(path, monkeypatch):
    def full(*_arguments, **_options):
        raise OSError("No space left on device")

    monkeypatch.setattr(left_files, "TemporaryDirectory", full)
    assert files_at_rest([path]) == set()
