"""Events and activity over the time of a session, by pyqtgraph."""

from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from adibas.texts import decimal_text
from adibas.texts import translate as _
from ui.behaviour.measured import S_PER_MINUTE, HeatMap, Raster
from ui.theme import Theme
from ui.widgets.plot import Plot

if TYPE_CHECKING:
    from pyqtgraph import PlotWidget

BAR_HEIGHT = 0.8
POINT_SHARE = 0.003
"""Of the session: so wide is an event that does not last."""
LEAST_LETTERS, LEAST_LINES = 20, 10
NAMES_SHARE, LINES_BELOW = 0.45, 4
"""Of the width, for the longest name; for the axis below, with air."""
COLOR_MAP = "viridis"
MOST_MINUTES_IN_SECONDS = 5.0


class TimePlot(Plot):
    """One row for each behaviour or joint, time across."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(theme, parent)
        self._content: Raster | HeatMap | None = None
        self.setMinimumSize(QSize(0, 0))

    def minimumSizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        """Ask for room for some lines."""
        letters = self.fontMetrics()
        return QSize(LEAST_LETTERS * letters.averageCharWidth(), LEAST_LINES * letters.height())

    @property
    def n_points(self) -> int:
        return 0 if self._content is None else len(self._content.rows)

    def show_content(self, content: Raster | HeatMap | None) -> None:
        """Show events or activity; None for nothing."""
        self._content = content
        self.setAccessibleDescription("" if content is None else "; ".join(_told(content)))
        self.redraw()

    def draw(self, plot: "PlotWidget") -> None:
        content = self._content
        if content is None:
            return
        scale, unit = _scale(content)
        for _name, begin, end in content.sections:
            self._add_section(plot, scale * begin, scale * end)
        if isinstance(content, Raster):
            self._add_bars(plot, content)
        else:
            self._add_map(plot, content)
        n_rows = len(content.rows)
        plot.getViewBox().invertY(True)
        plot.setXRange(0.0, max(scale * content.end_min, 1e-6), padding=0.0)
        plot.setYRange(-0.5, n_rows - 0.5, padding=0.0)
        letters, room_px = self.fontMetrics(), round(NAMES_SHARE * self.width())
        n_lines = max(self.height() // letters.height() - LINES_BELOW, 1)
        every = -(-n_rows // n_lines)
        names = [
            (row, letters.elidedText(name, Qt.TextElideMode.ElideRight, room_px))
            for row, name in enumerate(content.rows)
            if row % every == 0
        ]
        widest_px = max(letters.horizontalAdvance(name) for _row, name in names)
        plot.getAxis("left").setTicks([names, []])
        plot.getAxis("left").setWidth(widest_px + 2 * letters.averageCharWidth())
        self.name_axes(plot, unit, "")
        self.setToolTip(_brightest(content))

    def _add_section(self, plot: "PlotWidget", begin: float, end: float) -> None:
        import pyqtgraph

        tint = QColor(self._theme.tokens.accent)
        tint.setAlpha(30)
        pen = pyqtgraph.mkPen(QColor(self._theme.tokens.line), width=1)
        part = pyqtgraph.LinearRegionItem(values=(begin, end), brush=tint, pen=pen, movable=False)
        part.setZValue(-20)
        plot.addItem(part)

    def _add_bars(self, plot: "PlotWidget", content: Raster) -> None:
        import pyqtgraph

        scale, _unit = _scale(content)
        least = POINT_SHARE * scale * content.end_min
        bars = pyqtgraph.BarGraphItem(
            x0=[scale * begin for _row, begin, _end, _color in content.bars],
            width=[max(scale * (end - begin), least) for _row, begin, end, _color in content.bars],
            y=[row for row, _begin, _end, _color in content.bars],
            height=BAR_HEIGHT,
            brushes=[QColor(color) for _row, _begin, _end, color in content.bars],
            pen=None,
        )
        plot.addItem(bars)

    def _add_map(self, plot: "PlotWidget", content: HeatMap) -> None:
        import pyqtgraph

        if not np.isfinite(content.values).any():
            return
        image = pyqtgraph.ImageItem(content.values, axisOrder="row-major")
        image.setLevels((0.0, max(float(np.nanmax(content.values)), 1e-9)))
        image.setColorMap(pyqtgraph.colormap.get(COLOR_MAP))
        n_rows = len(content.rows)
        scale, _unit = _scale(content)
        image.setRect(QRectF(0.0, -0.5, max(scale * content.end_min, 1e-6), n_rows))
        plot.addItem(image)


def _scale(content: Raster | HeatMap) -> tuple[float, str]:
    """Return the units of the axis in a minute, and its title: a short session in seconds."""
    if content.end_min > MOST_MINUTES_IN_SECONDS:
        return 1.0, _("Time [min]")
    return S_PER_MINUTE, _("Time [s]")


def _brightest(content: Raster | HeatMap) -> str:
    if isinstance(content, Raster) or not np.isfinite(content.values).any():
        return ""
    most = decimal_text(float(np.nanmax(content.values)), 1)
    return _("Brightest: {most} m/min; empty: not seen").format(most=most)


def _told(content: Raster | HeatMap) -> list[str]:
    """Say the same in words, to who cannot see it."""
    if isinstance(content, Raster):
        counts = np.bincount([bar[0] for bar in content.bars], minlength=len(content.rows))
        return [f"{name}: {count}" for name, count in zip(content.rows, counts, strict=True)]
    means = [
        float(np.mean(row[np.isfinite(row)])) if np.isfinite(row).any() else 0.0
        for row in content.values
    ]
    return [
        f"{name}: {decimal_text(mean, 2)} m/min"
        for name, mean in zip(content.rows, means, strict=True)
    ]
