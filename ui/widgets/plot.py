"""A plot by pyqtgraph in the theme's colours and the letters in use, which the keyboard reaches."""

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QBuffer, QByteArray, QEvent, QIODevice, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFont,
    QFontMetrics,
    QImage,
    QImageWriter,
    QKeyEvent,
    QPainter,
    QResizeEvent,
)
from PySide6.QtWidgets import QApplication, QFrame, QVBoxLayout, QWidget

from adibas.texts import decimal_text
from ui.theme import Theme

if TYPE_CHECKING:
    from pyqtgraph import PlotWidget

LEAST_SIZE = QSize(320, 200)
DOT_SHARE, RING_SHARE = 0.75, 1.3
"""Of a point and of the ring about the chosen one, in heights of a letter."""
LINE_PX = 2.0
TITLE_SHARE = 1.2
EXPORT_RATIO = 2.0
MARGIN_PX = 12
TICK_GAP_PX = 6
"""Between two numbers below a plot, at the least."""
ROUNDING = 1e-9
LETTERS_OF_A_DAY = 14
"""Under the axis, with air."""
LEAST_SPANS = {"deg": 2.0, "mm": 6.0, "cm": 1.0, "%": 5.0}
"""An axis shows no less, so that noise does not look like a change."""
LOOKS_CHANGED = (
    QEvent.Type.FontChange,
    QEvent.Type.PaletteChange,
    QEvent.Type.StyleChange,
)


class Plot(QFrame):
    """Points that Left, Right, Home and End go through; derived classes draw them.

    pyqtgraph is imported when the first plot is drawn.
    """

    stepped = Signal(int)
    """The keyboard or the mouse chose a point."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("plot")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(LEAST_SIZE)
        self._theme = theme
        self._widget: PlotWidget | None = None
        self._chosen = -1
        self._layout = QVBoxLayout(self)
        self._layout.setContentsMargins(3, 3, 3, 3)

    @property
    def n_points(self) -> int:
        """How many points there are to choose."""
        return 0

    @property
    def is_drawn(self) -> bool:
        """Whether there is anything to draw."""
        return self.n_points > 0

    @property
    def chosen(self) -> int:
        """Index of the chosen point; -1 for none."""
        return self._chosen

    def sizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        """Ask for what it needs at least: what is drawn would ask for its own usual size."""
        return self.minimumSize().expandedTo(self.minimumSizeHint())

    def draw(self, plot: "PlotWidget") -> None:
        """Draw everything onto an empty plot; called only where something is to be drawn."""

    def choose(self, index: int) -> None:
        """Mark a point."""
        if index != self._chosen:
            self._chosen = index
            self.redraw()

    def redraw(self) -> None:
        """Draw anew, in the theme, the letters and the language in use."""
        if not self.is_drawn:
            if self._widget is not None:
                self._widget.clear()
            return
        plot = self._made()
        plot.clear()
        tokens, font = self._theme.tokens, self.font()
        plot.setBackground(tokens.raised)
        for side in ("left", "bottom"):
            axis = plot.getAxis(side)
            axis.setPen(QColor(tokens.line))
            axis.setTextPen(QColor(tokens.text))
            axis.setTickFont(font)
            axis.enableAutoSIPrefix(False)
            axis.setSIPrefixEnableRanges(())  # below 1 it counts in thousandths all the same
            axis.setStyle(hideOverlappingLabels=self._half_label_px())
            axis.tickStrings = tick_texts
        across = plot.getAxis("bottom")
        across.setStyle(maxTextLevel=0)
        across.tickStrings = partial(_texts_beside_one_another, across, self.fontMetrics())
        margins = (self.left_margin_px(), MARGIN_PX // 2, self.right_margin_px(), 1)
        plot.getPlotItem().layout.setContentsMargins(*margins)
        plot.showGrid(x=False, y=True, alpha=0.25)
        self.draw(plot)

    def left_margin_px(self) -> int:
        """Return what is kept free beside the numbers at the left for the first text below."""
        return 1

    def right_margin_px(self) -> int:
        """Return what is kept free beside the plot for the last text below it."""
        return self._half_label_px()

    def name_axes(self, plot: "PlotWidget", across: str, up: str) -> None:
        """Write what the axes are; a title longer than its axis goes on in another line."""
        style = {"color": self._theme.tokens.text, "font-size": f"{self.font().pointSizeF():.1f}pt"}
        plot.setLabel("bottom", across, **style)
        metrics = self.fontMetrics()
        room_px = max(self.height() - 3 * metrics.height(), 0)  # ticks and the title below
        plot.setLabel("left", _in_lines(up, metrics, room_px), **style)

    def add_points(self, plot: "PlotWidget", x: Sequence[float], y: Sequence[float]) -> None:
        """Draw the points, and a ring about the chosen one."""
        import pyqtgraph

        letter_px = self.fontMetrics().height()
        color = QColor(self._theme.tokens.accent)
        dots = pyqtgraph.ScatterPlotItem(
            x=list(x),
            y=list(y),
            size=DOT_SHARE * letter_px,
            brush=color,
            pen=pyqtgraph.mkPen(self._theme.tokens.raised, width=1),
        )
        dots.sigClicked.connect(self._on_clicked)
        plot.addItem(dots)
        if 0 <= self._chosen < len(x):
            ring = pyqtgraph.ScatterPlotItem(
                x=[x[self._chosen]],
                y=[y[self._chosen]],
                size=RING_SHARE * letter_px,
                brush=None,
                pen=pyqtgraph.mkPen(self._theme.tokens.text, width=LINE_PX),
            )
            plot.addItem(ring)

    def add_level(self, plot: "PlotWidget", y: float, color: str, *, is_dashed: bool) -> None:
        """Draw a line across the plot."""
        import pyqtgraph

        style = Qt.PenStyle.DashLine if is_dashed else Qt.PenStyle.SolidLine
        pen = pyqtgraph.mkPen(color, width=LINE_PX, style=style)
        plot.addItem(pyqtgraph.InfiniteLine(pos=y, angle=0, pen=pen, movable=False))

    def add_band(self, plot: "PlotWidget", low: float, high: float, color: str) -> None:
        """Tint the plot between two heights."""
        import pyqtgraph

        tint, edge = QColor(color), QColor(color)
        tint.setAlpha(45)
        edge.setAlpha(160)
        band = pyqtgraph.LinearRegionItem(
            values=(low, high),
            orientation="horizontal",
            brush=tint,
            pen=pyqtgraph.mkPen(edge, width=1),
            movable=False,
        )
        band.setZValue(-20)
        plot.addItem(band)

    def picture_png(self, title: str, caption: str) -> bytes:
        """Return the plot between its title and its caption, as a PNG file."""
        plot = self._made()
        font = QFont(self.font())
        heading = QFont(font)
        heading.setPointSizeF(TITLE_SHARE * font.pointSizeF())
        heading.setBold(True)
        width = plot.width()
        above = _height(heading, title, width) + MARGIN_PX
        below = _height(font, caption, width) + MARGIN_PX
        size = QSize(width + 2 * MARGIN_PX, above + plot.height() + below + 2 * MARGIN_PX)
        image = QImage(size * EXPORT_RATIO, QImage.Format.Format_RGB32)
        image.setDevicePixelRatio(EXPORT_RATIO)
        image.fill(QColor(self._theme.tokens.raised))
        painter = QPainter(image)
        painter.setPen(QColor(self._theme.tokens.text))
        painter.translate(MARGIN_PX, MARGIN_PX)
        _write(painter, heading, title, QRectF(0, 0, width, above))
        plot.render(painter, QRectF(0, above, width, plot.height()))
        lower = QRectF(0, above + plot.height() + MARGIN_PX, width, below)
        _write(painter, font, caption, lower)
        painter.end()
        return _png(image)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        last = self.n_points - 1
        steps = {
            Qt.Key.Key_Left: max(self._chosen - 1, 0),
            Qt.Key.Key_Right: min(self._chosen + 1, last),
            Qt.Key.Key_Home: 0,
            Qt.Key.Key_End: last,
        }
        wanted = steps.get(Qt.Key(event.key()))
        if wanted is None or last < 0:
            super().keyPressEvent(event)
        else:
            self._step(wanted)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        """Follow the theme and the size of letters."""
        super().changeEvent(event)
        if event.type() in LOOKS_CHANGED and self._widget is not None:
            self.redraw()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        """Write as much beside the axes as there is room for."""
        super().resizeEvent(event)
        if self._widget is not None:
            self.redraw()

    def _half_label_px(self) -> int:
        """Return half the width of a date: so far a text below the axis reaches beyond its end."""
        return LETTERS_OF_A_DAY * self.fontMetrics().averageCharWidth() // 2

    def _on_clicked(self, _dots: Any, points: Sequence[Any], _event: Any) -> None:
        if len(points):
            self._step(int(points[0].index()))

    def _step(self, index: int) -> None:
        self.choose(index)
        self.stepped.emit(index)

    def _made(self) -> "PlotWidget":
        if self._widget is None:
            import pyqtgraph

            plot = pyqtgraph.PlotWidget(self, enableMenu=False)
            plot.hideButtons()
            plot.setMouseEnabled(x=False, y=False)
            plot.setAntialiasing(True)
            plot.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            self._layout.addWidget(plot)
            self._widget = plot
        return self._widget


def _in_lines(text: str, metrics: QFontMetrics, room_px: int) -> str:
    """Return a text broken between words where it is longer than its room."""
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and metrics.horizontalAdvance(longer) <= room_px:
            lines[-1] = longer
        else:
            lines.append(word)
    if len(lines) > 1:
        lines.append("&nbsp;")  # the axis has room for 80 % of the lines
    return "<br>".join(lines)


def tick_texts(values: Sequence[float], scale: float, spacing: float) -> list[str]:
    """Return what stands at the ticks of an axis, with the decimals that tell them apart."""
    n_decimals = max(0, math.ceil(-math.log10(spacing * scale) - ROUNDING))
    return [decimal_text(value * scale, n_decimals) for value in values]


def _texts_beside_one_another(
    axis: Any, metrics: QFontMetrics, values: Sequence[float], scale: float, spacing: float
) -> list[str]:
    """Return what stands below a plot; where it is narrow, at every second or third tick alone."""
    texts = tick_texts(values, scale, spacing)
    low, high = axis.range
    room_px = spacing / (high - low) * axis.width()
    widest_px = max(map(metrics.horizontalAdvance, texts), default=0) + TICK_GAP_PX
    every = max(1, math.ceil(widest_px / room_px))
    marked = zip(values, texts, strict=True)
    return [text if round(value / spacing) % every == 0 else "" for value, text in marked]


def spread(values: Sequence[float], unit: str) -> tuple[float, float]:
    """Return the ends of an axis that shows all values of a unit."""
    low, high = min(values), max(values)
    middle, half = (low + high) / 2, max(high - low, LEAST_SPANS[unit]) / 2
    return middle - half, middle + half


def _height(font: QFont, text: str, width: int) -> int:
    box = QFontMetrics(font).boundingRect(
        QRect(0, 0, width, 10_000), Qt.TextFlag.TextWordWrap, text
    )
    return box.height()


def _write(painter: QPainter, font: QFont, text: str, room: QRectF) -> None:
    painter.setFont(font)
    painter.drawText(room, Qt.TextFlag.TextWordWrap, text)


def _png(image: QImage) -> bytes:
    buffer = QBuffer(QApplication.instance())
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    QImageWriter(buffer, QByteArray(b"png")).write(image)
    data = bytes(buffer.data().data())
    buffer.deleteLater()
    return data
