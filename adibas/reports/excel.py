"""The Excel report of a session."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TypeAlias

from openpyxl import Workbook

from adibas.arrays import UInt8Array
from adibas.data.landmark_texts import landmark_text
from adibas.data.measures import AngleMeasure, DistanceMeasure
from adibas.data.report import CaptureReport, SessionReport
from adibas.reports.excel_changes import add_changes
from adibas.reports.facts import (
    analysed,
    capture_facts,
    capture_names,
    comparison_facts,
    general_facts,
    notices,
    protocol_facts,
    session_facts,
)
from adibas.reports.memory_workbook import write_in_memory
from adibas.reports.pictures import draw_markers, picture_of
from adibas.reports.rows import (
    USER,
    NumberRow,
    angle_rows,
    distance_rows,
    free_remark,
    free_rows,
    marker_rows,
    measure_rows,
    remark,
)
from adibas.reports.sheets import Column, Part, Value, add_parts, add_table
from adibas.texts import translate as _

PICTURE_HEIGHT_PX = 720
DECIMALS = "0.0"
FINE_DECIMALS = "0.00"

Rows: TypeAlias = Iterable[tuple[Value, ...]]


def write_workbook(report: SessionReport, path: Path) -> None:
    """Write the sheets Summary, Markers, Distances, Angles, (Free measures,) and Provenance.

    Every number is a value with a number format; no cell holds a formula. Where there are several
    captures each table begins with a column that names the view.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    ReportError
        The pictures cannot be as the report asks.
    """
    write_in_memory(path, report.language, lambda workbook: _add_sheets(workbook, report))


def _add_sheets(workbook: Workbook, report: SessionReport) -> None:
    footer = _("For research, education and documentation")
    add_parts(workbook, _("Summary"), _("Posture report"), _summary(report), footer)
    tables = [
        (_("Markers"), _marker_columns(), [_markers(capture) for capture in report.captures]),
        (
            _("Distances"),
            distance_columns(),
            [distance_cells(one.analysis.distances) for one in report.captures],
        ),
        (
            _("Angles"),
            angle_columns(),
            [angle_cells(one.analysis.angles) for one in report.captures],
        ),
    ]
    if any(capture.analysis.measures for capture in report.captures):
        measures = [_measures(capture) for capture in report.captures]
        tables.insert(0, (_("Measures"), _measure_columns(), measures))
    if any(capture.measures for capture in report.captures):
        free = [_free_measures(capture) for capture in report.captures]
        tables.append((_("Free measures"), _free_columns(), free))
    for title, columns, rows in tables:
        add_table(workbook, title, *_with_view(report, columns, rows), footer)
    add_changes(workbook, report, footer)
    add_parts(workbook, _("Provenance"), _("Provenance"), _provenance(report), footer)


def _with_view(
    report: SessionReport, columns: tuple[Column, ...], rows: list[Rows]
) -> tuple[tuple[Column, ...], list[tuple[Value, ...]]]:
    """Return one table; of several captures each row begins with the view's name."""
    if len(rows) == 1:
        return columns, list(rows[0])
    names = capture_names(report)
    joined = [(name, *row) for name, some in zip(names, rows, strict=True) for row in some]
    return (Column(_("View"), 16), *columns), joined


def _summary(report: SessionReport) -> list[Part]:
    if len(report.captures) == 1:
        capture = report.captures[0]
        pairs = [
            *session_facts(report),
            *comparison_facts(report),
            *capture_facts(report, capture),
            *general_facts(report),
            *protocol_facts(capture.analysis),
            *notices(capture.analysis),
        ]
        return [Part("", pairs, _picture(report, capture))]
    told = [*session_facts(report), *comparison_facts(report), *general_facts(report)]
    parts = [Part("", told)]
    for name, capture in zip(capture_names(report), report.captures, strict=True):
        told = [*protocol_facts(capture.analysis), *notices(capture.analysis)]
        pairs = [*capture_facts(report, capture), *told]
        parts.append(Part(name, pairs, _picture(report, capture)))
    return parts


def _picture(report: SessionReport, capture: CaptureReport) -> UInt8Array:
    picture = picture_of(capture.analysis, report.pictures, report.rotation_deg)
    return draw_markers(picture, PICTURE_HEIGHT_PX)


def _marker_columns() -> tuple[Column, ...]:
    return (
        Column(_("Marker"), 18),
        Column("u [px]", 10, FINE_DECIMALS),
        Column("v [px]", 10, FINE_DECIMALS),
        *(Column(f"{axis} [mm]", 11, DECIMALS) for axis in "xyz"),
        *(Column(_("sd {axis} [mm]").format(axis=axis), 11, FINE_DECIMALS) for axis in "xyz"),
        Column(_("Named by"), 34),
        Column(_("Confidence of the name"), 13, FINE_DECIMALS),
        Column(_("Remark"), 34),
    )


def _markers(capture: CaptureReport) -> Rows:
    nowhere = (None, None, None)
    for row in marker_rows(capture.analysis):
        place, deviation = row.position_mm or nowhere, row.deviation_mm or nowhere
        named_by = _("a person") if row.named_by == USER else row.named_by or None
        yield (
            *(landmark_text(row.label), row.u_px, row.v_px, *place, *deviation),
            *(named_by, row.name_confidence, remark(capture, row)),
        )


def distance_columns() -> tuple[Column, ...]:
    """Return the columns of `distance_cells`."""
    return (
        Column("A", 18),
        Column("B", 18),
        Column(_("Distance [mm]"), 15, DECIMALS),
        *_interval_columns("mm"),
    )


def distance_cells(distances: Iterable[DistanceMeasure]) -> Rows:
    """Yield the cells of each distance."""
    for row in distance_rows(distances):
        yield landmark_text(row.a), landmark_text(row.b), row.mm, row.low_mm, row.high_mm


def angle_columns() -> tuple[Column, ...]:
    """Return the columns of `angle_cells`."""
    return (
        Column("A", 18),
        Column(_("Vertex"), 18),
        Column("C", 18),
        Column(_("Angle [deg]"), 13, DECIMALS),
        *_interval_columns(_("deg")),
        Column(_("Bias [deg]"), 12, FINE_DECIMALS),
    )


def angle_cells(angles: Iterable[AngleMeasure]) -> Rows:
    """Yield the cells of each angle."""
    for row in angle_rows(angles):
        corners = map(landmark_text, (row.a, row.vertex, row.c))
        yield *corners, row.deg, row.low_deg, row.high_deg, row.bias_deg


def _measure_columns() -> tuple[Column, ...]:
    low, high = _("95 % from, instrument only"), _("95 % to, instrument only")
    return (
        Column(_("Measure"), 16),
        Column(_("Name"), 44),
        Column(_("Value"), 10, DECIMALS),
        Column(_("Unit"), 7),
        Column(low, 15, DECIMALS),
        Column(high, 15, DECIMALS),
        Column(_("Positive means"), 34),
        Column(_("In the plane"), 11, DECIMALS),
        *(
            Column(_("{limit}, in the plane").format(limit=one), 17, DECIMALS)
            for one in (low, high)
        ),
        Column(_("In space"), 11, DECIMALS),
        *(Column(_("{limit}, in space").format(limit=one), 17, DECIMALS) for one in (low, high)),
        Column(_("Values of others, with their source"), 60),
        Column(_("Remark"), 34),
    )


def _measures(capture: CaptureReport) -> Rows:
    for row in measure_rows(capture.analysis):
        value, low, high = number_cells(row.main)
        yield (
            *(row.measure_id, row.name, value, _(row.unit), low, high, row.positive or None),
            *number_cells(row.projected),
            *number_cells(row.spatial),
            *(row.reference or None, row.remark or None),
        )


def number_cells(row: NumberRow | None) -> tuple[float | None, float | None, float | None]:
    """Return value and interval, empty where there is none."""
    return (None, None, None) if row is None else (row.value, row.low, row.high)


def _free_columns() -> tuple[Column, ...]:
    return (
        Column(_("Measure"), 12),
        Column("A", 18),
        Column(_("Vertex"), 18),
        Column("C", 18),
        Column(_("Value"), 12, DECIMALS),
        Column(_("Unit"), 8),
        Column(_("95 % from, instrument only"), 19, DECIMALS),
        Column(_("95 % to, instrument only"), 19, DECIMALS),
        Column(_("Remark"), 34),
    )


def _free_measures(capture: CaptureReport) -> Rows:
    for row in free_rows(capture):
        kind = _("Angle") if row.vertex else _("Distance")
        corners = map(landmark_text, (row.a, row.vertex, row.c))
        yield kind, *corners, row.value, _(row.unit), row.low, row.high, free_remark(row)


def _interval_columns(unit: str) -> tuple[Column, Column]:
    low = _("95 % from [{unit}], instrument only").format(unit=unit)
    high = _("95 % to [{unit}], instrument only").format(unit=unit)
    return Column(low, 19, DECIMALS), Column(high, 19, DECIMALS)


def _provenance(report: SessionReport) -> list[Part]:
    names = capture_names(report) if len(report.captures) > 1 else ("",)
    return [
        Part(name, list(_provenance_of(capture)))
        for name, capture in zip(names, report.captures, strict=True)
    ]


def _provenance_of(capture: CaptureReport) -> Iterator[tuple[str, str | float]]:
    analysis = capture.analysis
    provenance = analysis.provenance
    yield _("Recording (SHA-256)"), provenance.recording_sha256
    yield _("First frame"), analysis.first_frame
    yield _("Frames in the burst"), analysis.n_frames
    yield _("Calibration"), provenance.calibration
    yield _("Software version"), provenance.version
    yield analysed(provenance)
    yield from _flattened("", provenance.parameters)


def _flattened(prefix: str, value: object) -> Iterator[tuple[str, str | float]]:
    """Yield every leaf of nested mappings as ("stage.parameter", value)."""
    if isinstance(value, Mapping):
        for key, part in value.items():
            yield from _flattened(f"{prefix}.{key}" if prefix else str(key), part)
    else:
        yield prefix, value if isinstance(value, int | float) else str(value)
