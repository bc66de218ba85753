"""Colour calibrations of other programs: OpenCV's YAML and XML, ROS camera_info."""

from collections.abc import Iterator, Mapping
from typing import Any

import cv2
import yaml

from adibas.arrays import FloatArray
from adibas.calibration.json_format import number, numbers, whole_number
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.errors import CalibrationError
from adibas.geometry.pinhole import Intrinsics
from adibas.texts import message

MATRIX_NAMES = ("camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "M1", "intrinsics")
DISTORTION_NAMES = (
    "distortion_coefficients",
    "Distortion_Coefficients",
    "distCoeffs",
    "D",
    "D1",
    "distortion",
)
WIDTH_NAMES = ("image_width", "image_Width", "width")
HEIGHT_NAMES = ("image_height", "image_Height", "height")
SIZE_NAMES = ("image_size", "imageSize")
ROS_MODELS = ("plumb_bob", "rational_polynomial", "")
ROS_MATRIX_NAMES = ("camera_matrix", "K", "k")
ROS_DISTORTION_NAMES = ("distortion_coefficients", "D", "d")
ROS_WIDTH_NAMES = ("image_width", "width")
ROS_HEIGHT_NAMES = ("image_height", "height")
MAX_OPENCV_CHARACTERS = 1_048_576
MAX_OPENCV_GROUPS = 2000
"""OpenCV's parser calls itself for each group within a group until the stack overflows."""

MAX_YAML_CHARACTERS = 65_536
"""The parser is slow, and a camera_info has about a thousand."""


class PlainLoader(yaml.SafeLoader):
    """Reads YAML without references, by which a small file can unfold to any size."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        """Refuse a reference, else go on."""
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("a reference has no place in a calibration")
        return super().compose_node(parent, index)


def calibration_from_opencv(text: str, file: str) -> RgbdCalibration:
    """Return the colour camera of an OpenCV FileStorage, YAML or XML.

    Raises
    ------
    CalibrationError
        It cannot be parsed, or lacks the camera matrix or the image size.
    """
    n_groups = sum(text.count(opening) for opening in ("[", "{", "<"))
    if len(text) > MAX_OPENCV_CHARACTERS or n_groups > MAX_OPENCV_GROUPS:
        raise _unreadable(file, message("it is too large for a camera's calibration"))
    try:
        storage = cv2.FileStorage(text, cv2.FileStorage_READ | cv2.FileStorage_MEMORY)
        try:
            matrix = _first_matrix(storage, MATRIX_NAMES)
            distortion = _first_matrix(storage, DISTORTION_NAMES)
            size = _opencv_size(storage)
        finally:
            storage.release()
    except (cv2.error, SystemError, OverflowError, ValueError) as error:
        raise _unreadable(file, message("it is not what OpenCV writes")) from error
    if matrix is None or matrix.shape != (3, 3) or size is None:
        raise _unreadable(file, message("it has no 3x3 camera matrix, or no image size"))
    return _calibration(file, size, matrix, [] if distortion is None else distortion.ravel())


def calibration_from_ros(text: str, file: str) -> RgbdCalibration:
    """Return the colour camera of a ROS ``camera_info`` YAML file.

    Raises
    ------
    CalibrationError
        It cannot be parsed, lacks a part, or has another lens model.
    """
    if len(text) > MAX_YAML_CHARACTERS:
        raise _unreadable(file, message("it is too large for a camera_info"))
    try:
        document = yaml.load(text, PlainLoader)  # noqa: S506  (a SafeLoader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise _unreadable(file, message("it is no YAML")) from error
    if not isinstance(document, Mapping):
        raise _unreadable(file, message("it is no camera_info"))
    model = document.get("distortion_model") or ""
    if model not in ROS_MODELS:
        raise _unreadable(file, message("its lens model is not plumb_bob or rational_polynomial"))
    try:
        size = (
            whole_number(_first(document, ROS_WIDTH_NAMES)),
            whole_number(_first(document, ROS_HEIGHT_NAMES)),
        )
        matrix = _data(_first(document, ROS_MATRIX_NAMES)).reshape(3, 3)
        distortion = _data(_first(document, ROS_DISTORTION_NAMES) or [])
    except ValueError as error:
        raise _unreadable(
            file, message("its size, camera matrix or distortion is damaged")
        ) from error
    return _calibration(file, size, matrix, distortion)


def _first(document: Mapping[str, Any], names: tuple[str, ...]) -> Any:
    """Return the value of the first name that is there; None without any."""
    return next((document[name] for name in names if name in document), None)


def _data(part: Any) -> FloatArray:
    return numbers("data", part.get("data") if isinstance(part, Mapping) else part).ravel()


def _nodes(storage: cv2.FileStorage, names: tuple[str, ...]) -> Iterator[cv2.FileNode]:
    for name in names:
        node = storage.getNode(name)
        if not node.empty():
            yield node


def _first_matrix(storage: cv2.FileStorage, names: tuple[str, ...]) -> Any:
    for node in _nodes(storage, names):
        if node.isMap():
            return node.mat()
    return None


def _opencv_size(storage: cv2.FileStorage) -> tuple[int, int] | None:
    for node in _nodes(storage, SIZE_NAMES):
        if node.isSeq() and node.size() == 2:  # noqa: PLR2004  (width, height)
            return int(node.at(0).real()), int(node.at(1).real())
    width = next((int(node.real()) for node in _nodes(storage, WIDTH_NAMES)), 0)
    height = next((int(node.real()) for node in _nodes(storage, HEIGHT_NAMES)), 0)
    return (width, height) if width > 0 and height > 0 else None


def _calibration(file: str, size: tuple[int, int], matrix: Any, distortion: Any) -> RgbdCalibration:
    """Build the calibration; trailing zeros beyond a known length of distortion are dropped."""
    if matrix[0, 1] != 0:
        raise _unreadable(file, message("its camera matrix has skew, which is not supported"))
    if matrix[1, 0] != 0 or matrix[2].tolist() != [0, 0, 1]:
        raise _unreadable(file, message("its camera matrix is none"))
    try:
        k = Intrinsics(*(float(matrix[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2))))
        coefficients = tuple(number(float(value)) for value in distortion)
        camera = CameraCalibration(size[0], size[1], k, _without_tilt(coefficients))
    except ValueError as error:
        raise _unreadable(file, str(error)) from error
    return RgbdCalibration(color=camera)


def _without_tilt(coefficients: tuple[float, ...]) -> tuple[float, ...]:
    """Drop OpenCV's two tilt coefficients where they are zero (14 values -> 12)."""
    has_no_tilt = len(coefficients) == 14 and not any(coefficients[12:])  # noqa: PLR2004
    return coefficients[:12] if has_no_tilt else coefficients


def _unreadable(file: str, reason: str) -> CalibrationError:
    return CalibrationError(
        "{file} cannot be used as a calibration: {reason}. Choose another file, or calibrate the "
        "sensor.",
        file=file,
        reason=reason,
    )
