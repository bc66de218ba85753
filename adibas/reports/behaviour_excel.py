"""The Excel report of behaviour."""

from collections.abc import Sequence
from pathlib import Path

from openpyxl import Workbook

from adibas.data.coding import Coding
from adibas.pipeline.behaviour import BehaviourAnalysis
from adibas.reports import behaviour_tables as tables
from adibas.reports.behaviour_facts import behaviour_facts, general_facts
from adibas.reports.behaviour_plots import timeline_picture
from adibas.reports.behaviour_texts import behaviour_text
from adibas.reports.memory_workbook import write_in_memory
from adibas.reports.sheets import Column, Part, Value, add_blocks, add_parts, add_table
from adibas.texts import translate as _

PICTURE_PT = (560.0, 420.0)


def write_behaviour_workbook(analysis: BehaviourAnalysis, path: Path, language: str) -> None:
    """Write the timeline, activity, behaviours, their bins and transitions, and all events.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    write_in_memory(path, language, lambda workbook: _add_sheets(workbook, analysis))


def codings_of(analysis: BehaviourAnalysis) -> list[Coding]:
    """Return what was seen by the observer, if there is one, and by the program."""
    return [one for one in (analysis.observed, analysis.detected) if one is not None]


def _add_sheets(workbook: Workbook, analysis: BehaviourAnalysis) -> None:
    footer = _("For research, education and documentation")
    codings = codings_of(analysis)
    summary = [
        Part("", behaviour_facts(analysis)),
        Part(_("About this report"), general_facts(analysis)),
        Part(_("Timeline"), [], timeline_picture(analysis, *PICTURE_PT)),
    ]
    add_parts(workbook, _("Summary"), _("Behaviour report"), summary, footer)
    for title, columns, rows in (
        (_("Activity"), tables.activity_columns(), tables.activity_rows(analysis)),
        (_("Activity in time"), tables.bin_columns(), tables.bin_rows(analysis)),
    ):
        add_table(workbook, title, columns, rows, footer)
    _add_counts(workbook, codings, analysis.bin_ms, footer)
    bands = [block for block in tables.band_blocks(analysis) if block.rows]
    if bands:
        title = _("Power of velocity in bands [m²/s²]")
        add_blocks(workbook, _("Band power"), title, bands, footer)
    add_table(workbook, _("Ethogram"), _ethogram_columns(), _ethogram_rows(codings), footer)


def add_coding_sheets(workbook: Workbook, codings: Sequence[Coding], bin_ms: int) -> None:
    """Add the sheets of what is counted in codings, and of their ethograms."""
    footer = _("For research, education and documentation")
    _add_counts(workbook, codings, bin_ms, footer)
    add_table(workbook, _("Ethogram"), _ethogram_columns(), _ethogram_rows(codings), footer)


def _add_counts(workbook: Workbook, codings: Sequence[Coding], bin_ms: int, footer: str) -> None:
    for title, columns, rows in (
        (_("Behaviour"), tables.budget_columns(), tables.budget_rows(codings)),
        (
            _("Behaviour in time"),
            tables.behaviour_bin_columns(),
            tables.behaviour_bin_rows(codings, bin_ms),
        ),
        (_("Events"), tables.event_columns(), tables.event_rows(codings)),
    ):
        add_table(workbook, title, columns, rows, footer)
    blocks = list(tables.transition_blocks(codings))
    if blocks:
        add_blocks(workbook, _("Transitions"), _("What began after what (counts)"), blocks, footer)


def _ethogram_columns() -> list[Column]:
    return [
        Column(_("Observer"), 14),
        Column(_("Behaviour"), 26),
        Column(_("Kind"), 10),
        Column(_("Description"), 44),
        Column(_("Sources"), 44),
    ]


def _ethogram_rows(codings: Sequence[Coding]) -> list[tuple[Value, ...]]:
    kinds = {"state": _("state"), "point": _("point event")}
    return [
        (
            coding.observer,
            behaviour_text(one.name),
            kinds[one.kind],
            one.description,
            "; ".join(one.sources),
        )
        for coding in codings
        for one in coding.ethogram.behaviours
    ]
