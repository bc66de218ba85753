"""Colours and pictures in lists and on buttons: as they are, also where they are chosen."""

from PySide6.QtGui import QColor, QIcon, QPainter, QPixmap

from ui.theme import SWATCH_BORDER


def swatch(color: QColor, size_px: int) -> QPixmap:
    """Return a square of a colour; its border tells it from the ground of both themes."""
    pixmap = QPixmap(size_px, size_px)
    pixmap.fill(color)
    painter = QPainter(pixmap)
    painter.setPen(QColor(SWATCH_BORDER))
    painter.drawRect(0, 0, size_px - 1, size_px - 1)
    painter.end()
    return pixmap


def true_icon(pixmap: QPixmap) -> QIcon:
    """Return an icon that keeps its colours where its line is chosen: Qt would tint them."""
    icon = QIcon(pixmap)
    icon.addPixmap(pixmap, QIcon.Mode.Selected)
    return icon
