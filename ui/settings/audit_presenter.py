"""What was done in the store, by whom: the audit log to read and to hand out. Knows no Qt."""

from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from adibas.files import check_place
from adibas.reports.audit_csv import write_audit_csv
from adibas.texts import translate as _
from ui.ports import Job, JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions import AuditEntry

MOST_SHOWN = 200
EVERY_LINE = 2**31


class AuditView(Protocol):
    """The page, as this presenter needs it."""

    def show_entries(self, entries: "tuple[AuditEntry, ...]", *, is_cut: bool) -> None:
        """Show lines, newest first; `is_cut` where there are older ones."""


class AuditPresenter:
    """Reads the log in a job; of several wishes the newest one is shown."""

    def __init__(self, view: AuditView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._text = ""
        self._job: Job | None = None

    def enter(self) -> None:
        """Show the log as it is now."""
        self.search(self._text)

    def search(self, text: str) -> None:
        """Show the lines on the patients that a text finds, or all lines."""
        self._text = text
        if self._job is not None and self._job.is_running:
            self._job.cancel()

        def work(_control: JobControl) -> "tuple[AuditEntry, ...]":
            return self._entries(text, MOST_SHOWN + 1)

        self._job = self._workspace.jobs.start(
            _("Reading the audit log"), work, lambda found: self._show(text, found)
        )

    def export(self, path: Path) -> None:
        """Write all lines of what is shown as CSV; that they were written is a line, too."""
        text, store = self._text, self._workspace.store

        def work(_control: JobControl) -> None:
            entries = self._entries(text, EVERY_LINE)
            check_place(path)
            store.note_export("audit log", "store")  # first: half a log has left the store, too
            write_audit_csv(entries, path)

        def done(_nothing: None) -> None:
            self._workspace.tell(
                "good", _("The audit log is written to {file}.").format(file=path.name)
            )
            self.enter()

        self._workspace.jobs.start(_("Writing the audit log"), work, done, stop="tells")

    def _entries(self, text: str, limit: int) -> "tuple[AuditEntry, ...]":
        from adibas.sessions.patients import ALL_OF_THEM

        store, typed = self._workspace.store, text.strip()
        if not typed:
            return store.audit.entries(limit)
        found = store.patients.search(typed, limit=ALL_OF_THEM, with_deleted=True)
        # A patient who was removed for good is found by the whole pseudonym alone.
        pseudonyms = {typed.upper(), *(row.pseudonym for row in found)}
        return store.audit.entries(limit, patients=pseudonyms)

    def _show(self, text: str, found: "tuple[AuditEntry, ...]") -> None:
        if text == self._text:
            self._view.show_entries(found[:MOST_SHOWN], is_cut=len(found) > MOST_SHOWN)
