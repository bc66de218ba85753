"""A picture that is worked on: pointed at, its dots chosen and dragged, by mouse and keyboard."""

import math
from collections.abc import Callable

from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QColor, QFocusEvent, QHelpEvent, QKeyEvent, QMouseEvent, QPainter
from PySide6.QtWidgets import QToolTip, QWidget

from ui.theme import DRAWN
from ui.widgets.overlay_painter import GRAB_PX
from ui.widgets.overlays import Dot
from ui.widgets.picture_canvas import WHEEL_STEP, PictureCanvas

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


class ImageView(PictureCanvas):
    """A picture to work on.

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
        self._cross: tuple[float, float] | None = None
        self._pressed_at: QPointF | None = None
        self._grabbed: Dot | None = None
        self._grab_offset = (0.0, 0.0)
        self._is_moving = False
        self._is_nudging = False
        self._has_nudged = False
        self.modifiers = Qt.KeyboardModifier.NoModifier
        self.setMouseTracking(True)

    def set_nudging(self, *, is_on: bool) -> None:
        """Let arrows nudge what is chosen (`nudged`) instead of moving the cross."""
        if not is_on:
            self._end_nudge()
        self._is_nudging = is_on

    def picture_resized(self) -> None:
        """Forget the cross, too."""
        self._cross = None
        super().picture_resized()

    def paint_above(self, painter: QPainter) -> None:
        """Paint the keyboard's cross."""
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


def _step_px(modifiers: Qt.KeyboardModifier) -> float:
    if modifiers & Qt.KeyboardModifier.ShiftModifier:
        return LARGE_STEP_PX
    return SMALL_STEP_PX if modifiers & Qt.KeyboardModifier.ControlModifier else 1.0
