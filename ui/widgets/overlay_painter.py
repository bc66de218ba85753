"""Paints overlays so that they are seen on any picture: light lines on a dark border."""

from collections.abc import Iterator, Sequence
from functools import cache, lru_cache

from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
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

from ui.theme import DRAWN, PICTURE_GROUND
from ui.widgets.image_geometry import ImagePlacement
from ui.widgets.label_places import Box, Label, Named, Ring, Size, place_labels
from ui.widgets.overlays import Curve, Dot, Line, Overlay, Region, Role, Text
from ui.widgets.region_image import region_image

GRAB_PX = 9.0
LEAST_RADIUS_PX = 6.0
BORDER = QColor(PICTURE_GROUND)
"""Nothing shines through: Qt draws a line that is half seen in ten times the time."""
HALF_PEN_PX = 2.0
N_TEXTS_KEPT = 256
DASHED: tuple[Role, ...] = ("plumb", "markerless")


def paint_overlays(
    painter: QPainter, placement: ImagePlacement, overlays: tuple[Overlay, ...]
) -> QRectF:
    """Paint overlays onto a picture placed so, and their names above them all.

    Returns
    -------
    reach : QRectF
        Where things were drawn that may lie beside the picture: all but regions.
    """
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
            _paint_region(painter, placement, overlay)
    boxes = _paint_names(painter, placement, overlays)
    painter.restore()
    return _joined([*_extents(placement, overlays), *boxes])


def _extents(placement: ImagePlacement, overlays: tuple[Overlay, ...]) -> Iterator[Box]:
    """Give the boxes of dots and of the ends of lines."""
    for overlay in overlays:
        points: tuple[tuple[float, float], ...] = ()
        reach = HALF_PEN_PX
        if isinstance(overlay, Dot):
            points, reach = ((overlay.u, overlay.v),), HALF_PEN_PX + _radius(placement, overlay)
        elif isinstance(overlay, Line):
            points = (overlay.u1, overlay.v1), (overlay.u2, overlay.v2)
        elif isinstance(overlay, Curve):
            points = overlay.points
        for u, v in points:
            x, y = placement.to_widget(u, v)
            yield _grown((x, y, x, y), reach)


def _joined(boxes: list[Box]) -> QRectF:
    if not boxes:
        return QRectF()
    lefts, tops, rights, bottoms = zip(*boxes, strict=True)
    corners = QPointF(min(lefts), min(tops)), QPointF(max(rights), max(bottoms))
    return QRectF(*corners)


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
    for pen in _line_pens(line.role):
        painter.setPen(pen)
        painter.drawLine(start, end)


def _paint_curve(painter: QPainter, placement: ImagePlacement, curve: Curve) -> None:
    points = [QPointF(*placement.to_widget(u, v)) for u, v in curve.points]
    for pen in _pens(curve.role):
        painter.setPen(pen)
        painter.drawPolyline(QPolygonF(points))


def _paint_names(
    painter: QPainter, placement: ImagePlacement, overlays: tuple[Overlay, ...]
) -> list[Box]:
    """Paint all texts beside what they name: names of markers first, then values.

    Returns
    -------
    boxes : list of Box
        Where they stand.
    """
    value_radius = painter.fontMetrics().ascent() / 2
    dots = [one for one in overlays if isinstance(one, Dot)]
    others = [one for one in overlays if not isinstance(one, Dot | Region) and one.text]
    named = [(one.label, one.role, _ring(placement, one)) for one in dots if one.label]
    named += [(one.text, one.role, _value_ring(placement, one, value_radius)) for one in others]
    nameless = tuple(_ring(placement, one) for one in dots if not one.label)
    return paint_names(painter, placement.widget, named, nameless)


def paint_names(
    painter: QPainter,
    window: Size,
    named: Sequence[tuple[str, Role, Ring]],
    nameless: tuple[Ring, ...] = (),
) -> list[Box]:
    """Paint texts beside their rings, each whole and off the others; see `place_labels`.

    Parameters
    ----------
    named : sequence of (str, Role, Ring)
        Each text, and what it names.
    nameless : tuple of Ring
        Rings without a text, which no text may cover.

    Returns
    -------
    boxes : list of Box
        Where they stand.
    """
    if not named:
        return []
    words, ratio = painter.font().toString(), painter.device().devicePixelRatioF()
    images = [_letters(text, words, role, ratio) for text, role, _place in named]
    sizes = [image.deviceIndependentSize() for image in images]
    things = tuple(
        Named(ring, size.width(), size.height())
        for (_text, _role, ring), size in zip(named, sizes, strict=True)
    )
    labels = place_labels(things, window, nameless)
    for (_text, role, _place), image, label in zip(named, images, labels, strict=True):
        if label is not None:  # else the tip and the list tell it; nearer by there is room
            _paint_label(painter, label, image, role)
    return [_grown(label.box, 1.0) for label in labels if label is not None]


def _ring(placement: ImagePlacement, dot: Dot) -> Ring:
    """Return the circle about a dot as far as its pen reaches."""
    radius = _radius(placement, dot) + HALF_PEN_PX
    return Ring(*placement.to_widget(dot.u, dot.v), radius, dot.name)


def _value_ring(placement: ImagePlacement, overlay: Line | Curve | Text, radius: float) -> Ring:
    """Return where a line must not be hidden by its own value."""
    return Ring(*placement.to_widget(*_anchor(overlay)), radius, kind="value")


def _paint_label(painter: QPainter, label: Label, image: QImage, role: Role) -> None:
    """Paint a name on whole pixels of the screen, where it is copied, and its line if any."""
    if label.leader is not None:
        for color, width in ((BORDER, 3.0), (QColor(DRAWN[role]), 1.0)):
            pen = QPen(color, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap)
            painter.setPen(pen)  # flat: it reaches neither into the ring nor into the letters
            painter.drawLine(QLineF(*label.leader))
    ratio = image.devicePixelRatio()
    place = QPointF(round(label.box[0] * ratio), round(label.box[1] * ratio))
    painter.drawImage(place / ratio, image)


def _grown(box: Box, by_px: float) -> Box:
    """Return a box that is larger on every side: by a pen, a circle, or what letters have below."""
    return box[0] - by_px, box[1] - by_px, box[2] + by_px, box[3] + by_px


def _anchor(overlay: Line | Curve | Text) -> tuple[float, float]:
    """Return the pixel beside which the text of an overlay stands."""
    if isinstance(overlay, Line):
        return (overlay.u1 + overlay.u2) / 2, (overlay.v1 + overlay.v2) / 2
    if isinstance(overlay, Curve):
        return overlay.points[len(overlay.points) // 2]
    return overlay.u, overlay.v


@lru_cache(maxsize=N_TEXTS_KEPT)
def _letters(text: str, font_words: str, role: Role, ratio: float) -> QImage:
    """Return letters with a border; the image is no larger than they are.

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
    return image


def _paint_region(painter: QPainter, placement: ImagePlacement, region: Region) -> None:
    """Lay the region's border over the picture, and a tint where it is filled."""
    found = region_image(region, placement, painter.device().devicePixelRatioF())
    if found is not None:
        image, place = found
        painter.drawImage(place, image)


@cache
def _line_pens(role: Role) -> tuple[QPen, ...]:
    """Return the pens of a line: the plumb line, and what was found without markers, is dashed."""
    pens = _pens(role)
    if role not in DASHED:
        return pens
    dashed = tuple(map(QPen, pens))
    for pen in dashed:
        pen.setStyle(Qt.PenStyle.DashLine)
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    return dashed


@cache
def _pens(role: Role) -> tuple[QPen, ...]:
    """Return the dark border's pen and the light line's; flat ends cost half of Qt's usual ones."""
    return QPen(BORDER, 4.0), QPen(QColor(DRAWN[role]), 2.0)
