"""Brings the window into the states in which a user meets it, for pictures of every screen."""

import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import shiboken6
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QPixmap
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QComboBox,
    QLabel,
    QLineEdit,
    QListWidget,
    QPushButton,
    QTabWidget,
)

from adibas.pipeline.demo import run_demo
from adibas.pipeline.demo_session import take_demo_session
from adibas.pipeline.learning import read_target
from adibas.sessions import open_store
from adibas.sessions.key_wrapping import Argon2Params
from adibas.texts import LANGUAGES, spoken_language
from adibas.texts import translate as _
from installers.screenshot_sessions import add_sessions_to_compare
from ui.application import Application
from ui.navigation import TITLES
from ui.patients.history_list import HistoryList
from ui.preferences import PreferencesFile
from ui.widgets.help_page import HelpDock
from ui.widgets.image_view import ImageView

PASSPHRASE = "four words are enough"  # noqa: S105  (of a store that is thrown away)
CHEAP = Argon2Params(iterations=1, lanes=1, memory_kib=8)
SIZE = (1280, 800)
PAGED = ("comparison", "settings")
"""Screens whose pages are all drawn."""
HELPED = ("patients", "capture", "review")
"""Screens that are drawn with their help, too."""
N_FRAMES = 10
N_BOARDS = 3
"""Pictures of the board that are taken before the calibration is drawn."""
N_LAYOUTS = 5
"""More than lie around any words that change by themselves."""
PATIENCE_S = 300.0
USERS_FOLDER = "/home/puig/adibas"
"""Shown in place of the folder that is thrown away, which says nothing to a reader."""


@contextmanager
def opened_studio() -> Iterator["Studio"]:
    """Open the window over a demo session, in a store that is thrown away."""
    app = QApplication([sys.argv[0]])
    with tempfile.TemporaryDirectory() as name:
        session_id = _make_store(Path(name))
        preferences = PreferencesFile(Path(name) / "preferences.json")
        preferences.change(language="en", theme="light", autolock_minutes=0)
        application = Application(app, preferences, Path(name) / "store")
        application.start()
        yield Studio(app, application, preferences, session_id, name)
        application.window.close()
        application.close()
        shiboken6.delete(application.window)  # before the application that it belongs to


def _make_store(folder: Path) -> str:
    """Take the demo session; return its id."""
    demo = run_demo(folder / "demo", _say_nothing)
    with open_store(folder / "store", PASSPHRASE, operator="M. Puig", key_params=CHEAP) as store:
        target = read_target(str(demo.colors))
        session_id = take_demo_session(store, target, N_FRAMES, _say_nothing).session_id
    add_sessions_to_compare(folder / "store", session_id, PASSPHRASE, CHEAP)
    return session_id


class Studio:
    """Brings each screen into the state in which a user meets it."""

    def __init__(
        self,
        app: QApplication,
        application: Application,
        preferences: PreferencesFile,
        session_id: str,
        folder: str,
    ) -> None:
        self._app = app
        self._application = application
        self._preferences = preferences
        self._session_id = session_id
        self._window = application.window
        self._folder = folder

    def unlock(self) -> QPixmap:
        """Return a picture of the page before the screens, and open the store."""
        self._settle()
        picture = self._window.grab()
        page = self._window.unlock_page
        field = next(one for one in page.findChildren(QLineEdit) if one.isVisible())
        field.setText(PASSPHRASE)
        page.findChildren(QPushButton)[0].click()
        self._wait(lambda: self._application.workspace is not None)
        self._prepare()
        return picture

    def wear(
        self,
        language: str,
        theme: str = "light",
        font_scale: float = 1.0,
        size: tuple[int, int] = SIZE,
    ) -> None:
        """Let the window look so from now on."""
        self._preferences.change(language=language, theme=theme, font_scale=font_scale)
        self._window.resize(*size)

    def _prepare(self) -> None:
        """Choose the demo session, and learn a colour on its live picture."""
        workspace = self._application.workspace
        if workspace is None:
            raise RuntimeError("the store did not open")
        session = workspace.store.sessions.get(self._session_id)
        workspace.choose_patient(workspace.store.patients.get(session.patient))
        workspace.choose_session(session)
        workspace.choose_capture(session.capture_ids[0])
        self._window.show_screen("capture")
        self._wait(lambda: _sees_somebody(workspace.live.newest))
        self._window.show_screen("markers")
        self._wait(lambda: _sees_somebody(workspace.live.newest))
        picture = self._window.screen_named("markers").findChild(ImageView)
        captures = workspace.store.captures.of_session(self._session_id)
        for marker in captures[0].detected[:2]:
            x, y = picture.placement.to_widget(marker.u, marker.v)
            QTest.mouseClick(picture, Qt.MouseButton.LeftButton, pos=QPoint(round(x), round(y)))
            self._settle()

    def pictures(self) -> Iterator[tuple[str, QPixmap]]:
        """Yield every screen, and every page of one that has pages, by its name."""
        for name in TITLES:
            self._show(name)
            tabs = self._window.screen_named(name).findChild(QTabWidget)
            if tabs is None or name not in PAGED:
                yield name, self._grab()
                continue
            for index in range(tabs.count()):
                tabs.setCurrentIndex(index)
                self._settle()
                yield f"{name}-{index + 1}", self._grab()
            tabs.setCurrentIndex(0)
        dock = self._window.findChild(HelpDock)
        for name in HELPED:
            self._show(name)
            self._window.show_help()
            self._settle()
            yield f"help-{name}", self._grab()
            if dock.isFloating():
                yield f"help-{name}-floating", dock.grab()
        dock.hide()

    def _grab(self) -> QPixmap:
        """Return a picture of the window, its folders as on a user's computer.

        What a frame has just said is laid out first. Qt does so one level of nested layouts at a
        time, so that on a display the next paint is right and a picture would keep the one before.
        """
        told = {
            label: label.text()
            for label in self._window.findChildren(QLabel)
            if self._folder in label.text()
        }
        for label, text in told.items():
            label.setText(text.replace(self._folder, USERS_FOLDER))
        for _level in range(N_LAYOUTS):
            QApplication.sendPostedEvents()
        picture = self._window.grab()
        for label, text in told.items():
            label.setText(text)
        return picture

    def _show(self, name: str) -> None:
        workspace = self._application.workspace
        self._window.show_screen(name)
        if name == "capture" and workspace is not None:
            self._wait(lambda: _sees_somebody(workspace.live.newest))
        self._settle()
        if name == "calibration" and workspace is not None:
            taken = self._window.screen_named(name).findChild(QListWidget)
            self._wait(lambda: taken.count() >= N_BOARDS and _sees_board(workspace.live.newest))
            self._settle()
        if name == "patients":
            sessions = self._window.screen_named(name).findChild(HistoryList)
            sessions.setCurrentIndex(sessions.model().index(0, 0))
        if name == "behaviour":
            self._open_recording()

    def _open_recording(self) -> None:
        """Open a recording of the session, with the example of a scheme in the language.

        Each language has a recording of its own: a scheme stays with what it was opened for.
        """
        screen = self._window.screen_named("behaviour")
        boxes = (box for box in screen.findChildren(QComboBox) if box.isVisible())
        chooser = next(box for box in boxes if box.itemText(0) == _("Recordings of the session"))
        chooser.activated.emit(1 + list(LANGUAGES).index(spoken_language()))
        self._settle()

    def _settle(self) -> None:
        """Let jobs and repaints come to rest."""
        self._wait(lambda: not self._application.jobs.is_busy)
        for _round in range(5):
            self._app.processEvents()
            time.sleep(0.02)

    def _wait(self, condition: Callable[[], bool]) -> None:
        end_s = time.monotonic() + PATIENCE_S
        while not condition():
            if time.monotonic() > end_s:
                raise TimeoutError("the window does not come to rest")
            self._app.processEvents()
            time.sleep(0.01)


def _sees_somebody(frame: object) -> bool:
    return getattr(frame, "outline", None) is not None


def _sees_board(frame: object) -> bool:
    search = getattr(frame, "board", None)
    return getattr(search, "corners", None) is not None


def _say_nothing(_done: int, _total: int) -> None:
    """Show no progress."""
