"""What would be lost if the window closed now: looked for in all screens and in their dialogs."""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

from PySide6.QtWidgets import QApplication, QDialog

from ui.widgets.screen import Screen
from ui.window import MainWindow


@runtime_checkable
class HoldsWork(Protocol):
    """A dialog in which something can be typed or learned that is not saved at once."""

    def unsaved(self) -> tuple[str, ...]:
        """Name what would be lost; nothing for nothing."""


class UnsavedWork:
    """Asked before the window closes.

    Parameters
    ----------
    window : MainWindow
    others : callable
        Names what would be lost and is on no screen.
    """

    def __init__(self, window: MainWindow, others: Callable[[], tuple[str, ...]]) -> None:
        self._window = window
        self._others = others
        self._place = ""

    def names(self) -> tuple[str, ...]:
        """Name everything that would be lost, each once; what saves itself is saved before."""
        _let_fields_be_taken()
        found = {screen.name: _names(screen) for screen in self._window.built_screens}
        self._place = next((name for name, names in found.items() if names), "")
        if found.get(self._window.shown):
            self._place = ""  # it is seen already
        on_screens = tuple(one for names in found.values() for one in names)
        return tuple(dict.fromkeys(on_screens or self._others()))

    def lead_back(self) -> None:
        """Show where the first of it is, unless some of it is seen, or nothing may be."""
        if self._place and self._window.shown:
            self._window.show_screen(self._place)


def _names(screen: Screen) -> tuple[str, ...]:
    """Name what would be lost of a screen and of its open dialogs."""
    dialogs = [one for one in screen.findChildren(QDialog) if one.isVisible()]
    held = [one.unsaved() for one in dialogs if isinstance(one, HoldsWork)]
    return (*screen.unsaved(), *(name for names in held for name in names))


def _let_fields_be_taken() -> None:
    """Let a field that is taken when it is left be taken; the next key goes there all the same."""
    field = QApplication.focusWidget()
    if field is not None:
        field.clearFocus()
        field.setFocus()
