"""Changes since an earlier session in the PDF report: pictures, a table, plots."""

from reportlab.platypus import CondPageBreak, Flowable, PageBreak

from adibas.data.reliability import Comparison, Verdict
from adibas.data.report import SessionReport
from adibas.data.trends import Trend
from adibas.pipeline.picture_overlay import WAYS
from adibas.reports.comparison_pictures import OVERLAY_LEGEND, picture_pairs
from adibas.reports.facts import comparison_facts, verdict_text, view_name
from adibas.reports.pdf_layout import (
    SMALL_NAME,
    SMALL_TEXT,
    WIDTH,
    note,
    number_table,
    paragraph,
    picture_row,
    title,
)
from adibas.reports.trend_plots import plotted, trend_figures, trend_legend
from adibas.texts import decimal_text
from adibas.texts import translate as _

DASH = "\N{EN DASH}"
MOST_CHANGES = 120
PICTURE_HEIGHT_PX = 800
ROW_HEIGHT = 128.0
"""Of plots, points."""
HEADING_HEIGHT = 60.0
"""Of heading and legend above them."""
SHARES = (0.34, 0.11, 0.11, 0.11, 0.15, 0.08, 0.1)


def change_flowables(report: SessionReport) -> list[Flowable]:
    """Return pictures of both sessions, the table, what chance alone would mark, and trends."""
    if report.comparison is None:
        return []
    return [
        PageBreak(),
        title(_("Changes"), level=2),
        *(note(f"{name}: {value}") for name, value in comparison_facts(report)),
        *_pictures(report),
        *_table(report.comparison.comparison),
        *_trends(report.comparison.trends),
    ]


def _pictures(report: SessionReport) -> list[Flowable]:
    """Return each view before, now, and both overlaid."""
    found: list[Flowable] = []
    for pair in picture_pairs(report, PICTURE_HEIGHT_PX):
        before = _("{view}, before ({day})").format(view=pair.name, day=pair.before_day)
        now = _("{view}, now ({day})").format(view=pair.name, day=pair.now_day)
        both = _("{view}, overlaid").format(view=pair.name)
        named = [(before, pair.before_rgb), (now, pair.now_rgb), (both, pair.both_rgb)]
        found += [picture_row(named), note(_(WAYS[pair.way]))]
    return [*found, note(_(OVERLAY_LEGEND))] if found else []


def _table(found: Comparison) -> list[Flowable]:
    """Return the changes of what was measured at all."""
    changes = [one for one in found.changes if one.before is not None or one.after is not None]
    cells: list[list[str | Flowable]] = []
    for one in changes[:MOST_CHANGES]:
        name = f"{one.name} ({one.measure_id}) [{_(one.unit)}], {view_name(one.view)}"
        low, high = one.interval or (None, None)
        style = SMALL_NAME if one.verdict is Verdict.BEYOND else SMALL_TEXT
        cells.append(
            [
                paragraph(name, style),
                *(_number(value) for value in (one.before, one.after, one.difference)),
                DASH if one.interval is None else f"{_number(low)} {DASH} {_number(high)}",
                _number(one.mdc95),
                paragraph(verdict_text(one.verdict), style),
            ]
        )
    names = (_("Measure"), _("Before"), _("Now"), _("Difference"), _("95 %"))
    header = [*names, "MDC95", _("Change")]
    widths = [share * WIDTH for share in SHARES]
    table = number_table(header, cells, widths, text_columns=(0, 6))
    if len(changes) <= MOST_CHANGES:
        return [table]
    text = _("The first {shown} of {total} measures; all are in the Excel report.")
    return [table, note(text.format(shown=MOST_CHANGES, total=len(changes)))]


def _trends(trends: tuple[Trend, ...]) -> list[Flowable]:
    """Return plots of what was measured twice at least, and how they are read."""
    shown = plotted(trends)
    if not shown:
        return []
    from adibas.reports.vector_figures import FigureFlowable

    figures = [FigureFlowable(figure) for figure in trend_figures(shown, WIDTH, ROW_HEIGHT)]
    return [
        CondPageBreak(figures[0].height + HEADING_HEIGHT),
        title(_("Measures over the sessions"), level=2),
        note(trend_legend()),
        *figures,
    ]


def _number(value: float | None) -> str:
    return DASH if value is None else decimal_text(value, 1)
