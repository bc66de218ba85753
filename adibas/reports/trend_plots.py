"""Measures over a patient's sessions as small plots: value and interval by date."""

import io
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from adibas.arrays import UInt8Array
from adibas.clock import day_here
from adibas.data.trends import Trend
from adibas.reports.facts import view_name
from adibas.texts import decimal_text
from adibas.texts import translate as _

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

VALUE, BAND, INK, FAINT = "#0072B2", "#009E73", "#16212B", "#C3CCD4"
N_ACROSS, N_DOWN = 3, 5
FONT_PT, TITLE_PT = 6.0, 6.5
DOTS_PER_INCH = 130
MOST_PLOTS = 30
LEAST_POINTS = 2
LEAST_SPANS = {"deg": 2.0, "mm": 6.0, "cm": 1.0, "%": 5.0}
"""An axis shows no less, so that noise does not look like a change."""
LETTERS_OF_A_LINE = 42
DAY_S = 86_400.0


def plotted(trends: Sequence[Trend]) -> tuple[Trend, ...]:
    """Return the trends that a report draws: those that somebody chose and that have two points.

    Where a protocol has nothing but every pair and triplet it is these; at most `MOST_PLOTS`.
    """
    lines = [trend for trend in trends if len(trend.points) >= LEAST_POINTS]
    chosen = [trend for trend in lines if not trend.definition.is_one_of_all]
    return tuple((chosen or lines)[:MOST_PLOTS])


def trend_figures(trends: Sequence[Trend], width_pt: float, row_pt: float) -> list["Figure"]:
    """Draw each trend; a figure has as many rows as a page.

    Parameters
    ----------
    trends : sequence of Trend
        See `plotted`.
    width_pt, row_pt : float
        Width of a figure and height of one row of plots, points.
    """
    from adibas.reports.vector_figures import new_figure

    per_page = N_ACROSS * N_DOWN
    figures = []
    for first in range(0, len(trends), per_page):
        some = trends[first : first + per_page]
        n_rows = -(-len(some) // N_ACROSS)
        figure = new_figure(width_pt, row_pt * n_rows)
        for place, trend in enumerate(some, 1):
            _draw(figure.add_subplot(n_rows, N_ACROSS, place), trend)
        figures.append(figure)
    return figures


def trend_pictures(trends: Sequence[Trend], width_pt: float, row_pt: float) -> list[UInt8Array]:
    """Return the same as (H, W, 3) pixels."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    pictures = []
    for figure in trend_figures(trends, width_pt, row_pt):
        FigureCanvasAgg(figure)
        file = io.BytesIO()
        figure.savefig(file, format="png", dpi=DOTS_PER_INCH)
        picture: UInt8Array = np.array(Image.open(file).convert("RGB"))
        pictures.append(picture)
    return pictures


def trend_legend() -> str:
    """Say how the plots are read."""
    return _(
        "Dots and bars: value and 95 % interval of the instrument, by date. Green band: the first "
        "value and the smallest detectable change (MDC95), where it is known."
    )


def _draw(axes: "Axes", trend: Trend) -> None:
    times = [point.taken_utc.timestamp() / DAY_S for point in trend.points]
    values = np.array([point.value for point in trend.points])
    ends = np.array([point.interval for point in trend.points])
    if trend.band is not None:
        axes.axhspan(*trend.band, color=BAND, alpha=0.15, linewidth=0)
    axes.errorbar(
        times,
        values,
        yerr=np.stack([values - ends[:, 0], ends[:, 1] - values]),
        color=VALUE,
        marker="o",
        markersize=2.5,
        linewidth=0.8,
        elinewidth=0.6,
        capsize=1.5,
    )
    shown = [*ends.ravel(), *(trend.band or ())]
    middle = (min(shown) + max(shown)) / 2
    half = max(max(shown) - min(shown), LEAST_SPANS[trend.definition.unit]) / 2
    axes.set_ylim(middle - 1.1 * half, middle + 1.1 * half)
    half_days = max(times[-1] - times[0], 1.0) / 2
    center = (times[-1] + times[0]) / 2
    axes.set_xlim(center - 1.15 * half_days, center + 1.15 * half_days)
    _dress(axes, trend, times)


def _dress(axes: "Axes", trend: Trend, times: list[float]) -> None:
    days = [day_here(point.taken_utc).isoformat() for point in trend.points]
    axes.set_xticks([times[0], times[-1]], [days[0], days[-1]])
    first, last = axes.get_xticklabels()
    first.set_horizontalalignment("left")
    last.set_horizontalalignment("right")
    axes.yaxis.set_major_formatter(lambda value, _position: decimal_text(value, 1))
    axes.set_title(_title(trend), fontsize=TITLE_PT, color=INK, parse_math=False)
    axes.grid(visible=True, axis="y", color=FAINT, linewidth=0.3)
    axes.tick_params(labelsize=FONT_PT, colors=INK, length=2)
    for spine in axes.spines.values():
        spine.set_color(FAINT)
        spine.set_linewidth(0.4)


def _title(trend: Trend) -> str:
    """Return name, unit and view in lines as wide as a plot."""
    definition = trend.definition
    name = f"{definition.name.text} [{_(definition.unit)}], {view_name(trend.view)}"
    return "\n".join(textwrap.wrap(name, LETTERS_OF_A_LINE))
