"""The numbers of a movement as JSON, and its curves as CSV."""

import csv
import math
from pathlib import Path
from typing import Any

from adibas.data.movement import Movement
from adibas.data.protocol_measures import INSTRUMENT_ONLY
from adibas.files import written_whole
from adibas.recordings.joints_csv import ORIGIN
from adibas.reports.movement_facts import rests_on_markers
from adibas.reports.movement_rows import curve_table, range_rows, symmetry_rows


def movement_to_json(movement: Movement) -> dict[str, Any]:
    """Return the document of ``adibas movement --json``: ranges and symmetry without the curves."""
    ranges = zip(movement.ranges, range_rows(movement), strict=True)
    pairs = zip(movement.symmetries, symmetry_rows(movement), strict=True)
    provenance = movement.provenance
    return {
        "origin": movement.origin,
        "duration_s": float(movement.times_s[-1] - movement.times_s[0]),
        "rate_hz": None if math.isnan(movement.rate_hz) else movement.rate_hz,
        "vertical_measured": movement.is_up_measured,
        "intervals": INSTRUMENT_ONLY if rests_on_markers(movement) else None,
        "smoothing": dict(movement.smoothing),
        "ranges": [
            {
                "angle": found.name,
                "least_deg": row.least_deg,
                "greatest_deg": row.greatest_deg,
                "range_deg": row.range_deg,
                "extreme_ci95_deg": row.sure_deg,
                "least_at_s": row.least_at_s,
                "greatest_at_s": row.greatest_at_s,
                "fastest_deg_s": row.fastest_deg_s,
                "speed_ci95_deg_s": row.sure_deg_s,
                "fastest_is_noise": row.is_speed_noise,
                "seen_percent": row.seen_percent,
            }
            for found, row in ranges
        ],
        "symmetry": [
            {
                "angle": found.name,
                "left_deg": row.left_deg,
                "right_deg": row.right_deg,
                "index_percent": row.index_percent,
            }
            for found, row in pairs
        ],
        "notices": [notice.text for notice in movement.notices],
        "provenance": {
            "recording_sha256": provenance.recording_sha256,
            "calibration": provenance.calibration,
            "version": provenance.version,
            "parameters": dict(provenance.parameters),
        },
    }


def write_movement_csv(movement: Movement, path: Path) -> None:
    """Write every angle over time, degrees, and its speed, degrees a second; empty = not known.

    The last column says in every row where the joints come from, as tables of joints do.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    with (
        written_whole(path) as unfinished,
        unfinished.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        names = (curve.name for curve in movement.curves)
        columns = (f"{name}_{unit}" for name in names for unit in ("deg", "deg_s"))
        writer.writerow(("time_s", *columns, ORIGIN))
        for time_s, *cells in curve_table(movement):
            texts = ("" if cell is None else f"{cell:.4f}" for cell in cells)
            writer.writerow((f"{time_s:.6f}", *texts, movement.origin))
