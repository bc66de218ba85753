"""Puts the program together: Qt, theme, store, screens; and takes it apart again."""

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QLocale, QLoggingCategory, QTimer
from PySide6.QtWidgets import QApplication, QToolTip

from adibas.data.patients import Patient
from adibas.errors import AdibasError
from adibas.sessions import default_store_folder
from adibas.sessions.roles import TITLES, Permission
from adibas.texts import translate as _
from adibas.texts import use_language
from ui.appearance import Appearance
from ui.closing import OrderlyClose
from ui.collector import look_at_all
from ui.crash import install_crash_report
from ui.drafts import Drafts
from ui.dropping import screen_for
from ui.frame_bridge import CallBridge
from ui.idle import IdleCall
from ui.inactivity import InactivityWatch
from ui.jobs import JobRunner
from ui.live_source import QtLiveSource
from ui.log import log_folder, start_log
from ui.preferences import Preferences, PreferencesFile
from ui.scheduled_backup import back_up_if_due
from ui.screens import preload, screen_builders
from ui.signals import SignalWatch
from ui.theme import Theme
from ui.unlock_presenter import UnlockPresenter
from ui.widgets.for_roles import only_for
from ui.window import MainWindow
from ui.workspace import Place, Workspace

if TYPE_CHECKING:  # what they bring along is needed after the patients are listed
    from adibas.sensors.ports import DepthCamera, SensorOptions
    from adibas.sessions import SessionStore

logger = logging.getLogger(__name__)

BACKUP_CHECK_MS = 3_600_000
"""A window may be open for weeks."""
PRELOAD_MS = 1500
"""After the start: who types a passphrase or looks for a patient does not notice."""

SCREENS_FOR_ROLES = {"reports": Permission.REPORT, "comparison": Permission.COMPARE}
"""The others are for everybody; what is in them asks for itself."""

LIVE_SCREENS = ("capture", "markers", "calibration")
"""They show the sensor, and open it when they are entered."""


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
        self.workspace: Workspace | None = None
        self._left_at: tuple[Place, str] | None = None
        self._left_by = ""
        self._drafts = Drafts(self.window)
        self._is_locking = False
        self._watch = InactivityWatch(self.lock, self.window)
        self._backup_timer = QTimer(self.window)
        self._idle = IdleCall(self.jobs, self._finish_lock)
        self._closing = OrderlyClose(self.window, self.jobs)
        self._bugs = CallBridge(lambda said: self.window.tell_of_bug(str(said)), self.window)
        self._take_hook_away = install_crash_report(self._bugs.publish)
        self._appearance = Appearance(app, self._theme, self.window, preferences)
        self._autolock_minutes = preferences.now.autolock_minutes
        self._language = preferences.now.language
        self._is_closed = False
        self.to_open: tuple[Path, ...] = ()
        self._connect()

    def _connect(self) -> None:
        self._app.installEventFilter(self._watch)
        self.preferences.changed.subscribe(self._on_preferences)
        self.window.may_close = self._closing.may_close
        self.window.while_building = self._unwatched
        self.window.closing.subscribe(self.close)
        self.window.shown_changed.subscribe(lambda _name: self._rest_sensor())
        self.jobs.changed.subscribe(lambda _job, _done, _total: self._rest_sensor())
        self.window.dropped.subscribe(self._open_dropped)
        self.window.lock_wanted.subscribe(self.lock)
        self._backup_timer.setInterval(BACKUP_CHECK_MS)
        self._backup_timer.timeout.connect(self._back_up)

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
        if self.workspace is None or self._is_locking:
            return
        self._is_locking = True
        self._watch.set_minutes(0)
        self._left_at = (self.workspace.place, self.window.shown)
        self._left_by = _owner(self.workspace.store)
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
        self._take_apart()
        self.jobs.close()
        self._take_hook_away()

    def _finish_lock(self) -> None:
        self._is_locking = False
        self._close_other_windows()
        if self.workspace is not None:
            self._drafts.keep(self.workspace.store.drafts, _owner(self.workspace.store))
        self._take_apart()
        self._show_unlock().ask()

    def _show_unlock(self) -> UnlockPresenter:
        page = self.window.unlock_page
        operator = self.preferences.now.operator
        presenter = UnlockPresenter(page, self._folder, operator, self.jobs, self._on_opened)
        page.bind(presenter)
        self.window.show_unlock()
        return presenter

    def _on_opened(self, store: "SessionStore", is_new: bool) -> None:
        from adibas.sessions.demo_patient import demo_patient

        live = QtLiveSource(self.window, _open_calibrated)
        workspace = Workspace(store, self.jobs, self.preferences, live)
        if is_new:
            workspace.attempt(lambda: _want_nothing(demo_patient(store)))
        logger.info("store opened, read only: %s", store.is_read_only)
        self.workspace = workspace
        workspace.noticed.subscribe(self.window.tell)
        workspace.retry_offered.subscribe(self.window.offer_again)
        workspace.dispute_found.subscribe(self.window.ask_which_holds)
        workspace.screen_wanted.subscribe(self._show_screen)
        workspace.patient_changed.subscribe(self._show_patient)
        for name, build in screen_builders(workspace, self._theme, self.window).items():
            self.window.offer_screen(name, build)
        workspace.person_changed.subscribe(partial(self._show_person, store))
        self._show_person(store)
        self.window.setLocale(QLocale(self.preferences.now.language))
        self.window.show_read_only(is_read_only=store.is_read_only)
        self._watch.set_minutes(self.preferences.now.autolock_minutes)
        self._show_where_the_user_was(workspace)
        if store.is_read_only:
            self._tell_read_only(workspace)
        else:
            self._drafts.give_back(store.drafts, _owner(store))
            back_up_if_due(workspace)
            self._backup_timer.start()
        if self.to_open:
            paths, self.to_open = self.to_open, ()
            self._open_dropped(paths)

    def _back_up(self) -> None:
        """Look again in a window that stays open; while something runs, the next hour will do."""
        if self.workspace is not None and not self._is_locking and not self.jobs.is_busy:
            back_up_if_due(self.workspace)

    def _tell_read_only(self, workspace: Workspace) -> None:
        if self._drafts.are_there:
            sentence = _(
                "Another window has the patient store open. What you were typing is kept: close "
                "that window, then lock this one (Ctrl+L) and unlock it."
            )
        else:
            sentence = _(
                "Another window has the patient store open. Here you can look at everything "
                "and write reports; close that window to change anything."
            )
        workspace.tell("warning", sentence)

    def _show_where_the_user_was(self, workspace: Workspace) -> None:
        left_at, self._left_at = self._left_at, None
        if left_at is None or self._left_by != _owner(workspace.store):
            self.window.show_first_screen()
            return
        place, screen = left_at
        workspace.return_to(place)
        permission = SCREENS_FOR_ROLES.get(screen)
        if permission is not None and not workspace.store.may(permission):
            self.window.show_first_screen()  # of another role meanwhile
            return
        self.window.show_screen(screen)

    def _show_screen(self, name: str) -> None:
        if self._is_locking and self._left_at is not None:
            self._left_at = (self._left_at[0], name)  # what is being finished goes on there
        else:
            self.window.show_screen(name)

    def _show_person(self, store: "SessionStore") -> None:
        """Say who has the store open, and offer the screens of that role."""
        person = store.person
        told = "" if person is None else f"{person.name}  ·  {_(TITLES[person.role])}"
        self.window.show_person(told)
        for name, permission in SCREENS_FOR_ROLES.items():
            self.window.keep_screen(name, "" if store.may(permission) else only_for(permission))

    def _open_dropped(self, paths: tuple[Path, ...]) -> None:
        workspace = self.workspace
        if workspace is None:
            return
        try:
            name = screen_for(paths, self.window.shown)
        except AdibasError as error:
            workspace.report_problem(error)
            return
        self.window.show_screen(name)
        self.window.screen_named(name).open_files(paths)

    def _close_other_windows(self) -> None:
        """Close dialogs, menus and tips: they may show a patient."""
        QToolTip.hideText()
        for widget in self._app.topLevelWidgets():
            if widget is not self.window and widget.isVisible():
                widget.close()

    def _take_apart(self) -> None:
        """Close screens, sensor and store."""
        if self.workspace is None:
            return
        self.window.remove_screens()
        self._backup_timer.stop()
        self.workspace.live.end()
        self.workspace.store.close()
        self.workspace = None
        look_at_all()

    def _rest_sensor(self) -> None:
        """Let go of the sensor where no screen shows it and no job may need it."""
        if self.workspace is None or self.window.shown in LIVE_SCREENS or self.jobs.is_busy:
            return
        if self.workspace.live.state.kind != "closed":
            self.workspace.live.close()

    def _show_patient(self) -> None:
        if self.workspace is None or self._is_locking:
            return
        patient = self.workspace.patient
        text = "" if patient is None else f"{patient.identity.name}  ·  {patient.pseudonym}"
        self.window.show_patient(text)

    def _report(self, error: AdibasError) -> None:
        if self.workspace is not None:
            self.workspace.report_problem(error)

    def _on_preferences(self, now: Preferences) -> None:
        if now.autolock_minutes != self._autolock_minutes and self.workspace is not None:
            self._watch.set_minutes(now.autolock_minutes)
        self._autolock_minutes = now.autolock_minutes
        if self.workspace is not None:
            self.workspace.store.operator = now.operator
            self._name_demo_patient(self.workspace)

    def _name_demo_patient(self, workspace: Workspace) -> None:
        """Call the demo patient as in the language in use: no English in a Spanish window."""
        if self._language == self.preferences.now.language:
            return
        self._language = self.preferences.now.language
        if workspace.store.may(Permission.CHANGE_PATIENTS):
            workspace.attempt(lambda: _rename_demo_patient(workspace))


def _owner(store: "SessionStore") -> str:
    """Return who has the store open; nobody in a store without people."""
    return "" if store.person is None else store.person.person_id


def _open_calibrated(text: str, options: "SensorOptions") -> "DepthCamera":
    """Open a source with the calibration that was kept of it; called by the thread that reads."""
    from adibas.calibration.kept import KeptCalibrations
    from adibas.sensors.calibrated import CalibratedOpener

    return CalibratedOpener(KeptCalibrations())(text, options)


def _preload() -> None:
    """Import what other screens need."""
    preload()


def _rename_demo_patient(workspace: Workspace) -> None:
    from adibas.sessions.demo_patient import rename_demo_patient

    renamed, chosen = rename_demo_patient(workspace.store), workspace.patient
    if renamed is not None and chosen is not None and chosen.pseudonym == renamed.pseudonym:
        workspace.choose_patient(renamed)


def _want_nothing(_patient: Patient) -> None:
    """Want nothing of what an action returns."""


def run(recordings: list[str]) -> int:
    """Open the window, with recordings if any are named, and return when it is closed."""
    from adibas.pipeline.warming import start_warming

    end_log = start_log(log_folder())
    app = QApplication(sys.argv[:1])
    app.setApplicationName("ADiBAS")
    app.setDesktopFileName("adibas")
    if app.platformName() == "offscreen":  # it says of every window what it cannot do with it
        QLoggingCategory.setFilterRules("default.warning=false")
    application = Application(app, PreferencesFile())
    application.to_open = tuple(Path(name).absolute() for name in recordings)
    signals = SignalWatch(application.end)
    application.start()
    QTimer.singleShot(PRELOAD_MS, app, _preload)
    compiling = start_warming()
    code = app.exec()
    application.close()
    if compiling is not None:
        compiling.terminate()
    signals.close()
    end_log()
    return code
