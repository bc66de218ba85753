"""The Excel report of a posture session."""

import io
from pathlib import Path

from openpyxl import Workbook
from openpyxl.drawing.image import Image
from openpyxl.worksheet.worksheet import Worksheet
from PIL import Image as PillowImage

from adibas.data.posture import PostureAnalysis
from adibas.files import written_whole
from adibas.reports.pictures import draw_markers
from adibas.reports.rows import angle_rows, distance_rows, marker_rows
from adibas.reports.sheets import Column, add_pairs, add_table, prepare_page
from adibas.texts import translate as _

PICTURE_HEIGHT_PX = 720
DECIMALS = "0.0"
FINE_DECIMALS = "0.00"


def write_posture_workbook(analysis: PostureAnalysis, path: Path) -> None:
    """Write the sheets Summary, Markers, Distances, Angles and Provenance.

    Every number is a value with a number format; no cell holds a formula.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    workbook = Workbook()
    del workbook[workbook.sheetnames[0]]
    _add_summary(workbook.create_sheet(_("Summary")), analysis)
    _add_markers(workbook.create_sheet(_("Markers")), analysis)
    _add_distances(workbook.create_sheet(_("Distances")), analysis)
    _add_angles(workbook.create_sheet(_("Angles")), analysis)
    _add_provenance(workbook.create_sheet(_("Provenance")), analysis)
    for sheet in workbook.worksheets:
        prepare_page(sheet, footer=_("For research, education and documentation"))
    with written_whole(path) as unfinished:
        unfinished.write_bytes(_encoded(workbook))


def _encoded(workbook: Workbook) -> bytes:
    """Return the file's bytes; a zip file on a full disk would complain once more when deleted."""
    encoded = io.BytesIO()
    workbook.save(encoded)
    return encoded.getvalue()


def _add_summary(sheet: Worksheet, analysis: PostureAnalysis) -> None:
    measured = sum(marker.position_m is not None for marker in analysis.markers)
    pairs: list[tuple[str, str | float]] = [
        (_("Patient (pseudonym)"), analysis.patient),
        (_("View"), analysis.view or _("not told")),
        (_("Analysed (UTC)"), analysis.provenance.created_utc),
        (_("Frames in the burst"), analysis.n_frames),
        (_("Markers found"), len(analysis.markers)),
        (_("Markers with a position"), measured),
        (_("Calibration"), _calibration_text(analysis)),
        (_("Software version"), analysis.provenance.version),
        (
            _("Intended use"),
            _("Research, education and documentation. Not for diagnosis."),
        ),
        (
            _("Intervals"),
            _("95 %, instrument only: the palpation of landmarks and the stance are not in them."),
        ),
    ]
    pairs += [(_("Notice"), notice) for notice in analysis.notices]
    pairs += [
        (_("Not counted as a marker"), f"({blob.u:.0f}, {blob.v:.0f}) {_(blob.reason)}")
        for blob in analysis.rejected
    ]
    add_pairs(sheet, _("Posture report"), pairs)
    sheet.add_image(_picture(analysis), f"A{len(pairs) + 4}")


def _calibration_text(analysis: PostureAnalysis) -> str:
    calibration = analysis.calibration
    known = [
        calibration.sensor_serial,
        calibration.created_utc,
        analysis.provenance.calibration[: len("sha256:") + 12],
    ]
    return ", ".join(part for part in known if part)


def _picture(analysis: PostureAnalysis) -> Image:
    encoded = io.BytesIO()
    PillowImage.fromarray(draw_markers(analysis, PICTURE_HEIGHT_PX)).save(encoded, format="PNG")
    return Image(encoded)


def _add_markers(sheet: Worksheet, analysis: PostureAnalysis) -> None:
    columns = (
        Column(_("Marker"), 18),
        Column("u [px]", 10, FINE_DECIMALS),
        Column("v [px]", 10, FINE_DECIMALS),
        *(Column(f"{axis} [mm]", 11, DECIMALS) for axis in "xyz"),
        *(Column(_("sd {axis} [mm]").format(axis=axis), 11, FINE_DECIMALS) for axis in "xyz"),
        Column(_("Remark"), 34),
    )
    nowhere = (None, None, None)
    rows = [
        (
            row.label,
            row.u_px,
            row.v_px,
            *(row.position_mm or nowhere),
            *(row.deviation_mm or nowhere),
            None if row.position_mm else _("the depth gives no position here"),
        )
        for row in marker_rows(analysis)
    ]
    add_table(sheet, columns, rows)


def _add_distances(sheet: Worksheet, analysis: PostureAnalysis) -> None:
    columns = (
        Column("A", 18),
        Column("B", 18),
        Column(_("Distance [mm]"), 15, DECIMALS),
        *_interval_columns("mm", DECIMALS),
    )
    rows = [(row.a, row.b, row.mm, row.low_mm, row.high_mm) for row in distance_rows(analysis)]
    add_table(sheet, columns, rows)


def _add_angles(sheet: Worksheet, analysis: PostureAnalysis) -> None:
    columns = (
        Column("A", 18),
        Column(_("Vertex"), 18),
        Column("C", 18),
        Column(_("Angle [deg]"), 13, DECIMALS),
        *_interval_columns("deg", DECIMALS),
        Column(_("Bias [deg]"), 12, FINE_DECIMALS),
    )
    rows = [
        (row.a, row.vertex, row.c, row.deg, row.low_deg, row.high_deg, row.bias_deg)
        for row in angle_rows(analysis)
    ]
    add_table(sheet, columns, rows)


def _interval_columns(unit: str, number_format: str) -> tuple[Column, Column]:
    low = _("95 % from [{unit}], instrument only").format(unit=unit)
    high = _("95 % to [{unit}], instrument only").format(unit=unit)
    return Column(low, 19, number_format), Column(high, 19, number_format)


def _add_provenance(sheet: Worksheet, analysis: PostureAnalysis) -> None:
    provenance = analysis.provenance
    pairs: list[tuple[str, str | float]] = [
        (_("Recording (SHA-256)"), provenance.recording_sha256),
        (_("First frame"), analysis.first_frame),
        (_("Frames in the burst"), analysis.n_frames),
        (_("Calibration"), provenance.calibration),
        (_("Software version"), provenance.version),
        (_("Analysed (UTC)"), provenance.created_utc),
        *_flattened("", provenance.parameters),
    ]
    add_pairs(sheet, _("Provenance"), pairs)


def _flattened(prefix: str, value: object) -> list[tuple[str, str | float]]:
    """Return every leaf of nested mappings as ("stage.parameter", value)."""
    if isinstance(value, dict):
        return [
            pair
            for key, part in value.items()
            for pair in _flattened(f"{prefix}.{key}" if prefix else str(key), part)
        ]
    return [(prefix, value if isinstance(value, int | float) else str(value))]
