"""What is held of the chosen patient, and what can be done with it. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from adibas.texts import translate as _
from ui.ports import JobControl
from ui.preferences import Preferences
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions.backup_schedule import BackupPlan
    from adibas.sessions.holdings import Holdings


class HoldingsView(Protocol):
    """The dialog, as this presenter needs it."""

    def show_holdings(self, held: "Holdings") -> None:
        """List all of it."""

    def show_actions(self, *, can_hide: bool, can_remove: bool) -> None:
        """Offer what can be done now."""

    def finish(self) -> None:
        """Close."""


@dataclass(frozen=True, slots=True)
class Actions:
    """What the patients screen does with the chosen patient: hide, or ask before a removal."""

    hide: Callable[[], None]
    ask_removal: Callable[[], None]


class HoldingsPresenter:
    """Looks in a job, as a store may have many files; what is done goes to the patients screen."""

    def __init__(self, view: HoldingsView, workspace: Workspace, actions: Actions) -> None:
        self._view = view
        self._workspace = workspace
        self._actions = actions
        view.show_actions(can_hide=False, can_remove=False)

    def look(self) -> None:
        """List what is held of the chosen patient now."""
        patient, store = self._workspace.patient, self._workspace.store
        if patient is None:
            return
        plan = planned(self._workspace.preferences.now)

        def work(_control: JobControl) -> "Holdings":
            return store.holdings.of(patient.pseudonym, plan)

        self._workspace.jobs.start(_("Looking for what is held"), work, self._show)

    def hide(self) -> None:
        """Hide the patient; it can be undone."""
        self._view.finish()
        self._actions.hide()

    def ask_removal(self) -> None:
        """Ask for the word that confirms a removal for good."""
        self._view.finish()
        self._actions.ask_removal()

    def _show(self, held: "Holdings") -> None:
        self._view.show_holdings(held)
        can_change = held.gone_utc is None and not self._workspace.store.is_read_only
        self._view.show_actions(can_hide=can_change and not held.is_deleted, can_remove=can_change)


def planned(now: Preferences) -> "BackupPlan | None":
    """Return the plan of backups of the preferences; None where none are made."""
    from adibas.sessions.backup_schedule import BackupPlan

    if not now.backup_folder:
        return None
    return BackupPlan(Path(now.backup_folder), now.backup_days, now.backup_keep)
