"""Pictures of the back: its asymmetry in colours, and the spine of two sessions in one plot."""

from typing import TYPE_CHECKING, Literal

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from adibas.arrays import FloatArray
from adibas.texts import decimal_text, message
from adibas.texts import translate as _
from ui.comparison.back_content import Backs, SeenBack
from ui.theme import Theme
from ui.widgets.plot import LINE_PX, MARGIN_PX, Plot

if TYPE_CHECKING:
    from pyqtgraph import PlotWidget

Curve = Literal["profile_mm", "aside_mm", "rotation_deg"]
ACROSS = {
    "profile_mm": message("to the back [mm]"),
    "aside_mm": message("to the right [mm]"),
    "rotation_deg": message("right side back [°]"),
}
LEAST_REACH = {"profile_mm": 40.0, "aside_mm": 15.0, "rotation_deg": 6.0}
"""An axis shows no less, so that noise does not look like a deformity."""
COLORS = "CET-D1"
"""Blue, white, red: Kovesi, Good colour maps: how to design them, arXiv 1509.03700."""
LARGEST_MM = 20.0
"""Asymmetry at which the colours end."""
LEAST_MAP_PX = 240
"""A back is narrow, and beside two of them there must be room for a plot."""
HALF_WIDTH_MM = 210.0
MM_PER_M = 1000.0
PADDING = 0.03
NAME_GAP, LONGEST_NAME = 0.2, "ICT"
"""Between a turn's dot and its name, as a share of the name."""

LETTERS_AT_THE_LEFT = 4
"""Heights of a letter that the numbers and the title beside the plot take at the most."""


class AsymmetryMap(Plot):
    """One back seen from behind; red lies further back than the other side."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(theme, parent)
        self.setMinimumWidth(LEAST_MAP_PX)
        self._back: SeenBack | None = None

    @property
    def is_drawn(self) -> bool:
        return self._back is not None

    def show_back(self, back: SeenBack | None) -> None:
        """Show another back."""
        self._back = back
        self.redraw()
        if back is None:
            self.setAccessibleDescription("")
            return
        largest_mm = float(np.nanpercentile(np.abs(back.asymmetry_mm), 95))
        told = _("95 % of the back differ by less than {mm} mm from the other side.")
        self.setAccessibleDescription(told.format(mm=decimal_text(largest_mm, 1)))

    def draw(self, plot: "PlotWidget") -> None:
        import pyqtgraph

        back = self._back
        if back is None:
            return
        image = pyqtgraph.ImageItem(
            back.asymmetry_mm[::-1].astype(np.float32),
            axisOrder="row-major",
            levels=(-LARGEST_MM, LARGEST_MM),
            colorMap=pyqtgraph.colormap.get(COLORS),
        )
        size = back.right_mm - back.left_mm, back.top_m - back.bottom_m
        image.setRect(QRectF(back.left_mm, back.bottom_m, *size))
        plot.addItem(image)
        pen = pyqtgraph.mkPen(QColor(Qt.GlobalColor.black), width=LINE_PX)
        plot.addItem(pyqtgraph.PlotDataItem(back.aside_mm, back.height_m, pen=pen))
        plot.setAspectLocked(lock=True, ratio=1.0 / MM_PER_M)
        known = np.flatnonzero(np.isfinite(back.asymmetry_mm).any(axis=1))
        heights_m = np.linspace(back.top_m, back.bottom_m, len(back.asymmetry_mm))
        plot.setRange(
            xRange=(-HALF_WIDTH_MM, HALF_WIDTH_MM),
            yRange=(heights_m[known[-1]], heights_m[known[0]]),
            padding=PADDING,
        )
        aside = ACROSS["aside_mm"]
        self.name_axes(plot, _(aside), _("Height over the floor [m]"))


class SpinePlot(Plot):
    """The spine before and now, over the height."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(theme, parent)
        self._backs = Backs()
        self._curve: Curve = "profile_mm"

    @property
    def is_drawn(self) -> bool:
        return self._backs.earlier is not None or self._backs.later is not None

    def show_backs(self, backs: Backs, curve: Curve) -> None:
        """Show one of the curves of both backs."""
        self._backs, self._curve = backs, curve
        self.redraw()
        told = [_extremes(one, curve) for one in (backs.earlier, backs.later) if one is not None]
        self.setAccessibleDescription(" ".join(told))

    def draw(self, plot: "PlotWidget") -> None:
        import pyqtgraph

        tokens = self._theme.tokens
        zero = pyqtgraph.mkPen(QColor(tokens.line), width=1)
        plot.addItem(pyqtgraph.InfiniteLine(pos=0.0, angle=90, pen=zero, movable=False))
        styles = (tokens.warning, Qt.PenStyle.DashLine), (tokens.accent, Qt.PenStyle.SolidLine)
        seen = [self._backs.earlier, self._backs.later]
        for back, (color, style) in zip(seen, styles, strict=True):
            if back is not None:
                pen = pyqtgraph.mkPen(QColor(color), width=LINE_PX, style=style)
                values = self._values(back)
                plot.addItem(pyqtgraph.PlotDataItem(values, back.height_m, pen=pen))
        shown = [back for back in seen if back is not None]
        if self._curve == "profile_mm":
            self._name_turns(plot, shown[-1])
        every = np.concatenate([self._values(back) for back in shown])
        least = LEAST_REACH[self._curve]
        low, high = min(float(every.min()), -least), max(float(every.max()), least)
        heights_m = np.concatenate([back.height_m for back in shown])
        plot.setXRange(low, high + self._room_for_names(high - low), padding=PADDING)
        plot.setYRange(float(heights_m.min()), float(heights_m.max()), padding=PADDING)
        self.name_axes(plot, _(ACROSS[self._curve]), _("Height over the floor [m]"))

    def right_margin_px(self) -> int:
        """Return less where the names of turns have room in the plot: numbers are no dates."""
        usual_px = super().right_margin_px()
        return 2 * usual_px // 3 if self._curve == "profile_mm" else usual_px

    def _room_for_names(self, span: float) -> float:
        """Return how much longer the axis is for a name beside its end, in its own unit."""
        if self._curve != "profile_mm":
            return 0.0
        metrics = self.fontMetrics()
        name_px = (1 + NAME_GAP) * (metrics.horizontalAdvance(LONGEST_NAME) + MARGIN_PX)
        plot_px = self.width() - LETTERS_AT_THE_LEFT * metrics.height() - self.right_margin_px()
        return span * name_px / max(plot_px - name_px, name_px)

    def _values(self, back: SeenBack) -> FloatArray:
        return _curve_of(back, self._curve)

    def _name_turns(self, plot: "PlotWidget", back: SeenBack) -> None:
        import pyqtgraph

        tokens = self._theme.tokens
        for name, value_mm, height_m in back.turns:
            dot = pyqtgraph.ScatterPlotItem(
                x=[value_mm], y=[height_m], size=self.fontMetrics().height() / 2,
                brush=QColor(tokens.accent), pen=None,
            )  # fmt: skip
            text = pyqtgraph.TextItem(name, color=QColor(tokens.text), anchor=(-NAME_GAP, 0.5))
            text.setFont(self.font())
            text.setPos(value_mm, height_m)
            for item in (dot, text):
                plot.addItem(item)


def _curve_of(back: SeenBack, curve: Curve) -> FloatArray:
    values: FloatArray = getattr(back, curve)
    return values


def _extremes(back: SeenBack, curve: Curve) -> str:
    values = _curve_of(back, curve)
    low, high = (decimal_text(float(value), 1) for value in (values.min(), values.max()))
    return _("{low} to {high}").format(low=low, high=high) + "."
