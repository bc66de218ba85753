"""Events and activity over the time of a session, by pyqtgraph."""

from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from adibas.arrays import FloatArray
from adibas.reports.behaviour_lines import time_axis
from adibas.texts import decimal_text
from adibas.texts import translate as _
from ui.behaviour.measured import HeatMap, Raster
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
    def is_drawn(self) -> bool:
        return self._content is not None and bool(self._content.rows)

    def show_content(self, content: Raster | HeatMap | None) -> None:
        """Show events or activity; None for nothing."""
        self._content = content
        self.setAccessibleDescription("" if content is None else "; ".join(_told(content)))
        self.redraw()

    def draw(self, plot: "PlotWidget") -> None:
        content = self._content
        if content is None:
            return
        unit_s, title = time_axis(content.duration_s)
        for _name, begin_s, end_s in content.sections:
            self._add_section(plot, begin_s / unit_s, end_s / unit_s)
        if isinstance(content, Raster):
            self._add_bars(plot, content, unit_s)
        else:
            self._add_map(plot, content, unit_s)
        n_rows = len(content.rows)
        plot.getViewBox().invertY(True)
        plot.setXRange(0.0, max(content.duration_s / unit_s, 1e-6), padding=0.0)
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
        self.name_axes(plot, title, "")
        self.setToolTip(_brightest(content))

    def _add_section(self, plot: "PlotWidget", begin: float, end: float) -> None:
        import pyqtgraph

        tint = QColor(self._theme.tokens.accent)
        tint.setAlpha(30)
        pen = pyqtgraph.mkPen(QColor(self._theme.tokens.line), width=1)
        part = pyqtgraph.LinearRegionItem(values=(begin, end), brush=tint, pen=pen, movable=False)
        part.setZValue(-20)
        plot.addItem(part)

    def _add_bars(self, plot: "PlotWidget", content: Raster, unit_s: float) -> None:
        import pyqtgraph

        least_s = POINT_SHARE * content.duration_s
        bars = pyqtgraph.BarGraphItem(
            x0=[begin / unit_s for _row, begin, _end, _color in content.bars],
            width=[max(end - begin, least_s) / unit_s for _row, begin, end, _color in content.bars],
            y=[row for row, _begin, _end, _color in content.bars],
            height=BAR_HEIGHT,
            brushes=[QColor(color) for _row, _begin, _end, color in content.bars],
            pen=None,
        )
        plot.addItem(bars)

    def _add_map(self, plot: "PlotWidget", content: HeatMap, unit_s: float) -> None:
        import pyqtgraph

        if not np.isfinite(content.values).any():
            return
        image = pyqtgraph.ImageItem(content.values, axisOrder="row-major")
        image.setLevels((0.0, max(float(np.nanmax(content.values)), 1e-9)))
        image.setColorMap(pyqtgraph.colormap.get(COLOR_MAP))
        n_rows, n_bins = content.values.shape  # the last bin may reach beyond the end
        image.setRect(QRectF(0.0, -0.5, n_bins * content.bin_s / unit_s, n_rows))
        plot.addItem(image)


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
    return [
        f"{name}: {_speed(row)}" for name, row in zip(content.rows, content.values, strict=True)
    ]


def _speed(per_minute_m: FloatArray) -> str:
    seen = per_minute_m[np.isfinite(per_minute_m)]
    return f"{decimal_text(float(np.mean(seen)), 2)} m/min" if seen.size else _("not seen")
