"""Changes since an earlier session in the workbook: a table, trends, pictures and plots."""

from collections.abc import Iterator

from openpyxl import Workbook

from adibas.data.reliability import Comparison
from adibas.data.report import SessionReport
from adibas.data.trends import Trend
from adibas.pipeline.picture_overlay import WAYS
from adibas.reports.comparison_pictures import OVERLAY_LEGEND, picture_pairs
from adibas.reports.facts import comparison_facts, verdict_text, view_name
from adibas.reports.sheets import Column, Part, Value, add_parts, add_table
from adibas.reports.trend_plots import plotted, trend_legend, trend_pictures
from adibas.texts import translate as _

DECIMALS = "0.0"
PICTURE_HEIGHT_PX = 520
PLOTS_WIDTH_PT, ROW_HEIGHT_PT = 560.0, 128.0


def add_changes(workbook: Workbook, report: SessionReport, footer: str) -> None:
    """Add the sheets Comparison, Changes and Trends; nothing where nothing was compared."""
    if report.comparison is None:
        return
    compared = report.comparison
    add_parts(workbook, _("Comparison"), _("Changes"), _parts(report), footer)
    changes = list(_changes(compared.comparison))
    add_table(workbook, _("Changes"), _change_columns(), changes, footer)
    trends = list(_trends(compared.trends))
    if trends:
        add_table(workbook, _("Trends"), _trend_columns(), trends, footer)


def _parts(report: SessionReport) -> list[Part]:
    """Return the facts, each view before and now, and the plots."""
    parts = [Part("", comparison_facts(report))]
    for pair in picture_pairs(report, PICTURE_HEIGHT_PX):
        days = [(_("Before, at the left"), pair.before_day), (_("Now, at the right"), pair.now_day)]
        parts.append(Part(pair.name, days, pair.beside_rgb))
        how_laid = [(_("Overlaid"), _(WAYS[pair.way])), (_("How to read it"), _(OVERLAY_LEGEND))]
        parts.append(Part(pair.name, how_laid, pair.both_rgb))
    shown = () if report.comparison is None else plotted(report.comparison.trends)
    how: list[tuple[str, Value]] = [(_("How to read it"), trend_legend())]
    plots = trend_pictures(shown, PLOTS_WIDTH_PT, ROW_HEIGHT_PT)
    return parts + [Part(_("Measures over the sessions"), how, picture) for picture in plots]


def _measure_columns() -> tuple[Column, ...]:
    return (
        Column(_("View"), 16),
        Column(_("Measure"), 16),
        Column(_("Name"), 44),
        Column(_("Unit"), 7),
    )


def _interval_columns() -> tuple[Column, ...]:
    names = (_("95 % from, instrument only"), _("95 % to, instrument only"))
    return tuple(Column(name, 17, DECIMALS) for name in names)


def _change_columns() -> tuple[Column, ...]:
    return (
        *_measure_columns(),
        *(Column(name, 12, DECIMALS) for name in (_("Before"), _("Now"), _("Difference"))),
        *_interval_columns(),
        Column("MDC95", 10, DECIMALS),
        Column(_("Change"), 16),
    )


def _changes(comparison: Comparison) -> Iterator[tuple[Value, ...]]:
    for one in comparison.changes:
        low, high = one.interval or (None, None)
        yield (
            *(view_name(one.view), one.measure_id, one.name, _(one.unit)),
            *(one.before, one.after, one.difference, low, high, one.mdc95),
            verdict_text(one.verdict),
        )


def _trend_columns() -> tuple[Column, ...]:
    return (
        *_measure_columns(),
        Column(_("Session begun (UTC)"), 22),
        Column(_("Value"), 10, DECIMALS),
        *_interval_columns(),
        Column(_("Since the first"), 12, DECIMALS),
        Column("MDC95", 10, DECIMALS),
        Column(_("Change"), 16),
    )


def _trends(trends: tuple[Trend, ...]) -> Iterator[tuple[Value, ...]]:
    for trend in trends:
        definition = trend.definition
        named = (view_name(trend.view), definition.measure_id, definition.name.text)
        for index, point in enumerate(trend.points):
            taken = point.taken_utc.isoformat(timespec="seconds")
            change = trend.change_of(index) if index else None
            verdict = verdict_text(trend.verdict_of(index)) if index else None
            yield (
                *(*named, _(definition.unit), taken, point.value, *point.interval),
                *(change, trend.mdc95, verdict),
            )
