"""Draws every screen of the window in every language, theme and size: ``make screenshots``.

A demo session is taken first, through the same calls as in the window; then one window speaks
each language in turn, so that what is not translated at once would be seen. One more set of each
language has letters of twice the size. Pictures go to ``build/screenshots``; with ``--docs`` one
set in English goes to ``docs/screenshots``.
"""

import argparse
import os
import re
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import shiboken6
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QPushButton, QTabWidget

from adibas.pipeline.demo import run_demo
from adibas.pipeline.demo_session import take_demo_session
from adibas.pipeline.learning import read_target
from adibas.sessions import open_store
from adibas.sessions.key_wrapping import Argon2Params
from adibas.texts import LANGUAGES
from adibas.texts import translate as _
from installers.screenshot_sessions import add_sessions_to_compare
from ui.application import Application
from ui.navigation import TITLES
from ui.patients.history_list import HistoryList
from ui.preferences import PreferencesFile
from ui.widgets.help_page import HelpDock
from ui.widgets.image_view import ImageView

PROJECT = Path(__file__).parents[1]
PASSPHRASE = "four words are enough"  # noqa: S105  (of a store that is thrown away)
CHEAP = Argon2Params(iterations=1, lanes=1, memory_kib=8)
SIZES = ((1280, 800), (1920, 1080))
THEMES = ("light", "dark")
PAGED = ("comparison", "settings")
"""Screens whose pages are all drawn."""
LARGEST_LETTERS = 2.0
N_FRAMES = 10
PATIENCE_S = 120.0


def main() -> int:
    """Draw all screens; return 0."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--docs", action="store_true", help="one set in English, for the manual")
    parser.add_argument("--only", default="", help="sets whose name matches, as in es_light")
    options = parser.parse_args()
    is_for_docs = options.docs
    folder = PROJECT / ("docs/screenshots" if is_for_docs else "build/screenshots")
    app = QApplication([sys.argv[0]])
    with tempfile.TemporaryDirectory() as name:
        session_id = _make_store(Path(name))
        preferences = PreferencesFile(Path(name) / "preferences.json")
        preferences.change(language="en", theme="light", autolock_minutes=0)
        application = Application(app, preferences, Path(name) / "store")
        application.start()
        studio = _Studio(app, application)
        studio.unlock(folder, "en_light" if not is_for_docs else "")
        studio.prepare(session_id)
        for look in _DOCS if is_for_docs else _looks():
            if not re.search(options.only, look.suffix):
                continue
            preferences.change(language=look.language, theme=look.theme, font_scale=look.font_scale)
            application.window.resize(*look.size)
            for path in studio.draw(folder, look.suffix):
                sys.stdout.write(f"{path}\n")
        application.window.close()
        application.close()
        shiboken6.delete(application.window)  # before the application that it belongs to
    return 0


@dataclass(frozen=True, slots=True)
class _Look:
    """What the window looks like in one set, and the end of its files' names."""

    language: str
    theme: str
    size: tuple[int, int]
    suffix: str
    font_scale: float = 1.0


_DOCS = (_Look("en", "light", SIZES[0], ""),)


def _looks() -> Iterator[_Look]:
    for language in LANGUAGES:
        for theme in THEMES:
            for width, height in SIZES:
                suffix = f"_{language}_{theme}_{width}x{height}"
                yield _Look(language, theme, (width, height), suffix)
    for language in LANGUAGES:
        suffix = f"_{language}_light_large-letters"
        yield _Look(language, "light", SIZES[0], suffix, LARGEST_LETTERS)


def _make_store(folder: Path) -> str:
    """Take the demo session; return its id."""
    demo = run_demo(folder / "demo", _say_nothing)
    with open_store(folder / "store", PASSPHRASE, operator="M. Puig", key_params=CHEAP) as store:
        target = read_target(str(demo.colors))
        session_id = take_demo_session(store, target, N_FRAMES, _say_nothing).session_id
    add_sessions_to_compare(folder / "store", session_id, PASSPHRASE, CHEAP)
    return session_id


class _Studio:
    """Brings each screen into the state in which a user meets it."""

    def __init__(self, app: QApplication, application: Application) -> None:
        self._app = app
        self._application = application
        self._window = application.window

    def unlock(self, folder: Path, suffix: str) -> None:
        """Draw the page before the screens, and open the store."""
        self._settle()
        self._save(folder / f"unlock{'_' if suffix else ''}{suffix}.png")
        page = self._window.unlock_page
        page.findChildren(QLineEdit)[0].setText(PASSPHRASE)
        page.findChildren(QPushButton)[0].click()
        self._wait(lambda: self._application.workspace is not None)

    def prepare(self, session_id: str) -> None:
        """Choose the demo session, and learn a colour on its live picture."""
        workspace = self._application.workspace
        if workspace is None:
            raise RuntimeError("the store did not open")
        session = workspace.store.sessions.get(session_id)
        workspace.choose_patient(workspace.store.patients.get(session.patient))
        workspace.choose_session(session)
        workspace.choose_capture(session.capture_ids[0])
        self._window.show_screen("capture")
        self._wait(lambda: _sees_somebody(workspace.live.newest))
        self._window.show_screen("markers")
        self._wait(lambda: _sees_somebody(workspace.live.newest))
        picture = self._window.screen_named("markers").findChild(ImageView)
        captures = workspace.store.captures.of_session(session_id)
        for marker in captures[0].detected[:2]:
            x, y = picture.placement.to_widget(marker.u, marker.v)
            QTest.mouseClick(picture, Qt.MouseButton.LeftButton, pos=QPoint(round(x), round(y)))
            self._settle()

    def draw(self, folder: Path, suffix: str) -> Iterator[Path]:
        """Draw every screen, and every page of one that has pages."""
        for name in TITLES:
            self._show(name)
            tabs = self._window.screen_named(name).findChild(QTabWidget)
            if tabs is None or name not in PAGED:
                yield self._save(folder / f"{name}{suffix}.png")
                continue
            for index in range(tabs.count()):
                tabs.setCurrentIndex(index)
                self._settle()
                yield self._save(folder / f"{name}-{index + 1}{suffix}.png")
            tabs.setCurrentIndex(0)
        for name in ("patients", "capture", "review"):
            self._show(name)
            self._window.show_help()
            self._settle()
            yield self._save(folder / f"help-{name}{suffix}.png")
            if (dock := self._window.findChild(HelpDock)).isFloating():
                path = folder / f"help-{name}-floating{suffix}.png"
                dock.grab().save(str(path))
                yield path
        self._window.findChild(HelpDock).hide()

    def _show(self, name: str) -> None:
        workspace = self._application.workspace
        self._window.show_screen(name)
        if name == "capture" and workspace is not None:
            self._wait(lambda: _sees_somebody(workspace.live.newest))
        self._settle()
        if name == "patients":
            sessions = self._window.screen_named(name).findChild(HistoryList)
            sessions.setCurrentIndex(sessions.model().index(0, 0))
        if name == "behaviour":
            self._open_recording()

    def _open_recording(self) -> None:
        """Open the first recording of the session, with the example of a scheme in the language."""
        screen = self._window.screen_named("behaviour")
        boxes = (box for box in screen.findChildren(QComboBox) if box.isVisible())
        chooser = next(box for box in boxes if box.itemText(0) == _("Recordings of the session"))
        chooser.activated.emit(1)
        self._settle()

    def _save(self, path: Path) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._window.grab().save(str(path))
        return path

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


def _say_nothing(_done: int, _total: int) -> None:
    """Show no progress."""


if __name__ == "__main__":
    raise SystemExit(main())
