"""One measure over the patient's sessions: value and interval by date, and what is detectable."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from adibas.data.protocols import ReferenceValue
from adibas.data.trends import Trend, TrendPoint
from adibas.texts import translate as _
from ui.comparison.rows import point_rows
from ui.theme import Theme
from ui.widgets.dates import day_text
from ui.widgets.plot import LETTERS_OF_A_DAY, LINE_PX, Plot, spread

if TYPE_CHECKING:
    from pyqtgraph import PlotWidget

DAY_S = 86_400.0
BEAM_SHARE = 0.012
"""Of the width, half the beam at the end of an interval."""
PADDING = 0.05


class TrendPlot(Plot):
    """Dots with bars, the band of the smallest detectable change, and a reference where wanted."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(theme, parent)
        self._trend: Trend | None = None
        self._reference: ReferenceValue | None = None

    @property
    def n_points(self) -> int:
        return 0 if self._trend is None else len(self._trend.points)

    def left_margin_px(self) -> int:
        """Keep room for half the first date: the axis takes two lines of letters at least."""
        return max(self._half_date_px(0) - 2 * self.fontMetrics().height(), 1)

    def right_margin_px(self) -> int:
        """Keep room for half the last date."""
        return max(super().right_margin_px(), self._half_date_px(-1))

    def show_trend(self, trend: Trend | None, reference: ReferenceValue | None) -> None:
        """Show a measure, and what others found."""
        self._trend, self._reference = trend, reference
        self._chosen = self.n_points - 1
        self.redraw()

    def redraw(self) -> None:
        """Draw anew, and say the same in words to who cannot see it."""
        super().redraw()
        if self._trend is None:
            self.setAccessibleDescription("")
            return
        lines = (", ".join(row.cells) for row in point_rows(self._trend))
        self.setAccessibleDescription(". ".join(lines))

    def draw(self, plot: "PlotWidget") -> None:
        trend, tokens = self._trend, self._theme.tokens
        if trend is None:
            return
        times_s = [point.taken_utc.timestamp() for point in trend.points]
        values = [point.value for point in trend.points]
        if trend.band is not None:
            self.add_band(plot, *trend.band, tokens.good)
        if self._reference is not None:
            self.add_level(plot, self._reference.mean, tokens.warning, is_dashed=True)
        self._draw_intervals(plot, trend, times_s)
        self.add_points(plot, times_s, values)
        self._scale(plot, trend, times_s)
        unit = _(trend.definition.unit)
        self.name_axes(plot, _("Session"), _("Value [{unit}]").format(unit=unit))

    def _draw_intervals(self, plot: "PlotWidget", trend: Trend, times_s: list[float]) -> None:
        import numpy as np
        import pyqtgraph

        values = np.array([point.value for point in trend.points])
        ends = np.array([point.interval for point in trend.points])
        pen = pyqtgraph.mkPen(QColor(self._theme.tokens.accent), width=LINE_PX)
        plot.addItem(pyqtgraph.PlotDataItem(times_s, values, pen=pen))
        plot.addItem(
            pyqtgraph.ErrorBarItem(
                x=np.array(times_s),
                y=values,
                top=ends[:, 1] - values,
                bottom=values - ends[:, 0],
                beam=2 * BEAM_SHARE * _span(times_s),
                pen=pen,
            )
        )

    def _half_date_px(self, index: int) -> int:
        if self._trend is None:
            return 0
        text = _date_below(self._trend.points[index])
        return self.fontMetrics().horizontalAdvance(text) // 2 + 1

    def _scale(self, plot: "PlotWidget", trend: Trend, times_s: list[float]) -> None:
        shown = [limit for point in trend.points for limit in point.interval]
        shown += trend.band or ()
        if self._reference is not None:
            shown.append(self._reference.mean)
        plot.setYRange(*spread(shown, trend.definition.unit), padding=PADDING)
        center, reach = (times_s[0] + times_s[-1]) / 2, _span(times_s) / 2
        plot.setXRange(center - reach, center + reach, padding=PADDING)
        days = [_date_below(point) for point in trend.points]
        room = max(self.width(), 1) / (LETTERS_OF_A_DAY * self.fontMetrics().averageCharWidth())
        kept = spaced(times_s, _span(times_s) / max(room - 1, 1))
        ticks = [(times_s[index], days[index]) for index in kept]
        plot.getAxis("bottom").setTicks([ticks, []])


def _date_below(point: TrendPoint) -> str:
    return day_text(point.taken_utc.astimezone().date())


def _span(times_s: Sequence[float]) -> float:
    return max(times_s[-1] - times_s[0], DAY_S)


def spaced(places: Sequence[float], least: float) -> list[int]:
    """Return the indices of as many places as stand so far apart, the first and the last first."""
    last = len(places) - 1
    kept = [0]
    for index in range(1, last):
        far = places[index] - places[kept[-1]] >= least
        if far and places[last] - places[index] >= least:
            kept.append(index)
    if places[last] - places[kept[-1]] >= least:
        kept.append(last)
    return kept
