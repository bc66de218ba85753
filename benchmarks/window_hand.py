"""Somebody in front of the real window: a hand that takes its time, and counts what it does."""

import time
from collections.abc import Callable
from typing import TypeVar

from PySide6.QtCore import QEventLoop, QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QFileDialog, QWidget

from ui.application import Application
from ui.widgets.image_view import ImageView

ACTION_S = 1.0
"""To look and to move the hand, before each click, key or field."""
LETTER_S = 0.2
"""Of somebody who types 60 words a minute."""
REPEAT_S = 0.04
"""Between the steps of a key that is held down."""
PATIENCE_S = 240.0
POLL_MS = 20
NO_KEY = Qt.KeyboardModifier.NoModifier
Seen = TypeVar("Seen", bound=QWidget)


class Hand:
    """Presses, types and waits as a person does.

    Attributes
    ----------
    n_actions : int
        Clicks, keys (a key that is held down once) and fields that were typed into.
    waited_s : float
        How long nothing could be done because the program was not ready.
    """

    def __init__(self, app: QApplication, application: Application) -> None:
        self._app = app
        self.application = application
        self.window = application.window
        self.n_actions = 0
        self.waited_s = 0.0

    def wait(self, what: str, is_so: Callable[[], object]) -> None:
        """Wait until something is so; this is the program's time."""
        start_s = time.perf_counter()
        while not is_so():
            if time.perf_counter() - start_s > PATIENCE_S:
                raise TimeoutError(f"waiting for {what}; told: {self.window.told!r}")
            self._live_s(POLL_MS / 1e3)
        self.waited_s += time.perf_counter() - start_s

    def press(self, text: str, parent: QWidget | None = None) -> None:
        """Click on a button, as soon as it can be pressed."""
        button = self._button(text, parent)
        self._think()
        self.click(button)

    def click(self, widget: QWidget, at: QPoint | None = None) -> None:
        """Click without thinking first."""
        place = at or QPoint(12, widget.height() // 2)
        QTest.mouseClick(widget, Qt.MouseButton.LeftButton, NO_KEY, place)

    def go_to(self, screen: str) -> None:
        """Click on the rail."""
        self._think()
        self.click(self.seen(QAbstractButton, f"go-{screen}"))
        self.wait(screen, lambda: self.window.shown == screen)

    def point(self, picture: ImageView, u: float, v: float) -> None:
        """Click on a pixel of a picture."""
        self._think()
        self.click(picture, _place(picture, u, v))

    def drag(
        self, picture: ImageView, start: tuple[float, float], end: tuple[float, float]
    ) -> None:
        """Drag from a pixel of a picture to another one."""
        self._think()
        button, here, there = (
            Qt.MouseButton.LeftButton,
            *(_place(picture, *p) for p in (start, end)),
        )
        QTest.mousePress(picture, button, NO_KEY, here)
        QTest.mouseMove(picture, (here + there) / 2)
        QTest.mouseMove(picture, there)
        self._live_s(ACTION_S)
        QTest.mouseRelease(picture, button, NO_KEY, there)

    def write(self, text: str) -> None:
        """Type a text where the focus is."""
        self._think()
        for letter in text:
            QTest.keyClicks(self._focus(), letter)
            self._live_s(LETTER_S)

    def key(self, key: Qt.Key, modifiers: Qt.KeyboardModifier = NO_KEY) -> None:
        """Press a key."""
        self._think()
        QTest.keyClick(self._focus(), key, modifiers)

    def hold(self, key: Qt.Key, n_steps: int, modifiers: Qt.KeyboardModifier = NO_KEY) -> None:
        """Hold a key down for so many steps."""
        if n_steps > 0:
            self._think()
        for _ in range(n_steps):
            QTest.keyClick(self._focus(), key, modifiers)
            self._live_s(REPEAT_S)

    def alt(self, button_text: str, parent: QWidget | None = None) -> None:
        """Press the underlined letter of a button with Alt, as soon as it can be pressed."""
        button = self._button(button_text, parent)
        letter = button.text()[button.text().index("&") + 1].upper()
        self.key(Qt.Key[f"Key_{letter}"], Qt.KeyboardModifier.AltModifier)

    def tab_to(self, is_wanted: Callable[[QWidget], bool], most: int = 60) -> None:
        """Hold Tab until the focus is where it is wanted."""
        self._think()
        for _ in range(most):
            if is_wanted(self._focus()):
                return
            QTest.keyClick(self._focus(), Qt.Key.Key_Tab)
            self._live_s(REPEAT_S)
        raise LookupError("Tab does not lead there")

    def take_proposed_folder(self, *, has_mouse: bool) -> None:
        """Accept the folder that the open dialog for files proposes."""
        self.wait("the dialog", _open_dialog)
        (self.press if has_mouse else self.alt)("Choose", _open_dialog())
        self.wait("the end of the dialog", lambda: _open_dialog() is None)
        self.window.activateWindow()  # what a desktop does by itself

    def seen(self, kind: type[Seen], name: str = "", parent: QWidget | None = None) -> Seen:
        """Return the first widget of a kind that is seen, of this object's name if one is given."""
        for one in (parent or self.window).findChildren(kind):
            if one.isVisible() and name in ("", one.objectName()):
                return one
        raise LookupError(f"no {kind.__name__} {name} is seen")

    def _button(self, text: str, parent: QWidget | None) -> QAbstractButton:
        """Wait for a button that can be pressed: some come a moment after the last click."""

        def found() -> list[QAbstractButton]:
            return [
                one
                for one in (parent or self.window).findChildren(QAbstractButton)
                if one.isVisible() and one.isEnabled() and one.text().replace("&", "") == text
            ]

        self.wait(text, found)
        (button,) = found()
        return button

    def _focus(self) -> QWidget:
        return QApplication.focusWidget() or self.window

    def look(self) -> None:
        """Look at something."""
        self._think()

    def _think(self) -> None:
        self.n_actions += 1
        self._live_s(ACTION_S)

    def _live_s(self, seconds: float) -> None:
        """Let the window live meanwhile."""
        end_s = time.perf_counter() + seconds
        while (left_s := end_s - time.perf_counter()) > 0:
            flags = QEventLoop.ProcessEventsFlag.AllEvents
            self._app.processEvents(flags, max(1, round(1e3 * left_s)))
            time.sleep(min(left_s, POLL_MS / 4e3))


def _place(picture: ImageView, u: float, v: float) -> QPoint:
    x, y = picture.placement.to_widget(u, v)
    return QPoint(round(x), round(y))


def _open_dialog() -> QFileDialog | None:
    seen = (one for one in QApplication.topLevelWidgets() if isinstance(one, QFileDialog))
    return next((one for one in seen if one.isVisible()), None)
