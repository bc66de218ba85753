"""Puts the program together: Qt, theme, window, store; and takes it apart again."""

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QLoggingCategory, QSettings, QTimer
from PySide6.QtWidgets import QApplication, QDialog, QToolTip

from adibas.errors import AdibasError
from adibas.sessions import default_store_folder
from adibas.texts import translate as _
from adibas.texts import use_language
from ui.appearance import Appearance
from ui.closing import OrderlyClose, close_at_once
from ui.crash import install_crash_report
from ui.drafts import Drafts
from ui.frame_bridge import CallBridge
from ui.idle import IdleCall
from ui.inactivity import InactivityWatch
from ui.jobs import JobRunner
from ui.log import log_folder, start_log
from ui.open_store import Left, OpenStore
from ui.preferences import Preferences, PreferencesFile
from ui.screens import preload
from ui.signals import SignalWatch
from ui.theme import Theme
from ui.unlock_presenter import UnlockPresenter
from ui.unsaved import UnsavedWork
from ui.window import MainWindow
from ui.workspace import Workspace

if TYPE_CHECKING:  # what it brings along is needed after the patients are listed
    from adibas.sessions import SessionStore

logger = logging.getLogger(__name__)

PRELOAD_MS = 1500
"""After the start: who types a passphrase or looks for a patient does not notice."""


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

    Attributes
    ----------
    to_open : tuple of Path
        Recordings that are shown when the store is open.
    """

    def __init__(
        self, app: QApplication, preferences: PreferencesFile, store_folder: Path | None = None
    ) -> None:
        self._app = app
        self.preferences = preferences
        told_folder = Path(preferences.now.store) if preferences.now.store else None
        self._folder = store_folder or told_folder or default_store_folder()
        self._theme = Theme(app)
        use_language(preferences.now.language)
        self._theme.use(preferences.now.theme, preferences.now.font_scale)
        self.jobs = JobRunner(self._report)
        self.window = MainWindow(self._theme, self.jobs, preferences)
        self._opened: OpenStore | None = None
        self._left: Left | None = None
        self._drafts = Drafts(self.window)
        self._watch = InactivityWatch(self.lock, self.window)
        self._idle = IdleCall(self.jobs, self._finish_lock)
        unsaved = UnsavedWork(self.window, self._unsaved_elsewhere)
        self._closing = OrderlyClose(self.window, self.jobs, unsaved.names, unsaved.lead_back)
        self._bugs = CallBridge(lambda said: self.window.tell_of_bug(str(said)), self.window)
        self._take_hook_away = install_crash_report(self._bugs.publish)
        self._appearance = Appearance(app, self._theme, self.window, preferences)
        self._autolock_minutes = preferences.now.autolock_minutes
        self._is_closed = False
        self.to_open: tuple[Path, ...] = ()
        self._connect()

    @property
    def workspace(self) -> Workspace | None:
        """What the screens of the open store share; None while it is locked."""
        return None if self._opened is None else self._opened.workspace

    def _connect(self) -> None:
        self._app.installEventFilter(self._watch)
        self.preferences.changed.subscribe(self._on_preferences)
        self.window.may_close = self._closing.may_close
        self.window.while_building = self._unwatched
        self.window.closing.subscribe(self.close)
        self.window.lock_wanted.subscribe(self.lock)

    @contextmanager
    def _unwatched(self) -> Iterator[None]:
        """Watch for no touch where none can be: a screen is put together in a third less time."""
        self._app.removeEventFilter(self._watch)
        try:
            yield
        finally:
            self._app.installEventFilter(self._watch)

    def start(self) -> None:
        """Show the window and open the store."""
        self.window.show()
        self._show_unlock().begin()

    def lock(self) -> None:
        """Show nothing of patients, and put the store away until it is unlocked again.

        What still runs is finished behind the lock: a report in the making is not thrown away.
        """
        if self._opened is None or self._opened.left is not None:
            return
        self._watch.set_minutes(0)
        self._opened.leave()
        self._close_other_windows()
        logger.info("locked")
        self.window.unlock_page.show_locking()
        self.window.show_unlock()
        self._idle.wait()

    def end(self) -> None:
        """Close the window without a question: the desktop session or the terminal ends."""
        self._closing.close_without_asking()

    def close(self) -> None:
        """End threads and close the store; a second call does nothing."""
        if self._is_closed:
            return
        self._is_closed = True
        self._app.removeEventFilter(self._watch)
        self._appearance.close()
        self._watch.set_minutes(0)
        self._closing.finish()
        self._idle.close()
        close_at_once(lambda: self.window.findChildren(QDialog))
        self._close_store()
        self.jobs.close()
        self._take_hook_away()

    def _finish_lock(self) -> None:
        self._close_other_windows()
        if self._opened is not None:
            self._drafts.keep(self._opened.store.drafts, self._opened.owner)
            self._left = self._opened.left
        self._close_store()
        self._show_unlock().ask()

    def _close_store(self) -> None:
        opened, self._opened = self._opened, None
        if opened is not None:
            opened.close()

    def _show_unlock(self) -> UnlockPresenter:
        page = self.window.unlock_page
        operator = self.preferences.now.operator
        presenter = UnlockPresenter(page, self._folder, operator, self.jobs, self._on_opened)
        page.bind(presenter)
        self.window.show_unlock()
        return presenter

    def _on_opened(self, store: "SessionStore", is_new: bool) -> None:
        opened = OpenStore(store, self.window, self.jobs, self.preferences, self._theme)
        self._opened = opened
        if is_new:
            opened.add_demo_patient()
        self._watch.set_minutes(self.preferences.now.autolock_minutes)
        left, self._left = self._left, None
        opened.return_to(left)
        if store.is_read_only:
            opened.tell_read_only(has_drafts=self._drafts.are_there)
        else:
            self._drafts.give_back(store.drafts, opened.owner)
            opened.keep_backed_up()
        if self.to_open:
            paths, self.to_open = self.to_open, ()
            opened.open_files(paths)
        if is_new and not store.is_read_only:
            opened.offer_recovery_key()

    def _close_other_windows(self) -> None:
        """Close dialogs, menus and tips: they may show a patient."""
        QToolTip.hideText()
        close_at_once(
            lambda: (one for one in self._app.topLevelWidgets() if one is not self.window)
        )

    def _unsaved_elsewhere(self) -> tuple[str, ...]:
        """Name what would be lost and stands on no screen."""
        if self._drafts.are_there:
            return (_("What was typed before the window locked"),)
        if self.workspace is not None and self.workspace.has_retry:
            return (_("What could not be saved and can be tried again"),)
        return ()

    def _report(self, error: AdibasError) -> None:
        if self._opened is not None:
            self._opened.workspace.report_problem(error)

    def _on_preferences(self, now: Preferences) -> None:
        if now.autolock_minutes != self._autolock_minutes and self._opened is not None:
            self._watch.set_minutes(now.autolock_minutes)
        self._autolock_minutes = now.autolock_minutes


def note_no_folders() -> None:
    """Keep Qt's own file dialog from writing down which folders were visited.

    They stood in ``QtProject.conf`` of this user, and a folder may bear a patient's name.
    """
    QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, os.devnull)


def run(recordings: list[str]) -> int:
    """Open the window, with recordings if any are named, and return when it is closed."""
    from adibas.pipeline.warming import start_warming

    end_log = start_log(log_folder())
    note_no_folders()
    app = QApplication(sys.argv[:1])
    app.setApplicationName("ADiBAS")
    app.setDesktopFileName("adibas")
    if app.platformName() == "offscreen":  # it says of every window what it cannot do with it
        QLoggingCategory.setFilterRules("default.warning=false")
    application = Application(app, PreferencesFile())
    if not application.preferences.now.geometry:  # else Qt has found it a place on a screen
        application.window.keep_on_screen()
    application.to_open = tuple(Path(name).absolute() for name in recordings)
    signals = SignalWatch(application.end)
    application.start()
    QTimer.singleShot(PRELOAD_MS, app, preload)
    compiling = start_warming()
    code = app.exec()
    application.close()
    if compiling is not None:
        compiling.terminate()
    signals.close()
    end_log()
    return code
