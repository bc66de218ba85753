"""The numbers of a session as one tidy CSV table, a value a row."""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from adibas.data.posture import PostureAnalysis
from adibas.data.report import CaptureReport, SessionReport
from adibas.files import written_whole
from adibas.reports.cells import neutralised
from adibas.reports.facts import notice_texts
from adibas.reports.rows import (
    MeasureRow,
    NumberRow,
    angle_rows,
    distance_rows,
    free_remark,
    free_rows,
    marker_rows,
    measure_rows,
    remark,
)
from adibas.texts import speaking

AXES = ("x", "y", "z")


class Line(NamedTuple):
    """One row after capture and view; its fields name the columns, and empty is not told."""

    quantity: str
    a: str = ""
    vertex: str = ""
    b: str = ""
    value: float | str = ""
    unit: str = ""
    ci95_low_instrument_only: float | str = ""
    ci95_high_instrument_only: float | str = ""
    protocol: str = ""
    revision: str = ""
    plane: str = ""
    named_by: str = ""
    name_confidence: float | str = ""
    remark: str = ""


def write_csv(report: SessionReport, path: Path) -> None:
    """Write every measure, marker position, distance and angle, and the notices of each capture.

    A value that is empty was not measured; the remark says why, in the report's language.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    with (
        speaking(report.language),
        written_whole(path) as unfinished,
        unfinished.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file)
        writer.writerow(("capture", "view", *Line._fields))
        for number, capture in enumerate(report.captures, 1):
            for line in _lines(capture):
                row = (number, capture.analysis.view, *line)
                writer.writerow(
                    [neutralised(cell) if isinstance(cell, str) else cell for cell in row]
                )


def _lines(capture: CaptureReport) -> Iterator[Line]:
    yield from _measures(capture.analysis)
    yield from _markers(capture)
    yield from _distances(capture.analysis)
    yield from _angles(capture.analysis)
    yield from _free_measures(capture)
    for text in notice_texts(capture.analysis):
        yield Line("notice", remark=text)


def _measures(analysis: PostureAnalysis) -> Iterator[Line]:
    measures = analysis.measures
    if measures is None:
        return
    plane = measures.plane.value
    for result, row in zip(measures.results, measure_rows(analysis), strict=True):
        of_main = "" if result.definition.is_spatial else plane
        for quantity, numbers, in_plane in (
            ("measure", row.main, of_main),
            ("measure_plane", row.projected, plane),
            ("measure_space", row.spatial, ""),
        ):
            line = _measure(quantity, row, numbers)
            followed = measures.protocol
            yield line._replace(
                protocol=followed.protocol_id, revision=followed.revision, plane=in_plane
            )


def _measure(quantity: str, row: MeasureRow, numbers: NumberRow | None) -> Line:
    line = Line(quantity, row.measure_id, unit=row.unit, remark=row.remark)
    if numbers is None:
        return line
    return line._replace(
        value=numbers.value,
        ci95_low_instrument_only=numbers.low,
        ci95_high_instrument_only=numbers.high,
    )


def _markers(capture: CaptureReport) -> Iterator[Line]:
    for marker in marker_rows(capture.analysis):
        line = Line(
            "",
            marker.label,
            named_by=marker.named_by,
            name_confidence="" if marker.name_confidence is None else marker.name_confidence,
            remark=remark(capture, marker) or "",
        )
        yield line._replace(quantity="u", value=marker.u_px, unit="px")
        yield line._replace(quantity="v", value=marker.v_px, unit="px")
        position_mm: tuple[float | str, ...] = marker.position_mm or ("", "", "")
        for axis, value_mm in zip(AXES, position_mm, strict=True):
            yield line._replace(quantity=axis, value=value_mm, unit="mm")


def _distances(analysis: PostureAnalysis) -> Iterator[Line]:
    for row in distance_rows(analysis.distances):
        yield Line("distance", row.a, "", row.b, row.mm, "mm", row.low_mm, row.high_mm)


def _angles(analysis: PostureAnalysis) -> Iterator[Line]:
    for row in angle_rows(analysis.angles):
        yield Line("angle", row.a, row.vertex, row.c, row.deg, "deg", row.low_deg, row.high_deg)


def _free_measures(capture: CaptureReport) -> Iterator[Line]:
    for row in free_rows(capture):
        quantity = "free_angle" if row.vertex else "free_distance"
        value, low, high = ("" if one is None else one for one in (row.value, row.low, row.high))
        line = Line(quantity, row.a, row.vertex, row.c, value, row.unit, low, high)
        yield line._replace(remark=free_remark(row) or "")
