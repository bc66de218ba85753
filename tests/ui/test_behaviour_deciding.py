"""The observer decides what the program saw, takes everything back, and looks slowly."""

from dataclasses import replace

import pytest
from PySide6.QtCore import QPoint
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QComboBox, QInputDialog, QLineEdit, QPushButton
from shiboken6 import isValid

from adibas.behaviour.editing import with_detected
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
from tests.ui.test_behaviour_presenter import analysis
from ui.behaviour.screen import build_behaviour_screen
from ui.behaviour.section_dialog import SectionDialog
from ui.workspace import Workspace

WATCHED_MS = 700


@pytest.fixture
def observer(qtbot, inline_jobs, preferences, theme, tmp_path):
    workspace = Workspace(None, inline_jobs, preferences, NoSensor())
    screen = build_behaviour_screen(workspace, theme)
    screen.resize(1100, 700)
    qtbot.addWidget(screen)
    screen.show()
    screen.activateWindow()
    yield Observer(screen, qtbot, make_recording(tmp_path / "child.mcap"))
    screen.closed()


def let_the_program_see(observer, *spans):
    """Propose waves between frames."""
    found = replace(analysis(*spans).detected, name=observer.coding.draft.coding.name)
    observer.coding.edit(lambda old: with_detected(old, found))
    observer.coding.select_next_proposed()
    observer.see(spans[0][0])


def mark_a_section(observer):
    choose(observer, "Coding", "Mark a section")
    dialog = dialog_of(SectionDialog)
    observer.qtbot.waitUntil(dialog.isVisible)
    mark = next(one for one in dialog.findChildren(QPushButton) if one.text() == "&Mark")
    QTest.keyClicks(dialog.findChild(QComboBox).lineEdit(), "game")
    QTest.mouseClick(mark, LEFT)
    observer.qtbot.waitUntil(lambda: not isValid(dialog) or not dialog.isVisible())


def test_what_the_program_saw_is_decided_by_one_key_each_and_all_is_taken_back(observer):
    let_the_program_see(observer, (10, 20), (30, 40), (50, 60))
    drafts = [observer.coding.draft]
    observer.key(Key.Key_Return)
    drafts.append(observer.coding.draft)
    observer.see(30)
    observer.key(Key.Key_Delete)
    drafts.append(observer.coding.draft)
    observer.see(50)
    for index, key in ((52, Key.Key_B), (58, Key.Key_E)):
        observer.step_to(index)
        observer.key(key, CTRL)
        drafts.append(observer.coding.draft)
    observer.key(Key.Key_Return)
    drafts.append(observer.coding.draft)
    mark_a_section(observer)
    drafts.append(observer.coding.draft)
    scheme = observer.coding.draft.coding.ethogram
    observer.coding.use_ethogram(replace(scheme, name="another"))
    drafts.append(observer.coding.draft)
    assert observer.events() == [
        ("waves", time_ms(10), time_ms(20)),
        ("waves", time_ms(52), time_ms(58)),
    ]
    for draft in reversed(drafts[:-1]):
        observer.key(Key.Key_Z, CTRL)
        assert observer.coding.draft == draft
    for draft in drafts[1:]:
        observer.key(Key.Key_Z, CTRL | SHIFT)
        assert observer.coding.draft == draft


def test_the_end_of_a_detected_event_is_dragged_before_it_is_decided(observer):
    let_the_program_see(observer, (30, 50))
    timeline = observer.timeline
    timeline.verticalScrollBar().setValue(timeline.verticalScrollBar().maximum())
    bar = observer.bar("waves")
    y = timeline.middle_of(bar).y()
    here, there = (QPoint(round(timeline.scale.x_of(time_ms(index))), y) for index in (50, 70))
    view = timeline.viewport()
    QTest.mousePress(view, LEFT, NO_KEY, here)
    QTest.mouseMove(view, (here + there) / 2)
    QTest.mouseMove(view, there)
    QTest.mouseRelease(view, LEFT, NO_KEY, there)
    (one,) = observer.coding.draft.proposed
    assert one.begin_ms == time_ms(30)
    assert abs(one.end_ms - time_ms(70)) < 2 / timeline.scale.px_per_ms


def test_a_quarter_of_the_speed_leaves_no_frame_out_and_names_each_rightly(observer):
    observer.key(Key.Key_Down, CTRL)
    observer.key(Key.Key_Down, CTRL)
    observer.key(Key.Key_Space)
    QTest.qWait(WATCHED_MS)
    observer.key(Key.Key_Space)
    assert all(index == shade for index, shade in observer.shown)
    indices = [index for index, _shade in observer.shown]
    assert indices == list(range(len(indices)))
    assert 1 < len(indices) <= 2 + 0.25 * 4 * WATCHED_MS / FRAME_MS


def test_who_codes_blind_cannot_change_the_scheme_nor_open_a_coding(observer):
    seated_until(observer, 30)
    QTest.mouseClick(observer.button("Second observer"), LEFT)
    dialog = dialog_of(QInputDialog)
    observer.qtbot.waitUntil(dialog.isVisible)
    QTest.keyClicks(dialog.findChild(QLineEdit), "MP")
    QTest.keyClick(dialog.findChild(QLineEdit), Key.Key_Return)
    assert observer.timeline._content.bars == ()
    assert observer.coding.draft.coding.ethogram.is_locked
    for button, actions in (("Scheme", ("Change", "Open")), ("Coding", ("Open",))):
        menu = observer.button(button).menu()
        told = [one for one in menu.actions() if one.text().startswith(actions)]
        assert len(told) == len(actions)
        assert not any(one.isEnabled() for one in told)
