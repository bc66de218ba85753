"""The offline help of one screen, and the way to its page of the manual."""

from PySide6.QtCore import QCoreApplication, Qt, QUrl
from PySide6.QtGui import QDesktopServices, QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QDockWidget,
    QLabel,
    QPushButton,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)
from shiboken6 import isValid

from adibas.resources import resource_path
from adibas.texts import spoken_language
from adibas.texts import translate as _
from ui.manual import manual_page

MANUAL_KEY = "Shift+F1"
LEAST_WIDTH_PX = 320
SEPARATOR_PX = 8
FLOATING_LETTERS = 48
"""Wide enough to be read well."""

FRAME_TEXTS = {
    "qt_dockwidget_floatbutton": ("Float", "Undocks and re-attaches the dock widget"),
    "qt_dockwidget_closebutton": ("Close", "Closes the dock widget"),
}
"""Name and description of a button of the frame, as Qt's catalogues have them."""
QT_CONTEXT = QDockWidget.__name__
"""Where they are in those catalogues; ours do not have them."""


def read_help(name: str, language: str) -> str:
    """Return a help page as Markdown, in English where it was not written in `language`."""
    for one in (language, "en"):
        path = resource_path("help", one, f"{name}.md")
        if path.is_file():
            return path.read_text(encoding="utf-8")
    return ""


class HelpDock(QDockWidget):
    """Shows the help beside the screen it is about; Escape puts it away.

    The manual, with figures and in full, is opened by what the desktop opens pages with.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("help")
        self._name = "start"
        self._text = QTextBrowser(self)
        self._text.setOpenLinks(False)
        self._text.setMinimumWidth(LEAST_WIDTH_PX)
        self._manual = QPushButton(self)
        self._manual.clicked.connect(self.open_manual)
        self._problem = QLabel(self)
        self._problem.setProperty("kind", "warning")
        self._problem.setWordWrap(True)
        self._problem.hide()
        self._lay_out()
        self.setAllowedAreas(
            Qt.DockWidgetArea.RightDockWidgetArea | Qt.DockWidgetArea.LeftDockWidgetArea
        )
        self._focus_before: QWidget | None = None
        self._is_pushed_out = False
        escape = QShortcut(QKeySequence(Qt.Key.Key_Escape), self._text, self._put_away)
        escape.setContext(Qt.ShortcutContext.WidgetShortcut)
        QShortcut(QKeySequence(MANUAL_KEY), parent or self, self.open_manual)
        self.retranslate()
        self.hide()

    def _lay_out(self) -> None:
        content = QWidget(self)
        column = QVBoxLayout(content)
        column.setContentsMargins(0, 0, 0, 0)
        for part in (self._text, self._problem, self._manual):
            column.addWidget(part)
        self.setWidget(content)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setWindowTitle(_("Help"))
        self._manual.setText(_("Open the manual"))
        keys = QKeySequence(MANUAL_KEY).toString(QKeySequence.SequenceFormat.NativeText)
        tip = _("Everything about this screen, with figures, in the browser")
        self._manual.setToolTip(f"{tip} ({keys})")
        self._problem.hide()  # a sentence of the page or the language before
        self._text.setAccessibleName(_("Help"))
        self._text.setMarkdown(read_help(self._name, spoken_language()))
        self._name_frame()

    def _name_frame(self) -> None:
        """Name the buttons of the frame for screen readers; Qt does it once, when they are made."""
        for name, texts in FRAME_TEXTS.items():
            button = self.findChild(QAbstractButton, name)
            if button is not None:
                title, told = (QCoreApplication.translate(QT_CONTEXT, text) for text in texts)
                button.setAccessibleName(title)
                button.setAccessibleDescription(told)

    def show_page(self, name: str) -> None:
        """Show the page of a screen; Escape leads back to where the user was."""
        self._name = name
        if not self._text.hasFocus():
            self._focus_before = QApplication.focusWidget()
        self.retranslate()
        self.show()
        self._text.setFocus()

    def open_manual(self) -> None:
        """Open the manual where it tells of the screen that is seen; say where it cannot be."""
        page = manual_page(self._name, spoken_language())
        if page is None:
            self._tell(_("The manual is not there. Install the program again, or: make manual"))
        elif not QDesktopServices.openUrl(QUrl.fromLocalFile(str(page))):
            self._tell(
                _("Nothing opens the manual here. Open this file in a browser: {file}").format(
                    file=page
                )
            )

    def _tell(self, sentence: str) -> None:
        self.show_page(self._name)
        self._problem.setText(sentence)
        self._problem.setAccessibleName(sentence)
        self._problem.show()

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
