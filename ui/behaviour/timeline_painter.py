"""Paints the timeline."""

from collections.abc import Iterator
from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QFontMetricsF, QPainter, QPen

from adibas.reports.behaviour_texts import behaviour_text, subject_text
from adibas.texts import decimal_mark
from ui.behaviour.content import Bar, Layer, Row, Timeline, time_text
from ui.behaviour.timeline_scale import TimeScale
from ui.theme import Tokens

UNREADABLE = "#7F7F7F"
"""In place of a colour that the coding scheme spells wrongly."""
LEAST_PX = 3.0
TICK_LETTERS = 12


@dataclass(frozen=True, slots=True)
class LineHeights:
    """How high a line is, and what of it a layer takes: the observer's own above, others below."""

    ruler_px: int
    row_px: int

    @classmethod
    def of_letters(cls, letter_px: int) -> "LineHeights":
        """Return the heights for letters of a height."""
        return cls(round(1.5 * letter_px), round(1.7 * letter_px))

    def top_of(self, row: int) -> int:
        """Return where a line begins."""
        return self.ruler_px + row * self.row_px

    def part_of(self, layer: Layer) -> tuple[float, float]:
        """Return top and height of a layer within its line."""
        shares = {"coded": (0.1, 0.5), "begun": (0.1, 0.5), "difference": (0.88, 0.1)}
        top, height = shares.get(layer, (0.62, 0.26))
        return top * self.row_px, height * self.row_px


def row_text(row: Row) -> str:
    """Return what a line is called."""
    name = behaviour_text(row.behaviour)
    return f"{name} ({subject_text(row.subject)})" if row.subject else name


@dataclass(frozen=True, slots=True)
class TimelineLook:
    """How the timeline is painted: which time lies where, how high lines are, and colours."""

    scale: TimeScale
    heights: LineHeights
    tokens: Tokens
    scrolled_px: int


def paint_still(painter: QPainter, content: Timeline, look: TimelineLook, height_px: int) -> None:
    """Paint everything that stays where it is while the video runs."""
    scale, heights, tokens = look.scale, look.heights, look.tokens
    right_px = scale.left_px + scale.width_px
    painter.fillRect(QRectF(0, 0, right_px + 20, height_px), QColor(tokens.raised))
    painter.save()
    painter.translate(0, -look.scrolled_px)
    _paint_lines(painter, content, scale, heights, tokens)
    _clip(painter, content, look)
    for bar in bars_to_paint(content, scale):
        _paint_bar(painter, bar, bar.end_ms, content, look)
    painter.restore()
    _paint_ruler(painter, content, scale, heights, tokens)


def bars_to_paint(content: Timeline, scale: TimeScale) -> Iterator[Bar]:
    """Yield what is in sight and over: of hours not what lies in the pixel that is full already."""
    full: dict[tuple[int, Layer], int] = {}
    for bar in content.bars:
        is_seen = bar.end_ms >= scale.from_ms and bar.begin_ms <= scale.to_ms
        if not is_seen or bar.layer == "begun":
            continue
        left_px, right_px = int(scale.x_of(bar.begin_ms)), int(scale.x_of(bar.end_ms))
        line = bar.row, bar.layer
        is_chosen = bar.occurrence is not None and bar.occurrence == content.chosen
        if is_chosen or not left_px == right_px == full.get(line):
            full[line] = right_px
            yield bar


def paint_moving(
    painter: QPainter, content: Timeline, look: TimelineLook, at_ms: int, height_px: int
) -> None:
    """Paint what lasts up to now, and where the video is."""
    painter.save()
    painter.translate(0, -look.scrolled_px)
    _clip(painter, content, look)
    for bar in content.bars:
        if bar.layer == "begun":
            _paint_bar(painter, bar, max(at_ms, bar.begin_ms), content, look)
    painter.restore()
    x = look.scale.x_of(at_ms)
    painter.setPen(QPen(QColor(look.tokens.bad), 2))
    painter.drawLine(QPointF(x, 0), QPointF(x, height_px))


def _clip(painter: QPainter, content: Timeline, look: TimelineLook) -> None:
    """Let bars cover neither names nor the ruler."""
    top_px = look.heights.ruler_px + look.scrolled_px
    height_px = look.heights.top_of(len(content.rows))
    painter.setClipRect(QRectF(look.scale.left_px, top_px, look.scale.width_px + 1, height_px))


def _paint_lines(
    painter: QPainter, content: Timeline, scale: TimeScale, heights: LineHeights, tokens: Tokens
) -> None:
    metrics = QFontMetricsF(painter.font())
    for number, row in enumerate(content.rows):
        top = heights.top_of(number)
        if number % 2:
            whole = QRectF(0, top, scale.left_px + scale.width_px + 20, heights.row_px)
            painter.fillRect(whole, QColor(tokens.sunken))
        painter.setPen(QColor(tokens.text))
        text = metrics.elidedText(row_text(row), Qt.TextElideMode.ElideRight, scale.left_px - 12)
        place = QRectF(6, top, scale.left_px - 6, heights.row_px)
        painter.drawText(place, Qt.AlignmentFlag.AlignVCenter, text)


def _paint_bar(
    painter: QPainter, bar: Bar, end_ms: int, content: Timeline, look: TimelineLook
) -> None:
    tokens = look.tokens
    left, right = look.scale.x_of(bar.begin_ms), look.scale.x_of(end_ms)
    top_px, height_px = look.heights.part_of(bar.layer)
    top = look.heights.top_of(bar.row) + top_px
    place = QRectF(left, top, max(right - left, LEAST_PX), height_px)
    is_chosen = bar.occurrence is not None and bar.occurrence == content.chosen
    color = QColor(tokens.bad) if bar.layer == "difference" else _color(content.rows[bar.row])
    painter.setPen(QPen(QColor(tokens.text), 2.5 if is_chosen else 1))
    if bar.layer == "difference":
        painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(_brush(bar.layer, color, tokens))
    if bar.begin_ms == bar.end_ms and bar.layer in ("coded", "proposed", "other"):
        middle, half = place.center().y(), place.height() / 2
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.drawPolygon(
            [
                QPointF(left, middle - half),
                QPointF(left + half, middle),
                QPointF(left, middle + half),
                QPointF(left - half, middle),
            ]
        )
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
    else:
        painter.drawRect(place)


def _brush(layer: Layer, color: QColor, tokens: Tokens) -> QBrush:
    if layer == "proposed":
        return QBrush(QColor(tokens.raised))
    if layer == "other":
        return QBrush(color, Qt.BrushStyle.BDiagPattern)
    return QBrush(color)


def _color(row: Row) -> QColor:
    color = QColor(row.color)
    return color if color.isValid() else QColor(UNREADABLE)


def _paint_ruler(
    painter: QPainter, content: Timeline, scale: TimeScale, heights: LineHeights, tokens: Tokens
) -> None:
    right_px = scale.left_px + scale.width_px
    painter.fillRect(QRectF(0, 0, right_px + 20, heights.ruler_px), QColor(tokens.ground))
    for section in content.sections:
        left = max(scale.x_of(section.begin_ms), float(scale.left_px))
        right = min(scale.x_of(section.end_ms), float(right_px))
        if right > left:
            tint = QColor(tokens.accent)
            tint.setAlpha(60)
            place = QRectF(left, 0, right - left, heights.ruler_px)
            painter.fillRect(place, tint)
            painter.setPen(QColor(tokens.text))
            painter.drawText(place.adjusted(4, 0, 0, 0), Qt.AlignmentFlag.AlignTop, section.name)
    painter.setPen(QColor(tokens.quiet))
    letter_px = QFontMetricsF(painter.font()).averageCharWidth()
    for tick_ms in scale.ticks_ms(TICK_LETTERS * letter_px):
        x = scale.x_of(tick_ms)
        painter.drawLine(QPointF(x, heights.ruler_px - 5), QPointF(x, heights.ruler_px))
        text = time_text(tick_ms - content.begin_ms).removesuffix(f"{decimal_mark()}000")
        place = QRectF(x + 3, 0, TICK_LETTERS * letter_px, heights.ruler_px)
        painter.drawText(place, Qt.AlignmentFlag.AlignVCenter, text)
