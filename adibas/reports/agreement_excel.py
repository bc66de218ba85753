"""The Excel report of observers' agreement: figures with their methods, and every disagreement."""

from collections.abc import Iterator
from pathlib import Path

from matplotlib.figure import Figure as Drawing
from openpyxl import Workbook

from adibas import __version__
from adibas.arrays import UInt8Array
from adibas.behaviour.agreement import Figure
from adibas.behaviour.matching import Match
from adibas.data.coding import MS_PER_S
from adibas.pipeline.behaviour_agreement import AgreementReport, ComparedSession
from adibas.reports.agreement_texts import METHOD_TEXTS, method_text, table_name
from adibas.reports.behaviour_texts import subject_text
from adibas.reports.facts import intended_use
from adibas.reports.figure_pictures import picture_of
from adibas.reports.memory_workbook import write_in_memory
from adibas.reports.sheets import Block, Column, Part, Value, add_blocks, add_parts, add_table
from adibas.reports.vector_figures import new_figure
from adibas.texts import decimal_text
from adibas.texts import translate as _

TWO, THREE = "0.00", "0.000"
PICTURE_PT = (560.0, 380.0)
FIRST, SECOND, BOTH, INK = "#0072B2", "#D55E00", "#C3CCD4", "#16212B"
FONT_PT = 6.0
Rows = list[tuple[Value, ...]]


def write_agreement_workbook(report: AgreementReport, path: Path, language: str) -> None:
    """Write figures, tables of who called it what, and all disagreements with their times.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    write_in_memory(path, language, lambda workbook: _add_sheets(workbook, report))


def _add_sheets(workbook: Workbook, report: AgreementReport) -> None:
    footer = _("For research, education and documentation")
    parts = [Part("", _facts(report))]
    parts.append(Part(_("Methods"), [(method_text(name), _(text)) for name, text in METHOD_TEXTS]))
    for session in report.sessions:
        heading = _("Disagreements in {session}").format(session=session.name)
        parts.append(Part(heading, [], _picture(session)))
    add_parts(workbook, _("Summary"), _("Agreement of observers"), parts, footer)
    add_table(workbook, _("Agreement"), _figure_columns(), _figure_rows(report), footer)
    blocks = list(_blocks(report))
    add_blocks(workbook, _("Who called it what"), _("Who called it what"), blocks, footer)
    add_table(workbook, _("Disagreements"), _difference_columns(), _difference_rows(report), footer)


def _facts(report: AgreementReport) -> list[tuple[str, Value]]:
    params = report.params
    facts: list[tuple[str, Value]] = [
        (_("Files"), ", ".join(report.files)),
        (_("Sessions"), str(len(report.sessions))),
        (_("Unit of time [s]"), decimal_text(params.unit_ms / MS_PER_S, 3)),
        (_("Events are the same within [s]"), decimal_text(params.tolerance_ms / MS_PER_S, 3)),
        (_("Intervals [s]"), decimal_text(params.interval_ms / MS_PER_S, 3)),
        (_("Software version"), __version__),
        (_("Intended use"), intended_use()),
    ]
    notices = [*report.notices, *(n for one in report.sessions for n in one.result.notices)]
    return [*facts, *((_("Notice"), notice.text) for notice in notices)]


def _figure_columns() -> list[Column]:
    return [
        Column(_("Session"), 18),
        Column(_("Method"), 40),
        Column(_("Who"), 16),
        Column(_("Behaviour"), 24),
        Column(_("Value"), 9, THREE),
        Column(_("Agreement"), 11, THREE),
        Column(_("By chance"), 9, THREE),
        Column(_("Rests on"), 9, "0"),
        Column(_("Why there is no value"), 60),
    ]


def _figure_rows(report: AgreementReport) -> Rows:
    return [
        _figure_row(one.name, figure) for one in report.sessions for figure in one.result.figures
    ]


def _figure_row(session: str, figure: Figure) -> tuple[Value, ...]:
    found = figure.coefficient
    is_whole = not figure.behaviour
    return (
        session,
        method_text(found.method),
        _("all") if is_whole else subject_text(figure.subject),
        figure.behaviour or _("all"),
        found.value,
        found.observed,
        found.expected,
        float(found.n),
        None if found.reason is None else found.reason.text,
    )


def _blocks(report: AgreementReport) -> Iterator[Block]:
    for session in report.sessions:
        for table in session.result.tables:
            names = [name or table_name(table.method) for name in table.names]
            first, second = session.result.observers[:2]
            corner = _("{first} (rows), {second} (columns)").format(
                first=first or _("first observer"), second=second or _("second observer")
            )
            columns = [Column(corner, 34), *(Column(name, 16, "0") for name in names)]
            rows: Rows = [
                (name, *row) for name, row in zip(names, table.counts.tolist(), strict=True)
            ]
            heading = f"{session.name}: {method_text(table.method)}"
            yield Block(heading, columns, rows, is_map=True)


def _difference_columns() -> list[Column]:
    return [
        Column(_("Session"), 18),
        Column(_("From [s]"), 10, THREE),
        Column(_("To [s]"), 10, THREE),
        Column(_("Who"), 16),
        Column(_("First observer"), 28),
        Column(_("Second observer"), 28),
        Column(_("What is different"), 44),
    ]


def _difference_rows(report: AgreementReport) -> Rows:
    rows: Rows = []
    for session in report.sessions:
        some: Rows = [_match_row(one) for one in session.result.matches if not one.is_agreed]
        some += [
            (
                one.begin_ms / MS_PER_S,
                one.end_ms / MS_PER_S,
                subject_text(one.subject),
                one.behaviour if one.is_first else None,
                None if one.is_first else one.behaviour,
                _("lasts for one observer alone"),
            )
            for one in session.result.differences
        ]
        rows += [(session.name, *row) for row in sorted(some, key=lambda row: (row[0], row[1]))]
    return rows


def _match_row(match: Match) -> tuple[Value, ...]:
    seen = [one for one in (match.first, match.second) if one is not None]
    names = [None if one is None else one.behaviour for one in (match.first, match.second)]
    what = _("called differently") if len(seen) > 1 else _("seen to begin by one observer alone")
    begin, end = (time / MS_PER_S for time in (match.begin_ms, max(one.end_ms for one in seen)))
    return begin, end, subject_text(seen[0].subject), *names, what


def _picture(session: ComparedSession) -> UInt8Array:
    """Draw both observers' states beside each other, and under them where they differ."""
    return picture_of(agreement_figure(session, *PICTURE_PT))


def agreement_figure(session: ComparedSession, width_pt: float, height_pt: float) -> Drawing:
    """Return a row for each behaviour and subject that either of the first two observers saw."""
    figure = new_figure(width_pt, height_pt)
    axes = figure.add_subplot()
    first, second = session.codings[:2]
    seen = {
        (one.subject, one.behaviour) for coding in (first, second) for one in coding.occurrences
    }
    rows = sorted(seen)
    for place, (subject, name) in enumerate(rows):
        for coding, shift, color in ((first, -0.22, FIRST), (second, 0.22, SECOND)):
            spans = [
                (one.begin_ms / MS_PER_S, max(one.duration_ms / MS_PER_S, 0.1))
                for one in coding.of(name, subject)
            ]
            axes.broken_barh(spans, (place + shift - 0.18, 0.36), color=color)
        for one in session.result.differences:
            if (one.subject, one.behaviour) == (subject, name):
                span = (one.begin_ms / MS_PER_S, (one.end_ms - one.begin_ms) / MS_PER_S)
                axes.broken_barh([span], (place + 0.42, 0.1), color=INK)
    labels = [f"{name} ({subject_text(subject)})" for subject, name in rows]
    axes.set_yticks(range(len(rows)), labels, parse_math=False)
    axes.set_ylim(max(len(rows), 1) - 0.4, -0.6)
    axes.set_xlabel(_("Time [s]"), fontsize=FONT_PT)
    axes.tick_params(labelsize=FONT_PT, length=2)
    for label, color in (
        (first.observer or _("first observer"), FIRST),
        (second.observer or _("second observer"), SECOND),
        (_("they differ"), INK),
    ):
        axes.plot([], [], color=color, linewidth=3, label=label)
    axes.legend(fontsize=FONT_PT, frameon=False, ncols=3, loc="lower right", bbox_to_anchor=(1, 1))
    return figure
