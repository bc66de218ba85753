"""A picture that can be looked at closely, pointed at, and drawn upon."""

import math
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from adibas.arrays import UInt8Array
from ui.theme import DRAWN
from ui.widgets.image_geometry import ImagePlacement
from ui.widgets.overlay_painter import GRAB_PX, paint_overlay
from ui.widgets.overlays import Dot, Overlay

WHEEL_STEP = 1.2
DRAG_PX = 4
"""A press that moves less is a click."""
Buttons = Qt.MouseButton
Keys = Qt.Key
ARROWS = {
    Keys.Key_Left: (-1, 0),
    Keys.Key_Right: (1, 0),
    Keys.Key_Up: (0, -1),
    Keys.Key_Down: (0, 1),
}


class ImageView(QWidget):
    """Shows an RGB picture, fitted or zoomed, and overlays in the picture's pixels.

    With the mouse: click, drag a movable dot, drag the picture (middle button, or left where it
    is zoomed), wheel to zoom. With the keyboard: arrows move a cross (or the dot that is held),
    Shift makes larger steps, Space or Enter clicks, Tab stays with Qt, ``+ - 0`` zoom.
    """

    clicked = Signal(float, float)
    """Pixel (u, v) of the picture."""
    pointed = Signal(float, float)
    """The mouse or the cross came to this pixel."""
    dot_pressed = Signal(str)
    dot_dragged = Signal(str, float, float)
    dot_dropped = Signal(str, float, float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._picture: UInt8Array | None = None
        self._image = QImage()
        self._placement = ImagePlacement((1, 1), (1, 1))
        self._overlays: tuple[Overlay, ...] = ()
        self._cross: tuple[float, float] | None = None
        self._pressed_at: QPointF | None = None
        self._grabbed: Dot | None = None
        self._is_moving = False
        self._placeholder = ""
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(160, 120)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def set_picture(self, picture_rgb: UInt8Array | None) -> None:
        """Show an (H, W, 3) picture; zoom and place stay where the size stays."""
        if picture_rgb is None:
            self._picture, self._image = None, QImage()
            self.update()
            return
        self._picture = np.ascontiguousarray(picture_rgb)  # the image only borrows the pixels
        height, width = self._picture.shape[:2]
        self._image = QImage(
            self._picture.data, width, height, 3 * width, QImage.Format.Format_RGB888
        )
        if self._placement.picture != (width, height):
            self._placement = replace(self._placement, picture=(width, height)).fitted()
            self._cross = None
        self.update()

    def set_overlays(self, overlays: tuple[Overlay, ...]) -> None:
        """Draw these over the picture."""
        self._overlays = overlays
        self.update()

    def set_rotation(self, rotation_deg: int) -> None:
        """Turn the picture clockwise by 0, 90, 180 or 270 degrees."""
        if rotation_deg != self._placement.rotation_deg:
            self._placement = replace(self._placement, rotation_deg=rotation_deg).fitted()
            self.update()

    def set_placeholder(self, text: str) -> None:
        """Say this where there is no picture."""
        self._placeholder = text
        self.update()

    @property
    def placement(self) -> ImagePlacement:
        """Where the picture lies; for tests and for what is drawn beside it."""
        return self._placement

    def fit(self) -> None:
        """Show the whole picture."""
        self._place(self._placement.fitted())

    def zoom_by(self, factor: float) -> None:
        """Come nearer to the middle, or go away from it."""
        x, y = self.width() / 2, self.height() / 2
        self._place(self._placement.zoomed(factor, x, y))

    def show_pixel(self, u: float, v: float) -> None:
        """Move the picture so that pixel (u, v) is seen."""
        x, y = self._placement.to_widget(u, v)
        if not self.rect().adjusted(20, 20, -20, -20).contains(int(x), int(y)):
            self._place(self._placement.centered(u, v))

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802  (Qt's name)
        painter = QPainter(self)
        painter.fillRect(event.rect(), QColor("#11161B"))
        if self._image.isNull():
            painter.setPen(QColor("#B3C0CB"))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, self._placeholder)
        else:
            self._paint_picture(painter)
            for overlay in self._overlays:
                paint_overlay(painter, self._placement, overlay)
            self._paint_cross(painter)
        if self.hasFocus():
            painter.setPen(QColor(DRAWN["plumb"]))
            painter.drawRect(self.rect().adjusted(0, 0, -1, -1))

    def _paint_picture(self, painter: QPainter) -> None:
        place = self._placement
        painter.save()
        is_small = place.scale < 1
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, is_small)
        painter.translate(self.width() / 2, self.height() / 2)
        painter.rotate(place.rotation_deg)
        painter.scale(place.scale, place.scale)
        left, top = -0.5 - place.center[0], -0.5 - place.center[1]
        painter.drawImage(QRectF(left, top, self._image.width(), self._image.height()), self._image)
        painter.restore()

    def _paint_cross(self, painter: QPainter) -> None:
        if self._cross is None or not self.hasFocus():
            return
        x, y = self._placement.to_widget(*self._cross)
        for color, width in (("#000000", 3), (DRAWN["focus"], 1)):
            pen = painter.pen()
            pen.setColor(QColor(color))
            pen.setWidth(width)
            painter.setPen(pen)
            for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                start, end = QPointF(x + 4 * dx, y + 4 * dy), QPointF(x + 14 * dx, y + 14 * dy)
                painter.drawLine(start, end)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        was_fitted = self._placement.zoom == 1.0
        self._placement = replace(
            self._placement, widget=(max(self.width(), 1), max(self.height(), 1))
        )
        if was_fitted:
            self._placement = self._placement.fitted()
        super().resizeEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802  (Qt's name)
        steps = event.angleDelta().y() / 120
        at = event.position()
        self._place(self._placement.zoomed(WHEEL_STEP**steps, at.x(), at.y()))
        event.accept()

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        if self._picture is None:
            return
        self._pressed_at = event.position()
        self._is_moving = event.button() == Buttons.MiddleButton
        if event.button() == Buttons.LeftButton:
            self._grabbed = self._dot_at(event.position())
            if self._grabbed is not None:
                self.dot_pressed.emit(self._grabbed.label)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        at = event.position()
        u, v = self._placement.to_picture(at.x(), at.y())
        if self._pressed_at is None:
            self.pointed.emit(u, v)
            return
        step = at - self._pressed_at
        if self._grabbed is not None:
            if self._is_moving or math.hypot(step.x(), step.y()) >= DRAG_PX:
                self._is_moving = True
                self.dot_dragged.emit(self._grabbed.label, u, v)
        elif self._is_moving or math.hypot(step.x(), step.y()) >= DRAG_PX:
            self._is_moving = True
            self._pressed_at = at
            self._place(self._placement.moved(step.x(), step.y()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        grabbed, was_moving = self._grabbed, self._is_moving
        was_pressed = self._pressed_at is not None
        self._pressed_at, self._grabbed, self._is_moving = None, None, False
        if self._picture is None or not was_pressed or event.button() != Buttons.LeftButton:
            return
        u, v = self._placement.to_picture(event.position().x(), event.position().y())
        if grabbed is not None and was_moving:
            self.dot_dropped.emit(grabbed.label, u, v)
        elif grabbed is None and not was_moving and self._placement.contains(u, v):
            self._cross = (u, v)
            self.clicked.emit(u, v)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        key = Keys(event.key())
        if self._picture is None:
            super().keyPressEvent(event)
        elif key in ARROWS:
            step = 10.0 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1.0
            self._move_cross(step * ARROWS[key][0], step * ARROWS[key][1])
        elif key in (Keys.Key_Space, Keys.Key_Return, Keys.Key_Enter) and self._cross is not None:
            self.clicked.emit(*self._cross)
        elif key in (Keys.Key_Plus, Keys.Key_Equal):
            self.zoom_by(WHEEL_STEP)
        elif key == Keys.Key_Minus:
            self.zoom_by(1 / WHEEL_STEP)
        elif key == Keys.Key_0:
            self.fit()
        else:
            super().keyPressEvent(event)

    def _move_cross(self, dx: float, dy: float) -> None:
        """Move the keyboard's cross by picture pixels along the directions seen."""
        place = self._placement
        if self._cross is None:
            self._cross = place.to_picture(self.width() / 2, self.height() / 2)
        x, y = place.to_widget(*self._cross)
        u, v = place.to_picture(x + dx * place.scale, y + dy * place.scale)
        if place.contains(u, v):
            self._cross = (u, v)
            self.show_pixel(u, v)
            self.pointed.emit(u, v)
        self.update()

    def _dot_at(self, at: QPointF) -> Dot | None:
        """Return the nearest movable dot within reach of the mouse."""
        nearest, least = None, math.inf
        for overlay in self._overlays:
            if isinstance(overlay, Dot) and overlay.is_movable:
                x, y = self._placement.to_widget(overlay.u, overlay.v)
                distance = math.hypot(x - at.x(), y - at.y())
                reach = max(GRAB_PX, overlay.radius_px * self._placement.scale)
                if distance <= reach and distance < least:
                    nearest, least = overlay, distance
        return nearest

    def _place(self, placement: ImagePlacement) -> None:
        self._placement = placement
        self.update()
