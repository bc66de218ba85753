"""The picture that is painted on: a drag of the left button is a stroke."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QWidget

from ui.widgets.image_view import ImageView

LEFT = Qt.MouseButton.LeftButton


class PaintView(ImageView):
    """Shows a frame; with `set_painting` a drag paints, else it moves the picture.

    The middle button moves the picture in any case, and a double click closes a polygon.
    """

    painted = Signal(float, float)
    """A stroke came to this pixel."""
    paint_ended = Signal()
    closed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._is_brush = True
        self._is_painting = False

    def set_painting(self, *, is_on: bool) -> None:
        """Let a drag of the left button paint."""
        self._is_brush = is_on

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        if self._is_brush and event.button() == LEFT:
            self._is_painting = True
            self._paint_at(event)
        else:
            super().mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        if self._is_painting:
            self._paint_at(event)
        else:
            super().mouseMoveEvent(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        if self._is_painting and event.button() == LEFT:
            self._is_painting = False
            self.paint_ended.emit()
        else:
            super().mouseReleaseEvent(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        if self._is_brush:
            self.mousePressEvent(event)
        elif event.button() == LEFT:
            self.closed.emit()

    def _paint_at(self, event: QMouseEvent) -> None:
        at = event.position()
        u, v = self.placement.to_picture(at.x(), at.y())
        self.painted.emit(u, v)
