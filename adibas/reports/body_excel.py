"""The Excel report on body and back."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from openpyxl import Workbook

from adibas.data.landmark_texts import landmark_text
from adibas.pipeline.back import Back
from adibas.pipeline.body import MeasuredBody
from adibas.pipeline.body_landmarks import Landmark
from adibas.pipeline.body_protocol import SideMeasures
from adibas.reports.body_facts import body_facts, general_facts, has_looks, heading_of
from adibas.reports.body_files import measures_of
from adibas.reports.body_look_plots import looks_figure
from adibas.reports.body_numbers import on_paper
from adibas.reports.body_plots import back_figure
from adibas.reports.body_protocol import side_rows
from adibas.reports.excel import (
    angle_cells,
    angle_columns,
    distance_cells,
    distance_columns,
    number_cells,
)
from adibas.reports.facts import view_name
from adibas.reports.figure_pictures import picture_of
from adibas.reports.memory_workbook import write_in_memory
from adibas.reports.sheets import Column, Part, Value, add_parts, add_table
from adibas.texts import translate as _

ONE, TWO = "0.0", "0.00"
PICTURE_PT = (620.0, 460.0)
STEP_M = 0.01


def write_body_workbook(body: MeasuredBody, path: Path, language: str) -> None:
    """Write Summary, Measures, sheets of landmarks and protocol where there are any, and Profile.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    write_in_memory(path, language, lambda workbook: _add_sheets(workbook, body))


def _add_sheets(workbook: Workbook, body: MeasuredBody) -> None:
    footer = _("For research, education and documentation")
    summary = [Part("", body_facts(body)), Part(_("About this report"), general_facts(body))]
    if has_looks(body):
        looks = looks_figure(body, *PICTURE_PT)
        summary.append(Part(_("The body"), [], picture_of(looks)))
    if body.back is not None:
        drawn = picture_of(back_figure(body.back, *PICTURE_PT))
        summary.append(Part(_("The back"), [], drawn))
    heading = heading_of(body)
    add_parts(workbook, _("Summary"), _(heading), summary, footer)
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
    if body.landmarks:
        add_table(
            workbook, _("Landmarks"), _landmark_columns(), list(_landmarks(body.landmarks)), footer
        )
    if body.distances:
        cells = list(distance_cells(body.distances))
        add_table(workbook, _("Distances"), distance_columns(), cells, footer)
    if body.angles:
        add_table(workbook, _("Angles"), angle_columns(), list(angle_cells(body.angles)), footer)
    if body.protocol:
        add_table(workbook, _("Protocol"), _side_columns(), list(_sides(body.protocol)), footer)
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
        rows.append((*told, value, low, high, _(unit), definition.source, remark))
    return rows


def _landmark_columns() -> tuple[Column, ...]:
    return (
        Column(_("Landmark"), 24),
        Column(_("To the right [mm]"), 14, ONE),
        Column(_("Height over the floor [mm]"), 14, ONE),
        Column(_("To the back [mm]"), 14, ONE),
        *(Column(_("sd {axis} [mm]").format(axis=axis), 11, TWO) for axis in "xyz"),
        Column(_("Views"), 30),
        Column(_("Views apart [mm]"), 14, TWO),
    )


def _landmarks(landmarks: Sequence[Landmark]) -> Iterator[tuple[Value, ...]]:
    for mark in landmarks:
        deviations_mm = 1e3 * np.sqrt(np.diag(mark.fused.covariance_m2))
        yield (
            landmark_text(mark.name),
            *(1e3 * mark.fused.position_m).tolist(),
            *deviations_mm.tolist(),
            ", ".join(view_name(view) for view in mark.places_m),
            None if mark.apart_m is None else 1e3 * mark.apart_m,
        )


def _side_columns() -> tuple[Column, ...]:
    low, high = _("95 % from, instrument only"), _("95 % to, instrument only")
    limits = Column(low, 15, TWO), Column(high, 15, TWO)
    return (
        Column(_("View"), 14),
        Column(_("Measure"), 16),
        Column(_("Name"), 44),
        Column(_("Unit"), 7),
        Column(_("In this view"), 12, TWO),
        *limits,
        Column(_("From all views"), 12, TWO),
        *limits,
        Column(_("Positive means"), 34),
        Column(_("Values of others, with their source"), 60),
        Column(_("Remark"), 34),
    )


def _sides(sides: Sequence[SideMeasures]) -> Iterator[tuple[Value, ...]]:
    for row in side_rows(sides):
        fused = row.fused
        yield (
            *(view_name(row.view), fused.measure_id, fused.name, _(fused.unit)),
            *number_cells(row.seen),
            *number_cells(fused.main),
            *(fused.positive or None, fused.reference or None, fused.remark or None),
        )


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
