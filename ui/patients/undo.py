"""The last deletion, and how it is undone in place. Knows nothing of Qt."""

from collections.abc import Callable
from typing import Protocol

from ui.events import Event
from ui.patients.content import UndoOffer
from ui.workspace import Workspace


class UndoView(Protocol):
    """The strip below the list, as `Undo` needs it."""

    def show_undo(self, offer: UndoOffer | None) -> None:
        """Offer to undo a deletion; None offers nothing."""


class Undo:
    """Remembers the last deletion of this window.

    Events
    ------
    hidden_changed()
        A patient or session was hidden, shown again, or removed for good.
    """

    def __init__(self, view: UndoView, workspace: Workspace) -> None:
        self.hidden_changed: Event[[]] = Event()
        self._view = view
        self._workspace = workspace
        self._restore: Callable[[], None] | None = None
        view.show_undo(None)

    def offer(self, offer: UndoOffer, restore: Callable[[], None]) -> None:
        """Take note of a deletion that `restore` takes back."""
        self._restore = restore
        self._view.show_undo(offer)
        self.hidden_changed.emit()

    def forget(self) -> None:
        """Offer nothing any more: something was restored or removed otherwise."""
        self._restore = None
        self._view.show_undo(None)
        self.hidden_changed.emit()

    def take_back(self) -> None:
        """Undo the last deletion."""
        if self._restore is not None and self._workspace.attempt(self._restore):
            self.forget()
