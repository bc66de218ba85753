"""Joints and gestures that are looked for in live pictures without markers, in a thread."""

import threading
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from unittest.mock import create_autospec

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QCheckBox, QComboBox, QLabel

from adibas.data.calibration import RgbdCalibration
from adibas.data.sentence import Sentence
from adibas.errors import GestureError
from adibas.gestures.model_file import shipped_gestures
from adibas.limbs.judging import NOBODY
from adibas.pipeline.live_frames import LiveFrame
from adibas.pipeline.live_people import LiveJoints
from tests.ui.conftest import NoSensor
from ui.capture.live_overlays import joints_of
from ui.capture.people_presenter import (
    CHOICES,
    PeoplePresenter,
    PeopleView,
    PeopleWatch,
    Wanted,
)
from ui.capture.people_watch import QtPeopleWatch
from ui.capture.screen import build_capture_screen
from ui.events import Event
from ui.widgets.overlays import Dot, Line
from ui.workspace import Workspace

FRAME = LiveFrame(1, 5, None, np.ones((4, 4), np.float32))
JOINTS = LiveJoints(1, 13, True, {"head": (5.0, 6.0)}, {})


class Scene:
    def __init__(self, workspace):
        self.workspace = workspace
        self.view = create_autospec(PeopleView, instance=True)
        self.watch = create_autospec(PeopleWatch, instance=True)
        self.watch.gesture_seen, self.watch.joints_seen = Event(), Event()
        self.watch.unseen, self.watch.failed = Event(), Event()
        self.presenter = PeoplePresenter(self.view, workspace, self.watch)
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
    scene.presenter.choose_gestures("shipped")
    assert scene.used == Wanted((shipped_gestures(),))
    frames.emit(FRAME)
    scene.watch.put.assert_called_once_with(FRAME)
    scene.presenter.leave()
    assert scene.used == Wanted()
    frames.emit(FRAME)
    scene.watch.put.assert_called_once_with(FRAME)
    scene.presenter.enter()
    assert scene.used == Wanted((shipped_gestures(),))
    scene.presenter.close()
    scene.watch.close.assert_called_once_with()


def test_own_gestures_are_looked_for_or_it_is_said_that_there_are_none(scene, tmp_path):
    scene.presenter.choose_gestures("own")
    assert scene.used == Wanted()
    assert "Learn one under Observe" in scene.told[-1][1]
    path = tmp_path / "models" / "gestures" / "hello.json"
    path.parent.mkdir(parents=True)
    path.write_text("{}")
    scene.presenter.choose_gestures("own")
    assert scene.used == Wanted((path,))


def test_what_is_recognised_is_told_until_the_next_or_for_some_seconds(scene):
    scene.watch.gesture_seen.emit("clap")
    scene.watch.gesture_seen.emit("jump")
    assert scene.view.show_followed.call_args.args == ("Gesture: jump",)
    first, second = (call.args[1] for call in scene.view.call_later.call_args_list)
    first()
    assert scene.view.show_followed.call_args.args == ("Gesture: jump",)
    second()
    assert scene.view.show_followed.call_args.args == ("",)


def test_why_nobody_is_watched_is_told_until_somebody_is(scene):
    scene.watch.unseen.emit("Only a dog is seen.")
    told = "Nobody is followed without markers. Only a dog is seen."
    assert scene.view.show_followed.call_args.args == (told,)
    scene.watch.unseen.emit("")
    assert scene.view.show_followed.call_args.args == ("",)


def test_a_reason_is_not_taken_away_with_the_gesture_before(scene):
    scene.watch.gesture_seen.emit("clap")
    scene.watch.unseen.emit("Nobody is seen.")
    scene.view.call_later.call_args.args[1]()
    assert "Nobody is seen." in scene.view.show_followed.call_args.args[0]


def test_a_model_that_cannot_be_read_is_told(scene):
    scene.watch.failed.emit(GestureError("{file} is damaged.", file="a.json"))
    assert scene.told[-1] == ("bad", "a.json is damaged.")


def test_joints_are_looked_for_where_they_are_wanted_beside_gestures(scene):
    scene.presenter.enter()
    scene.presenter.want_joints(are_wanted=True)
    assert scene.used == Wanted(joints=True)
    scene.workspace.live.frame_arrived.emit(FRAME)
    scene.watch.put.assert_called_once_with(FRAME)
    scene.presenter.choose_gestures("shipped")
    assert scene.used == Wanted((shipped_gestures(),), joints=True)
    scene.presenter.want_joints(are_wanted=False)
    assert scene.used == Wanted((shipped_gestures(),))


def test_joints_are_drawn_and_told_to_be_no_markers_until_they_are_not_wanted(scene):
    scene.presenter.want_joints(are_wanted=True)
    scene.watch.joints_seen.emit((JOINTS,))
    assert scene.view.show_joints.call_args.args == ((JOINTS,),)
    told = "Found without markers, less exact than with them: 13 of 15 joints."
    assert scene.view.show_followed.call_args.args == (told,)
    scene.watch.joints_seen.emit((JOINTS, JOINTS))
    assert "2 people" in scene.view.show_followed.call_args.args[0]
    scene.presenter.want_joints(are_wanted=False)
    assert scene.view.show_joints.call_args.args == ((),)
    assert scene.view.show_followed.call_args.args == ("",)


def test_where_front_or_back_is_not_known_it_is_told(scene):
    scene.watch.joints_seen.emit((replace(JOINTS, is_view_sure=False),))
    told = scene.view.show_followed.call_args.args[0]
    assert told.startswith("Found without markers")
    assert told.endswith("It is not sure yet whether the front or the back is seen.")


def test_a_gesture_is_told_before_the_joints_which_come_back_after_it(scene):
    scene.watch.gesture_seen.emit("clap")
    scene.watch.joints_seen.emit((JOINTS,))
    assert scene.view.show_followed.call_args.args == ("Gesture: clap",)
    scene.view.call_later.call_args.args[1]()
    assert "13 of 15" in scene.view.show_followed.call_args.args[0]


def test_joints_without_markers_are_dots_and_bones_that_no_marker_has():
    drawn = list(joints_of({4: {"head": (1.0, 2.0), "neck": (1.0, 5.0), "left_knee": (3.0, 9.0)}}))
    assert {one.role for one in drawn} == {"markerless"}
    assert [one for one in drawn if isinstance(one, Line)] == [
        Line(1.0, 2.0, 1.0, 5.0, "markerless")
    ]
    assert [(one.u, one.v) for one in drawn if isinstance(one, Dot)] == [
        (1.0, 2.0),
        (1.0, 5.0),
        (3.0, 9.0),
    ]


def test_several_people_without_markers_bear_their_numbers():
    places = {"neck": (1.0, 5.0), "left_knee": (3.0, 9.0)}
    labels = [one.label for one in joints_of({2: places, 5: places}) if isinstance(one, Dot)]
    assert labels == ["2", "", "5", ""]
    assert not any(one.label for one in joints_of({2: places}) if isinstance(one, Dot))


@pytest.fixture
def thread(qtbot, qapp):
    watch = QtPeopleWatch(RgbdCalibration, qapp)
    yield watch
    watch.close()
    assert "people" not in [one.name for one in threading.enumerate()]
    assert qtbot


class Everybody:
    """Finds somebody in every frame, whose only joint lies at the frame's time."""

    def look(self, _depth_m, timestamp_ns, _calibration, _rotation_deg):
        return SimpleNamespace(timestamp_ns=timestamp_ns, people=(timestamp_ns,), unseen=None)


@pytest.fixture
def chain(monkeypatch):
    """Put what a test wants in the place of the chain from depth to joints."""

    def put(people=Everybody, see=lambda _moment: []):
        gestures = lambda models: SimpleNamespace(see=partial(see, len(models)))  # noqa: E731
        monkeypatch.setattr("adibas.pipeline.live_people.LivePeople", people)
        monkeypatch.setattr("adibas.pipeline.live_gestures.LiveGestures", gestures)
        monkeypatch.setattr(
            "adibas.pipeline.live_people.joints_in_pictures",
            lambda one, _calibration: LiveJoints(1, 1, True, {"head": (float(one), 0.0)}, {}),
        )

    return put


def gesture(label):
    return SimpleNamespace(person=1, seen=SimpleNamespace(label=label))


def test_a_thread_looks_and_the_window_is_told(thread, qtbot, chain):
    seen, joints = [], []
    chain(see=lambda n_models, moment: [gesture(f"{n_models} at {moment.timestamp_ns}")])
    thread.gesture_seen.subscribe(seen.append)
    thread.joints_seen.subscribe(joints.append)
    thread.put(FRAME)
    thread.use(Wanted((shipped_gestures(),)))
    thread.put(LiveFrame(1, 4, None, None))
    thread.put(FRAME)
    qtbot.waitUntil(lambda: seen == ["1 at 5"])
    assert joints == [], "nobody asked for them"


def test_the_window_is_told_of_joints_without_any_gesture(thread, qtbot, chain):
    joints = []
    chain(see=lambda _n_models, _moment: [])
    thread.joints_seen.subscribe(joints.append)
    thread.use(Wanted(joints=True))
    thread.put(FRAME)
    qtbot.waitUntil(lambda: bool(joints))
    ((one,),) = joints
    assert one.in_color == {"head": (5.0, 0.0)}


def test_the_thread_knows_how_the_picture_is_turned(thread, qtbot, chain):
    turned_deg = []

    class Turned(Everybody):
        def look(self, depth_m, timestamp_ns, calibration, rotation_deg):
            turned_deg.append(rotation_deg)
            return super().look(depth_m, timestamp_ns, calibration, rotation_deg)

    chain(Turned, lambda _n_models, _moment: [])
    thread.use(Wanted(joints=True))
    thread.put(replace(FRAME, rotation_deg=270))
    qtbot.waitUntil(lambda: bool(turned_deg))
    assert turned_deg == [270]


def test_the_thread_tells_once_why_nobody_is_followed_and_once_that_somebody_is(
    thread, qtbot, chain
):
    reasons = iter([Sentence(NOBODY), Sentence(NOBODY), None])
    n_looks, told = [], []

    class Nobody:
        def look(self, *_frame):
            n_looks.append(1)
            return SimpleNamespace(people=(), unseen=next(reasons))

    chain(Nobody, lambda _n_models, _moment: [])
    thread.unseen.subscribe(told.append)
    thread.use(Wanted((shipped_gestures(),)))
    for number in range(1, 4):
        thread.put(FRAME)
        qtbot.waitUntil(lambda number=number: len(n_looks) == number)
    qtbot.waitUntil(lambda: len(told) > 1)
    assert told == [NOBODY, ""]


def test_the_window_does_not_wait_for_a_look_whose_gestures_are_not_wanted_any_more(
    thread, qtbot, chain
):
    looking, go_on = threading.Event(), threading.Event()
    was_free, seen = [], []

    def see(_n_models, _moment):
        looking.set()
        was_free.append(go_on.wait(5))
        return [gesture("late")]

    chain(see=see)
    thread.gesture_seen.subscribe(seen.append)
    thread.use(Wanted((shipped_gestures(),)))
    thread.put(FRAME)
    qtbot.waitUntil(looking.is_set)
    thread.use(Wanted())
    go_on.set()
    thread.close()
    QApplication.processEvents()
    assert was_free == [True]
    assert seen == []


def test_a_damaged_model_is_told_in_the_window(thread, qtbot, tmp_path):
    failed = []
    thread.failed.subscribe(failed.append)
    thread.use(Wanted((tmp_path / "missing.json",)))
    qtbot.waitUntil(lambda: bool(failed))
    assert "missing.json" in str(failed[0])


def choose(chooser, index):
    chooser.setCurrentIndex(index)
    chooser.activated.emit(index)


def test_the_capture_screen_offers_gestures_and_says_them(qtbot, workspace):
    screen = build_capture_screen(workspace)
    qtbot.addWidget(screen)
    chooser = next(one for one in screen.findChildren(QComboBox) if one.findData("shipped") >= 0)
    assert [chooser.itemData(index) for index in range(chooser.count())] == list(CHOICES)
    assert chooser.accessibleName()
    assert chooser.itemText(1) == "Gestures of the program"
    choose(chooser, 1)
    screen.show_followed("Gesture: clap")
    told = next(one for one in screen.findChildren(QLabel) if one.text() == "Gesture: clap")
    assert told.isVisibleTo(screen)
    screen.show_followed("")
    assert told.isVisibleTo(screen), "the picture stays where it is"
    choose(chooser, 0)
    assert not told.isVisibleTo(screen)
    screen.closed()


def test_the_capture_screen_draws_joints_over_colour_and_depth_while_the_box_is_ticked(
    qtbot, workspace
):
    screen = build_capture_screen(workspace)
    qtbot.addWidget(screen)
    wishes = []
    screen._people = None
    screen._display.joints_wanted.connect(wishes.append)
    box = next(one for one in screen.findChildren(QCheckBox) if "Joints" in one.text())
    assert not box.isChecked()
    box.click()
    assert wishes == [True]
    assert screen._followed.isVisibleTo(screen)
    screen.show()
    screen.show_both()
    screen.show_joints((LiveJoints(1, 1, True, {"head": (5.0, 6.0)}, {"head": (2.0, 3.0)}),))
    picture = np.zeros((8, 8, 3), np.uint8)
    screen.show_frame(LiveFrame(1, 5, picture, np.ones((4, 4), np.float32)))
    for view, place in ((screen._color, (5.0, 6.0)), (screen._depth, (2.0, 3.0))):
        dots = [one for one in view._overlays if isinstance(one, Dot)]
        assert [(one.u, one.v) for one in dots] == [place]
    box.click()
    assert wishes == [True, False]
    assert not screen._followed.isVisibleTo(screen)
    screen.closed()


def test_a_long_sentence_takes_a_second_line_and_neither_width_nor_the_picture(
    qtbot, workspace, theme
):
    assert theme
    screen = build_capture_screen(workspace)
    qtbot.addWidget(screen)
    label = screen._followed
    next(one for one in screen.findChildren(QCheckBox) if "Joints" in one.text()).click()
    screen.resize(1100, 700)
    with qtbot.waitExposed(screen):
        screen.show()
    QApplication.processEvents()
    before = screen.minimumSizeHint().width(), screen._color.size()
    words = "Nobody is followed without markers."
    while label.fontMetrics().horizontalAdvance(words) < 1.5 * label.width():
        words += " Too near."
    screen.show_followed(words)
    QApplication.processEvents()
    after = screen.minimumSizeHint().width(), screen._color.size()
    height_px = label.heightForWidth(label.width())
    screen.closed()
    assert after == before
    assert label.fontMetrics().lineSpacing() < height_px <= label.height()
