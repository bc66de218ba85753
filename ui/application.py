"""Puts the program together: Qt, theme, store, screens; and takes it apart again."""

import logging
import sys
from pathlib import Path

from PySide6.QtCore import QLibraryInfo, QLocale, QTranslator
from PySide6.QtWidgets import QApplication

from adibas.data.patients import Patient
from adibas.errors import AdibasError
from adibas.pipeline.demo_session import demo_patient
from adibas.sessions import SessionStore, default_store_folder
from adibas.texts import use_language
from ui.crash import install_crash_report
from ui.inactivity import InactivityWatch
from ui.jobs import JobRunner
from ui.live_source import QtLiveSource
from ui.preferences import Preferences, PreferencesFile
from ui.screens import build_screens
from ui.theme import Theme
from ui.unlock_presenter import UnlockPresenter
from ui.window import MainWindow
from ui.workspace import Workspace

logger = logging.getLogger(__name__)

BUSY_MINUTES = 1
"""So much later locking is tried again while something runs."""


class Application:
    """One window over one store.

    Parameters
    ----------
    app : QApplication
        Made by the caller: there is one a process.
    preferences : PreferencesFile
        Of this user.
    store_folder : Path or None
        None: as the preferences say, or the usual one.
    """

    def __init__(
        self, app: QApplication, preferences: PreferencesFile, store_folder: Path | None = None
    ) -> None:
        self._app = app
        self.preferences = preferences
        told_folder = Path(preferences.now.store) if preferences.now.store else None
        self._folder = store_folder or told_folder or default_store_folder()
        self._translator = QTranslator()
        self._theme = Theme(app)
        use_language(preferences.now.language)
        self._theme.use(preferences.now.theme, preferences.now.font_scale)
        self.jobs = JobRunner(self._report)
        self.window = MainWindow(self._theme, self.jobs, preferences)
        self.workspace: Workspace | None = None
        self._watch = InactivityWatch(self.lock, self.window)
        app.installEventFilter(self._watch)
        self._take_hook_away = install_crash_report(lambda said: self.window.tell("bad", said))
        preferences.changed.subscribe(self._on_preferences)
        self._used = preferences.now
        self._is_closed = False
        self.window.closing.subscribe(self.close)
        self._use_qt_language()

    def start(self) -> None:
        """Show the window and open the store."""
        self.window.show()
        self._unlock()

    def lock(self) -> None:
        """Put the store and everything of patients away until it is unlocked again."""
        if self.workspace is None:
            return
        if self.jobs.is_busy:
            self._watch.set_minutes(BUSY_MINUTES)  # a report in the making is not thrown away
            return
        self._take_apart()
        self._unlock()

    def close(self) -> None:
        """End threads and close the store; a second call does nothing."""
        if self._is_closed:
            return
        self._is_closed = True
        self._app.removeEventFilter(self._watch)
        self._watch.set_minutes(0)
        self.jobs.close()
        self._take_apart()
        self._take_hook_away()

    def _unlock(self) -> None:
        page = self.window.unlock_page
        presenter = UnlockPresenter(
            page, self._folder, self.preferences.now.operator, self.jobs, self._on_opened
        )
        page.bind(presenter)
        self.window.show_unlock()
        presenter.begin()

    def _on_opened(self, store: SessionStore, is_new: bool) -> None:
        live = QtLiveSource(self.window)
        workspace = Workspace(store, self.jobs, self.preferences, live)
        if is_new:
            workspace.attempt(lambda: _want_nothing(demo_patient(store)))
        self.workspace = workspace
        workspace.noticed.subscribe(self.window.tell)
        workspace.screen_wanted.subscribe(self.window.show_screen)
        workspace.patient_changed.subscribe(self._show_patient)
        for screen in build_screens(workspace, self._theme, self.window):
            self.window.add_screen(screen)
        self.window.show_read_only(is_read_only=store.is_read_only)
        self._watch.set_minutes(self.preferences.now.autolock_minutes)
        self.window.show_first_screen()

    def _take_apart(self) -> None:
        """Close screens, sensor and store."""
        if self.workspace is None:
            return
        self.window.remove_screens()
        self.workspace.live.end()
        self.workspace.store.close()
        self.workspace = None

    def _show_patient(self) -> None:
        patient = self.workspace.patient if self.workspace is not None else None
        text = "" if patient is None else f"{patient.identity.name}  ·  {patient.pseudonym}"
        self.window.show_patient(text)

    def _report(self, error: AdibasError) -> None:
        if self.workspace is not None:
            self.workspace.report_problem(error)

    def _on_preferences(self, now: Preferences) -> None:
        before, self._used = self._used, now
        if now.language != before.language:
            use_language(now.language)
            self._use_qt_language()
        if (now.theme, now.font_scale) != (before.theme, before.font_scale):
            self._theme.use(now.theme, now.font_scale)
            self.window.dress()
        if now.autolock_minutes != before.autolock_minutes:
            self._watch.set_minutes(now.autolock_minutes)
        if self.workspace is not None:
            self.workspace.store.operator = now.operator

    def _use_qt_language(self) -> None:
        """Let Qt's own texts speak, too; every widget is told of the change."""
        language = self.preferences.now.language
        self._app.removeTranslator(self._translator)
        folder = QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)
        self._translator.load(f"qtbase_{language}", folder)
        QLocale.setDefault(QLocale(language))
        self._app.installTranslator(self._translator)


def _want_nothing(_patient: Patient) -> None:
    """Want nothing of what an action returns."""


def run(arguments: list[str]) -> int:
    """Open the window and return when it is closed."""
    app = QApplication([sys.argv[0], *arguments])
    app.setApplicationName("ADiBAS")
    app.setDesktopFileName("adibas")
    application = Application(app, PreferencesFile())
    application.start()
    code = app.exec()
    application.close()
    return code
