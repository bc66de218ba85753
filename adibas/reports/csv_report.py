"""The numbers of a session as one tidy CSV table, a value a row."""

import csv
from collections.abc import Iterator
from pathlib import Path

from adibas.data.posture import PostureAnalysis
from adibas.data.report import CaptureReport, SessionReport
from adibas.files import written_whole
from adibas.reports.cells import neutralised
from adibas.reports.facts import capture_names
from adibas.reports.rows import angle_rows, distance_rows, free_rows, marker_rows, measure_rows
from adibas.texts import speaking

HEADER = ("quantity", "a", "vertex", "b", "value", "unit", "ci95_low", "ci95_high")
AXES = ("x", "y", "z")

Row = tuple[str | float, ...]


def write_csv(report: SessionReport, path: Path) -> None:
    """Write every marker position, distance and angle; empty = not measured.

    Where there are several captures each row begins with the view.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    with speaking(report.language):
        names = capture_names(report)
    with (
        written_whole(path) as unfinished,
        unfinished.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file)
        is_single = len(names) == 1
        writer.writerow(HEADER if is_single else ("view", *HEADER))
        for name, capture in zip(names, report.captures, strict=True):
            for row in _rows(capture):
                whole = row if is_single else (name, *row)
                writer.writerow(
                    [neutralised(cell) if isinstance(cell, str) else cell for cell in whole]
                )


def _rows(capture: CaptureReport) -> Iterator[Row]:
    yield from _measures(capture.analysis)
    yield from _markers(capture.analysis)
    yield from _distances(capture.analysis)
    yield from _angles(capture.analysis)
    yield from _free_measures(capture)


def _measures(analysis: PostureAnalysis) -> Iterator[Row]:
    for row in measure_rows(analysis):
        parts = (("measure", row.main), ("measure_plane", row.projected))
        for quantity, numbers in (*parts, ("measure_space", row.spatial)):
            values = ("", "", "") if numbers is None else (numbers.value, numbers.low, numbers.high)
            yield quantity, row.measure_id, "", "", values[0], row.unit, *values[1:]


def _markers(analysis: PostureAnalysis) -> Iterator[Row]:
    for marker in marker_rows(analysis):
        yield "u", marker.label, "", "", marker.u_px, "px", "", ""
        yield "v", marker.label, "", "", marker.v_px, "px", "", ""
        position_mm: tuple[float | str, ...] = marker.position_mm or ("", "", "")
        for axis, value_mm in zip(AXES, position_mm, strict=True):
            yield axis, marker.label, "", "", value_mm, "mm", "", ""


def _distances(analysis: PostureAnalysis) -> Iterator[Row]:
    for row in distance_rows(analysis):
        yield "distance", row.a, "", row.b, row.mm, "mm", row.low_mm, row.high_mm


def _angles(analysis: PostureAnalysis) -> Iterator[Row]:
    for row in angle_rows(analysis):
        yield "angle", row.a, row.vertex, row.c, row.deg, "deg", row.low_deg, row.high_deg


def _free_measures(capture: CaptureReport) -> Iterator[Row]:
    for row in free_rows(capture):
        quantity = "free_angle" if row.vertex else "free_distance"
        numbers = ["" if number is None else number for number in (row.value, row.low, row.high)]
        yield quantity, row.a, row.vertex, row.c, numbers[0], row.unit, *numbers[1:]
