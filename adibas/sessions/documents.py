"""What the tables keep as JSON, and back without any loss."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.json_format import calibration_from_json, calibration_to_json
from adibas.data.calibration import RgbdCalibration
from adibas.data.corrections import (
    Correction,
    FreeMeasure,
    MarkerCorrection,
    MeasureCorrection,
)
from adibas.data.markers import AutomaticName, Marker, RejectedBlob
from adibas.data.posture import Provenance
from adibas.data.sessions import SessionSetup
from adibas.sessions.json_line import to_json


def markers_to_json(markers: tuple[Marker, ...]) -> str:
    """Return the line of `markers`."""
    return to_json([_marker_to(marker) for marker in markers])


def markers_from_json(text: str) -> tuple[Marker, ...]:
    """Return the markers in `text`."""
    return tuple(_marker_from(part) for part in json.loads(text))


def rejected_to_json(rejected: tuple[RejectedBlob, ...]) -> str:
    """Return the line of `rejected`."""
    return to_json([[blob.u, blob.v, blob.reason] for blob in rejected])


def rejected_from_json(text: str) -> tuple[RejectedBlob, ...]:
    """Return the blobs in `text`."""
    return tuple(RejectedBlob(u, v, reason) for u, v, reason in json.loads(text))


def calibration_line(calibration: RgbdCalibration) -> str:
    """Return the line of `calibration`."""
    return to_json(calibration_to_json(calibration))


def calibration_of_line(text: str) -> RgbdCalibration:
    """Return the calibration in `text`."""
    return calibration_from_json(json.loads(text), file="calibration")


def provenance_to_json(provenance: Provenance) -> str:
    """Return the line of `provenance`."""
    return to_json(
        {
            "recording_sha256": provenance.recording_sha256,
            "calibration": provenance.calibration,
            "version": provenance.version,
            "created_utc": provenance.created_utc,
            "parameters": dict(provenance.parameters),
        }
    )


def provenance_from_json(text: str) -> Provenance:
    """Return the provenance in `text`."""
    return Provenance(**json.loads(text))


def setup_to_json(setup: SessionSetup) -> str:
    """Return the line of `setup`."""
    # What was not done is left out, so that a program from before this key reads the line.
    more: dict[str, object] = {} if setup.wand is None else {"wand": dict(setup.wand)}
    if setup.turn:
        more["turn"] = setup.turn
    if setup.is_repeat:
        more["is_repeat"] = True
    return to_json(
        {
            "source": setup.source,
            "color_size": list(setup.color_size),
            "markers": None if setup.markers is None else dict(setup.markers),
            "rotation_deg": setup.rotation_deg,
            "protocol": setup.protocol,
            **more,
        }
    )


def setup_from_json(text: str) -> SessionSetup:
    """Return the set-up in `text`."""
    document = json.loads(text)
    width, height = document.pop("color_size")
    return SessionSetup(color_size=(width, height), **document)


def correction_to_json(correction: Correction) -> str:
    """Return the line of `correction`."""
    part = _marker_to if isinstance(correction, MarkerCorrection) else _measure_to
    kind = "marker" if isinstance(correction, MarkerCorrection) else "measure"
    before, after = (
        None if one is None else part(one)  # type: ignore[arg-type]
        for one in (correction.before, correction.after)
    )
    return to_json({"of": kind, "before": before, "after": after})


def correction_from_json(text: str) -> Correction:
    """Return the correction in `text`."""
    document = json.loads(text)
    parts = (document["before"], document["after"])
    if document["of"] == "marker":
        return MarkerCorrection(*(None if m is None else _marker_from(m) for m in parts))
    return MeasureCorrection(*(None if m is None else FreeMeasure(tuple(m)) for m in parts))


def _measure_to(measure: FreeMeasure) -> list[str]:
    return list(measure.labels)


def _marker_to(marker: Marker) -> dict[str, object]:
    return {
        "label": marker.label,
        "u": marker.u,
        "v": marker.v,
        "radius_px": marker.radius_px,
        "covariance_px2": marker.covariance_px2.tolist(),
        "position_m": _list(marker.position_m),
        "covariance_m2": _list(marker.covariance_m2),
        "shared_m": _list(marker.shared_m),
        **_named_by_to(marker.named_by),
        **_rough_depth_to(marker.rough_depth_m),
    }


def _marker_from(part: Mapping[str, Any]) -> Marker:
    return Marker(
        label=part["label"],
        u=part["u"],
        v=part["v"],
        radius_px=part["radius_px"],
        covariance_px2=np.array(part["covariance_px2"], float),
        position_m=_array(part["position_m"]),
        covariance_m2=_array(part["covariance_m2"]),
        shared_m=_array(part.get("shared_m")),
        named_by=_named_by_from(part.get("named_by")),
        rough_depth_m=part.get("rough_depth_m"),
    )


def _named_by_to(name: AutomaticName | None) -> dict[str, object]:
    """Return nothing for names by hand: what older versions kept stays the same text."""
    if name is None:
        return {}
    return {"named_by": {"model": name.model, "confidence": name.confidence}}


def _named_by_from(part: Mapping[str, Any] | None) -> AutomaticName | None:
    return None if part is None else AutomaticName(part["model"], part["confidence"])


def _rough_depth_to(depth_m: float | None) -> dict[str, object]:
    """Return nothing where there is none: as with names."""
    return {} if depth_m is None else {"rough_depth_m": depth_m}


def _list(array: FloatArray | None) -> object:
    return None if array is None else array.tolist()


def _array(values: object) -> FloatArray | None:
    return None if values is None else np.array(values, float)
