"""The capture screen with real widgets, real jobs, a real store, and a sensor that tests drive."""

import errno

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QPushButton, QToolButton

from adibas.data.patients import Identity
from adibas.errors import RecordingError, SensorError
from adibas.pipeline import acquisition
from adibas.pipeline.live import LiveFrame, SensorState
from adibas.recordings.mcap_writer import McapWriter
from adibas.simulation.scenes import open_scene
from adibas.texts import use_language
from tests.unit.live_rig import UNPLUGGED, DrivenCamera, Sources, numbered
from tests.unit.store_samples import add_patient
from ui.capture import presenter
from ui.capture.presenter import CapturePresenter
from ui.capture.sources import usual_sources
from ui.capture.view import CaptureScreen
from ui.jobs import JobRunner
from ui.live_source import QtLiveSource
from ui.widgets.depth_picture import FARTHEST_M, blended, depth_picture
from ui.widgets.image_view import ImageView
from ui.workspace import Workspace

LEFT = Qt.MouseButton.LeftButton
PATIENCE_MS = 60_000
N_FRAMES = 3


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(acquisition, "RETRY_S", 0.01)


@pytest.fixture(scope="module")
def scene():
    return open_scene("anterior", seed=5, color_size=(480, 640))


@pytest.fixture(scope="module")
def frames(scene):
    return [scene.frame(i).sensor_frame for i in range(2)]


class Clinic:
    """The screen, and everything that it works with."""

    def __init__(self, store, preferences, cameras):
        self.told = []
        self.cameras = cameras
        self.jobs = JobRunner(self.report)
        self.live = QtLiveSource(opener=Sources(*cameras))
        self.workspace = Workspace(store, self.jobs, preferences, self.live)
        self.workspace.noticed.subscribe(lambda *notice: self.told.append(notice))
        self.screen = CaptureScreen()
        self.screen.bind(CapturePresenter(self.screen, self.workspace, look=usual_sources))

    def report(self, error):
        self.workspace.report_problem(error)

    def close(self):
        self.screen.closed()
        for camera in self.cameras:
            camera.push(*[UNPLUGGED] * 3)
        self.jobs.close()
        self.live.end()

    def words(self):
        return [label.text() for label in self.screen.findChildren(QLabel) if label.isVisible()]

    def button(self, text):
        (found,) = [
            one
            for one in self.screen.findChildren(QPushButton)
            if one.text().replace("&", "") == text
        ]
        return found


@pytest.fixture
def clinic(store, preferences, theme, qtbot, scene, frames):  # noqa: ARG001  (dressed)
    preferences.change(countdown_s=0, burst_frames=N_FRAMES, has_sound=False)
    cameras = [DrivenCamera(frames[:1], info=scene.info) for _ in range(8)]
    clinic = Clinic(store, preferences, cameras)
    qtbot.addWidget(clinic.screen)
    clinic.screen.resize(1140, 740)
    clinic.screen.show()
    clinic.screen.entered()
    yield clinic
    clinic.close()


@pytest.fixture
def wait(qtbot):
    return lambda condition: qtbot.waitUntil(condition, timeout=PATIENCE_MS)


@pytest.fixture
def ready(clinic, wait, store):
    """A patient, and a live picture."""
    clinic.workspace.choose_patient(add_patient(store, Identity("Ana")))
    wait(lambda: clinic.live.newest is not None)
    wait(lambda: clinic.button("Capture this view").isEnabled())
    return clinic


@pytest.fixture
def press(wait, qtbot):
    """Presses the button and waits until frames are taken."""

    def press(clinic):
        threads = clinic.live.view._running
        before = threads._burst
        qtbot.mouseClick(clinic.button("Capture this view"), LEFT)
        wait(lambda: threads._burst is not before)

    return press


def give(camera, frames, first=1, n_frames=N_FRAMES):
    camera.push(*numbered([frames[i % 2] for i in range(n_frames)], first))


def assert_nothing_kept(clinic):
    session = clinic.workspace.session
    store = clinic.workspace.store
    assert store.captures.of_session(session.session_id) == ()
    assert store.recordings.of_session(session.session_id) == ()
    assert list((store.folder / "recordings").rglob("*.sealed*")) == []


def test_a_view_is_captured_by_a_click(ready, wait, press, frames):
    press(ready)
    give(ready.cameras[0], frames)
    wait(lambda: bool(ready.workspace.session and ready.workspace.session.capture_ids))
    wait(lambda: not ready.jobs.is_busy)
    (capture,) = ready.workspace.store.captures.of_session(ready.workspace.session.session_id)
    assert (capture.view, capture.n_frames) == ("anterior", N_FRAMES)
    front = next(b for b in ready.screen.findChildren(QToolButton) if "Front" in b.text())
    assert front.text() == "✓ Front"
    assert front.accessibleName() == "Front, taken"
    back = next(b for b in ready.screen.findChildren(QToolButton) if "Back" in b.text())
    assert back.isChecked()


def test_an_unplugged_sensor_spoils_the_burst_and_not_the_session(ready, wait, press, frames):
    press(ready)
    give(ready.cameras[0], frames, n_frames=1)
    ready.cameras[0].push(SensorError("The sensor was unplugged."))
    wait(lambda: bool(ready.told))
    assert ready.told == [("bad", "The sensor was unplugged.")]
    wait(lambda: not ready.jobs.is_busy)
    assert_nothing_kept(ready)
    wait(lambda: ready.live.state.kind == "live")
    wait(lambda: ready.button("Capture this view").isEnabled())
    press(ready)
    give(ready.cameras[1], frames)
    wait(lambda: bool(ready.workspace.session.capture_ids))


def test_a_full_disk_is_told_in_one_sentence_and_nothing_is_kept(
    ready, wait, press, frames, monkeypatch
):
    def full(*_arguments):
        reason = OSError(errno.ENOSPC, "No space left on device")
        raise RecordingError("The disk is full.") from reason

    monkeypatch.setattr(McapWriter, "write", full)
    press(ready)
    give(ready.cameras[0], frames)
    wait(lambda: bool(ready.told))
    wait(lambda: not ready.jobs.is_busy)
    ((kind, sentence),) = ready.told
    assert kind == "bad"
    assert "No space left on device" in sentence
    assert "Nothing of it is kept" in sentence
    assert_nothing_kept(ready)


def test_a_burst_is_stopped_by_the_same_button(ready, wait, qtbot):
    qtbot.mouseClick(ready.button("Capture this view"), LEFT)
    qtbot.mouseClick(ready.button("Stop"), LEFT)
    wait(lambda: not ready.jobs.is_busy)
    assert ready.button("Capture this view").isEnabled()
    assert ready.told == []
    assert_nothing_kept(ready)


def test_status_is_seen_whatever_the_sensor_does(clinic, wait):
    def says(sentence):
        words = clinic.words()
        dropped = any("dropped" in text for text in words)
        disk = any("Disk" in text for text in words)
        return dropped and disk and any(sentence in text for text in words)

    wait(lambda: says("Live"))
    clinic.screen.show_sensor(SensorState("opening"))
    assert says("Waiting for the sensor")
    clinic.cameras[0].push(SensorError("The sensor was unplugged."))
    lost = []
    clinic.live.state_changed.subscribe(
        lambda state: lost.append(says("unplugged")) if state.kind == "lost" else None
    )
    wait(lambda: clinic.live.state.kind == "live" and bool(lost))
    assert lost == [True]
    clinic.screen.show_sensor(SensorState("ended"))
    assert says("The recording is over.")


def test_dropped_frames_stay_counted_while_the_sensor_is_lost(clinic, wait, frames):
    wait(lambda: clinic.live.newest is not None)
    clinic.cameras[0].push(*numbered(frames[:1], 4))
    wait(lambda: any(text == "3 frames dropped" for text in clinic.words()))
    clinic.screen.show_sensor(SensorState("lost", UNPLUGGED))
    assert "3 frames dropped" in clinic.words()


def test_both_pictures_stand_side_by_side_or_blended(clinic, wait):
    wait(lambda: clinic.live.newest is not None)
    color, depth = clinic.screen.findChildren(ImageView)
    mode = next(box for box in clinic.screen.findChildren(QComboBox) if box.count() == 4)
    seen = {}
    for name in ("color", "both", "blended", "depth"):
        mode.setCurrentIndex(mode.findData(name))
        mode.activated.emit(mode.currentIndex())
        seen[name] = color.isVisible(), depth.isVisible()
    assert seen == {
        "color": (True, False),
        "both": (True, True),
        "blended": (True, False),
        "depth": (False, True),
    }
    assert depth.placement.picture == (640, 480)


def test_the_picture_turns_with_the_sensor(ready, qtbot):
    qtbot.mouseClick(ready.button("Turn"), LEFT)
    assert all(one.placement.rotation_deg == 90 for one in ready.screen.findChildren(ImageView))
    assert ready.live.view.params.rotation_deg == 90


def test_overlays_are_drawn_as_far_as_they_are_wanted(clinic, wait):
    wait(lambda: clinic.live.newest is not None and clinic.live.newest.outline is not None)
    (color, _depth) = clinic.screen.findChildren(ImageView)
    n_drawn = [len(color._overlays)]
    for box in clinic.screen.findChildren(QCheckBox):
        box.setChecked(False)
        n_drawn.append(len(color._overlays))
    assert n_drawn[0] >= 2
    assert n_drawn[-1] == 0


def test_views_are_chosen_by_key_and_the_countdown_is_shown(ready, preferences):
    preferences.change(countdown_s=3)
    QTest.keyClick(ready.screen, Qt.Key.Key_F6)
    ready.screen.show_countdown(3)
    assert "3" in ready.words()
    assert ready.button("Stop").isEnabled()
    ready.screen.show_countdown(None)
    assert "3" not in ready.words()


def test_the_way_to_a_consent_is_a_button_that_is_seen_where_one_lacks(clinic, qtbot, store):
    asked = []
    clinic.workspace.consent_wanted.subscribe(asked.append)
    qtbot.addWidget(clinic.screen)
    clinic.screen.show()
    button = clinic.button("Record the consent...")
    assert not button.isVisible()
    clinic.workspace.choose_patient(store.patients.add(Identity("Bernat")))
    assert button.isVisible()
    assert any("no consent for treatment" in text for text in clinic.words())
    assert not clinic.button("Capture this view").isEnabled()
    qtbot.mouseClick(button, LEFT)
    assert asked == ["capture"]
    clinic.workspace.choose_patient(add_patient(store, Identity("Ana")))
    assert not button.isVisible()


def test_it_speaks_another_language_at_once(clinic):
    use_language("es")
    try:
        clinic.screen.retranslate()
        assert any("Disco" in text or "disco" in text for text in clinic.words())
    finally:
        use_language("en")
        clinic.screen.retranslate()


def test_everything_is_named_and_reached_by_the_keyboard(clinic):
    for kind in (QPushButton, QToolButton, QCheckBox):
        for one in clinic.screen.findChildren(kind):
            assert one.text() or one.accessibleName()
            assert one.focusPolicy() & Qt.FocusPolicy.TabFocus
    assert all(one.accessibleName() for one in clinic.screen.findChildren(ImageView))


def test_a_dropped_recording_is_opened(clinic, tmp_path):
    clinic.screen.open_file(tmp_path / "walk.mcap")
    assert clinic.live.opened[0] == str(tmp_path / "walk.mcap")
    sources = next(
        b for b in clinic.screen.findChildren(QComboBox) if b.currentText() == "walk.mcap"
    )
    assert sources.currentData() == str(tmp_path / "walk.mcap")


def test_a_hint_stands_under_the_picture_and_a_frame_without_colour_does_no_harm(clinic):
    frame = LiveFrame(1, 0, None, None, hints=("Nobody is seen.",))
    clinic.screen.show_frame(frame)
    assert "Nobody is seen." in clinic.words()


def test_depth_is_bright_where_it_is_near_and_black_where_nothing_was_measured():
    depth_m = np.array([[0.3, 0.5, 1.0, 2.0, 4.4, FARTHEST_M, 7.0, np.nan]], np.float32)
    (colors,) = depth_picture(depth_m).astype(int)
    assert (colors[0] == colors[1]).all(), "what is nearer than the nearest"
    assert (colors[5] == colors[6]).all(), "what is farther than the farthest"
    lightness = colors[1:6].sum(axis=1)
    assert (np.diff(lightness) < 0).all()
    assert lightness[-1] > 0
    assert (colors[7] == 0).all()


def test_a_blend_shows_the_colour_alone_where_no_depth_is():
    color = np.full((2, 2, 3), 200, np.uint8)
    depth_m = np.array([[np.nan, 1.0], [2.0, np.nan]], np.float32)
    mixed = blended(color, depth_m)
    np.testing.assert_array_equal(mixed[[0, 1], [0, 1]], 200)
    assert (mixed[[0, 1], [1, 0]] != 200).any(axis=1).all()


def test_the_presenter_asks_the_real_capture():
    assert presenter.take_capture.__module__ == "adibas.pipeline.capturing"
