"""The Excel report on the back."""

from pathlib import Path

import numpy as np
from openpyxl import Workbook

from adibas.pipeline.back import Back
from adibas.pipeline.body import MeasuredBody
from adibas.reports.body_facts import HEADING, body_facts, general_facts
from adibas.reports.body_files import measures_of
from adibas.reports.body_numbers import on_paper
from adibas.reports.body_plots import back_figure
from adibas.reports.figure_pictures import picture_of
from adibas.reports.memory_workbook import write_in_memory
from adibas.reports.sheets import Column, Part, Value, add_parts, add_table
from adibas.texts import translate as _

ONE, TWO = "0.0", "0.00"
PICTURE_PT = (620.0, 460.0)
STEP_M = 0.01


def write_body_workbook(body: MeasuredBody, path: Path, language: str) -> None:
    """Write the sheets Summary, Measures and Profile.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    write_in_memory(path, language, lambda workbook: _add_sheets(workbook, body))


def _add_sheets(workbook: Workbook, body: MeasuredBody) -> None:
    footer = _("For research, education and documentation")
    summary = [Part("", body_facts(body)), Part(_("About this report"), general_facts(body))]
    if body.back is not None:
        drawn = picture_of(back_figure(body.back, *PICTURE_PT))
        summary.append(Part(_("The back"), [], drawn))
    add_parts(workbook, _("Summary"), _(HEADING), summary, footer)
    columns = (
        Column(_("Measure"), 36),
        Column(_("Meaning"), 50),
        Column(_("Value"), 10, TWO),
        Column(_("From (95 %)"), 10, TWO),
        Column(_("To (95 %)"), 10, TWO),
        Column(_("Unit"), 8),
        Column(_("Source"), 40),
        Column(_("Remark"), 40),
    )
    add_table(workbook, _("Measures"), columns, _measures(body), footer)
    if body.back is not None:
        profile = (
            Column(_("Height over the floor [mm]"), 14, ONE),
            Column(_("To the right [mm]"), 14, ONE),
            Column(_("To the back [mm]"), 14, ONE),
            Column(_("Surface rotation [deg]"), 14, TWO),
        )
        add_table(workbook, _("Profile"), profile, _profile(body.back), footer)


def _measures(body: MeasuredBody) -> list[tuple[Value, ...]]:
    rows: list[tuple[Value, ...]] = []
    for measure in measures_of(body):
        definition = measure.definition
        value, interval, unit = on_paper(measure)
        low, high = interval if interval is not None else (None, None)
        remark = _(measure.reason) if measure.reason else None
        told = (_(definition.name), _(definition.meaning))
        rows.append((*told, value, low, high, unit, definition.source, remark))
    return rows


def _profile(back: Back) -> list[tuple[Value, ...]]:
    y_m = back.profile.heights_m(STEP_M)
    table = np.column_stack(
        [
            1e3 * y_m,
            1e3 * back.line.at(y_m),
            1e3 * back.profile.back_m(y_m),
            np.degrees(back.profile.rotation_rad(y_m)),
        ]
    )
    return [tuple(row) for row in table.tolist()]
