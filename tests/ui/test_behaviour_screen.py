"""The behaviour screen under mouse and keyboard, over a recording on the disk."""

import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QHelpEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QCheckBox,
    QComboBox,
    QInputDialog,
    QLabel,
    QLineEdit,
    QPushButton,
    QTableWidget,
    QTabWidget,
    QToolTip,
)
from shiboken6 import isValid

from adibas.data.coding import Occurrence
from adibas.recordings.codings import read_codings
from adibas.texts import LANGUAGES, speaking
from tests.ui.behaviour_observer import (
    CTRL,
    LEFT,
    NO_KEY,
    SHIFT,
    Key,
    Observer,
    choose,
    dialog_of,
    seated_until,
)
from tests.ui.behaviour_scene import FRAME_MS, make_recording, time_ms
from tests.ui.conftest import NoSensor
from tests.ui.test_mnemonics import assert_each_letter_is_one_control
from ui.behaviour.scheme_dialog import SchemeDialog
from ui.behaviour.screen import build_behaviour_screen
from ui.behaviour.section_dialog import SectionDialog
from ui.behaviour.transport import Transport
from ui.behaviour.video_view import VideoView
from ui.workspace import Workspace


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


def test_the_scheme_is_changed_in_a_dialog(observer):
    choose(observer, "Scheme", "Change the coding scheme")
    dialog = dialog_of(SchemeDialog)
    dialog.activateWindow()
    observer.qtbot.waitUntil(dialog.isActiveWindow)
    add, ok = (
        next(one for one in dialog.findChildren(QPushButton) if one.text() == text)
        for text in ("&Add", "&Use this scheme")
    )
    QTest.mouseClick(add, LEFT)
    QTest.keyClicks(QApplication.focusWidget(), "yawns")
    QTest.keyClick(QApplication.focusWidget(), Key.Key_Tab)
    QTest.keyClick(QApplication.focusWidget(), Key.Key_Down)
    QTest.keyClick(QApplication.focusWidget(), Key.Key_Tab)
    QTest.keyClicks(QApplication.focusWidget(), "s")
    QTest.mouseClick(ok, LEFT)
    (wrong,) = [one for one in dialog.findChildren(QLabel) if one.property("kind") == "bad"]
    assert "s stands twice" in wrong.text()
    assert wrong.isVisible()
    key = dialog._texts["key"]
    key.setFocus()
    key.selectAll()
    QTest.keyClicks(key, "y")
    QTest.mouseClick(ok, LEFT)
    observer.qtbot.waitUntil(lambda: not isValid(dialog) or not dialog.isVisible())
    assert observer.button("yawns").text() == "yawns  [y]"
    observer.key(Key.Key_Y)
    assert [name for name, *_times in observer.events() or observer.begun()] == ["yawns"]


def test_a_behaviour_is_removed_in_the_dialog(observer):
    choose(observer, "Scheme", "Change the coding scheme")
    dialog = dialog_of(SchemeDialog)
    observer.qtbot.waitUntil(dialog.isVisible)
    buttons = {one.text(): one for one in dialog.findChildren(QPushButton)}
    for _behaviour in range(10):
        QTest.mouseClick(buttons["&Remove"], LEFT)
    assert not buttons["&Remove"].isEnabled()
    QTest.mouseClick(buttons["&Add"], LEFT)
    QTest.mouseClick(buttons["&Use this scheme"], LEFT)
    assert [one.name for one in observer.coding.draft.coding.ethogram.behaviours] == [
        "new behaviour"
    ]


def test_a_section_is_marked_and_removed_in_a_dialog(observer):
    observer.step_to(30)
    choose(observer, "Coding", "Mark a section")
    dialog = dialog_of(SectionDialog)
    observer.qtbot.waitUntil(dialog.isVisible)
    mark = next(one for one in dialog.findChildren(QPushButton) if one.text() == "&Mark")
    assert not mark.isEnabled()
    QTest.keyClicks(dialog.findChild(QComboBox).lineEdit(), "game")
    QTest.mouseClick(mark, LEFT)
    (section,) = observer.coding.draft.coding.sections
    assert (section.name, section.begin_ms, section.end_ms) == ("game", time_ms(30), time_ms(89))
    observer.qtbot.waitUntil(lambda: not isValid(dialog) or not dialog.isVisible())
    QApplication.sendPostedEvents(None, 52)
    choose(observer, "Coding", "Mark a section")
    dialog = next(
        one
        for one in QApplication.topLevelWidgets()
        if isinstance(one, SectionDialog) and one.isVisible()
    )
    QTest.mouseClick(
        next(one for one in dialog.findChildren(QPushButton) if one.text() == "&Remove"), LEFT
    )
    assert observer.coding.draft.coding.sections == ()


def test_a_second_observer_codes_and_both_are_compared(observer):
    seated_until(observer, 30)
    QTest.mouseClick(observer.button("Second observer"), LEFT)
    dialog = dialog_of(QInputDialog)
    observer.qtbot.waitUntil(dialog.isVisible)
    QTest.keyClicks(dialog.findChild(QLineEdit), "MP")
    QTest.keyClick(dialog.findChild(QLineEdit), Key.Key_Return)
    assert observer.coding.is_blind
    assert not observer.button("Find").isEnabled()
    observer.step_to(0)
    seated_until(observer, 60)
    QTest.mouseClick(observer.button("End the second"), LEFT)
    assert observer.events() == [("seated", time_ms(0), time_ms(30))]
    pages = observer.screen.findChild(QTabWidget)
    pages.setCurrentIndex(2)
    table = pages.currentWidget().findChild(QTableWidget)
    assert table.item(0, 0).text() == "Kappa by units of time (Cohen)"
    observer.screen.grab()


def test_counts_are_read_in_a_table(observer):
    seated_until(observer, 30)
    pages = observer.screen.findChild(QTabWidget)
    pages.setCurrentIndex(1)
    table = pages.currentWidget().findChild(QTableWidget)
    titles = [table.horizontalHeaderItem(n).text() for n in range(table.columnCount())]
    assert table.item(0, titles.index("Total [s]")).text() == "0.99"
    kinds = pages.currentWidget().findChild(QComboBox)
    kinds.setCurrentIndex(3)
    kinds.activated.emit(3)
    assert table.rowCount() == 1
    table.selectRow(0)
    observer.coding.undo()
    observer.coding.undo()
    assert table.rowCount() == 0


@pytest.mark.parametrize("language", LANGUAGES)
def test_each_letter_goes_to_one_control_of_the_open_screen(observer, language):
    seated_until(observer, 30)
    with speaking(language):
        observer.screen.retranslate()
        observer.key(Key.Key_Left, CTRL)
        pages = observer.screen.findChild(QTabWidget)
        for index in range(pages.count()):
            pages.setCurrentIndex(index)
            assert_each_letter_is_one_control(observer.screen)


def test_the_timeline_tells_what_is_under_the_mouse_and_follows_the_wheel(observer):
    seated_until(observer, 30)
    timeline = observer.timeline
    view, place = timeline.viewport(), timeline.middle_of(observer.bar("seated"))
    tip = QHelpEvent(QEvent.Type.ToolTip, place, view.mapToGlobal(place))
    QApplication.sendEvent(view, tip)
    observer.qtbot.waitUntil(lambda: "0:00.990" in QToolTip.text())
    QToolTip.hideText()
    before = timeline.scale
    for modifiers in (CTRL, SHIFT, NO_KEY):
        wheel = QWheelEvent(
            QPointF(place),
            QPointF(view.mapToGlobal(place)),
            QPoint(0, 120),
            QPoint(0, 120),
            Qt.MouseButton.NoButton,
            modifiers,
            Qt.ScrollPhase.NoScrollPhase,
            False,
        )
        QApplication.sendEvent(view, wheel)
    assert timeline.scale.to_ms - timeline.scale.from_ms < before.to_ms - before.from_ms


@pytest.mark.parametrize("edge", ["begin", "point"])
def test_a_begin_and_a_point_are_dragged(observer, edge):
    observer.step_to(30)
    observer.key(Key.Key_R if edge == "point" else Key.Key_S)
    if edge == "begin":
        observer.step_to(60)
        observer.key(Key.Key_S)
    bar = observer.bar("raises hand" if edge == "point" else "seated")
    timeline, view = observer.timeline, observer.timeline.viewport()
    timeline.verticalScrollBar().setValue(0)
    if edge == "point":
        timeline.verticalScrollBar().setValue(timeline.verticalScrollBar().maximum())
    y = timeline.middle_of(bar).y()
    here, there = (QPoint(round(timeline.scale.x_of(time_ms(index))), y) for index in (30, 15))
    QTest.mouseMove(view, here)
    QTest.mousePress(view, LEFT, NO_KEY, here)
    QTest.mouseMove(view, there)
    observer.screen.grab()
    QTest.mouseRelease(view, LEFT, NO_KEY, there)
    ((_name, begin_ms, end_ms),) = observer.events()
    assert abs(begin_ms - time_ms(15)) < 2 / timeline.scale.px_per_ms
    assert end_ms == (begin_ms if edge == "point" else time_ms(60))
