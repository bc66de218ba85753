"""The messages of a native recording: Foxglove's schemas, and one of our own for depth.

Source: Foxglove schemas (CompressedImage, RawImage, CameraCalibration), field numbers as in their
protobuf files. `docs/recording-format.md` describes ours.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import UInt16Array
from adibas.data.calibration import CameraCalibration
from adibas.data.frames import EncodedImage
from adibas.errors import RecordingError
from adibas.recordings.protobuf import Field, MessageType, decode_message, encode_message
from adibas.recordings.rvl import decode_rvl, encode_rvl

COMPRESSED_IMAGE = MessageType(
    "foxglove.CompressedImage",
    (
        Field(1, "timestamp", "timestamp"),
        Field(2, "data", "bytes"),
        Field(3, "format", "string"),
        Field(4, "frame_id", "string"),
    ),
)
RAW_IMAGE = MessageType(
    "foxglove.RawImage",
    (
        Field(1, "timestamp", "timestamp"),
        Field(2, "width", "fixed32"),
        Field(3, "height", "fixed32"),
        Field(4, "encoding", "string"),
        Field(5, "step", "fixed32"),
        Field(6, "data", "bytes"),
        Field(7, "frame_id", "string"),
    ),
)
CAMERA_CALIBRATION = MessageType(
    "foxglove.CameraCalibration",
    (
        Field(1, "timestamp", "timestamp"),
        Field(2, "width", "fixed32"),
        Field(3, "height", "fixed32"),
        Field(4, "distortion_model", "string"),
        Field(5, "D", "doubles"),
        Field(6, "K", "doubles"),
        Field(7, "R", "doubles"),
        Field(8, "P", "doubles"),
        Field(9, "frame_id", "string"),
    ),
)
RVL_IMAGE = MessageType(
    "adibas.RvlImage",
    (
        Field(1, "timestamp", "timestamp"),
        Field(2, "frame_id", "string"),
        Field(3, "sequence", "uint64"),
        Field(4, "width", "fixed32"),
        Field(5, "height", "fixed32"),
        Field(6, "unit_m", "double"),
        Field(7, "data", "bytes"),
    ),
)
PLAIN_ENCODING = "16UC1"
_RADIAL_TERMS_OF_FOXGLOVE = 8


@dataclass(frozen=True, slots=True)
class Stamp:
    """When, by which camera, and which frame."""

    timestamp_ns: int
    camera: str
    sequence: int


def rvl_image(image: UInt16Array, unit_m: float, stamp: Stamp) -> bytes:
    """Return (H, W) counts of `unit_m` metres (0 for infrared: no length) as our own message."""
    height, width = image.shape
    values = {
        "timestamp": stamp.timestamp_ns,
        "frame_id": stamp.camera,
        "sequence": stamp.sequence,
        "width": width,
        "height": height,
        "unit_m": float(unit_m),
        "data": encode_rvl(image),
    }
    return encode_message(RVL_IMAGE, values)


def raw_image(image: UInt16Array, stamp: Stamp) -> bytes:
    """Return the (H, W) image as a Foxglove message without compression."""
    height, width = image.shape
    values = {
        "timestamp": stamp.timestamp_ns,
        "frame_id": stamp.camera,
        "width": width,
        "height": height,
        "encoding": PLAIN_ENCODING,
        "step": 2 * width,
        "data": np.ascontiguousarray(image, "<u2").tobytes(),
    }
    return encode_message(RAW_IMAGE, values)


def compressed_image(image: EncodedImage, stamp: Stamp) -> bytes:
    """Return a JPEG or PNG file as a Foxglove message."""
    values = {
        "timestamp": stamp.timestamp_ns,
        "frame_id": stamp.camera,
        "format": image.encoding,
        "data": image.payload,
    }
    return encode_message(COMPRESSED_IMAGE, values)


def camera_calibration(camera: CameraCalibration, stamp: Stamp) -> bytes:
    """Return `camera` as a Foxglove message; its model holds no thin prism (k6 is the last)."""
    lens = camera.intrinsics
    k = tuple(float(value) for value in lens.matrix().ravel())
    distortion = tuple(float(value) for value in camera.distortion[:_RADIAL_TERMS_OF_FOXGLOVE])
    is_rational = len(distortion) == _RADIAL_TERMS_OF_FOXGLOVE
    values: dict[str, object] = {
        "timestamp": stamp.timestamp_ns,
        "frame_id": stamp.camera,
        "width": camera.width,
        "height": camera.height,
        "distortion_model": "rational_polynomial" if is_rational else "plumb_bob",
        "D": distortion if is_rational else (*distortion, *([0.0] * (5 - len(distortion)))),
        "K": k,
        "R": tuple(np.eye(3).ravel().tolist()),
        "P": (*k[:3], 0.0, *k[3:6], 0.0, *k[6:], 0.0),
    }
    return encode_message(CAMERA_CALIBRATION, values)


def read_depth(schema: str, data: bytes) -> UInt16Array:
    """Return the (H, W) image of a message of type `schema`, `adibas.RvlImage` or `RawImage`."""
    if schema == RVL_IMAGE.full_name:
        values = decode_message(RVL_IMAGE, data)
        return decode_rvl(_bytes(values["data"]), (_size(values["height"]), _size(values["width"])))
    values = decode_message(RAW_IMAGE, data)
    height, width, step = (_size(values[name]) for name in ("height", "width", "step"))
    pixels = _bytes(values["data"])
    is_consistent = step == 2 * width and len(pixels) == height * step and len(pixels) > 0
    if values["encoding"] != PLAIN_ENCODING or not is_consistent:
        raise RecordingError("The depth image is damaged. Use another frame.")
    return np.frombuffer(pixels, "<u2").reshape(height, width).astype(np.uint16)


def read_color(data: bytes) -> EncodedImage:
    """Return the JPEG or PNG file in a message."""
    values = decode_message(COMPRESSED_IMAGE, data)
    payload = _bytes(values["data"])
    if values["format"] == "jpeg":
        return EncodedImage("jpeg", payload)
    if values["format"] == "png":
        return EncodedImage("png", payload)
    raise RecordingError("The colour image is neither JPEG nor PNG. Use another frame.")


def _size(value: object) -> int:
    if not isinstance(value, int):
        raise ValueError("a size is no number")  # noqa: TRY004  (bad input)
    return value


def _bytes(value: object) -> bytes:
    if not isinstance(value, bytes):
        raise ValueError("an image is no bytes")  # noqa: TRY004  (bad input)
    return value
