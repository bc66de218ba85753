"""Lists whose lines have several rows of words, beside a box to check."""

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QSize, Qt
from PySide6.QtWidgets import (
    QListWidget,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)


class WrappedLines(QListWidget):
    """A list as wide as there is room: words wrap, nothing is cut."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWordWrap(True)
        self.setResizeMode(QListWidget.ResizeMode.Adjust)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setItemDelegate(_WrappedLine(self))


class _WrappedLine(QStyledItemDelegate):
    """Asks for the height that words need beside the box; Qt leaves the box out."""

    def sizeHint(  # noqa: N802  (Qt's name)
        self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> QSize:
        hint = super().sizeHint(option, index)
        lines = option.widget
        if not isinstance(lines, WrappedLines):
            return hint
        style = lines.style()
        margin = style.pixelMetric(QStyle.PixelMetric.PM_FocusFrameHMargin, option, lines) + 1
        box = style.pixelMetric(QStyle.PixelMetric.PM_IndicatorWidth, option, lines)
        width = lines.viewport().width() - box - 4 * margin
        words = lines.fontMetrics().boundingRect(
            0, 0, width, 0, Qt.TextFlag.TextWordWrap, index.data(Qt.ItemDataRole.DisplayRole)
        )
        return QSize(hint.width(), max(hint.height(), words.height() + 2 * margin))
