"""A surface and landmarks from any side; painted without OpenGL, so that it works anywhere."""

import math
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
    QWheelEvent,
)
from PySide6.QtWidgets import QWidget

from adibas.arrays import Float32Array, FloatArray, Int32Array
from adibas.data.landmark_texts import landmark_text
from adibas.texts import translate as _
from ui.theme import DRAWN, PICTURE_GROUND
from ui.widgets.label_places import Ring
from ui.widgets.overlay_painter import paint_names
from ui.widgets.space import Space

GROUND = QColor(PICTURE_GROUND).rgb()
WHEEL_STEP = 1.2
TURN_PER_PX = 0.008
TURN_PER_KEY = 0.1
STEEPEST_RAD = 1.4
LEAST_ZOOM, MOST_ZOOM = 0.3, 8.0
DOT_PX = 4.0
LEAST_SIZE_M = 0.3
LARGEST_SQUARE_PX = 6
CELL_PX, BEHIND_M = 8, 0.05
"""A landmark that lies so far behind what is seen in its cell is on the other side."""
GAP_FACTOR = 1.6
"""Squares are so much wider than points are apart, for surfaces seen at a slant."""
TURNS = {
    Qt.Key.Key_Left: (-TURN_PER_KEY, 0.0),
    Qt.Key.Key_Right: (TURN_PER_KEY, 0.0),
    Qt.Key.Key_Up: (0.0, -TURN_PER_KEY),
    Qt.Key.Key_Down: (0.0, TURN_PER_KEY),
}


AnyFloats = TypeVar("AnyFloats", FloatArray, Float32Array)


class SpaceView(QWidget):
    """Turns with the mouse or the arrows, comes nearer with the wheel or plus, 0 looks from ahead.

    Points are projected in parallel: distances across the view can be compared.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._space: Space | None = None
        self._empty_text = ""
        self._middle_m = np.zeros(3)
        self._size_m, self._pitch_m = 1.0, 0.0
        self._packed = np.zeros(0, np.uint32)
        self._nearest = np.zeros((0, 0), np.float32)
        self._points_m = np.zeros((0, 3), np.float32)
        self._yaw_rad, self._pitch_rad, self._zoom = 0.0, 0.0, 1.0
        self._pressed_at: QPointF | None = None
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(160, 120)

    def sizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        return QSize(640, 480)

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
        if space is not None and len(space.points_m):
            low, self._middle_m, high = np.percentile(space.points_m, (5, 50, 95), axis=0)
            self._size_m = float(max((high - low)[:2].max(), LEAST_SIZE_M)) * 1.3
            steps_m = np.linalg.norm(np.diff(space.points_m, axis=0), axis=1)
            self._pitch_m = float(np.median(steps_m)) if len(steps_m) else 0.0
            self._points_m = space.points_m.astype(np.float32)
            red, green, blue = space.colors_rgb.astype(np.uint32).T
            self._packed = 0xFF000000 | red << 16 | green << 8 | blue

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
        return min(self.width(), self.height()) / self._size_m * self._zoom

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
        painter.fillRect(event.rect(), QColor.fromRgb(GROUND))
        if self._space is None:
            painter.setPen(QColor("#B3C0CB"))
            wrapped = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            usual = _("No depth was kept with this capture, so there is nothing to turn.")
            text = self._empty_text or usual
            painter.drawText(self.rect().adjusted(16, 16, -16, -16), wrapped, text)
        else:
            painter.drawImage(0, 0, self._surface_image())
            painter.save()
            self._paint_landmarks(painter, self._space)
            painter.restore()
        if self.hasFocus():
            painter.setPen(QColor(DRAWN["plumb"]))
            painter.drawRect(self.rect().adjusted(0, 0, -1, -1))

    def _surface_image(self) -> QImage:
        """Paint the points from far to near, each a square that leaves no gaps when fitted."""
        width, height = self.width(), self.height()
        places, depths = self.project(self._points_m)
        side = min(max(math.ceil(GAP_FACTOR * self._pitch_m * self._scale), 1), LARGEST_SQUARE_PX)
        columns, rows = np.rint(places).astype(np.int32).T
        is_seen = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
        order = np.argsort(-depths[is_seen])
        self._note_nearest(columns[is_seen][order], rows[is_seen][order], depths[is_seen][order])
        # Squares at the edges reach into a margin, so that no pixel needs to be checked again.
        stride = width + side
        picture = np.full((height + side) * stride, GROUND, np.uint32)
        first = (rows[is_seen] * stride + columns[is_seen])[order]
        colors = self._packed[is_seen][order]
        for down in range(side):
            for across in range(side):
                picture[first + (down * stride + across)] = colors
        image = QImage(picture.data, width, height, 4 * stride, QImage.Format.Format_RGB32)
        return image.copy()

    def _note_nearest(self, columns: Int32Array, rows: Int32Array, depths: Float32Array) -> None:
        """Note how near the surface is in each cell; points come from far to near."""
        shape = (self.height() // CELL_PX + 1, self.width() // CELL_PX + 1)
        self._nearest = np.full(shape, np.inf, np.float32)
        self._nearest[rows // CELL_PX, columns // CELL_PX] = depths

    def _is_before(self, x_px: float, y_px: float, depth: float) -> bool:
        """Say whether a place is on the side that is seen."""
        row, column = int(y_px) // CELL_PX, int(x_px) // CELL_PX
        n_rows, n_columns = self._nearest.shape
        if not (0 <= row < n_rows and 0 <= column < n_columns):
            return False
        return depth <= float(self._nearest[row, column]) + BEHIND_M

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
