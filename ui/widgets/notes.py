"""Sentences above what they are on: some lines of them are seen, the rest is scrolled to."""

from PySide6.QtCore import QEvent
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QLabel, QWidget

from ui.widgets.scrolled import Scrolled

MOST_LINES = 5
EDGE_PX = 1
"""Of the frame that shows the focus, as the style sheet draws it."""


class Notes(Scrolled):
    """As high as its sentences, but for many; nothing is seen where there are none."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.hold_words()
        self._label = QLabel(self)
        self._label.setWordWrap(True)
        self._label.setProperty("kind", "warning")
        self.column.addWidget(self._label)
        self.hide()

    def say(self, sentences: tuple[str, ...]) -> None:
        """Say these, each on a line of its own."""
        told = "\n".join(sentences)
        self._label.setText(told)
        self.setAccessibleName(told)
        self.verticalScrollBar().setValue(0)
        self.setVisible(bool(told))
        self._make_room()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        super().resizeEvent(event)
        self._make_room()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._make_room()

    def _make_room(self) -> None:
        """Be as high as all lines, or as the most that are seen at once."""
        whole_px = max(self._label.heightForWidth(self.viewport().width()), 0)
        most_px = MOST_LINES * self._label.fontMetrics().lineSpacing()
        self.setFixedHeight(min(whole_px, most_px) + 2 * EDGE_PX)
