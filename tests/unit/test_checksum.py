"""The fingerprint of a recording changes with everything that belongs to it."""

import hashlib
import os
import sys

import pytest

from adibas.errors import RecordingError
from adibas.recordings.checksum import recording_sha256


def test_a_file_has_the_usual_sum(tmp_path):
    content = bytes(range(256)) * 9000
    (tmp_path / "a.mcap").write_bytes(content)
    assert recording_sha256(tmp_path / "a.mcap") == hashlib.sha256(content).hexdigest()


def test_a_folder_changes_with_a_name_and_with_a_byte(tmp_path):
    sums = set()
    (tmp_path / "depth").mkdir()
    for name, content in (("a", b"1"), ("a", b"2"), ("b", b"2")):
        (tmp_path / "depth" / name).write_bytes(content)
        sums.add(recording_sha256(tmp_path))
    assert len(sums) == 3
    assert recording_sha256(tmp_path) in sums


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere every name is text")
def test_a_folder_may_hold_a_name_that_is_no_text(tmp_path):
    without = recording_sha256(tmp_path)
    (tmp_path / os.fsdecode(b"caf\xe9.txt")).write_bytes(b"1")
    assert recording_sha256(tmp_path) != without


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(RecordingError, match="nothing cannot be read"):
        recording_sha256(tmp_path / "nothing")
