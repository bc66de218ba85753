"""Asks for a word before anything is removed for good."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QDialog,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _

LETTERS_IN_A_LINE = 64


class TypedConsent(QDialog):
    """Can be confirmed once the word is there; Enter and Escape alone remove nothing.

    Parameters
    ----------
    explanation : str
        What will be removed.
    word : str
        What has to be typed; upper and lower case are the same.
    """

    confirmed = Signal()

    def __init__(self, explanation: str, word: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(_("Remove for good"))
        self._word = word
        text, ask = QLabel(explanation, self), QLabel(self)
        ask.setText(_("&Type {word} to confirm:").format(word=word))
        self.field = QLineEdit(self)
        ask.setBuddy(self.field)
        self.remove, keep = QPushButton(_("&Remove for good"), self), QPushButton(_("&Keep"), self)
        self.remove.setProperty("danger", "true")
        self.remove.setEnabled(False)
        keep.setDefault(True)
        for label in (text, ask):
            label.setWordWrap(True)
        self.field.textChanged.connect(self._on_typed)
        self.remove.clicked.connect(self.confirmed)
        self.remove.clicked.connect(self.accept)
        keep.clicked.connect(self.reject)
        buttons = QHBoxLayout()
        buttons.addStretch(1)
        buttons.addWidget(keep)
        buttons.addWidget(self.remove)
        column = QVBoxLayout(self)
        column.setContentsMargins(24, 20, 24, 20)
        column.setSpacing(12)
        for widget in (text, ask, self.field):
            column.addWidget(widget)
        column.addLayout(buttons)
        width = self.fontMetrics().averageCharWidth() * LETTERS_IN_A_LINE
        self.setMinimumSize(width, column.totalHeightForWidth(width))

    def _on_typed(self, text: str) -> None:
        self.remove.setEnabled(text.strip().casefold() == self._word.casefold())
