"""A line of text that is shortened where there is no room for it, and never asks for more."""

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QLabel, QStyle, QStyleOption

LEAST_LETTERS = 6


class ElidedLabel(QLabel):
    """Shows its text up to where it fits; the tip has all of it then."""

    def minimumSizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        usual = super().minimumSizeHint()
        least = LEAST_LETTERS * self.fontMetrics().averageCharWidth()
        return QSize(min(usual.width(), least), usual.height())

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802  (Qt's name)
        room = self.contentsRect()
        metrics = self.fontMetrics()
        shown = metrics.elidedText(self.text(), Qt.TextElideMode.ElideRight, room.width())
        self.setToolTip(self.text() if shown != self.text() else "")
        painter, option = QPainter(self), QStyleOption()
        option.initFrom(self)
        self.style().drawPrimitive(QStyle.PrimitiveElement.PE_Widget, option, painter, self)
        is_enabled, role = self.isEnabled(), self.foregroundRole()
        flags = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft
        self.style().drawItemText(painter, room, flags, self.palette(), is_enabled, shown, role)
