"""Lines of the screen's tables, worded in the language in use."""

from adibas.data.protocols import MeasureDefinition
from adibas.data.reliability import Change, Reliability
from adibas.data.trends import Trend
from adibas.reports.facts import verdict_text
from adibas.texts import translate as _
from ui.comparison.content import Differences, Repeats, definitions_of
from ui.view_names import VIEW_NAMES
from ui.widgets.dates import moment_text
from ui.widgets.rows import NOTHING, Interval, Key, Row, interval_text, measure_text, number


def change_headers() -> tuple[str, ...]:
    """Return the titles of the table of differences."""
    values = (_("Before"), _("Now"), _("Difference"), _("95 % interval"), "MDC95", _("Change"))
    return (_("View"), _("Measure"), *values)


def change_rows(differences: Differences) -> tuple[Row, ...]:
    """Return a line for each measure that either session has."""
    if differences.comparison is None or differences.protocol is None:
        return ()
    definitions = definitions_of(differences.protocol)
    return tuple(
        _change_row(one, definitions[one.measure_id])
        for one in differences.comparison.changes
        if one.before is not None or one.after is not None
    )


def _change_row(change: Change, definition: MeasureDefinition) -> Row:
    numbers = (change.before, change.after, change.difference)
    return Row(
        key=(change.view, change.measure_id),
        cells=(
            _(VIEW_NAMES[change.view]),
            measure_text(definition),
            *(number(value) for value in numbers),
            interval_text(change.interval),
            number(change.mdc95),
            verdict_text(change.verdict),
        ),
        order=(
            *(change.view, measure_text(definition), *numbers),
            *(_width(change.interval), change.mdc95, change.verdict.value),
        ),
        verdict=change.verdict,
    )


def trend_headers() -> tuple[str, ...]:
    """Return the titles of the list of measures over time."""
    return _("View"), _("Measure"), _("Last")


def trend_rows(trends: tuple[Trend, ...]) -> tuple[Row, ...]:
    """Return a line for each measure."""
    return tuple(
        Row(
            trend.key,
            (
                _(VIEW_NAMES[trend.view]),
                measure_text(trend.definition),
                number(trend.points[-1].value),
            ),
            (trend.view, measure_text(trend.definition), trend.points[-1].value),
            trend.verdict_of(len(trend.points) - 1),
        )
        for trend in trends
    )


def point_headers() -> tuple[str, ...]:
    """Return the titles of the table below a trend."""
    return _("Session"), _("Value"), _("95 % interval"), _("Since the first"), _("Change")


def point_rows(trend: Trend) -> tuple[Row, ...]:
    """Return a line for each session of a trend: what the plot shows, in words."""
    return tuple(
        Row(
            (point.session_id, ""),
            (
                moment_text(point.taken_utc),
                number(point.value),
                interval_text(point.interval),
                number(trend.change_of(index)) if index else NOTHING,
                verdict_text(trend.verdict_of(index)) if index else NOTHING,
            ),
            (
                *(point.taken_utc.isoformat(), point.value, _width(point.interval)),
                *(trend.change_of(index), trend.verdict_of(index).value),
            ),
            trend.verdict_of(index),
        )
        for index, point in enumerate(trend.points)
    )


def repeat_headers() -> tuple[str, ...]:
    """Return the titles of the table of repeats."""
    return _("View"), _("Measure"), "n", "SEM", "ICC(2,1)", "ICC(3,1)", "MDC95"


def repeat_rows(repeats: Repeats) -> tuple[Row, ...]:
    """Return a line for each measure that has a value anywhere."""
    if repeats.protocol is None:
        return ()
    definitions = definitions_of(repeats.protocol)
    return tuple(_repeat_row(key, found, definitions[key[1]]) for key, found in repeats.by_measure)


def _repeat_row(key: Key, found: Reliability, definition: MeasureDefinition) -> Row:
    correlations = [None if one is None else one.value for one in (found.icc_2_1, found.icc_3_1)]
    numbers = (found.sem, *correlations, found.mdc95)
    return Row(
        key=key,
        cells=(
            *(_(VIEW_NAMES[key[0]]), measure_text(definition), str(found.n_patients)),
            *(number(value, 2) for value in numbers),
        ),
        order=(key[0], measure_text(definition), found.n_patients, *numbers),
    )


def reliability_text(found: Reliability) -> str:
    """Say how well a measure repeats, each number with its interval."""
    parts = []
    if found.sem is not None and found.sem_interval is not None:
        parts.append(_told("SEM", found.sem, found.sem_interval))
    for name, one in (("ICC(2,1)", found.icc_2_1), ("ICC(3,1)", found.icc_3_1)):
        if one is not None:
            parts.append(_told(name, one.value, one.interval))
    if found.mdc95 is not None:
        parts.append(_("{name} {value}.").format(name="MDC95", value=number(found.mdc95, 2)))
    return " ".join(parts)


def _told(name: str, value: float, interval: Interval) -> str:
    low, high = (number(limit, 2) for limit in interval)
    return _("{name} {value} ({low} to {high}).").format(
        name=name, value=number(value, 2), low=low, high=high
    )


def _width(interval: Interval | None) -> float | None:
    return None if interval is None else interval[1] - interval[0]
