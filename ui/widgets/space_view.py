"""A surface and landmarks from any side; painted without OpenGL, so that it works anywhere."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

import numpy as np
from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import (
    QColor,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
    QWheelEvent,
)
from PySide6.QtWidgets import QWidget

from adibas.arrays import Float32Array, FloatArray
from adibas.data.discs import Discs
from adibas.data.landmark_texts import landmark_text
from adibas.texts import translate as _
from ui.theme import DRAWN, PICTURE_GROUND
from ui.widgets.label_places import Ring
from ui.widgets.overlay_painter import paint_names
from ui.widgets.space import Space

GROUND = QColor(PICTURE_GROUND)
WHEEL_STEP = 1.2
TURN_PER_PX = 0.008
TURN_PER_KEY = 0.1
STEEPEST_RAD = 1.4
LEAST_ZOOM, MOST_ZOOM = 0.3, 8.0
DOT_PX = 4.0
PATH_PX = 2.0
LEAST_SIZE_M = 0.3
ON_SIDE_DEG = (90, 270)
OUTLIERS_PERCENT, ROOM = 0.5, 1.08
"""What is left aside at each end, and how much more than the rest is seen."""
AROUND_PX, BEHIND_M = 4, 0.05
"""A landmark that lies so far behind what is seen around it is on the other side."""
OVERLAP = 1.3
"""Discs are made so much larger: measured ones do not lie evenly."""
TURNS = {
    Qt.Key.Key_Left: (-TURN_PER_KEY, 0.0),
    Qt.Key.Key_Right: (TURN_PER_KEY, 0.0),
    Qt.Key.Key_Up: (0.0, -TURN_PER_KEY),
    Qt.Key.Key_Down: (0.0, TURN_PER_KEY),
}


AnyFloats = TypeVar("AnyFloats", FloatArray, Float32Array)


class SpaceView(QWidget):
    """Turns with the mouse or the arrows, comes nearer with the wheel or plus, 0 looks from ahead.

    It is projected in parallel: distances across the view can be compared.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._space: Space | None = None
        self._empty_text = ""
        self._middle_m = np.zeros(3)
        self._sizes_m = np.ones(2)
        self._nearest_m = np.zeros((0, 0), np.float32)
        self._yaw_rad, self._pitch_rad, self._zoom = 0.0, 0.0, 1.0
        self._pressed_at: QPointF | None = None
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(160, 120)

    def sizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        return QSize(320, 240)

    def set_empty_text(self, text: str) -> None:
        """Say so where there is no surface; the usual sentence is on captures without depth."""
        self._empty_text = text
        self.update()

    def show_space(self, space: Space | None) -> None:
        """Show another surface, from ahead."""
        self._take(space)
        self.fit()

    def renew_space(self, space: Space) -> None:
        """Show the surface as it is now, from where it was looked at."""
        self._take(space)
        self.update()

    def _take(self, space: Space | None) -> None:
        self._space = space
        if space is not None and len(space.discs):
            ends = (OUTLIERS_PERCENT, 100.0 - OUTLIERS_PERCENT)
            low, high = np.percentile(space.discs.points_m, ends, axis=0)
            self._middle_m = (low + high) / 2
            across_m, down_m, _away_m = np.maximum(high - low, LEAST_SIZE_M) * ROOM
            is_on_side = space.rotation_deg in ON_SIDE_DEG
            self._sizes_m = np.array([down_m, across_m] if is_on_side else [across_m, down_m])

    def show_landmarks(self, landmarks_m: Mapping[str, FloatArray]) -> None:
        """Show the landmarks where they are now."""
        if self._space is not None:
            self._space = replace(self._space, landmarks_m=landmarks_m)
            self.update()

    def project(self, points_m: AnyFloats) -> tuple[AnyFloats, AnyFloats]:
        """Return the (N, 2) places in the widget and the (N) depths of points."""
        middle_m = self._middle_m.astype(points_m.dtype)
        turned = (points_m - middle_m) @ self._rotation().T.astype(points_m.dtype)
        middle = np.array([self.width() / 2, self.height() / 2], points_m.dtype)
        return turned[:, :2] * self._scale + middle, turned[:, 2]

    @property
    def _scale(self) -> float:
        """Widget pixels a metre."""
        across_m, down_m = self._sizes_m
        return float(min(self.width() / across_m, self.height() / down_m)) * self._zoom

    def _rotation(self) -> FloatArray:
        """Return the axes of the view in the camera's: upright first, then turned and tilted."""
        roll = np.deg2rad(0 if self._space is None else self._space.rotation_deg)
        about_y, about_x = (np.cos(a) for a in (self._yaw_rad, self._pitch_rad))
        s_y, s_x, s_r = np.sin(self._yaw_rad), np.sin(self._pitch_rad), np.sin(roll)
        upright = np.array([[np.cos(roll), -s_r, 0.0], [s_r, np.cos(roll), 0.0], [0.0, 0.0, 1.0]])
        turned = np.array([[about_y, 0.0, s_y], [0.0, 1.0, 0.0], [-s_y, 0.0, about_y]])
        tilted = np.array([[1.0, 0.0, 0.0], [0.0, about_x, -s_x], [0.0, s_x, about_x]])
        return np.asarray(tilted @ turned @ upright)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802  (Qt's name)
        painter = QPainter(self)
        painter.fillRect(event.rect(), GROUND)
        if self._space is None:
            painter.setPen(QColor("#B3C0CB"))
            wrapped = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            usual = _("No depth was kept with this capture, so there is nothing to turn.")
            text = self._empty_text or usual
            painter.drawText(self.rect().adjusted(16, 16, -16, -16), wrapped, text)
        else:
            painter.drawImage(0, 0, self._surface_image(self._space.discs))
            painter.save()
            self._paint_path(painter, self._space)
            self._paint_landmarks(painter, self._space)
            painter.restore()
        if self.hasFocus():
            painter.setPen(QColor(DRAWN["plumb"]))
            painter.drawRect(self.rect().adjusted(0, 0, -1, -1))

    def _surface_image(self, discs: Discs) -> QImage:
        """Draw the discs as fine as the screen is."""
        from adibas.geometry.disc_kernels import draw_discs  # the compiler comes with it

        ratio = self.devicePixelRatio()
        width, height = round(self.width() * ratio), round(self.height() * ratio)
        places, depths_m = self.project(discs.points_m)
        scale = self._scale * ratio
        picture, is_drawn, nearest_px = draw_discs(
            np.column_stack([places * ratio, depths_m * scale]).astype(np.float32),
            discs.normals @ self._rotation().T.astype(np.float32),
            discs.radii_m * np.float32(OVERLAP * scale),
            discs.colors_rgb,
            (height, width),
        )
        picture[~is_drawn] = (GROUND.red(), GROUND.green(), GROUND.blue())
        self._nearest_m = nearest_px / np.float32(scale)
        kind = QImage.Format.Format_RGB888
        image = QImage(picture.data, width, height, 3 * width, kind).copy()
        image.setDevicePixelRatio(ratio)
        return image

    def _is_before(self, x_px: float, y_px: float, depth_m: float) -> bool:
        """Say whether a place is on the side that is seen."""
        ratio, around = self.devicePixelRatio(), AROUND_PX
        row, column = int(y_px * ratio), int(x_px * ratio)
        if not (0 <= x_px < self.width() and 0 <= y_px < self.height()):
            return False
        near_m = self._nearest_m[
            max(row - around, 0) : row + around, max(column - around, 0) : column + around
        ]
        return depth_m <= float(near_m.min()) + BEHIND_M

    def _paint_path(self, painter: QPainter, space: Space) -> None:
        if not len(space.path_m):
            return
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        places, _depths = self.project(space.path_m)
        corners = [QPointF(x, y) for x, y in places.tolist()]
        painter.setPen(QPen(QColor(DRAWN["outline"]), PATH_PX))
        painter.drawPolyline(QPolygonF(corners))
        painter.setBrush(QColor(DRAWN["outline"]))
        painter.drawEllipse(corners[-1], DOT_PX, DOT_PX)  # where the camera is now

    def _paint_landmarks(self, painter: QPainter, space: Space) -> None:
        if not space.landmarks_m:
            return
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        places, depths = self.project(np.array(list(space.landmarks_m.values()), float))
        placed = zip(space.landmarks_m, places.tolist(), depths.tolist(), strict=True)
        seen = [(name, x, y) for name, (x, y), depth in placed if self._is_before(x, y, depth)]
        painter.setPen(QPen(QColor(0, 0, 0), 1.5))
        painter.setBrush(QColor(DRAWN["selected"]))
        for _name, x, y in seen:
            painter.drawEllipse(QPointF(x, y), DOT_PX, DOT_PX)
        rings = [(name, Ring(x, y, DOT_PX, name)) for name, x, y in seen]
        window = float(self.width()), float(self.height())
        paint_names(painter, window, [(landmark_text(name), "selected", at) for name, at in rings])

    def _turn(self, right_rad: float, down_rad: float) -> None:
        self._yaw_rad += right_rad
        tilt = self._pitch_rad - down_rad
        self._pitch_rad = min(max(tilt, -STEEPEST_RAD), STEEPEST_RAD)
        self.update()

    def zoom_by(self, factor: float) -> None:
        """Come nearer, or go away."""
        self._zoom = min(max(self._zoom * factor, LEAST_ZOOM), MOST_ZOOM)
        self.update()

    def fit(self) -> None:
        """Look from ahead at all of it."""
        self._yaw_rad, self._pitch_rad, self._zoom = 0.0, 0.0, 1.0
        self.update()

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        self._pressed_at = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        if self._pressed_at is not None:
            step = event.position() - self._pressed_at
            self._pressed_at = event.position()
            self._turn(step.x() * TURN_PER_PX, step.y() * TURN_PER_PX)

    def mouseReleaseEvent(self, _event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        self._pressed_at = None

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802  (Qt's name)
        self.zoom_by(WHEEL_STEP ** (event.angleDelta().y() / 120))
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        key = event.key()
        if key in TURNS:
            self._turn(*TURNS[Qt.Key(key)])
        elif key in (Qt.Key.Key_Plus, Qt.Key.Key_Equal):
            self.zoom_by(WHEEL_STEP)
        elif key == Qt.Key.Key_Minus:
            self.zoom_by(1 / WHEEL_STEP)
        elif key == Qt.Key.Key_0:
            self.fit()
        else:
            super().keyPressEvent(event)
