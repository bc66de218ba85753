"""The Excel report of a calibration."""

from collections.abc import Iterator
from pathlib import Path

from openpyxl import Workbook

from adibas.data.calibration_report import CalibrationReport
from adibas.reports.calibration_blocks import (
    FINE,
    ONE,
    TWO,
    coverage_blocks,
    depth_blocks,
    uncertainty_blocks,
)
from adibas.reports.calibration_facts import (
    camera_facts,
    change_facts,
    depth_facts,
    figures,
    general_facts,
    remark,
    verdict_facts,
)
from adibas.reports.calibration_rows import (
    comparison_of,
    corner_lines,
    image_rows,
    known,
    parameter_rows,
)
from adibas.reports.memory_workbook import write_in_memory
from adibas.reports.sheets import (
    Column,
    Part,
    Value,
    add_blocks,
    add_parts,
    add_table,
)
from adibas.texts import translate as _

PARAMETER = "0.000000"


def write_calibration_workbook(report: CalibrationReport, path: Path) -> None:
    """Write the sheets Summary, Parameters, Images, Corners, Coverage, Uncertainty (, Depth).

    Without a camera that the images gave there are Summary, Images and Depth, each where known.
    Every number is a value with a number format; no cell holds a formula.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    write_in_memory(path, report.language, lambda workbook: _add_sheets(workbook, report))


def _add_sheets(workbook: Workbook, report: CalibrationReport) -> None:
    footer = _("For research, education and documentation")
    add_parts(workbook, _("Summary"), _("Calibration report"), _summary(report), footer)
    fit = report.fit
    if fit is not None:
        add_table(workbook, _("Parameters"), *_parameters(report), footer)
    if report.images:
        add_table(workbook, _("Images"), _image_columns(), list(_images(report)), footer)
    if fit is not None:
        add_table(workbook, _("Corners"), _corner_columns(), list(_corners(report)), footer)
        coverage, uncertainty = list(coverage_blocks(report, fit)), list(uncertainty_blocks(fit))
        add_blocks(workbook, _("Coverage"), _("Coverage"), coverage, footer)
        add_blocks(workbook, _("Uncertainty"), _("Uncertainty"), uncertainty, footer)
    if report.depth is not None:
        add_blocks(workbook, _("Depth"), _("Depth"), list(depth_blocks(report.depth)), footer)


def _summary(report: CalibrationReport) -> list[Part]:
    numbers = [(figure.name, figure.value) for figure in figures(report)]
    parts = [
        Part("", verdict_facts(report)),
        Part(_("What was calibrated"), camera_facts(report)),
        Part(_("Results"), numbers, number_format=FINE),
    ]
    checks = [] if report.depth is None else depth_facts(report.depth)
    if checks:
        parts.append(Part(_("Depth"), checks))
    changes = change_facts(comparison_of(report))
    if changes:
        parts.append(Part(_("Depth against the calibration before (95 %)"), changes))
    return [*parts, Part(_("About this report"), general_facts(report))]


def _parameters(report: CalibrationReport) -> tuple[list[Column], list[tuple[Value, ...]]]:
    columns = [
        Column(_("Parameter"), 14),
        Column(_("Value"), 16, PARAMETER),
        Column(_("95 % from"), 16, PARAMETER),
        Column(_("95 % to"), 16, PARAMETER),
        Column(_("Unit"), 8),
    ]
    rows = list(parameter_rows(report))
    cells: list[tuple[Value, ...]] = [
        (row.name, row.value, row.low, row.high, row.unit) for row in rows
    ]
    if any(row.before is not None for row in rows):
        columns.append(Column(_("Calibration before"), 18, PARAMETER))
        cells = [(*line, row.before) for line, row in zip(cells, rows, strict=True)]
    return columns, cells


def _image_columns() -> tuple[Column, ...]:
    return (
        Column(_("No."), 6, "0"),
        Column(_("Image"), 30),
        Column(_("Corners found"), 11, "0"),
        Column(_("Corners used"), 11, "0"),
        Column(_("Error, rms [px]"), 11, FINE),
        Column(_("Largest error [px]"), 11, FINE),
        Column(_("Tilt [deg]"), 9, ONE),
        Column(_("Leans to [deg] (0 right, 90 down)"), 19, "0"),
        Column(_("Distance [m]"), 11, FINE),
        Column("Q_k [mm]", 10, FINE),
        Column(_("Blur [px]"), 9, TWO),
        Column(_("Remark"), 44),
    )


def _images(report: CalibrationReport) -> Iterator[tuple[Value, ...]]:
    for row in image_rows(report):
        yield (
            row.number,
            row.image.name,
            row.image.n_corners,
            row.n_used,
            row.rms_px,
            row.max_px,
            row.tilt_deg,
            row.lean_deg,
            row.distance_m,
            row.q_mm,
            known(row.image.blur_px),
            remark(row),
        )


def _corner_columns() -> tuple[Column, ...]:
    places = (_("real {axis} [mm]"), _("computed {axis} [mm]"), _("error {axis} [mm]"))
    return (
        Column(_("Image"), 30),
        Column("u [px]", 10, FINE),
        Column("v [px]", 10, FINE),
        *(Column(place.format(axis=axis), 12, FINE) for place in places for axis in "xy"),
        Column(_("error [mm]"), 10, FINE),
        Column(_("Q_k of the image [mm]"), 12, FINE),
    )


def _corners(report: CalibrationReport) -> Iterator[tuple[Value, ...]]:
    for line in corner_lines(report):
        yield (
            line.image,
            line.u_px,
            line.v_px,
            *line.real_mm,
            *line.computed_mm,
            *line.error_mm,
            line.off_mm,
            line.q_mm,
        )
