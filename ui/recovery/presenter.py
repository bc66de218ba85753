"""Shows a new recovery key once, and lets it open the store when it is kept. Knows nothing of Qt.

Nothing of it holds before it is printed, saved or said to be kept: who puts it off has lost
nothing, and the key of before still opens the store.
"""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from adibas.errors import AdibasError
from adibas.sessions.recovery_key import make_recovery_key
from adibas.texts import describe
from adibas.texts import translate as _
from ui.ports import JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:  # what writes PDFs comes when one is written
    from adibas.reports.recovery_sheet import RecoverySheet

Held = tuple[str, datetime]
"""Number of the store, and since when the key opens it."""


class RecoveryKeyView(Protocol):
    """The dialog, as this presenter needs it."""

    def show_key(self, groups: tuple[str, ...], replaced_utc: datetime | None) -> None:
        """Show the key, and when the one was made that it takes the place of."""

    def show_held(self) -> None:
        """Say that the key opens the store from now on."""

    def show_saved(self, name: str) -> None:
        """Say in which file the page is."""

    def show_problem(self, sentence: str) -> None:
        """Say what failed; the key is still shown."""

    def print_sheet(self, sheet: "RecoverySheet") -> None:
        """Ask for a printer and print the page."""

    def close_dialog(self) -> None:
        """Show the key no more."""


class RecoveryKeyPresenter:
    """Makes one key; whoever sees it decides what becomes of it.

    Parameters
    ----------
    held : callable
        Told when the key opens the store.
    """

    def __init__(
        self,
        view: RecoveryKeyView,
        workspace: Workspace,
        replaced_utc: datetime | None,
        held: Callable[[], None],
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._tell_held = held
        self._recovery_key = make_recovery_key()
        self._held: Held | None = None
        self._is_over = False
        view.show_key(tuple(self._recovery_key.split("-")), replaced_utc)

    def print_it(self) -> None:
        """Print the page."""
        self._hold(lambda held: self._view.print_sheet(self._sheet(held)))

    def save(self, path: Path) -> None:
        """Write the page as a PDF; it is in no other file."""

        def write(held: Held) -> None:
            sheet = self._sheet(held)

            def work(_control: JobControl) -> None:
                from adibas.reports.recovery_sheet import write_recovery_pdf

                write_recovery_pdf(path, sheet)

            self._workspace.jobs.start(
                _("Saving the recovery key"),
                work,
                lambda _nothing: self._saved(path.name),
                self._tell,
                stop="never",
            )

        self._hold(write)

    def keep(self) -> None:
        """End: it is kept in a safe place."""
        self._hold(lambda _held: self._view.close_dialog())

    def end(self) -> None:
        """Forget the key: the dialog is closed."""
        self._is_over = True
        self._recovery_key = ""

    def _hold(self, go_on: Callable[[Held], None]) -> None:
        """Let the key open the store, unless it does already, and go on."""
        if self._held is not None:
            go_on(self._held)
            return
        recovery, recovery_key = self._workspace.store.recovery, self._recovery_key

        def work(_control: JobControl) -> Held:
            recovery.hold(recovery_key)
            return recovery.store_id, recovery.made_utc() or self._workspace.store.audit.now_utc()

        def done(held: Held) -> None:
            self._held = held
            self._tell_held()
            if not self._is_over:
                self._view.show_held()
                go_on(held)

        label = _("Letting the recovery key open the store")
        self._workspace.jobs.start(label, work, done, self._tell, stop="never")

    def _sheet(self, held: Held) -> "RecoverySheet":
        from adibas.reports.recovery_sheet import recovery_sheet

        return recovery_sheet(self._recovery_key, *held)

    def _saved(self, name: str) -> None:
        if not self._is_over:
            self._view.show_saved(name)

    def _tell(self, error: AdibasError) -> None:
        if self._is_over:
            self._workspace.report_problem(error)
        else:
            self._view.show_problem(describe(error))
