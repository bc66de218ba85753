"""A capture through the whole core: simulated sensor, live view, markers, store."""

import errno
import functools
import math
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from adibas.data.frames import SourceInfo
from adibas.data.joints import JOINT_NAMES
from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.errors import CalibrationError, RecordingError, SensorError, StoreError
from adibas.markers.color_model import LearningParams, grow_region, learn_colors
from adibas.markers.lab import rgb_to_lab
from adibas.markers.led import LedParams
from adibas.pipeline import burst_names, capturing
from adibas.pipeline.acquisition import Arrival
from adibas.pipeline.capturing import TOO_OLD, CaptureRequest, take_capture
from adibas.pipeline.live import LiveView
from adibas.pipeline.looking import Look, Looker
from adibas.recordings.checksum import recording_sha256
from adibas.recordings.mcap_writer import McapWriter
from adibas.sensors.ports import DepthCamera
from adibas.sessions import open_store
from adibas.sessions.key_wrapping import Argon2Params
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import open_scene
from adibas.texts import speaking
from tests.unit.films import BENT, patient_with_leds
from tests.unit.live_rig import UNPLUGGED, Sources, Told, frame, numbered
from tests.unit.store_samples import add_patient

N_FRAMES = 4
CHEAP = Argon2Params(iterations=1, lanes=1, memory_kib=8)


@functools.cache
def frames_of(scene):
    return [scene.frame(i).sensor_frame for i in range(N_FRAMES)]


class SceneCamera(DepthCamera):
    """The first frames of a scene over and over, until it is unplugged."""

    def __init__(self, scene):
        self.info_ = scene.info
        self._frames = frames_of(scene)
        self._n_read = 0
        self.n_left = math.inf

    @property
    def info(self):
        return self.info_

    @property
    def is_live(self):
        return False

    def read(self, timeout_s=5.0):  # noqa: ARG002
        n_read, self._n_read = self._n_read, self._n_read + 1
        self.n_left -= 1
        if self.n_left < 0:
            raise UNPLUGGED
        one = self._frames[n_read % len(self._frames)]
        return numbered([one], n_read)[0]

    def close(self):
        pass


@pytest.fixture(scope="module")
def scene():
    return open_scene("anterior", seed=7, distance_m=2.4)


@pytest.fixture(scope="module")
def target(scene):
    simulated = scene.frame(0)
    lab = rgb_to_lab(simulated.sensor_frame.color)
    facing = sorted(simulated.truth.markers, key=lambda marker: marker.view_angle_rad)[:3]
    taken = sum(grow_region(lab, (one.u, one.v), 20.0) for one in facing) > 0
    rng = np.random.default_rng(0)
    return learn_colors(lab[taken].astype(float), rng, LearningParams(), {})


@pytest.fixture
def store(tmp_path):
    with open_store(tmp_path / "store", "four words are enough", key_params=CHEAP) as opened:
        yield opened


@pytest.fixture
def session_id(store):
    patient = add_patient(store, Identity("Somebody"))
    return store.sessions.start(patient.pseudonym, SessionSetup()).session_id


@pytest.fixture
def showing():
    """A live view on a camera, closed at the end."""
    views = []

    def show(camera):
        told = Told()
        view = LiveView(told, opener=Sources(camera))
        views.append(view)
        view.open("any")
        told.wait_for(lambda: told.frames)
        return view

    yield show
    for view in views:
        view.close()


def capture(store, view, session_id, target=None, progress=lambda *_: None):
    request = CaptureRequest(session_id, "anterior", N_FRAMES, target)
    return take_capture(store, view, request, progress)


def assert_nothing_kept(store, session_id):
    assert store.recordings.of_session(session_id) == ()
    assert store.captures.of_session(session_id) == ()
    assert list((store.folder / "recordings").rglob("*.sealed*")) == []


def offset_px(truth, marker):
    return np.hypot(truth.u - marker.u, truth.v - marker.v)


def nearest(markers, truth):
    return min(markers, key=lambda marker: offset_px(truth, marker))


@pytest.mark.parametrize(("created", "is_told"), [("2026-01-01", True), ("2026-11-20", False)])
def test_a_capture_tells_of_a_calibration_older_than_the_clinic_allows(
    created, is_told, store, session_id, showing, scene
):
    camera = SceneCamera(scene)
    made = replace(scene.info.calibration, created_utc=created)
    camera.info_ = replace(scene.info, calibration=made)
    view = showing(camera)
    request = CaptureRequest(session_id, "anterior", 1, None, 180)
    now = datetime(2026, 11, 21, tzinfo=UTC)
    taken = take_capture(store, view, request, lambda *_: None, lambda: now)
    assert (TOO_OLD in taken.notices) == is_told


def test_a_capture_holds_the_markers_where_they_truly_are(
    store, session_id, showing, scene, target
):
    progress = []
    view = showing(SceneCamera(scene))
    taken = capture(store, view, session_id, target, lambda *numbers: progress.append(numbers))
    saved = store.captures.get(taken.capture_id)
    assert (saved.view, saved.n_frames, saved.first_frame) == ("anterior", N_FRAMES, 0)
    visible = [one for one in scene.frame(0).truth.markers if one.is_visible]
    pairs = [(one, nearest(saved.markers(), one)) for one in visible]
    found = [(one, marker) for one, marker in pairs if offset_px(one, marker) < 1.0]
    assert len(found) >= len(visible) - 2
    assert len(saved.markers()) <= len(found) + 1
    errors_m = [
        np.linalg.norm(marker.position_m - one.position_m)
        for one, marker in found
        if marker.position_m is not None
    ]
    assert len(errors_m) >= len(found) - 2
    assert np.median(errors_m) < 0.005
    assert max(errors_m) < 0.015
    assert progress[-1] == (2 * N_FRAMES, 2 * N_FRAMES)
    assert [done for done, _ in progress] == sorted(done for done, _ in progress)


def test_markers_on_joints_have_their_names_where_the_protocol_marks_joints(store, showing, target):
    scene = open_scene("anterior", seed=7, distance_m=3.0, markers=MarkerSettings(JOINT_NAMES))
    patient = add_patient(store, Identity("Somebody")).pseudonym
    setup = SessionSetup(protocol="joints-15")
    session_id = store.sessions.start(patient, setup).session_id
    taken = capture(store, showing(SceneCamera(scene)), session_id, target)
    truth = {one.name: one for one in scene.frame(0).truth.markers}
    named = [one for one in taken.markers() if one.label in truth]
    assert len(named) >= 12
    assert max(offset_px(truth[one.label], one) for one in named) < 2.0
    models = {one.named_by.model for one in named}
    told = taken.provenance.parameters["names"]
    assert models == {told["model"]}
    assert told["knew_body"]


class Bending(SceneCamera):
    """Somebody in the deepest of a bend, who holds still there."""

    def __init__(self, scene):
        super().__init__(scene)
        self._frames = [scene.frame(BENT[len(BENT) // 2]).sensor_frame]


def bent_capture(store, showing, scene):
    patient = add_patient(store, Identity("Somebody")).pseudonym
    session_id = store.sessions.start(patient, SessionSetup(protocol="joints-15")).session_id
    return capture(store, showing(Bending(scene)), session_id, LedParams())


def test_who_bends_down_is_captured_as_the_live_picture_saw_them(store, showing, monkeypatch):
    scene = patient_with_leds(seed=7, gesture="bend")
    looker, look = Looker(), Look()
    for index in BENT[: len(BENT) // 2]:
        looker.look(Arrival(scene.frame(index).sensor_frame, scene.info, 30.0, 0), look)
    monkeypatch.setattr(LiveView, "person", looker.person)
    taken = bent_capture(store, showing, scene)
    markers = scene.frame(BENT[len(BENT) // 2]).truth.markers
    visible = {one.name: one for one in markers if one.is_visible}
    named = {one.label: one for one in taken.markers() if one.label in visible}
    assert len(named) >= len(visible) - 1
    assert max(offset_px(visible[name], one) for name, one in named.items()) < 2.0
    assert taken.provenance.parameters["names"]["knew_body"]
    assert taken.notices == ()


def test_who_was_seen_by_another_source_is_not_before_a_burst(showing, scene):
    """Its pictures may be of another size."""
    view = showing(SceneCamera(scene))
    assert view.person is not None

    def unplugged(*_told, **_more):
        raise UNPLUGGED

    view._opener = unplugged
    view.open("another")
    assert view.person is None


def test_who_is_bent_from_the_first_picture_on_is_nobody(store, showing):
    """As no rule for one image takes a head, arms and legs apart from each other for a person."""
    taken = bent_capture(store, showing, patient_with_leds(seed=7, gesture="bend"))
    assert taken.markers() == ()
    assert any("Nobody is seen" in notice for notice in taken.notices)


def test_markers_of_a_capture_get_no_name_against_the_body_that_its_depth_shows(
    store, showing, target, monkeypatch
):
    seen = []

    def on_nobody(namer, depth_m, view, calibration, rotation_deg, _pixels):
        seen.append((depth_m.shape, view, calibration.depth is not None, rotation_deg))
        return namer.who_sees(lambda points_m: np.full((len(points_m), len(namer.names)), -20.0))

    monkeypatch.setattr(burst_names, "with_body", on_nobody)
    scene = open_scene("anterior", seed=7, distance_m=3.0, markers=MarkerSettings(JOINT_NAMES))
    patient = add_patient(store, Identity("Somebody")).pseudonym
    session_id = store.sessions.start(patient, SessionSetup(protocol="joints-15")).session_id
    taken = capture(store, showing(SceneCamera(scene)), session_id, target)
    assert seen == [((480, 640), "anterior", True, 0)]
    assert not any(one.label in JOINT_NAMES for one in taken.markers())


def test_the_recording_of_a_capture_is_sealed_whole_and_named_in_it(
    store, session_id, showing, scene, target
):
    taken = capture(store, showing(SceneCamera(scene)), session_id, target)
    (facts,) = store.recordings.of_session(session_id)
    assert (facts.recording_id, facts.n_frames) == (taken.recording_id, N_FRAMES)
    sealed = next((store.folder / "recordings").rglob(f"{taken.recording_id}*"))
    assert taken.provenance.recording_sha256 == recording_sha256(sealed)
    with store.recordings.open(taken.recording_id) as recording:
        middle = recording.read(N_FRAMES // 2)
        depths = [one.depth_raw for one in recording]
    assert middle.color is not None
    assert store.captures.picture(taken.capture_id).shape == (1024, 1280, 3)
    surface = store.captures.surface(taken.capture_id)
    assert surface.n_frames == N_FRAMES
    np.testing.assert_array_equal(surface.n_readings, sum((one > 0).astype(int) for one in depths))


def test_a_capture_without_markers_is_kept_for_those_set_by_hand(store, session_id, showing, scene):
    taken = capture(store, showing(SceneCamera(scene)), session_id)
    assert taken.detected == ()
    assert taken.notices == (capturing.NOT_SOUGHT,)
    assert store.captures.surface(taken.capture_id) is not None


def test_why_no_markers_were_found_is_told_in_any_language(
    store, session_id, scene, target, showing
):
    everything = replace(target, threshold=150.0)
    view = showing(SceneCamera(scene))
    with speaking("es"):
        taken = capture(store, view, session_id, everything)
    (notice,) = taken.notices
    assert notice.startswith("The learned colour fits too much of the body.")
    assert "{" not in notice


def test_an_empty_room_is_captured_with_a_notice(store, session_id, showing, target):
    room = open_scene("empty", seed=7)
    taken = capture(store, showing(SceneCamera(room)), session_id, target)
    assert taken.detected == ()
    assert taken.notices[0].startswith("Nobody is seen in the depth image.")


def test_a_sensor_lost_in_the_burst_leaves_nothing(
    store, session_id, showing, scene, target, monkeypatch
):
    camera = SceneCamera(scene)
    view = showing(camera)
    begin = view.capture

    def begin_and_unplug(*given, **named):
        camera.n_left = N_FRAMES  # fewer than the disk may be behind
        return begin(1000, *given[1:], **named)

    monkeypatch.setattr(view, "capture", begin_and_unplug)
    with pytest.raises(SensorError, match="unplugged"):
        capture(store, view, session_id, target)
    assert_nothing_kept(store, session_id)


@pytest.mark.parametrize("n_steps", [1, N_FRAMES + 2], ids=["recording", "analysing"])
def test_the_user_can_stop_a_capture_at_any_time(
    store, session_id, showing, scene, target, n_steps
):
    class StoppedError(Exception):
        pass

    def progress(done, total):
        assert total == 2 * N_FRAMES
        if done >= n_steps:
            raise StoppedError

    view = showing(SceneCamera(scene))
    with pytest.raises(StoppedError):
        capture(store, view, session_id, target, progress)
    assert_nothing_kept(store, session_id)
    assert capture(store, view, session_id, target).n_frames == N_FRAMES


def test_a_full_disk_promises_no_frames(store, session_id, showing, scene, monkeypatch):
    def fail(*_):
        raise RecordingError("full") from OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(McapWriter, "write", fail)
    with pytest.raises(StoreError, match="Nothing of it is kept") as told:
        capture(store, showing(SceneCamera(scene)), session_id)
    assert "No space left on device" in str(told.value)
    assert_nothing_kept(store, session_id)


def test_a_capture_that_cannot_be_saved_leaves_its_whole_recording(
    store, session_id, showing, scene, monkeypatch
):
    def fail(*_):
        raise StoreError("full")

    monkeypatch.setattr(store.captures, "add", fail)
    with pytest.raises(StoreError, match="full"):
        capture(store, showing(SceneCamera(scene)), session_id)
    (facts,) = store.recordings.of_session(session_id)
    assert facts.n_frames == N_FRAMES


def test_without_a_calibration_nothing_is_recorded(store, session_id, showing, scene):
    camera = SceneCamera(scene)
    camera.info_ = SourceInfo(sensor_name="bare")
    with pytest.raises(CalibrationError, match="no calibration"):
        capture(store, showing(camera), session_id)
    assert_nothing_kept(store, session_id)


def test_a_calibration_that_does_not_fit_leaves_nothing(store, session_id, showing, scene):
    camera = SceneCamera(scene)
    camera._frames = [frame(0)]
    with pytest.raises(CalibrationError, match="resolution"):
        capture(store, showing(camera), session_id)
    assert_nothing_kept(store, session_id)


def test_nothing_is_captured_without_a_sensor(store, session_id):
    with pytest.raises(SensorError, match="No sensor is live"):
        capture(store, LiveView(Told()), session_id)
    assert_nothing_kept(store, session_id)
