"""Whether there is a recovery key, and the making of another one. Knows nothing of Qt."""

from collections.abc import Callable
from datetime import datetime
from typing import Protocol

from adibas.texts import translate as _
from ui.ports import JobControl
from ui.workspace import Workspace

ShowNew = Callable[[datetime | None, Callable[[], None]], object]
"""Shows a new key; given are when the one before was made, and what to do when the new holds."""


class RecoveryView(Protocol):
    """The page, as this presenter needs it."""

    def show_state(self, made_utc: datetime | None, *, can_change: bool) -> None:
        """Show since when there is a recovery key, or that there is none."""


class RecoveryPresenter:
    """Shows the state anew whenever the page is seen."""

    def __init__(self, view: RecoveryView, workspace: Workspace, show_new: ShowNew) -> None:
        self._view = view
        self._workspace = workspace
        self._show_new = show_new

    def enter(self) -> None:
        """Show what is so now."""
        self._read(self._show)

    def make(self) -> None:
        """Show a new key; it takes the place of the present one when it is kept."""
        self._read(lambda made_utc: self._show_new(made_utc, self.enter))

    def _show(self, made_utc: datetime | None) -> None:
        can_change = not self._workspace.store.is_read_only
        self._view.show_state(made_utc, can_change=can_change)

    def _read(self, done: Callable[[datetime | None], object]) -> None:
        def work(_control: JobControl) -> datetime | None:
            return self._workspace.store.recovery.made_utc()

        def go_on(made_utc: datetime | None) -> None:
            done(made_utc)

        self._workspace.jobs.start(_("Looking for the recovery key"), work, go_on)
