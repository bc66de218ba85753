"""Calibrations on the disk."""

import json
from pathlib import Path

from adibas.calibration.json_format import calibration_from_json, calibration_to_json
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.errors import CalibrationError
from adibas.files import written_whole
from adibas.texts import message

__all__ = [
    "calibration_from_json",
    "calibration_to_json",
    "check_fits",
    "read_calibration",
    "write_calibration",
]

MAX_BYTES = 16 * 1024 * 1024
"""No calibration is that large: the file is something else."""


def write_calibration(path: Path, calibration: RgbdCalibration) -> None:
    """Write `calibration.json`, whole or not at all.

    Raises
    ------
    FileError
        The disk is full, or the folder cannot be written.
    """
    text = json.dumps(calibration_to_json(calibration), indent=1, allow_nan=False)
    with written_whole(path) as unfinished:
        unfinished.write_text(text + "\n", encoding="utf-8")


def read_calibration(path: Path) -> RgbdCalibration:
    """Read `calibration.json`, OpenCV YAML or XML, or ROS camera_info YAML.

    The kind is told by the content, not by the name.

    Raises
    ------
    CalibrationError
        The file is missing, too large, or no calibration.
    """
    text = _read_text(path)
    start = text.lstrip("\ufeff \t\r\n")
    if start.startswith("{"):
        return calibration_from_json(_parse_json(start, path.name), path.name)
    from adibas.calibration.foreign_formats import calibration_from_opencv, calibration_from_ros

    is_opencv = start.startswith(("%YAML:1.0", "<?xml", "<opencv_storage")) or "!!opencv" in start
    reader = calibration_from_opencv if is_opencv else calibration_from_ros
    return reader(start, path.name)


def check_fits(
    calibration: RgbdCalibration,
    color_size: tuple[int, int] | None,
    depth_size: tuple[int, int] | None,
) -> None:
    """See that `calibration` has the cameras of images of these (height, width); None: no image.

    Raises
    ------
    CalibrationError
        A camera is missing, or it was calibrated at another resolution.
    """
    if color_size is not None:
        _check_camera(message("colour"), calibration.color, color_size)
    if depth_size is not None:
        _check_camera(message("depth"), calibration.depth, depth_size)


def _check_camera(name: str, camera: CameraCalibration | None, size: tuple[int, int]) -> None:
    if camera is None:
        raise CalibrationError(
            "The calibration has no {camera} camera, and positions need both cameras. Give a "
            "calibration of the whole sensor.",
            camera=name,
        )
    if (camera.height, camera.width) != size:
        raise CalibrationError(
            "The calibration is for {camera} images of {width}x{height}, but the recording has "
            "{recorded_width}x{recorded_height}. Give the calibration of this resolution.",
            camera=name,
            width=camera.width,
            height=camera.height,
            recorded_width=size[1],
            recorded_height=size[0],
        )


def _read_text(path: Path) -> str:
    try:
        if path.stat().st_size > MAX_BYTES:
            raise CalibrationError(
                "{file} is too large for a calibration. Choose another file.", file=path.name
            )
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise CalibrationError(
            "{file} cannot be read: {reason}. Check the name of the calibration.",
            file=path.name,
            reason=error.strerror or str(error),
        ) from error
    except UnicodeDecodeError as error:
        raise CalibrationError(
            "{file} is no calibration but a binary file. Choose another file.", file=path.name
        ) from error


def _parse_json(text: str, file: str) -> object:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise CalibrationError(
            "{file} is damaged: it is no whole JSON document. Restore it from a copy, or "
            "calibrate again.",
            file=file,
        ) from error
