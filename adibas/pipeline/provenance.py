"""What a result was computed from, in values that a report can print."""

import hashlib
import json
from dataclasses import asdict
from datetime import datetime

from adibas import __version__
from adibas.calibration.files import calibration_to_json
from adibas.data.calibration import RgbdCalibration
from adibas.data.posture import Provenance
from adibas.markers.color_model import ColorModel
from adibas.pipeline.posture import MarkerTarget, PostureParams


def provenance_of(
    recording_sha256: str,
    calibration: RgbdCalibration,
    target: MarkerTarget | None,
    params: PostureParams,
    now: datetime,
) -> Provenance:
    """Return the provenance of markers found in a recording; no `target`: none were looked for."""
    return Provenance(
        recording_sha256=recording_sha256,
        calibration=identity_of(calibration),
        version=__version__,
        created_utc=now.isoformat(timespec="seconds"),
        parameters={**asdict(params), "markers": _described(target)},
    )


def identity_of(calibration: RgbdCalibration) -> str:
    """Return ``sha256:`` and the hash of a calibration's canonical JSON."""
    canonical = json.dumps(calibration_to_json(calibration), sort_keys=True)
    return f"sha256:{hashlib.sha256(canonical.encode()).hexdigest()}"


def _described(target: MarkerTarget | None) -> dict[str, object]:
    """Return what was looked for, as plain values."""
    if target is None:
        return {}
    if isinstance(target, ColorModel):
        return {"centroids_lab": target.centroids_lab.tolist(), "threshold": target.threshold}
    return asdict(target)
