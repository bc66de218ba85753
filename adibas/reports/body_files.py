"""A measured body as files: the surface as PLY, the numbers as JSON."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from adibas.alignment.surfels import Surface
from adibas.data.body_measures import BodyMeasure
from adibas.pipeline.back import Back
from adibas.pipeline.body import MeasuredBody
from adibas.pipeline.body_protocol import SideMeasures, notices_of_sides
from adibas.reports.body_numbers import GREY, on_paper
from adibas.reports.body_protocol import side_rows
from adibas.reports.json_report import number_document, protocol_document
from adibas.reports.map_files import write_ply
from adibas.reports.rows import angle_rows, distance_rows
from adibas.surface.covering import covering_radii_m
from adibas.surface.merging import BodySurface
from adibas.texts import speaking

PROFILE_STEP_M = 0.01


def write_body_ply(surface: BodySurface, path: Path) -> None:
    """Write the surface, patient axes (x right, y up, z back); confidence: how well it was seen.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    write_ply(
        Surface(
            surface.points_m.astype(np.float32),
            surface.normals.astype(np.float32),
            np.nan_to_num(surface.colors, nan=GREY).astype(np.uint8),
            covering_radii_m(surface.points_m),
            surface.weights.astype(np.float32),
        ),
        path,
    )


def body_to_json(body: MeasuredBody) -> dict[str, Any]:
    """Return the document of ``adibas body --json``."""
    joined = body.whole.joined
    return {
        "views": {
            view: {
                "frames": body.n_frames[view],
                "patient_from_camera": {
                    "rotation": np.round(pose.rotation, 8).tolist(),
                    "translation_m": np.round(pose.translation_m, 5).tolist(),
                },
            }
            for view, pose in body.whole.patient_from_camera.items()
        },
        "points": len(body.whole.surface.points_m),
        "stature_mm": None if body.stature_m is None else round(1e3 * body.stature_m, 1),
        "joined_rms_mm": None if joined is None else round(1e3 * joined.rms_m, 3),
        "measures": [_measure(one) for one in measures_of(body)],
        "spine": None if body.back is None else _spine(body.back),
        "landmarks": [
            {
                "name": mark.name,
                "places_m": {
                    view: np.round(place, 5).tolist() for view, place in mark.places_m.items()
                },
                "apart_mm": None if mark.apart_m is None else round(1e3 * mark.apart_m, 2),
                "place_m": np.round(mark.fused.position_m, 5).tolist(),
                "sd_mm": np.round(1e3 * np.sqrt(np.diag(mark.fused.covariance_m2)), 3).tolist(),
            }
            for mark in body.landmarks
        ],
        "distances": [
            {
                "a": row.a,
                "b": row.b,
                "mm": round(row.mm, 3),
                "ci95": _rounded(row.low_mm, row.high_mm),
            }
            for row in distance_rows(body.distances)
        ],
        "angles": [
            {
                "a": row.a,
                "vertex": row.vertex,
                "c": row.c,
                "deg": round(row.deg, 3),
                "ci95": _rounded(row.low_deg, row.high_deg),
            }
            for row in angle_rows(body.angles)
        ],
        "protocol": _protocol(body.protocol),
        "notices": [notice.text for notice in body.notices],
        "provenance": {
            view: {
                "recording_sha256": one.recording_sha256,
                "calibration": one.calibration,
                "version": one.version,
                "parameters": dict(one.parameters),
            }
            for view, one in body.provenances.items()
        },
    }


def _protocol(sides: Sequence[SideMeasures]) -> dict[str, Any] | None:
    if not sides:
        return None
    with speaking("en"):  # as all words of the document
        measures = [
            {
                "view": row.view,
                "id": row.fused.measure_id,
                "unit": row.fused.unit,
                "in_view": number_document(row.seen),
                "all_views": number_document(row.fused.main),
                "remark": row.fused.remark,
            }
            for row in side_rows(sides)
        ]
        told = [notice.text for notice in notices_of_sides(sides)]
        followed = protocol_document(sides[0].fused)
    return {**followed, "notices": told, "measures": measures}


def _rounded(*values: float) -> list[float]:
    return [round(value, 3) for value in values]


def measures_of(body: MeasuredBody) -> tuple[BodyMeasure, ...]:
    """Return every measure that was asked for, in the order of reports."""
    return (*(() if body.back is None else body.back.measures), *body.girths)


def _measure(measure: BodyMeasure) -> dict[str, Any]:
    value, interval, unit = on_paper(measure)
    return {
        "id": measure.definition.measure_id,
        "value": value,
        "unit": unit,
        "ci95": None if interval is None else list(interval),
        "source": measure.definition.source,
        "reason": measure.reason,
    }


def _spine(back: Back) -> dict[str, Any]:
    """Return the line and the points of the profile, millimetres over the floor and the like."""
    y_m = back.profile.heights_m(PROFILE_STEP_M)
    shape = back.shape
    return {
        "highest_seen_mm": round(1e3 * back.stature_m, 1),
        "height_mm": np.round(1e3 * y_m, 1).tolist(),
        "right_mm": np.round(1e3 * back.line.at(y_m), 2).tolist(),
        "back_mm": np.round(1e3 * back.profile.back_m(y_m), 2).tolist(),
        "rotation_deg": np.round(np.degrees(back.profile.rotation_rad(y_m)), 2).tolist(),
        "points_mm": None
        if shape is None
        else {name.lower(): round(1e3 * height_m, 1) for name, height_m, _is_turn in shape.places},
    }
