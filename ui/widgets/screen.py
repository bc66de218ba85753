"""What every screen of the window has in common."""

from pathlib import Path

from PySide6.QtCore import QEvent
from PySide6.QtWidgets import QWidget


class Screen(QWidget):
    """A page of the window: speaks another language when asked, and knows when it is seen.

    Derived classes build their widgets in `__init__`, without texts, and call `retranslate` last.
    """

    name = ""
    """Of the help page, and of the screen in the window."""

    def retranslate(self) -> None:
        """Set every text in the language in use; a screen without texts has nothing to do."""

    def entered(self) -> None:
        """Take note: the screen is now seen."""

    def left(self) -> None:
        """Take note: the screen is no longer seen."""

    def closed(self) -> None:
        """Let go of threads, timers and files: the window closes."""

    def draft(self) -> str:
        """Return what was typed and is not saved, for `take_back`; nothing for nothing."""
        return ""

    def take_back(self, draft: str) -> None:
        """Give back what was typed before the window locked; most screens save at once."""

    def unsaved(self) -> tuple[str, ...]:
        """Name what would be lost if the window closed now; most screens save at once.

        What saves itself sooner or later is saved before.
        """
        return ()

    def open_file(self, path: Path) -> None:
        """Open what was dropped onto the window; most screens open nothing."""

    def open_files(self, paths: tuple[Path, ...]) -> None:
        """Open all that was dropped; most screens open one file at a time."""
        self.open_file(paths[0])

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        """Speak the new language."""
        if event.type() == QEvent.Type.LanguageChange:
            self.retranslate()
        super().changeEvent(event)
