"""Sealed files: only the key opens them, at their own place, and no change goes unseen."""

import errno
import os
import random

import pytest
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from hypothesis import given
from hypothesis import strategies as st

from adibas.errors import StoreError
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sealing import AesSeal

KEY = bytes(range(32))
OTHER_KEY = bytes(range(1, 33))
FIRST, SECOND = "ab" * 16, "0c" * 16


@pytest.fixture
def files(tmp_path):
    return SealedFiles(tmp_path / "pictures")


def test_a_file_opens_with_its_key_and_lies_under_its_id_alone(files):
    files.write(FIRST, KEY, b"a picture")
    files.write(SECOND, OTHER_KEY, b"")
    assert files.read(FIRST, KEY) == b"a picture"
    assert files.read(SECOND, OTHER_KEY) == b""
    assert files.ids() == {FIRST, SECOND}
    found = sorted(str(p.relative_to(files.folder)) for p in files.folder.rglob("*.*"))
    assert found == [f"0c/{SECOND}.sealed", f"ab/{FIRST}.sealed"]


def test_the_documented_layout_is_opened_by_hand(files):
    files.write(FIRST, KEY, b"a picture")
    data = (files.folder / "ab" / f"{FIRST}.sealed").read_bytes()
    assert data[:8] == b"\x8aADIBAS\x01"
    place = f"adibas-file-1/{FIRST}".encode()
    assert AESGCM(KEY).decrypt(data[8:20], data[20:], place) == b"a picture"
    assert b"picture" not in data


def test_two_writes_of_one_content_share_no_nonce(files):
    sealed = set()
    for _ in range(50):
        files.write(FIRST, KEY, b"same")
        sealed.add(files.path_of(FIRST).read_bytes())
    assert len({data[8:20] for data in sealed}) == 50


@given(st.binary(max_size=200))
def test_any_content_comes_back(payload):
    seal = AesSeal(KEY, "scope")
    assert seal.open("a", seal.seal("a", payload)) == payload


def test_every_changed_bit_is_refused(files):
    files.write(FIRST, KEY, b"a picture")
    path = files.path_of(FIRST)
    whole = path.read_bytes()
    for bit in range(8 * len(whole)):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        path.write_bytes(changed)
        with pytest.raises(StoreError, match="cannot be opened"):
            files.read(FIRST, KEY)


def test_a_cut_or_lengthened_file_is_refused(files):
    files.write(FIRST, KEY, b"a picture")
    path = files.path_of(FIRST)
    whole = path.read_bytes()
    for other in [*(whole[:n] for n in range(len(whole))), whole + b"\0"]:
        path.write_bytes(other)
        with pytest.raises(StoreError, match="cannot be opened"):
            files.read(FIRST, KEY)


def test_another_key_and_a_swapped_file_are_refused(files):
    files.write(FIRST, KEY, b"first")
    files.write(SECOND, KEY, b"second")
    with pytest.raises(StoreError, match="cannot be opened"):
        files.read(FIRST, OTHER_KEY)
    files.path_of(SECOND).replace(files.path_of(FIRST))
    with pytest.raises(StoreError, match="cannot be opened"):
        files.read(FIRST, KEY)
    with pytest.raises(StoreError, match="is missing from the store"):
        files.read(SECOND, KEY)


def test_a_hundred_damaged_files_are_refused(files):
    files.write(FIRST, KEY, os.urandom(300))
    path = files.path_of(FIRST)
    whole = path.read_bytes()
    for case in range(100):
        rng = random.Random(case)
        changed = bytearray(whole)
        at, length = rng.randrange(len(whole)), rng.randrange(1, 40)
        changed[at : at + rng.choice((0, length))] = rng.randbytes(length)
        if changed == whole:  # one byte in 256 is the same
            changed[at] ^= 1
        path.write_bytes(changed)
        with pytest.raises(StoreError, match="cannot be opened"):
            files.read(FIRST, KEY)


def test_a_file_of_impossible_size_takes_no_memory(files):
    files.write(FIRST, KEY, b"a")
    with files.path_of(FIRST).open("r+b") as file:
        file.truncate(1 << 40)  # a hole, no bytes on the disk
    with pytest.raises(StoreError, match="cannot be opened"):
        files.read(FIRST, KEY)


def test_the_checksum_is_that_of_the_file_on_the_disk(files):
    import hashlib

    files.write(FIRST, KEY, b"a picture")
    assert files.sha256(FIRST) == hashlib.sha256(files.path_of(FIRST).read_bytes()).hexdigest()
    assert files.size(FIRST) == files.path_of(FIRST).stat().st_size
    for fact in (files.sha256, files.size):
        with pytest.raises(StoreError, match="is missing from the store"):
            fact(SECOND)


def test_a_deleted_file_is_gone_and_may_be_deleted_again(files):
    files.write(FIRST, KEY, b"a picture")
    files.delete(FIRST)
    files.delete(FIRST)
    files.delete(SECOND)
    assert files.ids() == set()
    assert not list(files.folder.rglob("*.sealed"))


@pytest.mark.parametrize("bad", ["", "ab", "../../etc/passwd", "AB" * 16, "ab" * 16 + "/x", "a.b"])
def test_only_ids_name_files(files, bad):
    with pytest.raises(ValueError, match="no id"):
        files.path_of(bad)


@pytest.mark.parametrize("size", [0, 16, 31, 33])
def test_only_whole_keys_are_taken(files, size):
    with pytest.raises(ValueError, match="32 bytes"):
        files.write(FIRST, bytes(size), b"")


def test_a_full_disk_leaves_the_older_content(files, monkeypatch):
    def full(_descriptor):
        raise OSError(errno.ENOSPC, "No space left on device")

    files.write(FIRST, KEY, b"older")
    monkeypatch.setattr(os, "fsync", full)
    for file_id in (FIRST, SECOND):
        with pytest.raises(StoreError, match=r"disk is full. What was saved before is unharmed"):
            files.write(file_id, KEY, b"newer")
    monkeypatch.undo()
    assert files.read(FIRST, KEY) == b"older"
    assert files.ids() == {FIRST}
    assert files.remove_unfinished() == 0


def test_names_and_content_are_flushed_before_a_write_returns(files, monkeypatch):
    flushed = []
    genuine = os.fsync

    def note(descriptor):
        flushed.append(os.fstat(descriptor).st_ino)
        genuine(descriptor)

    monkeypatch.setattr(os, "fsync", note)
    files.write(FIRST, KEY, b"a picture")
    path = files.path_of(FIRST)
    assert flushed == [place.stat().st_ino for place in (path, path.parent, files.folder)]


def test_what_a_crash_left_half_written_is_no_file_and_can_be_removed(files):
    files.write(FIRST, KEY, b"a picture")
    leftover = files.folder / "ab" / f".{'1f' * 16}.sealed"
    leftover.write_bytes(b"half")
    (files.folder / "0c").mkdir()
    (files.folder / "0c" / f"{FIRST}.sealed").write_bytes(b"in the wrong folder")
    assert files.ids() == {FIRST}
    assert files.remove_unfinished() == 1
    assert not leftover.exists()
    assert files.read(FIRST, KEY) == b"a picture"
