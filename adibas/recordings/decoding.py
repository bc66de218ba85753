"""Colour images out of and into JPEG and PNG, and raw frames into metres."""

import struct
import zlib

import numpy as np

from adibas.arrays import UInt8Array, UInt16Array
from adibas.data.frames import EncodedImage, RgbdFrame, SensorFrame, SourceInfo, depth_in_metres
from adibas.errors import RecordingError
from adibas.recordings.ports import RecordingOptions
from adibas.texts import message

MAX_COLOR_PIXELS = 64_000_000
"""Largest image that is decoded: a few bytes must not ask for gigabytes."""
MAX_PIXELS_PER_BYTE = 1032
"""Deflate's best ratio, at one byte a pixel; JPEG needs a bit for each block of 64 pixels."""
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
PNG_PART_OVERHEAD = 12
JPEG_SIGNATURE = b"\xff\xd8\xff"
JPEG_MARKER = 0xFF
JPEG_FRAME_STARTS = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


def to_rgbd(frame: SensorFrame, info: SourceInfo) -> RgbdFrame:
    """Turn a frame as the sensor gave it into metres and decoded colour.

    Parameters
    ----------
    frame : SensorFrame
        With depth and colour.
    info : SourceInfo
        Of the recording or sensor that gave it.

    Raises
    ------
    RecordingError
        The frame lacks depth or colour, or its colour image is damaged.
    """
    if frame.depth_raw is None or frame.color is None:
        raise RecordingError(
            "Frame {sequence} has no {what}. Record depth and colour together, or choose other "
            "frames.",
            sequence=frame.sequence,
            what=message("depth") if frame.depth_raw is None else message("colour"),
        )
    return RgbdFrame(
        sequence=frame.sequence,
        timestamp_ns=frame.timestamp_ns,
        depth_m=depth_in_metres(frame.depth_raw, info.depth_unit_m),
        color_rgb=decode_color(frame.color, frame.sequence),
    )


def decode_color(image: UInt8Array | EncodedImage, sequence: int) -> UInt8Array:
    """Return the (H, W, 3) RGB image of frame `sequence`; an array is returned as it is."""
    if not isinstance(image, EncodedImage):
        return image
    import cv2

    height, width = encoded_size(image.payload)
    color = None
    is_sane = 0 < height * width <= min(MAX_COLOR_PIXELS, max_pixels(image.payload))
    if is_sane and is_whole_image(image.payload):
        flags = cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION
        try:
            color = cv2.imdecode(np.frombuffer(image.payload, np.uint8), flags)
        except cv2.error:
            color = None
    if color is None or color.shape[:2] != (height, width):
        raise RecordingError(
            "The colour image of frame {sequence} is damaged or too large. Choose other frames.",
            sequence=sequence,
        )
    return np.ascontiguousarray(color, np.uint8)


def encode_color(image: UInt8Array | EncodedImage, options: RecordingOptions) -> EncodedImage:
    """Return the (H, W, 3) RGB image as `options` say; an encoded one is returned as it is."""
    if isinstance(image, EncodedImage):
        return image
    import cv2

    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    if options.color == "jpeg":
        # A sticker is some pixels wide: at half the colour resolution its colour is gone.
        flags = [
            *(cv2.IMWRITE_JPEG_QUALITY, options.jpeg_quality),
            *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
        ]
        return EncodedImage("jpeg", cv2.imencode(".jpg", bgr, flags)[1].tobytes())
    return EncodedImage("png", encode_png(np.ascontiguousarray(bgr, np.uint8)))


def encode_png(image: UInt8Array | UInt16Array) -> bytes:
    """Return the (H, W) 16-bit or (H, W, 3) BGR 8-bit image as a PNG file.

    Runs alone, after the difference to the left neighbour: of noisy images three times as fast as
    the default, and no larger.
    """
    import cv2

    parameters = [cv2.IMWRITE_PNG_COMPRESSION, 1]
    parameters += [cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE]
    parameters += [cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_SUB]
    return cv2.imencode(".png", image, parameters)[1].tobytes()


def encoded_size(payload: bytes) -> tuple[int, int]:
    """Return (height, width) that the head of a JPEG or PNG file names; (0, 0) if it has none."""
    if payload.startswith(PNG_SIGNATURE) and len(payload) >= 24:  # noqa: PLR2004  (IHDR)
        width, height = struct.unpack(">II", payload[16:24])
        return height, width
    if payload.startswith(JPEG_SIGNATURE):
        return _jpeg_size(payload)
    return 0, 0


def max_pixels(payload: bytes) -> int:
    """Return how many pixels a JPEG or PNG file of that length can have at all."""
    return MAX_PIXELS_PER_BYTE * len(payload)


def _jpeg_size(payload: bytes) -> tuple[int, int]:
    """Walk the segments up to the start of frame; the marker's number says that it is one."""
    position = 2
    while position + 9 <= len(payload) and payload[position] == JPEG_MARKER:
        kind = payload[position + 1]
        if kind in JPEG_FRAME_STARTS:
            height, width = struct.unpack(">HH", payload[position + 5 : position + 9])
            return height, width
        length = int.from_bytes(payload[position + 2 : position + 4], "big")
        position += 1 if kind == JPEG_MARKER else 2 + max(2, length)
    return 0, 0


def is_whole_image(payload: bytes) -> bool:
    """Say whether a JPEG or PNG file is complete: the decoder would fill what is missing with grey.

    Of a PNG file every part is checked: the decoder takes as much memory as a part's length says.
    """
    if not payload.startswith(PNG_SIGNATURE):
        return payload.rstrip(b"\0").endswith(b"\xff\xd9")
    position = len(PNG_SIGNATURE)
    kind = b""
    while position + PNG_PART_OVERHEAD <= len(payload) and kind != b"IEND":
        end = position + PNG_PART_OVERHEAD + int.from_bytes(payload[position : position + 4], "big")
        kind = payload[position + 4 : position + 8]
        crc = zlib.crc32(payload[position + 4 : end - 4])
        if end > len(payload) or payload[end - 4 : end] != crc.to_bytes(4, "big"):
            return False
        if kind == b"acTL":  # an animation, whose pictures have sizes of their own
            return False
        position = end
    return kind == b"IEND"
