"""`calibration.json`: a calibration as a JSON document, and back without any loss."""

import math
from collections.abc import Mapping
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
LONGEST_SHOWN = 40
MOST_BITS = 1000

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
        "depth_bias": {
            "a": bias.a,
            "b": bias.b,
            "c": bias.c,
            "image_term": list(bias.image_term),
        },
        "sensor_serial": calibration.sensor_serial,
        "created_utc": calibration.created_utc,
    }
    if calibration.rms_px is not None:
        document |= {"rms_px": calibration.rms_px, "rms_convention": RMS_CONVENTION}
    if calibration.covariance is not None:
        document["parameter_names"] = list(calibration.parameter_names)
        document["covariance"] = calibration.covariance.tolist()
    document |= _vertical_to_json(calibration)
    if calibration.valid_region:
        document["valid_region"] = dict(calibration.valid_region)
    if calibration.corner_method:
        document["corner_method"] = calibration.corner_method
    return document


def _vertical_to_json(calibration: RgbdCalibration) -> dict[str, Any]:
    part: dict[str, Any] = {}
    if calibration.gravity is not None:
        part["gravity"] = calibration.gravity.tolist()
    if calibration.floor is not None:
        part["floor"] = {
            "normal": calibration.floor.normal.tolist(),
            "offset_m": calibration.floor.offset_m,
        }
    if calibration.gravity_sd_rad is not None:
        part["gravity_sd_rad"] = calibration.gravity_sd_rad
    if calibration.floor_flatness_m is not None:
        part["floor_flatness_m"] = calibration.floor_flatness_m
    return part


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
    except ValueError as error:
        raise CalibrationError(
            "{file} is damaged: {reason}. Restore it from a copy, or calibrate again.",
            file=file,
            reason=str(error),
        ) from error


def _from_document(document: Document) -> RgbdCalibration:
    cameras = {name: _camera_from_json(name, document.get(name)) for name in ("color", "depth")}
    if cameras["color"] is None and cameras["depth"] is None:
        raise ValueError("it has neither a color nor a depth camera")
    names, covariance = _covariance(document)
    gravity = document.get("gravity")
    floor = _part("floor", document.get("floor"))
    valid_region = _part("valid_region", document.get("valid_region"))
    return RgbdCalibration(
        color=cameras["color"],
        depth=cameras["depth"],
        color_from_depth=_transform(document.get("color_from_depth")),
        depth_unit_m=number(document.get("depth_unit_m", 0.001)),
        depth_bias=_depth_bias(document.get("depth_bias")),
        rms_px=_rms_px(document),
        parameter_names=names,
        covariance=covariance,
        gravity=None if gravity is None else numbers("gravity", gravity),
        floor=None if floor is None else _plane(floor),
        gravity_sd_rad=_number_or_none(document.get("gravity_sd_rad")),
        floor_flatness_m=_number_or_none(document.get("floor_flatness_m")),
        sensor_serial=str(document.get("sensor_serial") or ""),
        created_utc=str(document.get("created_utc") or ""),
        valid_region=valid_region or {},
        corner_method=str(document.get("corner_method") or ""),
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


def _camera_from_json(name: str, value: object) -> CameraCalibration | None:
    part = _part(name, value)
    if part is None:
        return None
    fx, fy, cx, cy = (number(_needed(name, part, key)) for key in ("fx", "fy", "cx", "cy"))
    return CameraCalibration(
        width=whole_number(_needed(name, part, "width")),
        height=whole_number(_needed(name, part, "height")),
        intrinsics=Intrinsics(fx, fy, cx, cy),
        distortion=tuple(numbers("distortion", part.get("distortion") or []).tolist()),
    )


def _transform(value: object) -> RigidTransform:
    name = "color_from_depth"
    part = _part(name, value)
    if part is None:
        return IDENTITY
    return RigidTransform(
        numbers("rotation", _needed(name, part, "rotation")),
        numbers("translation_m", _needed(name, part, "translation_m")),
    )


def _depth_bias(value: object) -> DepthBias:
    part = _part("depth_bias", value) or {}
    a, b, c = (number(part.get(name, default)) for name, default in (("a", 0), ("b", 1), ("c", 0)))
    image_term = numbers("image_term", part.get("image_term") or [])
    if image_term.ndim != 1:
        raise ValueError("image_term is no list of numbers")
    return DepthBias(a, b, c, tuple(image_term.tolist()))


def _rms_px(document: Document) -> float | None:
    if document.get("rms_px") is None:
        return None
    if document.get("rms_convention", RMS_CONVENTION) != RMS_CONVENTION:
        raise ValueError(f"its rms_convention is not {RMS_CONVENTION!r}")
    return number(document["rms_px"])


def _covariance(document: Document) -> tuple[tuple[str, ...], FloatArray | None]:
    names, values = document.get("parameter_names") or [], document.get("covariance") or []
    if not isinstance(names, list):
        raise ValueError("parameter_names is no list")  # noqa: TRY004  (the file's fault)
    covariance = numbers("covariance", values)
    if covariance.size == 0:
        return tuple(str(name) for name in names), None
    if covariance.shape != (len(names), len(names)):
        raise ValueError(
            f"covariance must have shape {(len(names), len(names))}, one row for each of "
            f"parameter_names, got {covariance.shape}"
        )
    return tuple(str(name) for name in names), covariance


def _plane(part: Document) -> Plane:
    return Plane(
        numbers("normal", _needed("floor", part, "normal")),
        number(_needed("floor", part, "offset_m")),
    )


def _part(name: str, value: object) -> Document | None:
    """Return a group of values, None where it is missing or null."""
    if value is None:
        return None
    if not isinstance(value, Mapping):
        raise ValueError(f"{name} is no group of values")  # noqa: TRY004  (the file's fault)
    return value


def _needed(name: str, part: Document, key: str) -> object:
    if key not in part:
        raise ValueError(f"{name}.{key} is missing")
    return part[key]


def _number_or_none(value: object) -> float | None:
    return None if value is None else number(value)


def number(value: object) -> float:
    """Return a finite number, or raise ValueError."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        shown = repr(value)[:LONGEST_SHOWN] if isinstance(value, str | bool) else "a value"
        raise ValueError(f"{shown} is no number")  # noqa: TRY004  (the file's fault)
    # An integer too large for a float is not finite either.
    if isinstance(value, int) and value.bit_length() > MOST_BITS:
        raise ValueError("a number is not finite")
    if not math.isfinite(value):
        raise ValueError(f"{value!r} is not finite")
    return float(value)


def whole_number(value: object) -> int:
    """Return a whole number, or raise ValueError."""
    if number(value) != int(number(value)):
        raise ValueError(f"{value!r} is no whole number")
    return int(number(value))


def numbers(name: str, values: object) -> FloatArray:
    """Return a list of numbers, or of rows of them, as an array; ValueError if it is none."""
    if not isinstance(values, list):
        raise ValueError(f"{name} is no list")  # noqa: TRY004  (the file's fault)
    if not all(isinstance(row, list) for row in values):
        return np.array([number(value) for value in values], float)
    if len({len(row) for row in values}) > 1:
        raise ValueError(f"{name} has rows of different lengths")
    return np.array([[number(value) for value in row] for row in values], float)
