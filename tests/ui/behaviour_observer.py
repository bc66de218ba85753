"""Somebody who sits before the behaviour screen, for its tests."""

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QPushButton

from tests.ui.behaviour_scene import time_ms
from ui.behaviour.timeline import TimelineView

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

    def begun(self):
        return [(one.behaviour,) for one in self.coding.draft.begun]

    def bar(self, behaviour):
        content = self.timeline._content
        return next(
            one for one in content.bars if one.occurrence and one.occurrence.behaviour == behaviour
        )

    def button(self, text):
        buttons = self.screen.findChildren(QPushButton)
        return next(one for one in buttons if one.text().replace("&", "").startswith(text))


def seated_until(observer, index):
    observer.key(Key.Key_S)
    observer.step_to(index)
    observer.key(Key.Key_S)


def dialog_of(kind):
    (found,) = [one for one in QApplication.topLevelWidgets() if isinstance(one, kind)]
    return found


def choose(observer, button, action):
    """Choose from the menu of a button."""
    menu = observer.button(button).menu()
    (chosen,) = [one for one in menu.actions() if one.text().startswith(action)]
    assert chosen.isEnabled()
    chosen.trigger()
