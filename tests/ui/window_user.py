"""Somebody in front of the real main window, with a mouse and a keyboard."""

import faulthandler
import sys

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QDialog,
    QFileDialog,
    QLineEdit,
    QMessageBox,
    QToolButton,
)
from shiboken6 import isValid

from adibas.texts import use_language
from ui.application import Application
from ui.preferences import PreferencesFile
from ui.recovery.dialog import RecoveryKeyDialog
from ui.theme import Theme

LEFT = Qt.MouseButton.LeftButton
NO_KEY, CTRL = Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ControlModifier
ALT, SHIFT = Qt.KeyboardModifier.AltModifier, Qt.KeyboardModifier.ShiftModifier
Key = Qt.Key
PATIENCE_MS = 60_000
"""Of a test on a busy computer; nothing waits so long that goes well."""
SECRET = "four words are enough"


def preferences_in(folder, **changes):
    """Return preferences of a test: English, no countdown, no sound, short bursts."""
    file = PreferencesFile(folder / "preferences.json")
    usual = {"language": "en", "countdown_s": 0, "burst_frames": 3, "has_sound": False}
    file.change(**(usual | changes))
    return file


@pytest.fixture
def open_window(qtbot, qapp, tmp_path):
    """Return what opens windows over the store of this test; those left open are closed."""
    users, letters = [], qapp.font()

    def open_one(folder=tmp_path, **changes):
        users.append(WindowUser(qtbot, qapp, folder, **changes))
        return users[-1]

    yield open_one
    for user in users:
        user.application.close()
        if isValid(user.window):
            user.window.close()
            user.window.deleteLater()
    use_language("en")
    qapp.setFont(letters)  # a theme begins with those that it finds
    Theme(qapp).use("light", 1.0)


class WindowUser:
    """Starts the program over a store, and does what a user does."""

    def __init__(self, qtbot, qapp, folder, **changes):
        self.qtbot, self.qapp = qtbot, qapp
        preferences = preferences_in(folder, **changes)
        self.application = Application(qapp, preferences, folder / "store")
        self.window = self.application.window
        self.window.resize(1280, 800)
        self.application.start()
        self.window.activateWindow()
        self.until(self.window.isActiveWindow)

    @property
    def workspace(self):
        return self.application.workspace

    @property
    def store(self):
        return self.workspace.store

    @property
    def screen(self):
        """The screen that is seen."""
        return self.window.screen_named(self.window.shown)

    @property
    def focus(self):
        return QApplication.focusWidget()

    def until(self, is_so):
        try:
            self.qtbot.waitUntil(lambda: bool(is_so()), timeout=PATIENCE_MS)
        except self.qtbot.TimeoutError:
            jobs = self.application.jobs.labels
            told = f"on {self.window.shown!r}, told {self.window.told!r}, still {jobs}"
            faulthandler.dump_traceback(sys.__stderr__)  # what every thread waits for
            raise AssertionError(told) from None

    def settle(self):
        """Wait until no job runs."""
        self.until(lambda: not self.application.jobs.is_busy)

    def give_new_passphrase(self, passphrase=SECRET, *, puts_key_off=True):
        page = self.window.unlock_page
        self.until(lambda: len(visible(page, QLineEdit)) == 2)
        self.keys(passphrase)
        self.key(Key.Key_Tab)
        self.keys(passphrase)
        self.key(Key.Key_Return)
        self.until(lambda: self.window.shown)
        if puts_key_off:
            self.put_recovery_key_off()

    def put_recovery_key_off(self):
        """Answer the dialog of the first start with Escape, which means later."""
        self.until(lambda: visible_dialogs(RecoveryKeyDialog))
        (dialog,) = visible_dialogs(RecoveryKeyDialog)
        QTest.keyClick(dialog, Key.Key_Escape)
        self.until(lambda: not visible_dialogs())
        self.window.activateWindow()  # what a desktop does by itself
        self.until(self.window.isActiveWindow)

    def give_passphrase(self, passphrase=SECRET):
        page = self.window.unlock_page
        self.until(lambda: len(visible(page, QLineEdit)) == 1)
        self.keys(passphrase)
        self.key(Key.Key_Return)

    def keys(self, text):
        QTest.keyClicks(self.focus, text)

    def key(self, key, modifiers=NO_KEY):
        QTest.keyClick(self.focus or self.window, key, modifiers)

    def button(self, text, parent=None):
        """Return the button that is seen with this text."""
        self.qapp.processEvents()
        found = [
            one
            for one in visible(parent or self.window, QAbstractButton)
            if one.text().replace("&", "") == text
        ]
        assert len(found) == 1, f"{len(found)} buttons {text!r}"
        return found[0]

    def click(self, text, parent=None):
        button = self.button(text, parent)
        assert button.isEnabled(), f"{text!r} cannot be pressed"
        QTest.mouseClick(button, LEFT, NO_KEY, QPoint(12, button.height() // 2))  # its box, too

    def go_to(self, name):
        """Click on the rail."""
        QTest.mouseClick(self.window.findChild(QToolButton, f"go-{name}"), LEFT)
        self.until(lambda: self.window.shown == name)

    def tab_to(self, is_wanted, most=60):
        """Press Tab until the focus is where it is wanted."""
        passed = []
        for _step in range(most):
            if self.focus is not None and is_wanted(self.focus):
                return self.focus
            passed.append(f"{type(self.focus).__name__} {describe_focus(self.focus)!r}")
            self.key(Key.Key_Tab)
        raise AssertionError(f"Tab leads nowhere but to {passed}")

    def tab_to_button(self, text):
        return self.tab_to(
            lambda one: isinstance(one, QAbstractButton) and one.text().replace("&", "") == text
        )

    def drop(self, *paths):
        """Drop files onto the window."""
        mime = QMimeData()
        mime.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
        args = (Qt.DropAction.CopyAction, mime, LEFT, NO_KEY)
        enter = QDragEnterEvent(QPoint(600, 400), *args)
        self.qapp.sendEvent(self.window, enter)
        if enter.isAccepted():
            self.qapp.sendEvent(self.window, QDropEvent(QPointF(600, 400), *args))
        return enter.isAccepted()

    def answer_file_dialog(self, path):
        """Paste a name into the dialog for files that is open, and accept it."""
        self.until(lambda: visible_dialogs(QFileDialog))
        (dialog,) = visible_dialogs(QFileDialog)
        field = dialog.findChild(QLineEdit, "fileNameEdit")
        self.until(field.hasFocus)
        QTest.keyClick(field, Key.Key_A, CTRL)
        QApplication.clipboard().setText(str(path))
        QTest.keyClick(field, Key.Key_V, CTRL)
        QTest.keyClick(field, Key.Key_Return)
        self.until(lambda: not visible_dialogs(QFileDialog))
        self.window.activateWindow()  # what a desktop does by itself
        self.until(self.window.isActiveWindow)

    def lose(self, what):
        """Close the window although this is not saved, and wait until it is gone."""
        self.window.close()
        (question,) = visible_dialogs(QMessageBox)
        assert question.informativeText() == what
        self.click("Close without saving", question)
        self.until(lambda: self.workspace is None and not self.window.isVisible())
        self.window.deleteLater()

    def close(self):
        """Close the window as its frame's button does, and wait until it is gone."""
        self.window.close()
        self.until(lambda: self.workspace is None and not self.window.isVisible())
        self.window.deleteLater()


def describe_focus(widget):
    return widget and (widget.accessibleName() or getattr(widget, "text", str)())


def visible(parent, kind):
    return [one for one in parent.findChildren(kind) if one.isVisible()]


def visible_dialogs(kind=QDialog):
    return [
        one for one in QApplication.topLevelWidgets() if isinstance(one, kind) and one.isVisible()
    ]


def at(image, u, v):
    """Return where a pixel of the picture lies in its widget."""
    x, y = image.placement.to_widget(u, v)
    return QPoint(round(x), round(y))


def drag(image, start, end, modifiers=NO_KEY):
    """Drag with the left button from one pixel of the picture to another."""
    here, there = at(image, *start), at(image, *end)
    QTest.mousePress(image, LEFT, modifiers, here)
    QTest.mouseMove(image, (here + there) / 2)
    QTest.mouseMove(image, there)
    QTest.mouseRelease(image, LEFT, modifiers, there)
