"""The numbers of a session as one JSON document."""

import json
from pathlib import Path
from typing import Any

from adibas.data.markers import Marker
from adibas.data.posture import PostureAnalysis
from adibas.data.protocol_measures import INSTRUMENT_ONLY, ProtocolMeasures
from adibas.data.report import CaptureReport, SessionReport
from adibas.data.trends import Trend
from adibas.files import printable, written_whole
from adibas.reports.rows import (
    MeasureRow,
    NumberRow,
    angle_rows,
    distance_rows,
    free_rows,
    measure_rows,
    name_origin,
)
from adibas.texts import speaking


def write_json(report: SessionReport, path: Path) -> None:
    """Write `session_to_json`.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    encoded = json.dumps(session_to_json(report), allow_nan=False, ensure_ascii=False, indent=1)
    with written_whole(path) as unfinished:
        unfinished.write_text(printable(encoded), encoding="utf-8")


def session_to_json(report: SessionReport) -> dict[str, Any]:
    """Return the document of a session: each capture as ``adibas posture --json`` gives it."""
    return {
        "patient": report.patient,
        "started_utc": None if report.started_utc is None else report.started_utc.isoformat(),
        "operator": report.operator,
        "protocol": report.protocol,
        "notes": report.notes,
        "version": report.version,
        "comparison": _comparison(report),
        "captures": [_capture(capture) for capture in report.captures],
    }


def _comparison(report: SessionReport) -> dict[str, Any] | None:
    if report.comparison is None:
        return None
    found = report.comparison.comparison
    return {
        "since_utc": report.comparison.since_utc.isoformat(),
        "n_judged": found.n_judged,
        "n_beyond": found.n_beyond,
        "expected_by_chance": found.expected_by_chance,
        "changes": [
            {
                "id": change.measure_id,
                "view": change.view,
                "unit": change.unit,
                "before": change.before,
                "after": change.after,
                "difference": change.difference,
                "ci95": None if change.interval is None else list(change.interval),
                "mdc95": change.mdc95,
                "verdict": change.verdict.value,
            }
            for change in found.changes
        ],
        "trends": [_trend(trend) for trend in report.comparison.trends],
    }


def _trend(trend: Trend) -> dict[str, Any]:
    return {
        "id": trend.definition.measure_id,
        "view": trend.view,
        "unit": trend.definition.unit,
        "mdc95": trend.mdc95,
        "points": [
            {
                "taken_utc": point.taken_utc.isoformat(),
                "value": point.value,
                "ci95": list(point.interval),
                "since_first": trend.change_of(index),
                "verdict": trend.verdict_of(index).value,
            }
            for index, point in enumerate(trend.points)
        ],
    }


def _capture(capture: CaptureReport) -> dict[str, Any]:
    return {
        **posture_to_json(capture.analysis),
        "placed_by_hand": sorted(capture.placed_by_hand),
        "free_measures": [
            {
                "a": row.a,
                "vertex": row.vertex or None,
                "c": row.c,
                "value": row.value,
                "unit": row.unit,
                "ci95": None if row.value is None else [row.low, row.high],
            }
            for row in free_rows(capture)
        ],
    }


def posture_to_json(analysis: PostureAnalysis) -> dict[str, Any]:
    """Return the document of ``adibas posture --json``; positions in the colour camera's axes."""
    provenance = analysis.provenance
    return {
        "view": analysis.view,
        "patient": analysis.patient,
        "n_frames": analysis.n_frames,
        "markers": [_marker(marker) for marker in analysis.markers],
        "rejected": [{"u": b.u, "v": b.v, "reason": b.reason} for b in analysis.rejected],
        "distances": [
            {"a": row.a, "b": row.b, "mm": row.mm, "ci95_mm": [row.low_mm, row.high_mm]}
            for row in distance_rows(analysis.distances)
        ],
        "angles": [
            {
                "a": row.a,
                "vertex": row.vertex,
                "c": row.c,
                "deg": row.deg,
                "ci95_deg": [row.low_deg, row.high_deg],
                "bias_deg": row.bias_deg,
            }
            for row in angle_rows(analysis.angles)
        ],
        **_followed_protocol(analysis),
        "notices": list(analysis.notices),
        "provenance": {
            "recording_sha256": provenance.recording_sha256,
            "calibration": provenance.calibration,
            "version": provenance.version,
            "created_utc": provenance.created_utc,
            "parameters": dict(provenance.parameters),
        },
    }


def _followed_protocol(analysis: PostureAnalysis) -> dict[str, Any]:
    with speaking("en"):  # as all words of the document
        return {
            "measures": [_measure(row) for row in measure_rows(analysis)],
            "protocol": None if analysis.measures is None else protocol_document(analysis.measures),
        }


def _measure(row: MeasureRow) -> dict[str, Any]:
    return {
        "id": row.measure_id,
        "name": row.name,
        **number_document(row.main),
        "unit": row.unit,
        "positive": row.positive,
        "in_plane": number_document(row.projected),
        "in_space": number_document(row.spatial),
        "reference": row.reference,
        "remark": row.remark,
    }


def number_document(row: NumberRow | None) -> dict[str, Any]:
    """Return value and interval; null where there is none."""
    if row is None:
        return {"value": None, "ci95": None}
    return {"value": row.value, "ci95": [row.low, row.high]}


def protocol_document(measures: ProtocolMeasures) -> dict[str, Any]:
    """Return what was followed, and on what its measures rest."""
    return {
        "id": measures.protocol.protocol_id,
        "revision": measures.protocol.revision,
        "source": measures.protocol.source,
        "plane": measures.plane.value,
        "vertical": measures.vertical.value,
        "origin": "markers",
        "intervals": INSTRUMENT_ONLY,
        "notices": [notice.text for notice in measures.notices],
    }


def _marker(marker: Marker) -> dict[str, Any]:
    covariance = marker.covariance_m2
    named_by, confidence = name_origin(marker)
    return {
        "label": marker.label,
        "named_by": named_by or None,
        "name_confidence": confidence,
        "u": marker.u,
        "v": marker.v,
        "position_m": None if marker.position_m is None else marker.position_m.tolist(),
        "covariance_m2": None if covariance is None else covariance.tolist(),
    }
