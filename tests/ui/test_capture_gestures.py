"""Gestures that are looked for in live pictures: chosen, told for some seconds, in a thread."""

import threading
from types import SimpleNamespace
from unittest.mock import create_autospec

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QComboBox, QLabel

from adibas.data.calibration import RgbdCalibration
from adibas.data.sentence import Sentence
from adibas.errors import GestureError
from adibas.gestures.model_file import shipped_gestures
from adibas.limbs.judging import NOBODY
from adibas.pipeline.live_frames import LiveFrame
from tests.ui.conftest import NoSensor
from ui.capture.gesture_presenter import CHOICES, GesturePresenter, GestureView, GestureWatch
from ui.capture.gesture_watch import QtGestureWatch
from ui.capture.screen import build_capture_screen
from ui.events import Event
from ui.workspace import Workspace

FRAME = LiveFrame(1, 5, None, np.ones((4, 4), np.float32))


class Scene:
    def __init__(self, workspace):
        self.workspace = workspace
        self.view = create_autospec(GestureView, instance=True)
        self.watch = create_autospec(GestureWatch, instance=True)
        self.watch.seen, self.watch.unseen, self.watch.failed = Event(), Event(), Event()
        self.presenter = GesturePresenter(self.view, workspace, self.watch)
        self.told = []
        workspace.noticed.subscribe(lambda kind, sentence: self.told.append((kind, sentence)))

    @property
    def used(self):
        return self.watch.use.call_args.args[0]


@pytest.fixture
def scene(inline_jobs, preferences, monkeypatch, tmp_path):
    monkeypatch.setattr("platformdirs.user_data_path", lambda *_told, **_more: tmp_path)
    return Scene(Workspace(None, inline_jobs, preferences, NoSensor()))


def test_frames_are_looked_at_while_gestures_are_chosen_and_the_screen_is_seen(scene):
    frames = scene.workspace.live.frame_arrived
    scene.presenter.enter()
    frames.emit(FRAME)
    scene.watch.put.assert_not_called()
    scene.presenter.choose("shipped")
    assert scene.used == (shipped_gestures(),)
    frames.emit(FRAME)
    scene.watch.put.assert_called_once_with(FRAME)
    scene.presenter.leave()
    assert scene.used == ()
    frames.emit(FRAME)
    scene.watch.put.assert_called_once_with(FRAME)
    scene.presenter.enter()
    assert scene.used == (shipped_gestures(),)
    scene.presenter.close()
    scene.watch.close.assert_called_once_with()


def test_own_gestures_are_looked_for_or_it_is_said_that_there_are_none(scene, tmp_path):
    scene.presenter.choose("own")
    assert scene.used == ()
    assert "Learn one under Observe" in scene.told[-1][1]
    path = tmp_path / "models" / "gestures" / "hello.json"
    path.parent.mkdir(parents=True)
    path.write_text("{}")
    scene.presenter.choose("own")
    assert scene.used == (path,)


def test_what_is_recognised_is_told_until_the_next_or_for_some_seconds(scene):
    scene.watch.seen.emit("clap")
    scene.watch.seen.emit("jump")
    assert scene.view.show_gesture.call_args.args == ("Gesture: jump",)
    first, second = (call.args[1] for call in scene.view.call_later.call_args_list)
    first()
    assert scene.view.show_gesture.call_args.args == ("Gesture: jump",)
    second()
    assert scene.view.show_gesture.call_args.args == ("",)


def test_why_nobody_is_watched_is_told_until_somebody_is(scene):
    scene.watch.unseen.emit("Only a dog is seen.")
    told = "No gesture is looked for. Only a dog is seen."
    assert scene.view.show_gesture.call_args.args == (told,)
    scene.watch.unseen.emit("")
    assert scene.view.show_gesture.call_args.args == ("",)


def test_a_reason_is_not_taken_away_with_the_gesture_before(scene):
    scene.watch.seen.emit("clap")
    scene.watch.unseen.emit("Nobody is seen.")
    scene.view.call_later.call_args.args[1]()
    assert "Nobody is seen." in scene.view.show_gesture.call_args.args[0]


def test_a_model_that_cannot_be_read_is_told(scene):
    scene.watch.failed.emit(GestureError("{file} is damaged.", file="a.json"))
    assert scene.told[-1] == ("bad", "a.json is damaged.")


@pytest.fixture
def thread(qtbot, qapp):
    watch = QtGestureWatch(RgbdCalibration, qapp)
    yield watch
    watch.close()
    assert "gestures" not in [one.name for one in threading.enumerate()]
    assert qtbot


def test_a_thread_looks_and_the_window_is_told(thread, qtbot, monkeypatch):
    seen, frames = [], []

    class Gestures:
        unseen = None

        def __init__(self, models):
            self.n_models = len(models)

        def look(self, _depth_m, timestamp_ns, _calibration):
            frames.append(timestamp_ns)
            label = f"{self.n_models} at {timestamp_ns}"
            return [SimpleNamespace(person=1, seen=SimpleNamespace(label=label))]

    monkeypatch.setattr("adibas.pipeline.live_gestures.LiveGestures", Gestures)
    thread.seen.subscribe(seen.append)
    thread.put(FRAME)
    thread.use((shipped_gestures(),))
    thread.put(LiveFrame(1, 4, None, None))
    thread.put(FRAME)
    qtbot.waitUntil(lambda: seen == ["1 at 5"])
    assert frames == [5]


def test_the_thread_tells_once_why_nobody_is_watched_and_once_that_somebody_is(
    thread, qtbot, monkeypatch
):
    reasons = iter([Sentence(NOBODY), Sentence(NOBODY), None])
    n_looks, told = [], []

    class Gestures:
        def __init__(self, _models):
            self.unseen = None

        def look(self, *_frame):
            self.unseen = next(reasons)
            n_looks.append(1)
            return []

    monkeypatch.setattr("adibas.pipeline.live_gestures.LiveGestures", Gestures)
    thread.unseen.subscribe(told.append)
    thread.use((shipped_gestures(),))
    for number in range(1, 4):
        thread.put(FRAME)
        qtbot.waitUntil(lambda number=number: len(n_looks) == number)
    qtbot.waitUntil(lambda: len(told) > 1)
    assert told == [NOBODY, ""]


def test_the_window_does_not_wait_for_a_look_whose_gestures_are_not_wanted_any_more(
    thread, qtbot, monkeypatch
):
    looking, go_on = threading.Event(), threading.Event()
    was_free, seen = [], []

    class Gestures:
        unseen = None

        def __init__(self, _models):
            pass

        def look(self, _depth_m, _timestamp_ns, _calibration):
            looking.set()
            was_free.append(go_on.wait(5))
            return [SimpleNamespace(person=1, seen=SimpleNamespace(label="late"))]

    monkeypatch.setattr("adibas.pipeline.live_gestures.LiveGestures", Gestures)
    thread.seen.subscribe(seen.append)
    thread.use((shipped_gestures(),))
    thread.put(FRAME)
    qtbot.waitUntil(looking.is_set)
    thread.use(())
    go_on.set()
    thread.close()
    QApplication.processEvents()
    assert was_free == [True]
    assert seen == []


def test_a_damaged_model_is_told_in_the_window(thread, qtbot, tmp_path):
    failed = []
    thread.failed.subscribe(failed.append)
    thread.use((tmp_path / "missing.json",))
    qtbot.waitUntil(lambda: bool(failed))
    assert "missing.json" in str(failed[0])


def test_the_capture_screen_offers_gestures_and_says_them(qtbot, workspace):
    screen = build_capture_screen(workspace)
    qtbot.addWidget(screen)
    chooser = next(one for one in screen.findChildren(QComboBox) if one.findData("shipped") >= 0)
    assert [chooser.itemData(index) for index in range(chooser.count())] == list(CHOICES)
    assert chooser.accessibleName()
    assert chooser.itemText(1) == "Gestures of the program"
    chooser.activated.emit(1)
    screen.show_gesture("Gesture: clap")
    told = next(one for one in screen.findChildren(QLabel) if one.text() == "Gesture: clap")
    assert told.isVisibleTo(screen)
    screen.show_gesture("")
    assert told.isVisibleTo(screen), "the picture stays where it is"
    chooser.activated.emit(0)
    assert not told.isVisibleTo(screen)
    screen.closed()
