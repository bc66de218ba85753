"""Captures, their pictures, corrections and recordings: what goes in comes out."""

import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from adibas.calibration.json_format import calibration_to_json
from adibas.data.corrections import (
    CorrectionHistory,
    FreeMeasure,
    MarkerCorrection,
    MeasureCorrection,
)
from adibas.data.markers import AutomaticName, Marker
from adibas.errors import StoreError
from adibas.recordings import open_recording
from adibas.sessions import images
from adibas.sessions.documents import correction_to_json, markers_from_json, markers_to_json
from tests.unit.recorded_frames import CALIBRATION, INFO, assert_same_frame, make_frames
from tests.unit.store_samples import (
    add_capture,
    add_session,
    marker,
    new_capture,
    open_sample,
    picture,
    raw_connection,
    surface,
)

HALF_A_RECORDING = """
import os
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[3])
from tests.unit.recorded_frames import INFO, make_frames
from tests.unit.store_samples import open_sample
store = open_sample(Path(sys.argv[1]))
writer = store.recordings.create(sys.argv[2], INFO)
for frame in make_frames(5):
    writer.write(frame)
os.kill(os.getpid(), 9)
"""


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "store"


@pytest.fixture
def store(folder):
    with open_sample(folder) as opened:
        yield opened


def moved(label, u):
    return MarkerCorrection(marker(label), marker(label, u))


def lines(history):
    return [correction_to_json(one) for one in history.corrections], history.n_done


def test_a_capture_comes_back_to_the_last_bit(folder):
    with open_sample(folder) as store:
        added = add_capture(store)
    with open_sample(folder) as store:
        capture = store.captures.get(added.capture_id)
        assert store.captures.of_session(added.session_id)[0].capture_id == added.capture_id
        np.testing.assert_array_equal(store.captures.picture(added.capture_id), picture())
        kept, given_surface = store.captures.surface(added.capture_id), surface()
    wanted = new_capture()
    assert markers_to_json(capture.detected) == markers_to_json(wanted.detected)
    np.testing.assert_array_equal(
        capture.detected[0].covariance_m2, wanted.detected[0].covariance_m2
    )
    assert capture.detected[2].position_m is None
    assert calibration_to_json(capture.calibration) == calibration_to_json(CALIBRATION)
    for name in ("view", "first_frame", "n_frames", "rejected", "provenance", "notices"):
        assert getattr(capture, name) == getattr(wanted, name), name
    assert capture.captured_utc == added.captured_utc
    np.testing.assert_array_equal(kept.mean_per_m, given_surface.mean_per_m)
    np.testing.assert_array_equal(kept.n_readings, given_surface.n_readings)
    assert kept.n_frames == given_surface.n_frames


def test_a_capture_keeps_who_named_a_marker_and_old_texts_stay_the_same():
    by_model = AutomaticName("a model", 0.93)
    plain, named = marker("m01"), replace(marker("neck"), named_by=by_model)
    text = markers_to_json((plain, named))
    assert text.count("named_by") == 1
    assert [one.named_by for one in markers_from_json(text)] == [None, by_model]


def test_a_capture_keeps_rough_depths_and_old_texts_stay_the_same():
    plain = marker("m01")
    rough = Marker("m02", 4.0, 5.0, 2.0, np.eye(2), rough_depth_m=1.875)
    text = markers_to_json((plain, rough))
    assert text.count("rough_depth_m") == 1
    assert [one.rough_depth_m for one in markers_from_json(text)] == [None, 1.875]


def test_a_capture_may_have_no_surface(store):
    session = add_session(store)
    capture = store.captures.add(session.session_id, new_capture(), picture(), None)
    assert store.captures.surface(capture.capture_id) is None


def test_a_thumbnail_is_small_and_alike(store):
    big = np.kron(np.array([[250, 10], [10, 250]], np.uint8), np.ones((512, 640), np.uint8))
    rgb = np.ascontiguousarray(np.stack([big, big // 2, 255 - big], axis=2))
    session = add_session(store)
    capture = store.captures.add(session.session_id, new_capture(), rgb, None)
    small = store.captures.thumbnail(capture.capture_id)
    assert small.shape == (128, 160, 3)
    np.testing.assert_allclose(small[20, 20], rgb[100, 100], atol=12)
    np.testing.assert_allclose(small[20, 140], rgb[100, 1200], atol=12)


def test_a_hidden_capture_comes_back_in_its_place(store):
    session = add_session(store)
    first = add_capture(store, session)
    second = add_capture(store, session, view="posterior")

    def ids():
        return store.sessions.get(session.session_id).capture_ids

    assert ids() == (first.capture_id, second.capture_id)
    store.captures.delete(first.capture_id)
    assert ids() == (second.capture_id,)
    assert [c.capture_id for c in store.captures.of_session(session.session_id)] == list(ids())
    assert store.captures.get(first.capture_id).is_deleted
    assert len(store.captures.of_session(session.session_id, with_deleted=True)) == 2
    store.captures.restore(first.capture_id)
    assert ids() == (first.capture_id, second.capture_id)


def test_what_is_not_there_is_told(store):
    actions = (
        lambda: store.captures.get("ab12"),
        lambda: store.captures.picture("ab12"),
        lambda: store.captures.correct("ab12", CorrectionHistory()),
        lambda: store.captures.add("ab12", new_capture(), picture()),
        lambda: store.recordings.open("ab12"),
        lambda: store.recordings.facts("ab12"),
        lambda: store.recordings.create("ab12", INFO),
        lambda: store.recordings.export("ab12", Path("x.mcap")),
    )
    for action in actions:
        with pytest.raises(StoreError, match="ab12"):
            action()


def test_a_recording_of_another_session_is_refused(store):
    session, other = add_session(store), add_session(store)
    with store.recordings.create(other.session_id, INFO) as writer:
        writer.write(make_frames(1)[0])
    with pytest.raises(ValueError, match="no recording"):
        add_capture(store, session, recording_id=writer.recording_id)
    assert add_capture(store, other, recording_id=writer.recording_id).recording_id


def test_a_picture_that_cannot_be_saved_leaves_nothing(folder, store, monkeypatch):
    session = add_session(store)

    def fail(*_arguments):
        raise StoreError("The disk is full.")

    monkeypatch.setattr("adibas.sessions.sealed_files.SealedFiles.write", fail)
    with pytest.raises(StoreError, match="full"):
        add_capture(store, session)
    monkeypatch.undo()
    assert store.captures.of_session(session.session_id) == ()
    assert store.verify().is_sound
    assert list((folder / "pictures").rglob("*.sealed")) == []


@pytest.mark.parametrize("payload", [b"", b"PK\x03\x04", b"\x89PNG"])
def test_damaged_pictures_and_surfaces_are_said_in_words(payload):
    for decode in (images.decode_picture, images.decode_surface):
        with pytest.raises(StoreError, match="damaged"):
            decode(payload)


def test_a_surface_that_is_cut_short_is_said_in_words():
    payload = images.encode_surface(surface())
    images.decode_surface(payload)
    with pytest.raises(StoreError, match="damaged"):
        images.decode_surface(payload[:-200])


edits = st.lists(
    st.one_of(
        st.tuples(st.just("move"), st.floats(0, 600)),
        st.just(("undo", 0)),
        st.just(("redo", 0)),
        st.just(("measure", 0)),
        st.just(("reopen", 0)),
        st.just(("save", 0)),
    ),
    max_size=25,
)


def edited(history, edit, value):
    if edit == "undo" and history.can_undo:
        return history.undone()
    if edit == "redo" and history.can_redo:
        return history.redone()
    if edit == "move":
        present = {m.label: m for m in history.markers(new_capture().detected)}
        return history.after(MarkerCorrection(present["m01"], marker("m01", value)))
    if edit == "measure" and not history.measures():
        return history.after(MeasureCorrection(None, FreeMeasure(("m01", "m02"))))
    return history


@settings(max_examples=15)
@given(edits=edits)
def test_every_sequence_of_edits_survives_closing_and_can_be_undone(edits):
    folder = Path(tempfile.mkdtemp())
    store = open_sample(folder / "store")
    try:
        capture_id = add_capture(store).capture_id
        history = CorrectionHistory()
        for edit, value in edits:
            history = edited(history, edit, value)
            if edit in ("save", "reopen"):
                saved = store.captures.correct(capture_id, history)
                assert lines(saved.history) == lines(history)
            if edit == "reopen":
                store.close()
                store = open_sample(folder / "store")
                assert lines(store.captures.get(capture_id).history) == lines(history)
        history = store.captures.correct(capture_id, history).history
        while history.can_undo:
            history = store.captures.correct(capture_id, history.undone()).history
        capture = store.captures.get(capture_id)
        assert markers_to_json(capture.markers()) == markers_to_json(capture.detected)
        while history.can_redo:
            history = store.captures.correct(capture_id, history.redone()).history
        last = [one.after for one in history.corrections if isinstance(one, MarkerCorrection)]
        first = store.captures.get(capture_id).markers()[0]
        assert first.u == (last[-1].u if last else marker().u)
        assert store.verify().is_sound
    finally:
        store.close()
        shutil.rmtree(folder)


def test_each_correction_undo_and_redo_is_a_line_of_the_log(store):
    capture = add_capture(store)
    first = capture.history.after(moved("m01", 31.0))
    both = first.after(moved("m02", 70.0))
    for history in (both, both.undone(), both.undone().redone(), both.undone().undone()):
        store.captures.correct(capture.capture_id, history)
    done = [
        entry.detail["correction"]
        for entry in reversed(store.audit.entries())
        if "correction" in entry.detail
    ]
    assert done == ["move", "move", "undo", "redo", "undo", "undo"]


def test_a_correction_in_place_of_undone_ones_keeps_them_readable(folder):
    with open_sample(folder) as store:
        capture = add_capture(store)
        first = capture.history.after(moved("m01", 31.0))
        store.captures.correct(capture.capture_id, first.after(moved("m02", 70.0)))
        instead = first.after(MarkerCorrection(marker("m02", 61.0), None))
        saved = store.captures.correct(capture.capture_id, instead)
        assert lines(saved.history) == lines(instead)
        done = [e.detail.get("correction") for e in reversed(store.audit.entries())]
        assert [one for one in done if one] == ["move", "move", "undo", "delete"]
    connection = raw_connection(folder)
    rows = connection.execute("SELECT position, content FROM corrections ORDER BY 1").fetchall()
    connection.close()
    assert [position for position, _ in rows] == [None, 0, 1]
    assert "70.0" in rows[0][1]


def test_the_same_history_saved_twice_is_no_change(store):
    capture = add_capture(store)
    history = capture.history.after(moved("m01", 31.0))
    store.captures.correct(capture.capture_id, history)
    n_lines = len(store.audit.entries())
    store.captures.correct(capture.capture_id, history)
    assert len(store.audit.entries()) == n_lines


def test_a_history_that_does_not_fit_is_refused(store):
    capture = add_capture(store)
    with pytest.raises(ValueError, match="no marker"):
        store.captures.correct(capture.capture_id, CorrectionHistory().after(moved("nobody", 31.0)))
    assert store.captures.get(capture.capture_id).history.corrections == ()


def test_a_recording_is_listed_when_it_is_closed_and_reads_back(folder, tmp_path):
    frames = make_frames(5)
    with open_sample(folder) as store:
        session = add_session(store)
        with store.recordings.create(session.session_id, INFO) as writer:
            for frame in frames:
                writer.write(frame)
            assert store.recordings.of_session(session.session_id) == ()
            with pytest.raises(StoreError, match="not finished"):
                store.recordings.open(writer.recording_id)
        writer.close()
    with open_sample(folder) as store:
        (facts,) = store.recordings.of_session(session.session_id)
        assert facts == store.recordings.facts(writer.recording_id)
        assert (facts.n_frames, facts.n_dropped, facts.notice) == (5, 3, "")
        assert facts.duration_ns == frames[-1].timestamp_ns - frames[0].timestamp_ns
        with store.recordings.open(facts.recording_id) as reader:
            for got, want in zip(reader, frames, strict=True):
                assert_same_frame(got, want)
        steps = []
        out = tmp_path / "out.mcap"
        store.recordings.export(facts.recording_id, out, lambda *step: steps.append(step))
    assert steps[-1] == (5, 5)
    with open_recording(out) as reader:
        for got, want in zip(reader, frames, strict=True):
            assert_same_frame(got, want)


def test_an_abandoned_recording_leaves_nothing(folder, store):
    session = add_session(store)
    writer = store.recordings.create(session.session_id, INFO)
    writer.write(make_frames(1)[0])
    writer.abandon()
    assert list((folder / "recordings").rglob("*.sealed")) == []
    assert store.verify().is_sound
    assert store.recordings.in_the_making == set()


def test_a_recording_cut_by_a_kill_is_listed_at_the_next_opening(folder):
    with open_sample(folder) as store:
        session = add_session(store)
    project = Path(__file__).parents[2]
    arguments = (str(folder), session.session_id, str(project))
    killed = subprocess.run(  # noqa: PLW1510
        [sys.executable, "-c", HALF_A_RECORDING, *arguments], capture_output=True, cwd=project
    )
    assert killed.returncode == -9, killed.stderr
    with open_sample(folder) as store:
        (facts,) = store.recordings.of_session(session.session_id)
        with store.recordings.open(facts.recording_id) as reader:
            frames = make_frames(5)[: len(reader)]
            for got, want in zip(reader, frames, strict=True):
                assert_same_frame(got, want)
        assert facts.n_frames == len(frames) == 5
        assert "interrupted" in facts.notice
        assert store.verify().is_sound
        assert "recover" in [entry.action for entry in store.audit.entries()]


def test_a_recording_cut_before_its_first_frame_leaves_nothing(folder):
    with open_sample(folder) as store:
        session = add_session(store)
        writer = store.recordings.create(session.session_id, INFO)
    with open_sample(folder) as store:
        assert store.recordings.of_session(session.session_id) == ()
        assert store.verify().is_sound
    assert list((folder / "recordings").rglob("*.sealed")) == []
    with pytest.raises(StoreError, match="is closed"):
        writer.abandon()


def test_pictures_that_a_crash_left_pending_go_at_the_next_opening(folder, monkeypatch):
    def power_cut(*_arguments):
        raise RuntimeError("power cut")

    with open_sample(folder) as store:
        session = add_session(store)
        monkeypatch.setattr("adibas.sessions.captures.save_history", power_cut)
        monkeypatch.setattr("adibas.sessions.kept_files.KeptFiles._remove", power_cut)
        with pytest.raises(RuntimeError, match="power cut"):
            add_capture(store, session)
        monkeypatch.undo()
        assert store.captures.of_session(session.session_id) == ()
        assert len(list((folder / "pictures").rglob("*.sealed"))) == 2
    with open_sample(folder) as store:
        assert store.verify().is_sound
    assert list((folder / "pictures").rglob("*.sealed")) == []


def test_a_picture_that_a_crash_left_half_written_goes_at_the_next_opening(folder, monkeypatch):
    class PowerCutError(BaseException):
        pass

    def power_cut(*_arguments, **_options):
        raise PowerCutError

    with open_sample(folder) as store:
        session = add_session(store)
        monkeypatch.setattr("pathlib.Path.replace", power_cut)
        monkeypatch.setattr("pathlib.Path.unlink", power_cut)
        with pytest.raises(PowerCutError):
            add_capture(store, session)
        monkeypatch.undo()
    (unfinished,) = (path for path in (folder / "pictures").rglob("*") if path.is_file())
    assert unfinished.name.startswith(".")
    with open_sample(folder) as store:
        assert store.verify().is_sound
    assert not unfinished.exists()


def test_many_threads_use_one_store(store):
    session = add_session(store)

    def work(number):
        capture = add_capture(store, session)
        history = capture.history.after(moved("m01", 30.0 + number))
        store.captures.correct(capture.capture_id, history)
        store.captures.picture(capture.capture_id)
        store.patients.search("x")

    with ThreadPoolExecutor(8) as threads:
        list(threads.map(work, range(8)))  # raises what a thread raised
    captures = store.captures.of_session(session.session_id)
    assert sorted(c.markers()[0].u for c in captures) == [30.0 + n for n in range(8)]
    assert store.verify().is_sound
