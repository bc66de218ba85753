"""The numbers of a posture analysis as one tidy CSV table, a value a row."""

import csv
from collections.abc import Iterator
from pathlib import Path

from adibas.data.posture import PostureAnalysis
from adibas.files import written_whole
from adibas.reports.cells import neutralised
from adibas.reports.rows import angle_rows, distance_rows, marker_rows

HEADER = ("quantity", "a", "vertex", "b", "value", "unit", "ci95_low", "ci95_high")
AXES = ("x", "y", "z")

Row = tuple[str | float, ...]


def write_posture_csv(analysis: PostureAnalysis, path: Path) -> None:
    """Write every marker position, distance and angle; empty = not measured.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    with (
        written_whole(path) as unfinished,
        unfinished.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file)
        writer.writerow(HEADER)
        for row in (*_markers(analysis), *_distances(analysis), *_angles(analysis)):
            writer.writerow([neutralised(cell) if isinstance(cell, str) else cell for cell in row])


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
