"""`SourceInfo` as the texts that stand in a file, and back."""

import json
import math
from dataclasses import replace

from adibas.calibration.files import calibration_from_json, calibration_to_json
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import SourceInfo
from adibas.errors import RecordingError

FORMAT = "adibas-recording"
VERSION = "1"


def info_to_texts(info: SourceInfo) -> dict[str, str]:
    """Return `info` as texts by name; floats so that they come back exactly."""
    texts = {
        "format": FORMAT,
        "version": VERSION,
        "depth_unit_m": repr(float(info.depth_unit_m)),
        "frame_rate_hz": repr(float(info.frame_rate_hz)),
        "sensor_name": info.sensor_name,
        "sensor_serial": info.sensor_serial,
        "is_depth_registered": "true" if info.is_depth_registered else "false",
        "n_dropped": str(info.n_dropped),
    }
    calibration = calibration_to_keep(info)
    if calibration is not None:
        texts["calibration"] = json.dumps(calibration_to_json(calibration))
    return texts


def calibration_to_keep(info: SourceInfo) -> RgbdCalibration | None:
    """Return the calibration; None where it has no camera: it could not be read back."""
    calibration = info.calibration
    has_camera = calibration is not None and (calibration.color or calibration.depth)
    return calibration if has_camera else None


def info_from_texts(texts: dict[str, str], file: str) -> SourceInfo:
    """Return the `SourceInfo` in `texts`.

    Raises
    ------
    RecordingError
        A text is missing or makes no sense, or the recording is of a later version.
    CalibrationError
        The calibration in it makes no sense.
    """
    if texts.get("format") != FORMAT or texts.get("version") != VERSION:
        raise RecordingError(
            "{file} was not recorded by this version of ADiBAS. Update the program, or record "
            "again.",
            file=file,
        )
    try:
        info = SourceInfo(
            depth_unit_m=_finite(texts["depth_unit_m"]),
            frame_rate_hz=_finite(texts["frame_rate_hz"]),
            sensor_name=texts.get("sensor_name", ""),
            sensor_serial=texts.get("sensor_serial", ""),
            is_depth_registered=texts.get("is_depth_registered") == "true",
            n_dropped=max(0, int(texts.get("n_dropped", "0"))),
        )
        calibration = json.loads(texts["calibration"]) if "calibration" in texts else None
    except (KeyError, ValueError, RecursionError) as error:
        raise RecordingError(
            "{file} is damaged: what it says of its sensor cannot be read. Restore it from a copy.",
            file=file,
        ) from error
    if calibration is None:
        return info
    return replace(info, calibration=calibration_from_json(calibration, file))


def _finite(value: str) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"not finite: {value}")
    return number
