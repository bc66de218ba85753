"""A figure of the body that shows how much each joint tells of a gesture."""

from collections.abc import Mapping

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from adibas.data.joints import PARENT_OF
from adibas.data.landmark_texts import landmark_text
from adibas.texts import translate as _
from ui.theme import Theme

PLACES = {
    "head": (0.0, 0.06), "neck": (0.0, 0.19), "torso": (0.0, 0.36),
    "left_shoulder": (0.13, 0.21), "left_elbow": (0.20, 0.37), "left_hand": (0.24, 0.52),
    "left_hip": (0.07, 0.51), "left_knee": (0.08, 0.73), "left_foot": (0.09, 0.95),
}  # fmt: skip
"""Across from the middle and down, in heights of the figure; the right side mirrors the left.

Seen from the front: the person's left is at the right.
"""
NAMED = 3
"""So many joints have their share written beside them."""
LEAST_PX, MOST_SHARE = 3.0, 0.05
"""Radius of a joint that tells nothing; of one that tells all, in heights of the figure."""
LEAST_LETTERS, LEAST_LINES = 30, 14
LINE_PX, HEAD_SHARE = 2.0, 0.055


class BodyFigure(QWidget):
    """Bones as lines, joints as discs: the larger and the stronger, the more a joint tells."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._shares: dict[str, float] = {}
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Expanding)

    def minimumSizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        """Ask for room for the figure and names on both sides."""
        letters = self.fontMetrics()
        return QSize(LEAST_LETTERS * letters.averageCharWidth(), LEAST_LINES * letters.height())

    def sizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        return self.minimumSizeHint()

    def show_shares(self, shares: Mapping[str, float]) -> None:
        """Show how much each joint tells, 0 to 1 with the sum 1; nothing for a plain figure."""
        self._shares = dict(shares)
        self.setAccessibleName(_("Joints that tell the gesture"))
        self.setAccessibleDescription(", ".join(map(self._told, self._in_order())))
        self.setToolTip("\n".join(map(self._told, self._in_order())))
        self.update()

    def place(self, joint: str) -> QPointF:
        """Return where a joint is painted."""
        side = -1.0 if joint.startswith("right_") else 1.0
        across, down = PLACES[joint.replace("right_", "left_")]
        high_px = self._high_px()
        return QPointF(self.width() / 2 + side * across * high_px, down * high_px)

    def _high_px(self) -> float:
        """Return the height of the figure: there is room for the texts at both sides."""
        text_px = self.fontMetrics().horizontalAdvance("100 %") + 2.0
        wide = 2.0 * (PLACES["left_hand"][0] + MOST_SHARE)
        return max(min(float(self.height()), (self.width() - 2 * text_px) / wide), 1.0)

    def radius_px(self, joint: str) -> float:
        """Return how large a joint is painted."""
        most = max(self._shares.values(), default=0.0)
        share = self._shares.get(joint, 0.0) / most if most > 0 else 0.0
        return LEAST_PX + share * max(MOST_SHARE * self._high_px() - LEAST_PX, 0.0)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802  (Qt's name)
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(self._theme.tokens.line), LINE_PX))
        for joint, parent in PARENT_OF.items():
            painter.drawLine(self.place(joint), self.place(parent))
        head_px = HEAD_SHARE * self._high_px()
        painter.setBrush(QColor(self._theme.tokens.ground))
        painter.drawEllipse(self.place("head"), head_px, head_px)
        most = max(self._shares.values(), default=0.0)
        for joint in ("neck", *reversed(self._in_order())):
            share = self._shares.get(joint, 0.0)
            color = QColor(self._theme.tokens.accent if share else self._theme.tokens.line)
            color.setAlphaF(0.35 + 0.65 * (share / most if most > 0 else 1.0))
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(color)
            radius_px = self.radius_px(joint)
            painter.drawEllipse(self.place(joint), radius_px, radius_px)
        painter.setPen(QColor(self._theme.tokens.text))
        for joint in self._in_order()[:NAMED]:
            self._write(painter, joint)
        painter.end()

    def _write(self, painter: QPainter, joint: str) -> None:
        """Write a share beside its joint: outside of the body, or below what is in its middle."""
        at, gap = self.place(joint), self.radius_px(joint) + 2.0
        high_px, half_px = self.fontMetrics().height(), self.width() / 2
        top = at.y() - high_px / 2
        is_left_half = at.x() < half_px - 1.0
        box = QRectF(at.x() + gap, top, max(self.width() - at.x() - gap, 0.0), high_px)
        if is_left_half:
            box = QRectF(0.0, top, max(at.x() - gap, 0.0), high_px)
        side = Qt.AlignmentFlag.AlignRight if is_left_half else Qt.AlignmentFlag.AlignLeft
        text = f"{100 * self._shares[joint]:.0f} %"
        painter.drawText(box, side | Qt.AlignmentFlag.AlignVCenter, text)

    def _in_order(self) -> list[str]:
        return sorted(self._shares, key=lambda joint: -self._shares[joint])

    def _told(self, joint: str) -> str:
        return f"{landmark_text(joint)} {100 * self._shares[joint]:.0f} %"
