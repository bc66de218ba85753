"""From OpenNI2's frame buffers to arrays of our own."""

import ctypes
from typing import Any

import numpy as np
import numpy.typing as npt

from adibas.arrays import UInt8Array
from adibas.errors import SensorError
from adibas.sensors.openni2_modes import PIXEL_FORMATS
from adibas.sensors.pairing import StreamImage

NS_PER_US = 1000
BYTES_PER_PIXEL = {
    "DEPTH_1_MM": 2,
    "DEPTH_100_UM": 2,
    "RGB888": 3,
    "YUV422": 2,
    "YUYV": 2,
    "GRAY8": 1,
    "GRAY16": 2,
}


def copy_image(frame: Any, *, is_color: bool, is_mirrored: bool) -> StreamImage:
    """Return a copy of the library's frame: RGB for colour, else uint16; never mirrored.

    Raises
    ------
    SensorError
        The frame's buffer does not hold the image that the frame describes.
    """
    pixels = _pixels(frame, is_color=is_color)
    if is_mirrored:
        pixels = np.ascontiguousarray(pixels[:, ::-1])
    return StreamImage(int(frame.frameIndex), int(frame.timestamp) * NS_PER_US, pixels)


def _pixels(frame: Any, *, is_color: bool) -> npt.NDArray[Any]:
    name = PIXEL_FORMATS.get(int(frame.videoMode.pixelFormat), "")
    rows = _rows(frame, BYTES_PER_PIXEL.get(name, 0))
    if is_color:
        return _rgb(rows, name)
    if BYTES_PER_PIXEL[name] == 1:
        return rows.astype(np.uint16)
    return rows.view(np.uint16)


def _rows(frame: Any, bytes_per_pixel: int) -> UInt8Array:
    height, stride, size = int(frame.height), int(frame.stride), int(frame.dataSize)
    row_bytes = int(frame.width) * bytes_per_pixel
    fits = 0 < row_bytes <= stride and height > 0 and size >= stride * (height - 1) + row_bytes
    if not (fits and frame.data):
        raise SensorError(
            "The sensor sent a broken picture ({size} bytes for {width} x {height} pixels). Plug "
            "it in anew, into a USB port of its own; a file is damaged: use its copy.",
            size=size,
            width=int(frame.width),
            height=height,
        )
    n_bytes = stride * (height - 1) + row_bytes
    copied = np.frombuffer(ctypes.string_at(frame.data, n_bytes), np.uint8)
    rows = np.lib.stride_tricks.as_strided(copied, (height, row_bytes), (stride, 1))
    return np.ascontiguousarray(rows)


def _rgb(rows: UInt8Array, name: str) -> UInt8Array:
    height = len(rows)
    if name == "RGB888":
        return rows.reshape(height, -1, 3)
    if name == "GRAY8":
        return np.repeat(rows[:, :, None], 3, axis=2)
    import cv2

    code = cv2.COLOR_YUV2RGB_UYVY if name == "YUV422" else cv2.COLOR_YUV2RGB_YUYV
    return np.asarray(cv2.cvtColor(rows.reshape(height, -1, 2), code), np.uint8)
