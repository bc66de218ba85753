"""Tables of the reports as lines of texts, in the language in use. Knows nothing of Qt."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from adibas.behaviour.agreement import Figure
from adibas.behaviour.sampling import SAMPLINGS, Sampling, samples
from adibas.data.coding import Coding
from adibas.reports import behaviour_tables as tables
from adibas.reports.agreement_texts import method_text
from adibas.reports.behaviour_texts import behaviour_text, subject_text
from adibas.reports.sheets import Column, Value
from adibas.texts import decimal_text
from adibas.texts import translate as _

NOTHING = "\N{EN DASH}"


@dataclass(frozen=True, slots=True)
class TextTable:
    """Titles and lines; `numbers` are the columns of numbers."""

    titles: tuple[str, ...] = ()
    lines: tuple[tuple[str, ...], ...] = ()
    numbers: frozenset[int] = frozenset()


def text_table(columns: Sequence[Column], rows: Iterable[Sequence[Value]]) -> TextTable:
    """Return a table of a report as its reader sees it."""
    return TextTable(
        tuple(one.title for one in columns),
        tuple(
            tuple(_text(value, one) for value, one in zip(row, columns, strict=True))
            for row in rows
        ),
        frozenset(n for n, one in enumerate(columns) if _decimals(one) is not None),
    )


def counted_table(kind: str, coding: Coding, bin_ms: int) -> TextTable:
    """Return what is counted in a coding.

    Parameters
    ----------
    kind : str
        ``totals`` (with those of each condition), ``bins``, ``transitions``, ``events``, or one of
        `SAMPLINGS`.
    coding : Coding
    bin_ms : int
        Length of a time bin, or of an interval of sampling.
    """
    codings = [coding]
    sampling = next((one for one in SAMPLINGS if one == kind), None)
    if sampling is not None:
        return _samples(coding, sampling, bin_ms)
    if kind == "transitions":
        return _transitions(codings)
    if kind == "totals":
        columns, rows = tables.budget_columns(), tables.budget_rows(codings)
    elif kind == "bins":
        columns = tables.behaviour_bin_columns()
        rows = tables.behaviour_bin_rows(codings, bin_ms)
    else:
        columns, rows = tables.event_columns(), tables.event_rows(codings)
    return text_table(columns[1:], (row[1:] for row in rows))  # all of one observer


def _samples(coding: Coding, sampling: Sampling, interval_ms: int) -> TextTable:
    """Return what sampling would have seen, beside the true share of the time."""
    titles = (_("Who"), _("Behaviour"), _("Intervals [%]"), _("Time [%]"))
    lines = tuple(
        (
            subject_text(one.subject),
            behaviour_text(one.behaviour),
            *(_percent(share) for share in (one.share, one.true_share)),
        )
        for one in samples(coding, sampling, interval_ms)
    )
    return TextTable(titles, lines, frozenset({2, 3}))


def _percent(share: float | None) -> str:
    return NOTHING if share is None else decimal_text(100 * share, 1)


def _transitions(codings: Sequence[Coding]) -> TextTable:
    """Return the tables of all subjects in one: who, what, what then, and how often."""
    lines = []
    for block in tables.transition_blocks(codings):
        who = block.heading.partition(": ")[2]
        for row in block.rows:
            for column, count in zip(block.columns[1:], row[1:], strict=True):
                if count:
                    lines.append((who, str(row[0]), column.title, _text(count, column)))
    titles = (_("Who"), _("Before"), _("Then"), _("Count"))
    return TextTable(titles, tuple(lines), frozenset({3}))


def agreement_table(figures: Iterable[Figure]) -> TextTable:
    """Return the figures of agreement; where there is none, the reason."""
    titles = (_("Method"), _("Value"), _("Who"), _("Behaviour"), _("Why there is no value"))
    lines = []
    for one in figures:
        found = one.coefficient
        lines.append(
            (
                method_text(found.method),
                NOTHING if found.value is None else decimal_text(found.value, 3),
                subject_text(one.subject) if one.behaviour else _("all"),
                behaviour_text(one.behaviour) or _("all"),
                "" if found.reason is None else found.reason.text,
            )
        )
    return TextTable(titles, tuple(lines), frozenset({1}))


def _text(value: Value, column: Column) -> str:
    if value is None:
        return NOTHING
    if isinstance(value, str):
        return value
    return decimal_text(float(value), _decimals(column) or 0)


def _decimals(column: Column) -> int | None:
    """Return how many decimals a column shows; None for texts."""
    whole, _point, part = column.number_format.partition(".")
    return len(part) if whole == "0" else None
