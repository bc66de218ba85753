"""`calibration.json`: a calibration as a JSON document, and back without any loss."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.errors import CalibrationError
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import IDENTITY, RigidTransform

FORMAT = "adibas-calibration"
VERSION = 1
RMS_CONVENTION = "points"

Document = Mapping[str, Any]


def calibration_to_json(calibration: RgbdCalibration) -> dict[str, Any]:
    """Return the document of `calibration`; what is not known is left out."""
    transform, bias = calibration.color_from_depth, calibration.depth_bias
    document: dict[str, Any] = {"format": FORMAT, "version": VERSION}
    if calibration.color is not None:
        document["color"] = _camera_to_json(calibration.color)
    if calibration.depth is not None:
        document["depth"] = _camera_to_json(calibration.depth)
    document |= {
        "color_from_depth": {
            "rotation": transform.rotation.tolist(),
            "translation_m": transform.translation_m.tolist(),
        },
        "depth_unit_m": calibration.depth_unit_m,
        "depth_bias": {"a": bias.a, "b": bias.b, "c": bias.c, "image_term": []},
        "sensor_serial": calibration.sensor_serial,
        "created_utc": calibration.created_utc,
    }
    if calibration.rms_px is not None:
        document |= {"rms_px": calibration.rms_px, "rms_convention": RMS_CONVENTION}
    if calibration.covariance is not None:
        document["parameter_names"] = list(calibration.parameter_names)
        document["covariance"] = calibration.covariance.tolist()
    if calibration.gravity is not None:
        document["gravity"] = calibration.gravity.tolist()
    if calibration.floor is not None:
        document["floor"] = {
            "normal": calibration.floor.normal.tolist(),
            "offset_m": calibration.floor.offset_m,
        }
    return document


def calibration_from_json(document: object, file: str) -> RgbdCalibration:
    """Return the calibration in `document`; every key after ``depth_unit_m`` may be missing.

    Parameters
    ----------
    document : object
        As `json.loads` gives it.
    file : str
        Its name, for the error.

    Raises
    ------
    CalibrationError
        It is no calibration, of a later version, or a value makes no sense.
    """
    if not isinstance(document, Mapping) or document.get("format") != FORMAT:
        raise CalibrationError(
            "{file} is no calibration of ADiBAS. Choose a calibration.json, or calibrate the "
            "sensor.",
            file=file,
        )
    if document.get("version") != VERSION:
        raise CalibrationError(
            "{file} was made by a later version of ADiBAS. Update the program, or calibrate again.",
            file=file,
        )
    try:
        return _from_document(document)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise CalibrationError(
            "{file} is damaged: {reason}. Restore it from a copy, or calibrate again.",
            file=file,
            reason=f"{error.args[0]} is missing" if isinstance(error, KeyError) else str(error),
        ) from error


def _from_document(document: Document) -> RgbdCalibration:
    color, depth = (
        _camera_from_json(document[name]) if document.get(name) else None
        for name in ("color", "depth")
    )
    if color is None and depth is None:
        raise ValueError("it has neither a color nor a depth camera")
    names = tuple(str(name) for name in document.get("parameter_names", ()))
    covariance = document.get("covariance")
    rms_px = document.get("rms_px")
    gravity = document.get("gravity")
    floor = document.get("floor")
    return RgbdCalibration(
        color=color,
        depth=depth,
        color_from_depth=_transform(document.get("color_from_depth")),
        depth_unit_m=number(document.get("depth_unit_m", 0.001)),
        depth_bias=_depth_bias(document.get("depth_bias", {})),
        rms_px=None if rms_px is None else number(rms_px),
        parameter_names=names,
        covariance=_numbers(covariance) if names and covariance is not None else None,
        gravity=None if gravity is None else _numbers(gravity),
        floor=None if floor is None else _plane(floor),
        sensor_serial=str(document.get("sensor_serial", "")),
        created_utc=str(document.get("created_utc", "")),
    )


def _camera_to_json(camera: CameraCalibration) -> dict[str, Any]:
    k = camera.intrinsics
    return {
        "width": camera.width,
        "height": camera.height,
        "fx": k.fx,
        "fy": k.fy,
        "cx": k.cx,
        "cy": k.cy,
        "distortion": list(camera.distortion),
    }


def _camera_from_json(part: Document) -> CameraCalibration:
    fx, fy, cx, cy = (number(part[name]) for name in ("fx", "fy", "cx", "cy"))
    return CameraCalibration(
        width=whole_number(part["width"]),
        height=whole_number(part["height"]),
        intrinsics=Intrinsics(fx, fy, cx, cy),
        distortion=tuple(number(value) for value in part.get("distortion", ())),
    )


def _transform(part: Document | None) -> RigidTransform:
    if part is None:
        return IDENTITY
    return RigidTransform(_numbers(part["rotation"]), _numbers(part["translation_m"]))


def _depth_bias(part: Document) -> DepthBias:
    if part.get("image_term"):
        raise ValueError("its depth_bias.image_term is of a kind that this version cannot apply")
    defaults = {"a": 0.0, "b": 1.0, "c": 0.0}
    return DepthBias(**{name: number(part.get(name, defaults[name])) for name in defaults})


def _plane(part: Document) -> Plane:
    return Plane(_numbers(part["normal"]), number(part["offset_m"]))


def number(value: object) -> float:
    """Return a finite number, or raise ValueError or TypeError."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{value!r} is no number")
    if not math.isfinite(value):
        raise ValueError(f"{value!r} is not finite")
    return float(value)


def whole_number(value: object) -> int:
    """Return a whole number, or raise ValueError or TypeError."""
    if number(value) != int(number(value)):
        raise ValueError(f"{value!r} is no whole number")
    return int(number(value))


def _numbers(values: Sequence[Any]) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    if not np.isfinite(array).all():
        raise ValueError("a matrix has a value that is not finite")
    return array
