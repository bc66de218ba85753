"""A patient store that is open in the window: its screens, its sensor, and who works with it."""

import logging
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QLocale, QTimer

from adibas.data.patients import Patient
from adibas.errors import AdibasError
from adibas.sessions.roles import TITLES, Permission
from adibas.texts import translate as _
from ui.collector import look_at_all
from ui.dropping import screen_for
from ui.jobs import JobRunner
from ui.live_source import QtLiveSource
from ui.preferences import Preferences, PreferencesFile
from ui.scheduled_backup import back_up_if_due
from ui.screens import screen_builders
from ui.theme import Theme
from ui.widgets.for_roles import only_for
from ui.window import MainWindow
from ui.workspace import Place, Workspace

if TYPE_CHECKING:  # what they bring along is needed after the patients are listed
    from adibas.sensors.ports import DepthCamera, SensorOptions
    from adibas.sessions import SessionStore

logger = logging.getLogger(__name__)

BACKUP_CHECK_MS = 3_600_000
"""A window may be open for weeks."""

SCREENS_FOR_ROLES = {"reports": Permission.REPORT, "comparison": Permission.COMPARE}
"""The others are for everybody; what is in them asks for itself."""

LIVE_SCREENS = ("capture", "markers", "calibration")
"""They show the sensor, and open it when they are entered."""


@dataclass(frozen=True, slots=True)
class Left:
    """Where somebody was when the window locked.

    Attributes
    ----------
    place : Place
        Patient, session and capture.
    screen : str
    person : str
        Who it was; empty in a store without people.
    """

    place: Place
    screen: str
    person: str


class OpenStore:
    """From unlocking to locking.

    Parameters
    ----------
    store : SessionStore
        Closed at the end.
    window : MainWindow
        Shows its screens.
    jobs : JobRunner
    preferences : PreferencesFile
    theme : Theme

    Attributes
    ----------
    workspace : Workspace
        What the screens share.
    left : Left or None
        Where to go on after the lock; None before `leave`.
    """

    def __init__(
        self,
        store: "SessionStore",
        window: MainWindow,
        jobs: JobRunner,
        preferences: PreferencesFile,
        theme: Theme,
    ) -> None:
        self._window = window
        self._jobs = jobs
        self._preferences = preferences
        self._language = preferences.now.language
        self.workspace = Workspace(store, jobs, preferences, QtLiveSource(window, _open_calibrated))
        self.left: Left | None = None
        self._backup_timer = QTimer()
        self._backup_timer.setInterval(BACKUP_CHECK_MS)
        self._backup_timer.timeout.connect(self._back_up)
        self._offer_screens(theme)
        self._ends = [
            window.shown_changed.subscribe(lambda _name: self._rest_sensor()),
            window.dropped.subscribe(self.open_files),
            jobs.changed.subscribe(lambda _job, _done, _total: self._rest_sensor()),
            preferences.changed.subscribe(self._on_preferences),
        ]
        logger.info("store opened, read only: %s", store.is_read_only)

    @property
    def store(self) -> "SessionStore":
        """The store itself."""
        return self.workspace.store

    @property
    def owner(self) -> str:
        """Who has it open; nobody in a store without people."""
        return "" if self.store.person is None else self.store.person.person_id

    def _offer_screens(self, theme: Theme) -> None:
        workspace, window = self.workspace, self._window
        workspace.noticed.subscribe(window.tell)
        workspace.notice_withdrawn.subscribe(window.withdraw)
        workspace.retry_offered.subscribe(window.offer_again)
        workspace.retry_withdrawn.subscribe(window.withdraw_retry)
        workspace.dispute_found.subscribe(window.ask_which_holds)
        workspace.screen_wanted.subscribe(self._show_screen)
        workspace.patient_changed.subscribe(self._show_patient)
        for name, build in screen_builders(workspace, theme, window).items():
            window.offer_screen(name, build)
        workspace.person_changed.subscribe(self._show_person)
        self._show_person()
        window.setLocale(QLocale(self._preferences.now.language))
        window.show_read_only(is_read_only=self.store.is_read_only)

    def return_to(self, left: Left | None) -> None:
        """Show where the same person was before; else the first screen."""
        if left is None or left.person != self.owner:
            self._window.show_first_screen()
            return
        self.workspace.return_to(left.place)
        permission = SCREENS_FOR_ROLES.get(left.screen)
        if permission is not None and not self.store.may(permission):
            self._window.show_first_screen()  # of another role meanwhile
            return
        self._window.show_screen(left.screen)

    def keep_backed_up(self) -> None:
        """Make the backup that is due, and look again as long as the window is open."""
        back_up_if_due(self.workspace)
        self._backup_timer.start()

    def tell_read_only(self, *, has_drafts: bool) -> None:
        """Say that another window changes it, and what becomes of what was being typed."""
        if has_drafts:
            sentence = _(
                "Another window has the patient store open. What you were typing is kept: close "
                "that window, then lock this one (Ctrl+L) and unlock it."
            )
        else:
            sentence = _(
                "Another window has the patient store open. Here you can look at everything "
                "and write reports; close that window to change anything."
            )
        self.workspace.tell("warning", sentence)

    def add_demo_patient(self) -> None:
        """Give a new store somebody to try everything with."""
        from adibas.sessions.demo_patient import demo_patient

        self.workspace.attempt(lambda: _want_nothing(demo_patient(self.store)))

    def offer_recovery_key(self) -> None:
        """Show the recovery key of a new store; who puts it off finds it in the settings."""
        from ui.recovery.dialog import open_recovery_key

        open_recovery_key(self.workspace, self._window, None, lambda: None)

    def open_files(self, paths: tuple[Path, ...]) -> None:
        """Show files on the screen that takes them; none behind the lock."""
        if self.left is not None:
            return
        try:
            name = screen_for(paths, self._window.shown)
        except AdibasError as error:
            self.workspace.report_problem(error)
            return
        self._window.show_screen(name)
        self._window.screen_named(name).open_files(paths)

    def leave(self) -> None:
        """Note where the user is; what still runs is finished, and nothing more is shown."""
        self.left = Left(self.workspace.place, self._window.shown, self.owner)

    def close(self) -> None:
        """Close screens, sensor and store."""
        for end in self._ends:
            end()
        self._window.remove_screens()
        self._backup_timer.stop()
        self.workspace.live.end()
        self.store.close()
        look_at_all()

    def _back_up(self) -> None:
        """Look again in a window that stays open; while something runs, the next hour will do."""
        if self.left is None and not self._jobs.is_busy:
            back_up_if_due(self.workspace)

    def _show_screen(self, name: str) -> None:
        if self.left is None:
            self._window.show_screen(name)
        else:
            self.left = replace(self.left, screen=name)  # what is being finished goes on there

    def _show_patient(self) -> None:
        if self.left is not None:
            return
        patient = self.workspace.patient
        text = "" if patient is None else f"{patient.identity.name}  ·  {patient.pseudonym}"
        self._window.show_patient(text)

    def _show_person(self) -> None:
        """Say who has the store open, and offer the screens of that role."""
        person = self.store.person
        told = "" if person is None else f"{person.name}  ·  {_(TITLES[person.role])}"
        self._window.show_person(told)
        for name, permission in SCREENS_FOR_ROLES.items():
            is_free = self.store.may(permission)
            self._window.keep_screen(name, "" if is_free else only_for(permission))

    def _rest_sensor(self) -> None:
        """Let go of the sensor where no screen shows it and no job may need it."""
        if self._window.shown in LIVE_SCREENS or self._jobs.is_busy:
            return
        if self.workspace.live.state.kind != "closed":
            self.workspace.live.close()

    def _on_preferences(self, now: Preferences) -> None:
        self.store.operator = now.operator
        if now.language != self._language:
            self._language = now.language
            self._name_demo_patient()

    def _name_demo_patient(self) -> None:
        """Call the demo patient as in the language in use: no English in a Spanish window."""
        if self.store.may(Permission.CHANGE_PATIENTS):
            self.workspace.attempt(partial(_rename_demo_patient, self.workspace))


def _open_calibrated(text: str, options: "SensorOptions") -> "DepthCamera":
    """Open a source with the calibration that was kept of it; called by the thread that reads."""
    from adibas.calibration.kept import KeptCalibrations
    from adibas.sensors.calibrated import CalibratedOpener

    return CalibratedOpener(KeptCalibrations())(text, options)


def _rename_demo_patient(workspace: Workspace) -> None:
    from adibas.sessions.demo_patient import rename_demo_patient

    renamed, chosen = rename_demo_patient(workspace.store), workspace.patient
    if renamed is not None and chosen is not None and chosen.pseudonym == renamed.pseudonym:
        workspace.choose_patient(renamed)


def _want_nothing(_patient: Patient) -> None:
    """Want nothing of what an action returns."""
