"""Pages of tabs that are made of several parts."""

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QScrollArea, QVBoxLayout, QWidget


class ScrolledParts(QScrollArea):
    """Parts below each other: a seventh tab has no room with large letters."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._page = _Page()
        self._column = QVBoxLayout(self._page)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.addStretch()
        self.setWidgetResizable(True)
        self.setWidget(self._page)
        self.setFrameShape(QScrollArea.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # it follows the fields in it
        for part in (self.viewport(), self._page):
            part.setAutoFillBackground(False)  # the frame of the tabs shines through

    def add(self, *parts: QWidget) -> None:
        """Put parts below those that are there."""
        for part in parts:
            self._column.insertWidget(self._column.count() - 1, part)


class _Page(QWidget):
    """As high as it needs at its width; Qt would ask for the height of its narrowest shape."""

    def minimumSizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        return QSize(super().minimumSizeHint().width(), 0)
