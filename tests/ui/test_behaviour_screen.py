"""The behaviour screen under mouse and keyboard, over a recording on the disk."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QCheckBox, QComboBox, QLineEdit, QPushButton

from adibas.data.coding import Occurrence
from adibas.recordings.codings import read_codings
from tests.ui.behaviour_scene import FRAME_MS, make_recording, time_ms
from tests.ui.conftest import NoSensor
from ui.behaviour.screen import build_behaviour_screen
from ui.behaviour.timeline import TimelineView
from ui.behaviour.transport import Transport
from ui.behaviour.video_view import VideoView
from ui.workspace import Workspace

LEFT = Qt.MouseButton.LeftButton
SHIFT, CTRL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier
NO_KEY = Qt.KeyboardModifier.NoModifier
Key = Qt.Key


class Observer:
    """Somebody who codes."""

    def __init__(self, screen, qtbot, recording):
        self.screen, self.qtbot, self.recording = screen, qtbot, recording
        self.shown = []
        show = screen.show_frame

        def note(picture, position):
            show(picture, position)
            self.shown.append((position.index, int(np.ravel(picture)[0])))

        screen.show_frame = note
        screen.entered()
        screen.open_file(recording)
        self.see(0)

    @property
    def coding(self):
        return self.screen._presenter.coding

    @property
    def timeline(self):
        return self.screen.findChild(TimelineView)

    def see(self, index):
        self.qtbot.waitUntil(lambda: [one for one, _shade in self.shown[-1:]] == [index])

    def key(self, key, modifiers=NO_KEY):
        QTest.keyClick(self.timeline, key, modifiers)

    def step_to(self, index):
        self.coding._go_to(time_ms(index))
        self.see(index)

    def events(self):
        return [
            (one.behaviour, one.begin_ms, one.end_ms)
            for one in self.coding.draft.coding.occurrences
        ]

    def bar(self, behaviour):
        content = self.timeline._content
        return next(
            one for one in content.bars if one.occurrence and one.occurrence.behaviour == behaviour
        )

    def button(self, text):
        buttons = self.screen.findChildren(QPushButton)
        return next(one for one in buttons if one.text().replace("&", "").startswith(text))


@pytest.fixture
def workspace(inline_jobs, preferences):
    """What screens share, without a store and a sensor."""
    return Workspace(None, inline_jobs, preferences, NoSensor())


@pytest.fixture
def observer(qtbot, workspace, theme, tmp_path):
    screen = build_behaviour_screen(workspace, theme)
    screen.resize(1100, 700)
    qtbot.addWidget(screen)
    screen.show()
    screen.activateWindow()
    yield Observer(screen, qtbot, make_recording(tmp_path / "child.mcap"))
    screen.closed()


def test_every_step_shows_the_frame_that_it_names(observer):
    observer.key(Key.Key_Right)
    observer.see(1)
    observer.key(Key.Key_Right, SHIFT)
    observer.see(1 + 1000 // FRAME_MS)
    observer.key(Key.Key_End)
    observer.see(89)
    observer.key(Key.Key_Left)
    observer.see(88)
    observer.key(Key.Key_Home)
    observer.see(0)
    assert all(index == shade for index, shade in observer.shown)


def test_a_running_video_shows_the_frames_that_it_names(observer):
    observer.key(Key.Key_Up, CTRL)
    observer.key(Key.Key_Up, CTRL)
    observer.key(Key.Key_Space)
    observer.see(89)
    observer.qtbot.waitUntil(lambda: observer.button("Play").isVisible())
    indices = [index for index, _shade in observer.shown]
    assert indices == sorted(indices)
    assert all(index == shade for index, shade in observer.shown)


def test_keys_code_at_the_frame_that_is_seen(observer):
    observer.key(Key.Key_S)
    observer.step_to(10)
    observer.key(Key.Key_L)
    observer.key(Key.Key_P)
    observer.step_to(20)
    observer.key(Key.Key_L)
    assert observer.events() == [
        ("seated", time_ms(0), time_ms(10)),
        ("changes posture", time_ms(10), time_ms(10)),
        ("leaves seat", time_ms(10), time_ms(20)),
    ]


def test_a_held_key_lasts_until_it_is_let_go(observer):
    QTest.mouseClick(observer.screen.findChild(QCheckBox), LEFT, pos=QPoint(10, 10))
    QTest.keyPress(observer.timeline, Key.Key_H)
    observer.step_to(5)
    QTest.keyRelease(observer.timeline, Key.Key_H)
    assert observer.events() == [("fidgets with hands", time_ms(0), time_ms(5))]


def test_the_mouse_codes_with_buttons(observer):
    QTest.mouseClick(observer.button("seated"), LEFT)
    assert observer.button("seated").isChecked()
    observer.step_to(4)
    QTest.mouseClick(observer.button("seated"), LEFT)
    assert not observer.button("seated").isChecked()
    assert observer.events() == [("seated", time_ms(0), time_ms(4))]


def seated_until(observer, index):
    observer.key(Key.Key_S)
    observer.step_to(index)
    observer.key(Key.Key_S)


def test_the_end_of_an_event_is_dragged_and_taken_back(observer):
    seated_until(observer, 30)
    bar, timeline = observer.bar("seated"), observer.timeline
    place = timeline.middle_of(bar)
    edge = QPoint(round(timeline.scale.x_of(bar.end_ms)), place.y())
    to = QPoint(round(timeline.scale.x_of(time_ms(60))), place.y())
    view = timeline.viewport()
    QTest.mousePress(view, LEFT, NO_KEY, edge)
    QTest.mouseMove(view, (edge + to) / 2)
    QTest.mouseMove(view, to)
    QTest.mouseRelease(view, LEFT, NO_KEY, to)
    ((_name, begin_ms, end_ms),) = observer.events()
    assert begin_ms == time_ms(0)
    assert abs(end_ms - time_ms(60)) < 2 / timeline.scale.px_per_ms
    observer.key(Key.Key_Z, CTRL)
    assert observer.events() == [("seated", time_ms(0), time_ms(30))]
    observer.key(Key.Key_Z, CTRL | SHIFT)
    assert observer.events() == [("seated", begin_ms, end_ms)]


def test_a_chosen_event_is_set_by_keys_and_deleted(observer):
    seated_until(observer, 30)
    view = observer.timeline.viewport()
    QTest.mouseClick(view, LEFT, NO_KEY, observer.timeline.middle_of(observer.bar("seated")))
    observer.step_to(5)
    observer.key(Key.Key_B, CTRL)
    observer.step_to(40)
    observer.key(Key.Key_E, CTRL)
    assert observer.events() == [("seated", time_ms(5), time_ms(40))]
    observer.key(Key.Key_Delete)
    assert observer.events() == []


def test_modifiers_and_comments_are_told_at_the_right(observer):
    observer.key(Key.Key_H)
    observer.step_to(9)
    observer.key(Key.Key_H)
    observer.key(Key.Key_Left, CTRL)
    (with_what,) = [
        one for one in observer.screen.findChildren(QComboBox) if one.accessibleName() == "with"
    ]
    with_what.setCurrentIndex(with_what.findData("clothes"))
    with_what.activated.emit(with_what.currentIndex())
    comment = observer.screen.findChild(QLineEdit, "comment")
    comment.setFocus()
    QTest.keyClicks(comment, "sleeve")
    QTest.keyClick(comment, Key.Key_Return)
    (one,) = observer.coding.draft.coding.occurrences
    assert (one.modifiers, one.comment) == (("clothes",), "sleeve")


def test_what_was_coded_is_beside_the_recording_at_once(observer):
    seated_until(observer, 30)
    observer.key(Key.Key_F)
    observer.screen._presenter._keeper.flush()
    (coding,) = read_codings(observer.recording.with_name("child.coding.csv"))
    assert coding.occurrences == (
        Occurrence("seated", time_ms(0), time_ms(30), "child"),
        Occurrence("fidgets with feet", time_ms(30), time_ms(30), "child"),
    )


def test_another_day_the_coding_goes_on(observer, qtbot, workspace, theme):
    seated_until(observer, 30)
    observer.screen.left()
    later = build_behaviour_screen(workspace, theme)
    qtbot.addWidget(later)
    later.show()
    again = Observer(later, qtbot, observer.recording)
    assert again.events() == [("seated", time_ms(0), time_ms(30))]
    later.closed()


def test_the_timeline_zooms_and_shows_a_time_that_is_clicked(observer):
    timeline = observer.timeline
    span = timeline.scale.to_ms - timeline.scale.from_ms
    observer.key(Key.Key_Plus, CTRL)
    assert timeline.scale.to_ms - timeline.scale.from_ms < span
    observer.key(Key.Key_0, CTRL)
    assert timeline.scale.to_ms - timeline.scale.from_ms == span
    place = QPoint(round(timeline.scale.x_of(time_ms(45))) + 1, 5)
    QTest.mouseClick(timeline.viewport(), LEFT, NO_KEY, place)
    observer.see(45)


def test_depth_is_shown_where_there_is_no_colour(qtbot, workspace, theme, tmp_path):
    screen = build_behaviour_screen(workspace, theme)
    qtbot.addWidget(screen)
    observer = Observer(screen, qtbot, make_recording(tmp_path / "d.mcap", 3, color=False))
    assert screen.findChild(VideoView).grab().size().width() > 0
    assert observer.shown[0] == (0, 1)
    screen.closed()


def test_the_speed_is_chosen_from_a_list(observer):
    chooser = observer.screen.findChild(Transport).findChild(QComboBox)
    chooser.setFocus()
    QTest.keyClick(chooser, Key.Key_Home)
    chooser.activated.emit(0)
    assert observer.screen._presenter._playing.speed == 0.25
    assert QApplication.focusWidget() is observer.timeline
