"""A page that has something to show, or says what to do first."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QStackedWidget, QWidget


class EmptyOr(QStackedWidget):
    """The content, or a sentence in the middle of its room."""

    def __init__(self, content: QWidget, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._sentence = QLabel(self)
        self._sentence.setWordWrap(True)
        self._sentence.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._sentence.setProperty("kind", "quiet")
        self.addWidget(content)
        self.addWidget(self._sentence)

    def say(self, sentence: str) -> None:
        """Say this in place of the content; nothing: show the content."""
        self._sentence.setText(sentence)
        self.setCurrentIndex(1 if sentence else 0)

    @property
    def said(self) -> str:
        """What is said in place of the content."""
        return self._sentence.text() if self.currentIndex() else ""
