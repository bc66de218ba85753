"""A purge leaves nothing of a patient but one line; nothing ever lies on the disk in plain."""

import pytest
from cryptography.hazmat.primitives.ciphers import Cipher, algorithms, modes

from adibas.data.corrections import MarkerCorrection
from adibas.data.patients import Consent
from adibas.errors import StoreError
from adibas.sessions.keys import load_key
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import (
    IDENTITY,
    NAME,
    PASSPHRASE,
    START,
    add_capture,
    add_session,
    all_bytes,
    marker,
    open_sample,
)

PAGE, RESERVED = 4096, 80
SIGNER = "Rosalia Quetzal"
SECRETS = [NAME, SIGNER, "HC-004711", "the left knee", "2014-03-27"]
PNG_HEAD, JPEG_HEAD = b"\x89PNG\r\n", b"\xff\xd8\xff\xe0"


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


def filled(store):
    """A session with everything that a patient can have."""
    session = add_session(store)
    store.patients.change(session.patient, notes="the left knee")
    consent = Consent(("treatment",), SIGNER, is_guardian=True, given_utc=START)
    store.patients.give_consent(session.patient, consent)
    with store.recordings.create(session.session_id, INFO) as writer:
        for frame in make_frames(3):
            writer.write(frame)
    capture = add_capture(store, session, recording_id=writer.recording_id)
    correction = MarkerCorrection(marker(), marker("m01", 33.0))
    store.captures.correct(capture.capture_id, capture.history.after(correction))
    return session


def sealed_files(folder):
    return sorted(path.name for path in folder.rglob("*.sealed"))


def dump(folder):
    """The plain content of every page on the disk, freed ones and the journal's included.

    Source: SQLCipher's design, "Security design": AES-256-CBC, the initial vector in the 80 bytes
    at the end of each page, a salt in place of the first 16 bytes of the file.
    """
    cipher = algorithms.AES(load_key(folder, PASSPHRASE))
    data = (folder / "adibas.db").read_bytes()
    pages = [data[i : i + PAGE] for i in range(0, len(data), PAGE)]
    pages[0] = pages[0][16:]
    journal = folder / "adibas.db-wal"
    frames = journal.read_bytes()[32:] if journal.exists() else b""
    pages += [frames[i + 24 : i + 24 + PAGE] for i in range(0, len(frames), 24 + PAGE)]
    plain = b""
    for page in pages:
        content, vector = page[:-RESERVED], page[-RESERVED : -RESERVED + 16]
        decryptor = Cipher(cipher, modes.CBC(vector)).decryptor()
        plain += decryptor.update(content) + decryptor.finalize()
    return plain.decode("utf-8", "ignore")


def test_nothing_lies_on_the_disk_in_plain(folder):
    with open_sample(folder) as store:
        filled(store)
        while_open = all_bytes(folder)
    for everything in (while_open, all_bytes(folder)):
        disk = b"".join(everything.values()) + "".join(everything).encode()
        for secret in SECRETS:
            for encoding in ("utf-8", "utf-16-le", "latin-1"):
                assert secret.encode(encoding) not in disk, secret
        assert PNG_HEAD not in disk
        assert JPEG_HEAD not in disk
    assert not all_bytes(folder)["adibas.db"].startswith(b"SQLite format")


def test_a_purged_patient_is_gone_but_for_one_line(folder):
    with open_sample(folder) as store:
        session = filled(store)
        other = filled(store)
        n_before = len(sealed_files(folder))
        copy = folder / "adibas.db.before-9999-from-0001"
        copy.write_bytes(b"an old copy")
        n_lines = len(store.audit.entries())
        store.patients.purge(session.patient)
        lines = store.audit.entries()
        assert [(line.action, line.subject) for line in lines[: len(lines) - n_lines]] == [
            ("purge", session.patient)
        ]
        assert store.verify().is_sound
        assert store.captures.of_session(other.session_id)
        with pytest.raises(StoreError, match="purged"):
            store.patients.get(session.patient)
        assert not copy.exists()
    assert len(sealed_files(folder)) == n_before // 2 == 3
    assert NAME in dump(folder)
    with open_sample(folder) as store:
        store.patients.purge(other.patient)
        while_open = dump(folder)
    assert sealed_files(folder) == []
    for plain in (while_open, dump(folder)):
        assert session.session_id in plain  # of the log: the pages are read rightly
        for secret in (*SECRETS, "ximena"):
            assert secret not in plain


def test_a_purged_session_leaves_its_patient(folder):
    with open_sample(folder) as store:
        session = filled(store)
        store.sessions.purge(session.session_id)
        assert store.patients.get(session.patient).identity == IDENTITY
        assert store.sessions.of_patient(session.patient, with_deleted=True) == ()
        assert store.verify().is_sound
    assert sealed_files(folder) == []


def test_a_patient_whose_recording_runs_is_not_purged(folder):
    with open_sample(folder) as store:
        session = add_session(store)
        with store.recordings.create(session.session_id, INFO) as writer:
            writer.write(make_frames(1)[0])
            for purge, subject in (
                (store.patients.purge, session.patient),
                (store.sessions.purge, session.session_id),
            ):
                with pytest.raises(StoreError, match="Stop it first"):
                    purge(subject)
        store.patients.purge(session.patient)
    assert sealed_files(folder) == []


def test_a_purge_that_was_cut_off_ends_at_the_next_opening(folder, monkeypatch):
    with open_sample(folder) as store:
        session = filled(store)
        monkeypatch.setattr("adibas.sessions.purging.remove_leftovers", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            store.patients.purge(session.patient)
        monkeypatch.undo()
        assert len(sealed_files(folder)) == 3
        assert store.verify().is_sound
    with open_sample(folder):
        assert sealed_files(folder) == []


def test_a_purged_file_that_cannot_be_removed_keeps_nobody_from_the_store(folder, caplog):
    with open_sample(folder) as store:
        session = filled(store)
        stuck, *others = folder.rglob("*.sealed")
        content = stuck.read_bytes()
        stuck.unlink()
        stuck.mkdir()  # what no program can remove as a file
        with pytest.raises(StoreError, match="Is a directory"):
            store.patients.purge(session.patient)
        assert not any(path.exists() for path in others)
    with open_sample(folder) as store:
        assert "not removed" in caplog.text
        assert store.patients.search("") == ()
    stuck.rmdir()
    stuck.write_bytes(content)
    with open_sample(folder):
        assert not stuck.exists()
