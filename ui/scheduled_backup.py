"""The backup that is due when somebody opens the store. Knows nothing of Qt."""

from pathlib import Path
from typing import TYPE_CHECKING

from adibas.sessions import key_state
from adibas.sessions.keys import BEHIND_PASSPHRASE
from adibas.texts import translate as _
from ui.ports import JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions.backing_up import BackupSummary


def back_up_if_due(workspace: Workspace) -> None:
    """Make the backup in a job where the preferences name a folder and one is due."""
    now, store = workspace.preferences.now, workspace.store
    if not now.backup_folder:
        return

    def work(control: JobControl) -> "tuple[Path, BackupSummary] | None":
        from adibas.sessions.backup_schedule import BackupPlan

        if key_state(store.folder) not in BEHIND_PASSPHRASE:
            return None  # the page of backups says so
        plan = BackupPlan(Path(now.backup_folder), now.backup_days, now.backup_keep)
        return store.backups.write_planned(plan, progress=control.progress)

    def done(made: "tuple[Path, BackupSummary] | None") -> None:
        if made is not None:
            tell_of_backup(workspace, *made)

    workspace.jobs.start(_("Backing the patient store up"), work, done, stop="tells")


def tell_of_backup(workspace: Workspace, path: Path, summary: "BackupSummary") -> None:
    """Say what was made, and what the store lacks."""
    if summary.damaged:
        workspace.tell(
            "warning",
            _(
                "The backup {file} is made, but some files of the store are missing or damaged. "
                "Check the store on the page Protection."
            ).format(file=path.name),
        )
    else:
        workspace.tell("good", _("The backup {file} is made.").format(file=path.name))
