"""A picture that can be looked at closely, pointed at, and drawn upon."""

import math
from collections.abc import Callable
from dataclasses import replace

from PySide6.QtCore import QEvent, QPointF, QRect, QRectF, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFocusEvent,
    QHelpEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from adibas.arrays import Float32Array, UInt8Array
from ui.theme import DRAWN, PICTURE_GROUND
from ui.widgets.image_geometry import ImagePlacement
from ui.widgets.image_rects import covered_rect, fitted_size, rect_with_rim, rects_beside
from ui.widgets.overlay_painter import GRAB_PX, paint_overlays
from ui.widgets.overlays import Dot, Overlay
from ui.widgets.shown_picture import Coloring, ShownPicture

GROUND = QColor(PICTURE_GROUND)
WHEEL_STEP = 1.2
DRAG_PX = 4
"""A press that moves less is a click."""
LARGE_STEP_PX, SMALL_STEP_PX = 10.0, 0.1
"""Of an arrow with Shift, and with Ctrl."""
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
    is zoomed), wheel to zoom. With the keyboard: arrows move a cross by a pixel, with Shift by ten,
    with Ctrl by a tenth (or nudge, see `set_nudging`); Space or Enter clicks, Tab stays with Qt,
    ``+ - 0`` zoom. A dot that is dragged keeps its distance from the mouse.
    """

    clicked = Signal(float, float)
    """Pixel (u, v) of the picture."""
    pointed = Signal(float, float)
    """The mouse or the cross came to this pixel."""
    dot_pressed = Signal(str)
    dot_dragged = Signal(str, float, float)
    dot_dropped = Signal(str, float, float)
    nudged = Signal(float, float)
    """By (du, dv) pixels of the picture, while an arrow is held."""
    nudge_ended = Signal()
    """The arrow was let go."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._picture: ShownPicture | None = None
        self._placement = ImagePlacement((1, 1), (1, 1))
        self._overlays: tuple[Overlay, ...] = ()
        self._cross: tuple[float, float] | None = None
        self._pressed_at: QPointF | None = None
        self._grabbed: Dot | None = None
        self._grab_offset = (0.0, 0.0)
        self._is_moving = False
        self._is_nudging = False
        self._has_nudged = False
        self.modifiers = Qt.KeyboardModifier.NoModifier
        self._placeholder = ""
        self._draws_beside = False
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)  # nothing shines through
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(160, 120)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def set_picture(self, picture_rgb: UInt8Array | None) -> None:
        """Show an (H, W, 3) picture; zoom and place stay where the size stays."""
        if picture_rgb is None:
            self._picture = None
            self.update()
        else:
            self._show(ShownPicture(picture_rgb))

    def set_numbers(self, numbers: Float32Array, coloring: Coloring) -> None:
        """Show an (H, W) picture of numbers: it is drawn for less than one of colours."""
        self._show(ShownPicture(numbers, coloring))

    def _show(self, picture: ShownPicture) -> None:
        self._refresh()
        self._picture = picture
        if self._placement.picture != picture.size:
            self._placement = replace(self._placement, picture=picture.size).fitted()
            self._cross = None
            self.update()

    def set_overlays(self, overlays: tuple[Overlay, ...]) -> None:
        """Draw these over the picture."""
        self._overlays = overlays
        self._refresh()

    def _refresh(self) -> None:
        """Have the picture painted anew; what is beside it only where something is drawn there."""
        if self._picture is None or self._draws_beside or self._placement.zoom != 1:
            self.update()
        else:
            self.update(rect_with_rim(self._placement, self.devicePixelRatioF()))

    def set_rotation(self, rotation_deg: int) -> None:
        """Turn the picture clockwise by 0, 90, 180 or 270 degrees."""
        if rotation_deg != self._placement.rotation_deg:
            self._placement = replace(self._placement, rotation_deg=rotation_deg).fitted()
            self.update()

    def set_placeholder(self, text: str) -> None:
        """Say this where there is no picture."""
        self._placeholder = text
        self.update()

    def set_nudging(self, *, is_on: bool) -> None:
        """Let arrows nudge what is chosen (`nudged`) instead of moving the cross."""
        if not is_on:
            self._end_nudge()
        self._is_nudging = is_on

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
        if self._picture is None:
            painter.fillRect(event.rect(), GROUND)
            painter.setPen(QColor("#B3C0CB"))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, self._placeholder)
        else:
            self._paint_picture(painter, self._picture)
            reach = paint_overlays(painter, self._placement, self._overlays)
            self._paint_cross(painter)
            self._note_reach(reach, event.rect())
        if self.hasFocus():
            painter.setPen(QColor(DRAWN["plumb"]))
            painter.drawRect(self.rect().adjusted(0, 0, -1, -1))

    def _note_reach(self, reach: QRectF, painted: QRect) -> None:
        """Have all painted anew where something came beside the picture that was cut off."""
        inside = QRectF(rect_with_rim(self._placement, self.devicePixelRatioF()))
        self._draws_beside = not (reach.isEmpty() or inside.contains(reach))
        if self._draws_beside and not painted.contains(self.rect()):
            self.update()

    def _paint_picture(self, painter: QPainter, picture: ShownPicture) -> None:
        place = self._placement
        if place.zoom == 1:
            ratio = self.devicePixelRatioF()
            image = picture.fitted(fitted_size(place, ratio), place.rotation_deg, ratio)
            covered = covered_rect(place, ratio)
            for beside in rects_beside(self.rect(), covered):
                painter.fillRect(beside, GROUND)
            painter.drawImage(covered.topLeft(), image)
            return
        painter.fillRect(self.rect(), GROUND)
        painter.save()
        is_small = place.scale < 1
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, is_small)
        painter.translate(self.width() / 2, self.height() / 2)
        painter.rotate(place.rotation_deg)
        painter.scale(place.scale, place.scale)
        left, top = -0.5 - place.center[0], -0.5 - place.center[1]
        painter.drawImage(QRectF(left, top, *picture.size), picture.whole())
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
        self.modifiers = event.modifiers()
        self._pressed_at = event.position()
        self._is_moving = event.button() == Buttons.MiddleButton
        if event.button() == Buttons.LeftButton:
            self._grabbed = self._dot_at(event.position())
            if self._grabbed is not None:
                u, v = self._placement.to_picture(event.position().x(), event.position().y())
                self._grab_offset = self._grabbed.u - u, self._grabbed.v - v
                self.dot_pressed.emit(self._grabbed.name)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        at = event.position()
        u, v = self._placement.to_picture(at.x(), at.y())
        if self._pressed_at is None:
            self.pointed.emit(u, v)
            return
        step = at - self._pressed_at
        if not self._is_moving and math.hypot(step.x(), step.y()) < DRAG_PX:
            return
        if self._grabbed is None:
            self._is_moving = True
            self._pressed_at = at
            self._place(self._placement.moved(step.x(), step.y()))
        elif self._grabbed.is_movable:
            self._is_moving = True
            self.dot_dragged.emit(self._grabbed.name, *self._held(u, v))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        grabbed, was_moving = self._grabbed, self._is_moving
        was_pressed = self._pressed_at is not None
        self._pressed_at, self._grabbed, self._is_moving = None, None, False
        if self._picture is None or not was_pressed or event.button() != Buttons.LeftButton:
            return
        self.modifiers = event.modifiers()
        u, v = self._placement.to_picture(event.position().x(), event.position().y())
        if grabbed is not None and was_moving:
            self.dot_dropped.emit(grabbed.name, *self._held(u, v))
        elif grabbed is None and not was_moving and self._placement.contains(u, v):
            self._cross = (u, v)
            self.clicked.emit(u, v)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        key = Keys(event.key())
        if self._picture is None:
            super().keyPressEvent(event)
        elif key in ARROWS:
            step = _step_px(event.modifiers())
            move = self._nudge if self._is_nudging else self._move_cross
            move(step * ARROWS[key][0], step * ARROWS[key][1])
        elif key in (Keys.Key_Space, Keys.Key_Return, Keys.Key_Enter) and self._cross is not None:
            self._click_cross(*self._cross)
        elif key in (Keys.Key_Plus, Keys.Key_Equal):
            self.zoom_by(WHEEL_STEP)
        elif key == Keys.Key_Minus:
            self.zoom_by(1 / WHEEL_STEP)
        elif key == Keys.Key_0:
            self.fit()
        else:
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        if event.key() in ARROWS and not event.isAutoRepeat():
            self._end_nudge()
        else:
            super().keyReleaseEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:  # noqa: N802  (Qt's name)
        self._end_nudge()
        super().focusOutEvent(event)

    def event(self, event: QEvent) -> bool:
        """Tell what the dot under the mouse says."""
        if not isinstance(event, QHelpEvent):
            return super().event(event)
        dot = self._nearest_dot(QPointF(event.pos()), lambda one: bool(one.tooltip or one.label))
        if dot is None:
            QToolTip.hideText()
        else:  # a name is not drawn where it would hide another one
            QToolTip.showText(event.globalPos(), dot.tooltip or dot.label, self)
        return True

    def _nudge(self, dx: float, dy: float) -> None:
        """Tell of a step along the directions seen."""
        place = self._placement
        u, v = place.to_picture(0.0, 0.0)
        u2, v2 = place.to_picture(dx * place.scale, dy * place.scale)
        self._has_nudged = True
        self.nudged.emit(u2 - u, v2 - v)

    def _end_nudge(self) -> None:
        if self._has_nudged:
            self._has_nudged = False
            self.nudge_ended.emit()

    def _click_cross(self, u: float, v: float) -> None:
        """Do what a click of the mouse there would do."""
        dot = self._dot_at(QPointF(*self._placement.to_widget(u, v)))
        self.modifiers = Qt.KeyboardModifier.NoModifier
        if dot is None:
            self.clicked.emit(u, v)
        else:
            self.dot_pressed.emit(dot.name)

    def _held(self, u: float, v: float) -> tuple[float, float]:
        """Return where the dot is whose grabbed place is at (u, v), inside the picture."""
        width, height = self._placement.picture
        return (
            min(max(u + self._grab_offset[0], 0.0), width - 1.0),
            min(max(v + self._grab_offset[1], 0.0), height - 1.0),
        )

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
        """Return the nearest dot within reach of the mouse that can be moved or chosen."""
        return self._nearest_dot(at, lambda dot: dot.is_movable or dot.is_pickable)

    def _nearest_dot(self, at: QPointF, is_meant: Callable[[Dot], bool]) -> Dot | None:
        nearest, least = None, math.inf
        for overlay in self._overlays:
            if isinstance(overlay, Dot) and is_meant(overlay):
                x, y = self._placement.to_widget(overlay.u, overlay.v)
                distance = math.hypot(x - at.x(), y - at.y())
                reach = max(GRAB_PX, overlay.radius_px * self._placement.scale)
                if distance <= reach and distance < least:
                    nearest, least = overlay, distance
        return nearest

    def _place(self, placement: ImagePlacement) -> None:
        self._placement = placement
        self.update()


def _step_px(modifiers: Qt.KeyboardModifier) -> float:
    if modifiers & Qt.KeyboardModifier.ShiftModifier:
        return LARGE_STEP_PX
    return SMALL_STEP_PX if modifiers & Qt.KeyboardModifier.ControlModifier else 1.0
