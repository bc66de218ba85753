"""The window locks itself when nobody touches anything, also over a night's sleep."""

import pytest
from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLineEdit

from ui.inactivity import MS_PER_S, S_PER_MINUTE, InactivityWatch


@pytest.fixture
def now():
    return [1000.0]


@pytest.fixture
def locked():
    return []


@pytest.fixture
def watch(qapp, now, locked):
    watch = InactivityWatch(lambda: locked.append(now[0]), None, lambda: now[0])
    qapp.installEventFilter(watch)
    yield watch
    qapp.removeEventFilter(watch)
    watch.set_minutes(0)


@pytest.fixture
def field(qtbot):
    field = QLineEdit()
    qtbot.addWidget(field)
    field.show()
    return field


def test_it_locks_after_the_time(watch, qtbot, locked):
    watch.set_minutes(1)
    assert watch._timer.interval() == S_PER_MINUTE * MS_PER_S
    watch._timer.setInterval(20)
    qtbot.waitUntil(lambda: bool(locked))
    assert not watch._timer.isActive()


def test_every_touch_begins_the_time_anew(watch, field, now, locked):
    watch.set_minutes(1)
    for letter in "abc":
        now[0] += 0.9 * S_PER_MINUTE
        QTest.keyClicks(field, letter)
    QTest.mouseClick(field, Qt.MouseButton.LeftButton)
    assert field.text() == "abc"
    assert not locked


def test_the_first_touch_after_a_long_sleep_locks_and_does_nothing_else(watch, field, now, locked):
    watch.set_minutes(1)
    now[0] += 10 * S_PER_MINUTE
    QTest.keyClick(field, Qt.Key.Key_X)
    assert len(locked) == 1
    assert field.text() == ""


def test_never_means_never(watch, field, now, locked):
    watch.set_minutes(1)
    watch.set_minutes(0)
    now[0] += 1e6
    QTest.keyClicks(field, "x")
    assert not locked
    assert not watch._timer.isActive()


def test_painting_is_no_touch(watch, now, locked):
    watch.set_minutes(1)
    now[0] += 0.9 * S_PER_MINUTE
    assert not watch.eventFilter(QObject(), QEvent(QEvent.Type.Paint))
    assert watch._touched_s == 1000.0
    assert not locked
