"""Backups by hand and every few days, their check and their way back. Knows nothing of Qt."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from adibas.sessions import key_state
from adibas.sessions.disk_words import forecast_text
from adibas.sessions.keys import BEHIND_PASSPHRASE
from adibas.sessions.merge_words import merge_texts
from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.ports import JobControl
from ui.preferences import Preferences
from ui.scheduled_backup import tell_of_backup
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions import VerifyReport
    from adibas.sessions.backing_up import BackupSummary
    from adibas.sessions.backup_format import BackupHeader
    from adibas.sessions.disk_use import DiskForecast
    from adibas.sessions.merging import MergeSummary

FEW_MONTHS = 3.0


class BackupView(Protocol):
    """The page, as this presenter needs it."""

    def show_plan(self, preferences: Preferences) -> None:
        """Show where, how often and how many."""

    def show_state(self, sentences: tuple[str, ...], *, is_urgent: bool) -> None:
        """Show how old the newest backup is, and how long the disk will last."""

    def show_result(self, sentences: tuple[str, ...]) -> None:
        """Show what a check or a restore found."""


class BackupPresenter:
    """Everything runs as a job: with progress, and with a way to stop it."""

    def __init__(self, view: BackupView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        view.show_plan(workspace.preferences.now)

    def enter(self) -> None:
        """Look at the backups and the disk."""
        store, now = self._workspace.store, self._workspace.preferences.now

        def work(_control: JobControl) -> "tuple[float | None, bool, DiskForecast]":
            days = store.backups.days_since(Path(now.backup_folder)) if now.backup_folder else None
            has_passphrase = key_state(store.folder) in BEHIND_PASSPHRASE
            return days, has_passphrase, store.forecast_disk()

        self._workspace.jobs.start(_("Looking at the backups"), work, self._show_state)

    def change(self, **changes: Any) -> None:
        """Take another plan."""
        self._workspace.preferences.change(**changes)
        self._view.show_plan(self._workspace.preferences.now)
        self.enter()

    def back_up(self, path: Path, passphrase: str) -> None:
        """Make a backup now; an empty passphrase means the store's."""
        store = self._workspace.store

        def work(control: JobControl) -> "BackupSummary":
            return store.backups.write(path, passphrase or None, progress=control.progress)

        def done(summary: "BackupSummary") -> None:
            tell_of_backup(self._workspace, path, summary)
            self.enter()

        self._workspace.jobs.start(_("Backing the patient store up"), work, done, stop="tells")

    def check(self, path: Path, passphrase: str) -> None:
        """Restore a backup for a moment beside what it is of, and check it there."""
        store = self._workspace.store

        def work(control: JobControl) -> "tuple[BackupHeader, VerifyReport]":
            return store.backups.verify(path, passphrase or None, control.progress)

        self._workspace.jobs.start(_("Checking the backup"), work, self._show_check)

    def restore(self, path: Path, passphrase: str) -> None:
        """Add what a backup has and the store has not."""
        store = self._workspace.store

        def work(control: JobControl) -> "MergeSummary":
            return store.backups.restore(path, passphrase or None, control.progress)

        def done(summary: "MergeSummary") -> None:
            self._view.show_result(merge_texts(summary))
            self._workspace.choose_patient(None)  # who is shown may be another version now

        self._workspace.jobs.start(_("Restoring from the backup"), work, done, stop="tells")

    def _show_check(self, found: "tuple[BackupHeader, VerifyReport]") -> None:
        header, report = found
        sentences = tuple(one.text for one in report.findings) or (
            _(
                "The backup of {time} UTC is whole: it was restored, and all of it was checked."
            ).format(time=header.created_utc[:16].replace("T", " ")),
        )
        self._view.show_result(sentences)

    def _show_state(self, found: "tuple[float | None, bool, DiskForecast]") -> None:
        days, has_passphrase, forecast = found
        now = self._workspace.preferences.now
        months = forecast.months_left
        is_urgent = days is None or days > now.backup_days or not has_passphrase
        is_urgent = is_urgent or (months is not None and months < FEW_MONTHS)
        sentences = (
            _age_text(days),
            *_plan_texts(has_passphrase=has_passphrase),
            forecast_text(forecast),
        )
        self._view.show_state(sentences, is_urgent=is_urgent)


def _age_text(days: float | None) -> str:
    if days is None:
        return _("There is no backup in the folder of backups yet.")
    n = round(days)
    told = translate_plural(
        "The newest backup is {n} day old.", "The newest backup is {n} days old.", n
    )
    return told.format(n=n)


def _plan_texts(*, has_passphrase: bool) -> tuple[str, ...]:
    if has_passphrase:
        return ()
    return (
        _(
            "The key of this store is in the desktop's keyring. Backups every few days need a "
            "passphrase: choose one on the page Protection."
        ),
    )
