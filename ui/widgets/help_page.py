"""The offline help of one screen."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import QApplication, QDockWidget, QTextBrowser, QWidget
from shiboken6 import isValid

from adibas.resources import resource_path
from adibas.texts import spoken_language
from adibas.texts import translate as _

LEAST_WIDTH_PX = 320
SEPARATOR_PX = 8
FLOATING_LETTERS = 48
"""Wide enough to be read well."""


def read_help(name: str, language: str) -> str:
    """Return a help page as Markdown, in English where it was not written in `language`."""
    for one in (language, "en"):
        path = resource_path("help", one, f"{name}.md")
        if path.is_file():
            return path.read_text(encoding="utf-8")
    return ""


class HelpDock(QDockWidget):
    """Shows the help beside the screen it is about; Escape puts it away."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("help")
        self._name = "start"
        self._text = QTextBrowser(self)
        self._text.setOpenLinks(False)
        self._text.setMinimumWidth(LEAST_WIDTH_PX)
        self.setWidget(self._text)
        self.setAllowedAreas(
            Qt.DockWidgetArea.RightDockWidgetArea | Qt.DockWidgetArea.LeftDockWidgetArea
        )
        self._focus_before: QWidget | None = None
        self._is_pushed_out = False
        escape = QShortcut(QKeySequence(Qt.Key.Key_Escape), self._text, self._put_away)
        escape.setContext(Qt.ShortcutContext.WidgetShortcut)
        self.retranslate()
        self.hide()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setWindowTitle(_("Help"))
        self._text.setAccessibleName(_("Help"))
        self._text.setMarkdown(read_help(self._name, spoken_language()))

    def show_page(self, name: str) -> None:
        """Show the page of a screen; Escape leads back to where the user was."""
        self._name = name
        if not self._text.hasFocus():
            self._focus_before = QApplication.focusWidget()
        self.retranslate()
        self.show()
        self._text.setFocus()

    def stand_beside(self, window: QWidget, room_px: int) -> None:
        """Stand in the window where there is room for it, else float above its right edge."""
        is_narrow = room_px < self.minimumSizeHint().width() + SEPARATOR_PX
        if is_narrow and not self.isFloating():
            self._is_pushed_out = True
            self.setFloating(True)
            edge = window.frameGeometry()
            width = min(
                max(FLOATING_LETTERS * self.fontMetrics().averageCharWidth(), LEAST_WIDTH_PX),
                edge.width(),
            )
            self.setGeometry(edge.right() - width, edge.top() + 60, width, edge.height() - 120)
        elif self._is_pushed_out and not is_narrow:
            self._is_pushed_out = False
            self.setFloating(False)

    def _put_away(self) -> None:
        self.hide()
        before = self._focus_before
        if before is not None and isValid(before) and before.isVisible():
            before.setFocus()

    def follow(self, name: str) -> None:
        """Turn to the page of the screen that is seen now, if the help is open."""
        self._name = name
        if not self.isHidden():
            self.retranslate()
