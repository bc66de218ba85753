"""The numbers of a posture analysis as one JSON document."""

from typing import Any

from adibas.data.markers import Marker
from adibas.data.posture import PostureAnalysis
from adibas.reports.rows import angle_rows, distance_rows


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
            for row in distance_rows(analysis)
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
            for row in angle_rows(analysis)
        ],
        "measures": [],
        "notices": list(analysis.notices),
        "provenance": {
            "recording_sha256": provenance.recording_sha256,
            "calibration": provenance.calibration,
            "version": provenance.version,
            "created_utc": provenance.created_utc,
            "parameters": dict(provenance.parameters),
        },
    }


def _marker(marker: Marker) -> dict[str, Any]:
    covariance = marker.covariance_m2
    return {
        "label": marker.label,
        "u": marker.u,
        "v": marker.v,
        "position_m": None if marker.position_m is None else marker.position_m.tolist(),
        "covariance_m2": None if covariance is None else covariance.tolist(),
    }
