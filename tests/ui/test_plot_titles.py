"""What an axis is stands beside it, all of it, also with large letters."""

from datetime import UTC, datetime
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from pyqtgraph import TextItem
from PySide6.QtCore import QLocale, QPointF
from PySide6.QtWidgets import QApplication

from adibas.data.trends import Trend, TrendPoint
from adibas.texts import LANGUAGES, speaking
from adibas.texts import translate as _
from tests.unit.test_trends import ACROMIA
from ui.comparison.back_content import Backs, SeenBack
from ui.comparison.back_plots import SpinePlot
from ui.comparison.trend_plot import TrendPlot
from ui.widgets import dates
from ui.widgets.dates import day_text
from ui.widgets.plot import Plot


class Empty(Plot):
    """Axes around nothing."""

    @property
    def is_drawn(self):
        return True

    def draw(self, plot):
        self.name_axes(plot, "", _("Height over the floor [m]"))


@pytest.mark.usefixtures("large_letters")
@pytest.mark.parametrize("height_px", [240, 320, 700])
def test_a_title_that_is_longer_than_its_axis_goes_on_in_another_line(qtbot, theme, height_px):
    with speaking("es"):
        plot = Empty(theme)
        qtbot.addWidget(plot)
        plot.resize(420, height_px)
        plot.show()
        plot.redraw()
        for _step in range(3):
            QApplication.processEvents()
        axis = plot._widget.getAxis("left")
        title = axis.label.mapRectToScene(axis.label.boundingRect())
    assert axis.label.toPlainText().split() == ["Altura", "sobre", "el", "suelo", "[m]"]
    assert title.top() >= -1
    assert title.bottom() <= plot.height() + 1
    assert title.left() >= -4
    is_long = height_px < 500
    assert ("\n" in axis.label.toPlainText()) == is_long


def a_back():
    height_m = np.linspace(0.8, 1.5, 50)
    profile_mm = 30.0 * np.sin(9.0 * height_m) - 20.0
    turns = tuple((name, float(profile_mm[k]), float(height_m[k])) for name, k in TURNS.items())
    empty = np.zeros((50, 20))
    return SeenBack(empty, -200.0, 200.0, 0.8, 1.5, height_m, *[profile_mm] * 3, turns, ())


TURNS = {"ILS": 2, "LA": 12, "ITL": 24, "KA": 36, "ICT": 47}


@pytest.mark.usefixtures("large_letters")
@pytest.mark.parametrize("width_px", [320, 420, 900])
def test_the_names_of_turns_stand_in_the_plot_whole(qtbot, theme, width_px):
    plot = SpinePlot(theme)
    qtbot.addWidget(plot)
    plot.resize(width_px, 320)
    plot.show()
    plot.show_backs(Backs(None, a_back()), "profile_mm")
    plot.redraw()  # as when the window gave it its place
    for _step in range(3):
        QApplication.processEvents()
    view = plot._widget.getPlotItem().getViewBox()
    names = [one for one in view.allChildren() if isinstance(one, TextItem)]
    assert len(names) == len(TURNS)
    room = view.mapRectToScene(view.boundingRect())
    for name in names:
        place = name.mapRectToScene(name.boundingRect())
        assert room.left() - TEXT_MARGIN_PX <= place.left(), name.toPlainText()
        assert place.right() <= room.right() + TEXT_MARGIN_PX, name.toPlainText()


TEXT_MARGIN_PX = 4
"""What pyqtgraph leaves about a text."""


@pytest.mark.usefixtures("large_letters")
@pytest.mark.parametrize("width_px", [320, 420, 900])
def test_numbers_below_a_plot_stand_apart(qtbot, theme, width_px, monkeypatch):
    plot = SpinePlot(theme)
    qtbot.addWidget(plot)
    plot.resize(width_px, 320)
    plot.show()
    plot.show_backs(Backs(None, a_back()), "profile_mm")
    QApplication.processEvents()
    axis = plot._widget.getAxis("bottom")
    drawn = []
    monkeypatch.setattr(axis, "drawPicture", lambda _p, _axis, _ticks, texts: drawn.append(texts))
    axis.picture = None
    plot._widget.grab()
    places = sorted(
        (box.left(), box.left() + plot.fontMetrics().horizontalAdvance(text))
        for box, _flags, text in drawn[-1]
        if text
    )
    assert places
    assert all(end < begin for (_left, end), (begin, _right) in pairwise(places))


@pytest.mark.usefixtures("large_letters")
@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("width_px", [320, 420, 900])
def test_the_first_and_the_last_date_below_a_trend_are_whole(
    qtbot, theme, language, width_px, monkeypatch
):
    monkeypatch.setattr(dates, "QLocale", partial(QLocale, language))
    begin_utc, end_utc = (
        datetime(2026, 9, 5, 12, tzinfo=UTC),
        datetime(2026, 11, 28, 12, tzinfo=UTC),
    )
    with speaking(language):
        plot = TrendPlot(theme)
        qtbot.addWidget(plot)
        plot.resize(width_px, 320)
        plot.show()
        plot.show_trend(trend_between(begin_utc, end_utc), None)
        plot.redraw()  # as when the window gave it its place
        for _step in range(3):
            QApplication.processEvents()
        widths_px = [
            plot.fontMetrics().horizontalAdvance(day_text(day.astimezone().date()))
            for day in (begin_utc, end_utc)
        ]
    view = plot._widget.getPlotItem().getViewBox()
    first_px, last_px = (
        view.mapViewToScene(QPointF(day.timestamp(), 0.0)).x() for day in (begin_utc, end_utc)
    )
    assert first_px - widths_px[0] / 2 >= 0
    assert last_px + widths_px[1] / 2 <= plot._widget.width()


def trend_between(begin_utc, end_utc):
    """Return a trend of two sessions."""
    points = tuple(
        TrendPoint(str(day), day, float(n), (n - 3.0, n + 3.0))
        for n, day in enumerate((begin_utc, end_utc))
    )
    return Trend(ACROMIA, "anterior", points)
