"""`verify` finds what was changed, what is missing and what is too much, and says what to do."""

import pytest

from adibas.errors import StoreError
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import add_capture, add_session, open_sample, raw_connection


@pytest.fixture
def folder(tmp_path):
    """A store with a recording, a picture and a surface."""
    with open_sample(tmp_path / "store") as store:
        session = add_session(store)
        with store.recordings.create(session.session_id, INFO) as writer:
            writer.write(make_frames(1)[0])
        add_capture(store, session, recording_id=writer.recording_id)
    return tmp_path / "store"


def found(folder):
    with open_sample(folder) as store:
        return store.verify().findings


def files(folder, kind):
    return sorted((folder / kind).rglob("*.sealed"))


def test_a_sound_store_has_no_findings(folder):
    steps = []
    with open_sample(folder) as store:
        report = store.verify(lambda *step: steps.append(step))
    assert report.is_sound
    assert (report.n_files, report.n_recordings) == (2, 1)
    assert report.n_lines == 7
    assert steps == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize("kind", ["recordings", "pictures"])
@pytest.mark.parametrize("place", [0, 0.5, 0.999])
def test_a_flipped_bit_is_found(folder, kind, place):
    path = files(folder, kind)[0]
    data = bytearray(path.read_bytes())
    data[int(place * len(data))] ^= 0x10
    path.write_bytes(data)
    (finding,) = found(folder)
    assert (finding.kind, finding.subject) == ("changed", path.stem)
    assert "Restore" in finding.text


@pytest.mark.parametrize("kind", ["recordings", "pictures"])
def test_a_missing_file_is_found(folder, kind):
    path = files(folder, kind)[0]
    path.unlink()
    (finding,) = found(folder)
    assert (finding.kind, finding.subject) == ("missing", path.stem)
    assert "Restore" in finding.text


@pytest.mark.parametrize("kind", ["recordings", "pictures"])
def test_a_file_that_nobody_knows_is_found(folder, kind):
    known = files(folder, kind)[0]
    stranger = folder / kind / "ab" / f"{'ab' * 16}.sealed"
    stranger.parent.mkdir(exist_ok=True)
    stranger.write_bytes(known.read_bytes())
    (finding,) = found(folder)
    assert (finding.kind, finding.subject) == ("orphan", stranger.stem)
    assert "delete the file" in finding.text


def test_an_unfinished_recording_that_nobody_knows_is_found(folder):
    recording = files(folder, "recordings")[0]
    stranger = folder / "recordings" / "ab" / f"{'ab' * 16}.part.sealed"
    stranger.parent.mkdir(exist_ok=True)
    stranger.write_bytes(recording.read_bytes())
    (finding,) = found(folder)
    assert (finding.kind, finding.subject) == ("orphan", "ab" * 16)


def test_a_recording_that_cannot_be_recovered_is_told_and_the_store_opens(folder):
    with open_sample(folder) as store:
        session = store.sessions.recent()[0]
        writer = store.recordings.create(session.session_id, INFO)
        writer.write(make_frames(1)[0])
    (part,) = (path for path in files(folder, "recordings") if ".part." in path.name)
    part.write_bytes(b"damaged" * 100)
    (finding,) = found(folder)
    assert (finding.kind, finding.subject) == ("unfinished", writer.recording_id)
    with open_sample(folder) as store:
        store.sessions.purge(session.session_id)
    assert found(folder) == ()
    with pytest.raises(StoreError, match="is closed"):
        writer.abandon()


def test_rows_that_point_nowhere_are_found(folder):
    connection = raw_connection(folder)
    connection.execute("DELETE FROM sessions")
    connection.close()
    assert [finding.kind for finding in found(folder)] == ["database"]
