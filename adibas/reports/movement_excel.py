"""The Excel report of a movement."""

from pathlib import Path

from openpyxl import Workbook

from adibas.data.movement import Movement
from adibas.reports.memory_workbook import write_in_memory
from adibas.reports.movement_facts import general_facts, movement_facts
from adibas.reports.movement_plots import SPEED, movement_picture
from adibas.reports.movement_rows import curve_table, range_rows, symmetry_rows
from adibas.reports.movement_texts import angle_text
from adibas.reports.sheets import (
    Column,
    Part,
    Value,
    add_parts,
    add_table,
)
from adibas.texts import translate as _

ONE, TWO, THREE = "0.0", "0.00", "0.000"
PICTURE_PT = (520.0, 620.0)


def write_movement_workbook(movement: Movement, path: Path, language: str) -> None:
    """Write the sheets Summary, Ranges, Symmetry, and Angles over time.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    write_in_memory(path, language, lambda workbook: _add_sheets(workbook, movement))


def _add_sheets(workbook: Workbook, movement: Movement) -> None:
    footer = _("For research, education and documentation")
    summary = [
        Part("", movement_facts(movement)),
        Part(_("About this report"), general_facts(movement)),
        Part(_("Angles over time"), [], movement_picture(movement, *PICTURE_PT)),
        Part(_("Speeds over time"), [], movement_picture(movement, *PICTURE_PT, SPEED)),
    ]
    add_parts(workbook, _("Summary"), _("Movement report"), summary, footer)
    add_table(workbook, _("Ranges"), _range_columns(), _ranges(movement), footer)
    add_table(workbook, _("Symmetry"), _symmetry_columns(), _symmetries(movement), footer)
    columns = [Column(_("Time [s]"), 10, THREE)]
    columns += [
        Column(f"{angle_text(curve.name)} [{unit}]", 16, TWO)
        for curve in movement.curves
        for unit in ("°", "°/s")
    ]
    add_table(workbook, _("Angles over time"), columns, list(curve_table(movement)), footer)


def _range_columns() -> tuple[Column, ...]:
    return (
        Column(_("Joint angle"), 42),
        Column(_("Least [deg]"), 11, ONE),
        Column(_("Greatest [deg]"), 11, ONE),
        Column(_("Range [deg]"), 11, ONE),
        Column(_("Plus or minus [deg]"), 12, TWO),
        Column(_("Least at [s]"), 11, TWO),
        Column(_("Greatest at [s]"), 11, TWO),
        Column(_("Fastest [deg/s]"), 11, ONE),
        Column(_("Speed plus or minus [deg/s]"), 12, ONE),
        Column(_("Seen [%]"), 9, ONE),
        Column(_("Remark"), 40),
    )


def _ranges(movement: Movement) -> list[tuple[Value, ...]]:
    return [
        (
            row.angle,
            row.least_deg,
            row.greatest_deg,
            row.range_deg,
            row.sure_deg,
            row.least_at_s,
            row.greatest_at_s,
            row.fastest_deg_s,
            row.sure_deg_s,
            row.seen_percent,
            _("fastest: not told from noise") if row.is_speed_noise else None,
        )
        for row in range_rows(movement)
    ]


def _symmetry_columns() -> tuple[Column, ...]:
    return (
        Column(_("Joint angle"), 42),
        Column(_("Range left [deg]"), 12, ONE),
        Column(_("Range right [deg]"), 12, ONE),
        Column(_("Right minus left [deg]"), 12, ONE),
        Column(_("Symmetry index [%]"), 12, ONE),
        Column(_("Remark"), 40),
    )


def _symmetries(movement: Movement) -> list[tuple[Value, ...]]:
    return [
        (
            row.motion,
            row.left_deg,
            row.right_deg,
            row.difference_deg,
            row.index_percent,
            None if row.index_percent is not None else _("neither side moved enough to compare"),
        )
        for row in symmetry_rows(movement)
    ]
