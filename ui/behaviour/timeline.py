"""The timeline: a line for each behaviour of each subject, and where the video is."""

from dataclasses import replace

from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QHelpEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPixmap,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QAbstractScrollArea, QFrame, QToolTip, QWidget

from adibas.data.coding import Occurrence
from ui.behaviour.content import Bar, Timeline, time_text
from ui.behaviour.timeline_painter import (
    LineHeights,
    TimelineLook,
    paint_moving,
    paint_still,
    row_text,
)
from ui.behaviour.timeline_scale import TimeScale
from ui.theme import Theme

GRAB_PX = 6
DRAG_PX = 3
ZOOM_STEP = 1.25
NAMES_SHARE = 0.3
"""Of the width, that names take at most."""
LEAST_LINES = 2
WHEEL_NOTCH = 120
Button = Qt.MouseButton
Modifier = Qt.KeyboardModifier


class TimelineView(QAbstractScrollArea):
    """Click: show that time, and choose the event there. Drag an event's begin or end: move it.

    Drag elsewhere: the video follows. Wheel: lines up and down; with Ctrl: zoom; with Shift: along
    the time. Keys are those of the screen.
    """

    time_chosen = Signal(int)
    event_chosen = Signal(object)
    """An `Occurrence`, or None."""
    event_moved = Signal(object, object)
    """The `Occurrence` as it was, and as it shall be."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._content = Timeline()
        self._at_ms = 0
        self._scale = TimeScale()
        self._held: tuple[Bar, str] | None = None
        self._ghost: Occurrence | None = None
        self._pressed_at: QPointF | None = None
        self._picture: QPixmap | None = None
        self._painted_as: tuple[object, ...] = ()
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.viewport().setMouseTracking(True)
        self._fit()

    @property
    def scale(self) -> TimeScale:
        """Which time lies where; for tests, too."""
        return self._scale

    def show_content(self, content: Timeline) -> None:
        """Show all events."""
        self._content = content
        self._scale = self._scale.of_session(content.begin_ms, content.end_ms)
        self._fit()
        self.viewport().update()

    def show_time(self, time_ms: int) -> None:
        """Show where the video is."""
        self._at_ms = time_ms
        self._scale = self._scale.showing(time_ms)
        self.viewport().update()

    def zoom_by(self, factor: float) -> None:
        """Show less, or more, around the time that is seen."""
        self._set_scale(self._scale.zoomed(factor, self._at_ms))

    def show_all(self) -> None:
        """Show the whole session."""
        self._set_scale(self._scale.fitted())

    def place_of(self, bar: Bar) -> QRectF:
        """Return where an event is drawn in the viewport."""
        top = self._heights.top_of(bar.row) - self.verticalScrollBar().value()
        left, right = (self._scale.x_of(time) for time in (bar.begin_ms, bar.end_ms))
        return QRectF(left, top, max(right - left, 1.0), self._heights.row_px)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802  (Qt's name)
        painter = QPainter(self.viewport())
        look = TimelineLook(
            self._scale, self._heights, self._theme.tokens, self.verticalScrollBar().value()
        )
        height_px = self.viewport().height()
        painter.drawPixmap(0, 0, self._still_picture(look))
        paint_moving(painter, self._content, look, self._at_ms, height_px)
        if self.hasFocus():
            painter.setPen(self.palette().highlight().color())
            painter.drawRect(self.viewport().rect().adjusted(0, 0, -1, -1))

    def _still_picture(self, look: TimelineLook) -> QPixmap:
        """Return what does not move while the video runs: it is painted once."""
        content = self._content
        if self._held is not None and self._ghost is not None:
            begin_ms, end_ms = self._ghost.begin_ms, self._ghost.end_ms
            held = replace(self._held[0], begin_ms=begin_ms, end_ms=end_ms)
            bars = tuple(held if bar is self._held[0] else bar for bar in content.bars)
            content = replace(content, bars=bars)
        viewport = self.viewport()
        ratio = viewport.devicePixelRatioF()
        painted_as = (content, look, viewport.size(), ratio, self.font().toString())
        if self._picture is None or self._painted_as != painted_as:
            self._picture = QPixmap(viewport.size() * ratio)
            self._picture.setDevicePixelRatio(ratio)
            painter = QPainter(self._picture)
            painter.setFont(self.font())
            paint_still(painter, content, look, viewport.height())
            painter.end()
            self._painted_as = painted_as
        return self._picture

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        super().changeEvent(event)
        if event.type() in (QEvent.Type.FontChange, QEvent.Type.LanguageChange):
            self._picture = None
            self._fit()

    def minimumSizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        """Ask for room for the ruler and some lines."""
        heights = self._heights
        return QSize(200, heights.ruler_px + LEAST_LINES * heights.row_px)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        event.ignore()  # the screen knows what keys mean

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802  (Qt's name)
        turned = event.angleDelta()
        notches = (turned.y() or turned.x()) / WHEEL_NOTCH
        is_along = bool(event.modifiers() & Modifier.ShiftModifier) or not turned.y()
        if event.modifiers() & Modifier.ControlModifier:
            at_ms = self._scale.ms_at(event.position().x())
            self._set_scale(self._scale.zoomed(ZOOM_STEP**notches, at_ms))
        elif is_along:
            span_ms = self._scale.to_ms - self._scale.from_ms
            self._set_scale(self._scale.moved(-notches * span_ms / 10))
        else:
            bar = self.verticalScrollBar()
            bar.setValue(round(bar.value() - notches * self._heights.row_px))
            self.viewport().update()
        event.accept()

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        if event.button() != Button.LeftButton:
            return
        self._pressed_at = event.position()
        self._held = self._edge_at(event.position())
        found = self._held[0] if self._held is not None else self._bar_at(event.position())
        self.event_chosen.emit(None if found is None else found.occurrence)
        if self._held is None:
            self.time_chosen.emit(self._scale.ms_at(event.position().x()))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        at = event.position()
        if self._pressed_at is None:
            is_edge = self._edge_at(at) is not None
            shape = Qt.CursorShape.SizeHorCursor if is_edge else Qt.CursorShape.ArrowCursor
            self.viewport().setCursor(shape)
        elif self._held is None:
            self.time_chosen.emit(self._scale.ms_at(at.x()))
        elif self._ghost is not None or abs(at.x() - self._pressed_at.x()) >= DRAG_PX:
            self._ghost = self._dragged(*self._held, self._scale.ms_at(at.x()))
            self.viewport().update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802  (Qt's name)
        held, ghost = self._held, self._ghost
        self._pressed_at, self._held, self._ghost = None, None, None
        if event.button() == Button.LeftButton and held is not None and ghost is not None:
            self.event_moved.emit(held[0].occurrence, ghost)
        self.viewport().update()

    def viewportEvent(self, event: QEvent) -> bool:  # noqa: N802  (Qt's name)
        """Tell what the event under the mouse is."""
        if not isinstance(event, QHelpEvent):
            return super().viewportEvent(event)
        bar = self._bar_at(QPointF(event.pos()))
        if bar is None:
            QToolTip.hideText()
        else:
            since_ms = self._content.begin_ms
            begin, end = (time_text(time - since_ms) for time in (bar.begin_ms, bar.end_ms))
            row = row_text(self._content.rows[bar.row])
            QToolTip.showText(event.globalPos(), f"{row}\n{begin} \N{EN DASH} {end}", self)
        return True

    def _dragged(self, bar: Bar, edge: str, at_ms: int) -> Occurrence | None:
        one = bar.occurrence
        if one is None:
            return None
        if edge == "point":
            return replace(one, begin_ms=at_ms, end_ms=at_ms)
        if edge == "begin":
            return replace(one, begin_ms=min(at_ms, max(one.end_ms - 1, one.begin_ms)))
        return replace(one, end_ms=max(at_ms, one.begin_ms + 1))

    def _edge_at(self, at: QPointF) -> tuple[Bar, str] | None:
        """Return the event whose begin or end is near, the nearest of the line that is pointed at.

        That of the chosen event wins, so that a neighbour does not take it.
        """
        found: list[tuple[bool, float, str, Bar]] = []
        for bar in self._content.bars:
            if bar.occurrence is None or not self._is_in_line(bar, at):
                continue
            is_chosen = bar.occurrence == self._content.chosen
            is_point = bar.begin_ms == bar.end_ms
            for edge, time_ms in (("begin", bar.begin_ms), ("end", bar.end_ms)):
                away_px = abs(self._scale.x_of(time_ms) - at.x())
                if away_px <= GRAB_PX:
                    found.append((not is_chosen, away_px, "point" if is_point else edge, bar))
        if not found:
            return None
        _rank, _away, edge, bar = min(found, key=lambda one: one[:2])
        return bar, edge

    def _bar_at(self, at: QPointF) -> Bar | None:
        for bar in reversed(self._content.bars):
            place = self.place_of(bar).adjusted(-GRAB_PX, 0, GRAB_PX, 0)
            if self._is_in_line(bar, at) and place.left() <= at.x() <= place.right():
                return bar
        return None

    def _is_in_line(self, bar: Bar, at: QPointF) -> bool:
        top_px, height_px = self._heights.part_of(bar.layer)
        place = self.place_of(bar)
        return at.y() > self._heights.ruler_px and (
            place.top() + top_px <= at.y() < place.top() + top_px + height_px
        )

    def _set_scale(self, scale: TimeScale) -> None:
        self._scale = scale
        self.viewport().update()

    def _fit(self) -> None:
        """Follow the letters and the room."""
        metrics = self.fontMetrics()
        self._heights = LineHeights.of_letters(metrics.height())
        longest = max(
            (metrics.horizontalAdvance(row_text(row)) for row in self._content.rows), default=0
        )
        viewport = self.viewport().size()
        names_px = min(longest + 16, round(NAMES_SHARE * viewport.width()))
        width_px = max(viewport.width() - names_px - 8, 1)
        self._scale = replace(self._scale, left_px=names_px, width_px=width_px)
        whole_px = self._heights.ruler_px + len(self._content.rows) * self._heights.row_px
        bar = self.verticalScrollBar()
        bar.setRange(0, max(whole_px - viewport.height(), 0))
        bar.setPageStep(viewport.height())
        bar.setSingleStep(self._heights.row_px)

    def scrollContentsBy(self, _dx: int, _dy: int) -> None:  # noqa: N802  (Qt's name)
        self.viewport().update()

    def middle_of(self, bar: Bar) -> QPoint:
        """Return a place of the viewport that lies on an event."""
        place = self.place_of(bar)
        top_px, height_px = self._heights.part_of(bar.layer)
        return QPoint(round(place.center().x()), round(place.top() + top_px + height_px / 2))
