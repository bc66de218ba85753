"""What is coded of a recording of the store is sealed like it, and goes with it."""

import pytest

from adibas.behaviour.editing import Draft
from adibas.errors import StoreError
from adibas.pipeline.coding_drafts import read_draft, write_draft
from adibas.sessions.coding_drafts import InStore
from tests.unit.coding_samples import coding
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import add_session, all_bytes, open_sample

DRAFT = Draft(coding(("seated", 1, 4, "child"), observer="Quetzal"))


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def store(folder):
    with open_sample(folder) as opened:
        yield opened


@pytest.fixture
def recording_id(store):
    with store.recordings.create(add_session(store).session_id, INFO) as writer:
        for frame in make_frames(3):
            writer.write(frame)
    return writer.recording_id


def test_a_draft_comes_back_and_nobody_reads_it_on_the_disk(store, folder, recording_id):
    place = InStore(store.recordings, recording_id)
    assert read_draft(place) is None
    write_draft(place, DRAFT, 0)
    assert read_draft(place) == DRAFT
    assert read_draft(InStore(store.recordings, recording_id, "MP")) is None
    assert b"seated" not in all_bytes(folder)


def test_a_purge_leaves_no_coding(store, folder, recording_id):
    write_draft(InStore(store.recordings, recording_id), DRAFT, 0)
    assert list(folder.glob("codings/*/*.sealed"))
    store.sessions.purge(store.recordings.facts(recording_id).session_id)
    assert not list(folder.glob("codings/*/*.sealed"))


def test_a_second_window_reads_and_does_not_write(store, folder, recording_id):
    write_draft(InStore(store.recordings, recording_id), DRAFT, 0)
    with open_sample(folder) as second:
        place = InStore(second.recordings, recording_id)
        assert read_draft(place) == DRAFT
        with pytest.raises(StoreError, match="Another window"):
            write_draft(place, DRAFT, 0)


def test_a_recording_that_is_gone_takes_no_coding(store):
    with pytest.raises(StoreError, match="no recording"):
        write_draft(InStore(store.recordings, "ab" * 16), DRAFT, 0)
