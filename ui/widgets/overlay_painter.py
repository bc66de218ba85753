"""Paints overlays so that they are seen on any picture: light lines on a dark border."""

import math
from functools import cache, lru_cache

import cv2
import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import (
    QColor,
    QFont,
    QImage,
    QPainter,
    QPainterPath,
    QPainterPathStroker,
    QPen,
    QPolygonF,
)

from ui.theme import DRAWN
from ui.widgets.image_geometry import ImagePlacement
from ui.widgets.label_places import Named, leader, place_labels
from ui.widgets.overlays import Curve, Dot, Line, Overlay, Region, Role, Text

GRAB_PX = 9.0
LEAST_RADIUS_PX = 6.0
BORDER = QColor(0, 0, 0, 190)
TINT_ALPHA = 90
TINTED, BORDERED = 1, 2
BORDER_WIDGET_PX = 1.5
N_REGIONS_KEPT, N_TEXTS_KEPT = 4, 256


def paint_overlays(
    painter: QPainter, placement: ImagePlacement, overlays: tuple[Overlay, ...]
) -> None:
    """Paint overlays onto a picture placed so, and their names above them all."""
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    for overlay in overlays:
        if isinstance(overlay, Dot):
            _paint_dot(painter, placement, overlay)
        elif isinstance(overlay, Line):
            _paint_line(painter, placement, overlay)
        elif isinstance(overlay, Curve):
            _paint_curve(painter, placement, overlay)
        elif isinstance(overlay, Region):
            painter.save()
            _paint_region(painter, placement, overlay)
            painter.restore()
    _paint_names(painter, placement, overlays)
    painter.restore()


def _paint_dot(painter: QPainter, placement: ImagePlacement, dot: Dot) -> None:
    center, radius = QPointF(*placement.to_widget(dot.u, dot.v)), _radius(placement, dot)
    for pen in _pens(dot.role):
        painter.setPen(pen)
        painter.drawEllipse(center, radius, radius)
    if dot.role == "rejected":
        arm = radius * 0.7
        painter.drawLine(center + QPointF(-arm, -arm), center + QPointF(arm, arm))
        painter.drawLine(center + QPointF(-arm, arm), center + QPointF(arm, -arm))


def _radius(placement: ImagePlacement, dot: Dot) -> float:
    return max(dot.radius_px * placement.scale + 2.0, LEAST_RADIUS_PX)


def _paint_line(painter: QPainter, placement: ImagePlacement, line: Line) -> None:
    start = QPointF(*placement.to_widget(line.u1, line.v1))
    end = QPointF(*placement.to_widget(line.u2, line.v2))
    for pen in _pens(line.role):
        painter.setPen(pen)
        painter.drawLine(start, end)


def _paint_curve(painter: QPainter, placement: ImagePlacement, curve: Curve) -> None:
    points = [QPointF(*placement.to_widget(u, v)) for u, v in curve.points]
    for pen in _pens(curve.role):
        painter.setPen(pen)
        painter.drawPolyline(QPolygonF(points))


def _paint_names(
    painter: QPainter, placement: ImagePlacement, overlays: tuple[Overlay, ...]
) -> None:
    """Paint all texts beside what they name: names of markers first, then values."""
    metrics = painter.fontMetrics()
    dots = [one for one in overlays if isinstance(one, Dot) and one.label]
    others = [one for one in overlays if not isinstance(one, Dot | Region) and one.text]
    named = [(dot.label, dot.role, dot.u, dot.v, _radius(placement, dot)) for dot in dots]
    named += [(one.text, one.role, *_anchor(one), metrics.ascent() / 2) for one in others]
    things = [
        Named(*placement.to_widget(u, v), radius, metrics.horizontalAdvance(text), metrics.ascent())
        for text, _role, u, v, radius in named
    ]
    for (text, role, *_place), thing, box in zip(
        named, things, place_labels(things, placement.widget), strict=True
    ):
        if box is None:
            continue  # the tip and the list tell it; nearer by there is room
        end = leader(thing, box)
        if end is not None:
            _paint_leader(painter, QPointF(thing.x, thing.y), QPointF(*end), role, thing.radius)
        _paint_text(painter, QPointF(box[0], box[3]), text, role)


def _paint_leader(
    painter: QPainter, center: QPointF, end: QPointF, role: Role, radius: float
) -> None:
    """Lead from the edge of a marker to its name, which stands apart."""
    way = end - center
    start = center + way * (radius / math.hypot(way.x(), way.y()))
    for color, width in ((BORDER, 3.0), (QColor(DRAWN[role]), 1.0)):
        painter.setPen(QPen(color, width))
        painter.drawLine(start, end)


def _anchor(overlay: Line | Curve | Text) -> tuple[float, float]:
    """Return the pixel beside which the text of an overlay stands."""
    if isinstance(overlay, Line):
        return (overlay.u1 + overlay.u2) / 2, (overlay.v1 + overlay.v2) / 2
    if isinstance(overlay, Curve):
        return overlay.points[len(overlay.points) // 2]
    return overlay.u, overlay.v


def _paint_text(painter: QPainter, at: QPointF, text: str, role: Role) -> None:
    ratio = painter.device().devicePixelRatioF()
    image, offset = _letters(text, painter.font().toString(), role, ratio)
    place = (at + offset) * ratio  # on whole pixels of the screen: it is copied then
    painter.drawImage(QPointF(round(place.x()), round(place.y())) / ratio, image)


@lru_cache(maxsize=N_TEXTS_KEPT)
def _letters(text: str, font_words: str, role: Role, ratio: float) -> tuple[QImage, QPointF]:
    """Return letters with a border, and where the image is if they begin at (0, 0).

    They are dear to make: as an image they cost nothing where the same text is drawn again.
    """
    font = QFont()
    font.fromString(font_words)
    letters = QPainterPath()
    letters.addText(0.0, 0.0, font, text)
    border = QPainterPathStroker(QPen(BORDER, 3.0)).createStroke(letters)
    box = border.boundingRect().toAlignedRect()
    image = QImage(box.size() * ratio, QImage.Format.Format_ARGB32_Premultiplied)
    image.setDevicePixelRatio(ratio)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.translate(-box.topLeft())
    painter.fillPath(border, BORDER)
    painter.fillPath(letters, QColor(DRAWN[role]))
    painter.end()
    return image, QPointF(box.topLeft())


def _paint_region(painter: QPainter, placement: ImagePlacement, region: Region) -> None:
    """Lay the region's border over the picture, and a tint where it is filled."""
    image, left, top = _region_image(region, max(1, round(BORDER_WIDGET_PX / placement.scale)))
    painter.translate(placement.widget[0] / 2, placement.widget[1] / 2)
    painter.rotate(placement.rotation_deg)
    painter.scale(placement.scale, placement.scale)
    place = QPointF(left - 0.5 - placement.center[0], top - 0.5 - placement.center[1])
    painter.drawImage(place, image)


@lru_cache(maxsize=N_REGIONS_KEPT)
def _region_image(region: Region, width_px: int) -> tuple[QImage, int, int]:
    """Return a region with its border, and where its upper left pixel lies in the picture.

    Only the part of the picture that has it, with a palette: what is drawn anew, because the mouse
    moves or a marker was found, costs nothing then.
    """
    inside = region.pixels.view(np.uint8)
    left, top, width, height = cv2.boundingRect(inside)
    left, top = max(left - width_px, 0), max(top - width_px, 0)
    part = inside[top : top + height + 2 * width_px, left : left + width + 2 * width_px]
    core = cv2.erode(part, np.ones((2 * width_px + 1, 2 * width_px + 1), np.uint8))
    levels = np.zeros(256, np.uint8)  # of 0: outside, 1: the border, 2: within
    levels[1:3] = BORDERED, TINTED if region.is_filled else 0
    indices = cv2.LUT(cv2.add(part, core), levels)
    height, width = indices.shape
    image = QImage(indices.data, width, height, width, QImage.Format.Format_Indexed8)
    image.setColorTable(_palette(region.role))
    return image.convertToFormat(QImage.Format.Format_ARGB32_Premultiplied), left, top


@cache
def _palette(role: Role) -> list[int]:
    """Return what 0, `TINTED` and `BORDERED` look like."""
    tint, border = QColor(DRAWN[role]), QColor(DRAWN[role])
    tint.setAlpha(TINT_ALPHA)
    return [0, tint.rgba(), border.rgba()]


@cache
def _pens(role: Role) -> tuple[QPen, QPen]:
    """Return the dark border's pen and the light line's; the plumb line is dashed."""
    pens = QPen(BORDER, 4.0), QPen(QColor(DRAWN[role]), 2.0)
    if role == "plumb":
        for pen in pens:
            pen.setStyle(Qt.PenStyle.DashLine)
    return pens
