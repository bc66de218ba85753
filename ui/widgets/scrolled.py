"""A part of a page or dialog that scrolls where it has less room than it needs."""

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtWidgets import QDialog, QFrame, QScrollArea, QVBoxLayout, QWidget

SHARE_OF_WINDOW = 0.95
"""That a dialog may take."""


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

    def hold_words(self) -> None:
        """Let Tab stop here where there is more to read than is seen; for words, not controls."""
        self.setObjectName("words")
        self.verticalScrollBar().rangeChanged.connect(self._stop_where_longer)

    def keep_lines(self, part: QWidget, n_lines: int) -> None:
        """Never make a part lower than so many lines."""
        self._kept[part] = n_lines
        self._fit()

    def height_in(self, dialog: QDialog, width_px: int, below_px: int) -> int:
        """Return how high a dialog shows all of this, within the window.

        Parameters
        ----------
        dialog : QDialog
            Laid out as a column with this in it.
        width_px : int
            Of the dialog.
        below_px : int
            Height of what stands under this.
        """
        around, column = dialog.contentsMargins(), dialog.layout()
        if column is not None:
            around = column.contentsMargins()
            below_px += column.spacing()
        inside_px = width_px - around.left() - around.right()
        wished_px = self.column.totalHeightForWidth(inside_px) + below_px
        wished_px += around.top() + around.bottom()
        return min(wished_px, round(SHARE_OF_WINDOW * window_room(dialog).height()))

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._fit()

    def _stop_where_longer(self, _least: int, most: int) -> None:
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus if most else Qt.FocusPolicy.NoFocus)

    def _fit(self) -> None:
        line_px = self.fontMetrics().height()
        for part, n_lines in self._kept.items():
            part.setMinimumHeight(n_lines * line_px)


def window_room(dialog: QDialog) -> QSize:
    """Return the size of the window that a dialog belongs to, else of the screen."""
    parent = dialog.parentWidget()
    return dialog.screen().size() if parent is None else parent.window().size()
