"""A part of a page that scrolls where it has less room than it needs."""

from PySide6.QtCore import QEvent, Qt
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget


class Scrolled(QScrollArea):
    """A column that is never squeezed: up and down it scrolls, and sideways where it must.

    What `keep_lines` was told of is at least so many lines of letters high.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        content = QWidget(self)
        self.column = QVBoxLayout(content)
        self.column.setContentsMargins(0, 0, 0, 0)
        self._kept: dict[QWidget, int] = {}
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setWidget(content)
        for part in (self.viewport(), content):
            part.setAutoFillBackground(False)  # what lies behind shines through

    def keep_lines(self, part: QWidget, n_lines: int) -> None:
        """Never make a part lower than so many lines."""
        self._kept[part] = n_lines
        self._fit()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._fit()

    def _fit(self) -> None:
        line_px = self.fontMetrics().height()
        for part, n_lines in self._kept.items():
            part.setMinimumHeight(n_lines * line_px)
