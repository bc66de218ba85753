"""What a screen shows that has nothing yet: a sentence, and the way to what it needs."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QPushButton, QVBoxLayout, QWidget

SPACING_PX = 16


class FirstStep(QWidget):
    """A sentence in the middle of the screen, and a button below it; more may follow."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._sentence, self.button = QLabel(self), QPushButton(self)
        self._sentence.setWordWrap(True)
        self._sentence.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._sentence.setProperty("kind", "title")
        self.button.setProperty("main", "true")
        self._column = QVBoxLayout(self)
        self._column.setSpacing(SPACING_PX)
        self._column.addStretch()
        self._column.addWidget(self._sentence)
        self._column.addWidget(self.button, 0, Qt.AlignmentFlag.AlignHCenter)
        self._column.addStretch()

    def add(self, widget: QWidget) -> None:
        """Show one more widget below the others."""
        self._column.insertWidget(
            self._column.count() - 1, widget, 0, Qt.AlignmentFlag.AlignHCenter
        )

    def say(self, sentence: str, button: str) -> None:
        """Set both texts in the language in use."""
        self._sentence.setText(sentence)
        self.button.setText(button)
