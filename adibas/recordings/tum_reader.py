"""Reads TUM RGB-D folders: our own, those of the benchmark, and others written like them."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from adibas.arrays import IntArray, UInt16Array
from adibas.calibration.files import read_calibration
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.files import is_there
from adibas.recordings.decoding import (
    JPEG_SIGNATURE,
    PNG_SIGNATURE,
    encoded_size,
    is_whole_image,
    max_pixels,
)
from adibas.recordings.ports import RecordingReader
from adibas.recordings.reading import DamagedError, cannot_read, damaged_frame
from adibas.recordings.rvl import MAX_PIXELS
from adibas.recordings.source_info import info_from_texts
from adibas.recordings.tum_frames import list_frames, read_notes
from adibas.recordings.tum_lists import ListedImage
from adibas.recordings.tum_writer import CALIBRATION_FILE, NOTES_FILE

TUM_UNIT_M = 1 / 5000
"""The benchmark's own scale; it holds where neither file beside the lists says otherwise."""
DEFAULT_RATE_HZ = 30.0
MAX_IMAGE_BYTES = 1 << 28
PNG_16_BIT_GREY = (16, 0)


class TumReader(RecordingReader):
    """A folder with ``rgb.txt`` or ``depth.txt``; the lists decide what belongs to it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.notice = None
        notes = read_notes(path / NOTES_FILE)
        self._frames = list_frames(path, notes)
        self.timestamps_ns = self._frames.times_ns
        self.timestamps_ns.flags.writeable = False
        beside = path / CALIBRATION_FILE
        calibration = read_calibration(beside) if is_there(beside) else None
        self.info = _info(path, notes, calibration, self.timestamps_ns)

    def read(self, index: int) -> SensorFrame:
        """Return frame `index`, counted from 0."""
        if not 0 <= index < len(self):
            raise IndexError(f"no frame {index} among {len(self)}")
        depth, color, infrared = self._frames.images(index)
        try:
            return SensorFrame(
                sequence=int(self._frames.sequences[index]),
                timestamp_ns=int(self.timestamps_ns[index]),
                depth_raw=decode_png16(self._load(depth)) if depth else None,
                color=_encoded(self._load(color)) if color else None,
                color_timestamp_ns=color.time_ns if color else None,
                infrared_raw=decode_png16(self._load(infrared)) if infrared else None,
            )
        except OSError as error:
            raise cannot_read(f"{self._path.name}: {error.filename}", error) from error
        except DamagedError as error:
            raise damaged_frame(self._path.name, index) from error

    def _load(self, image: ListedImage) -> bytes:
        path = (self._path / image.name).resolve()
        if not path.is_relative_to(self._path.resolve()):
            raise RecordingError(
                "{file} is refused: its image {name} is a link out of the folder. Copy the image "
                "into it.",
                file=self._path.name,
                name=image.name,
            )
        with path.open("rb") as file:
            payload = file.read(MAX_IMAGE_BYTES + 1)
        if len(payload) > MAX_IMAGE_BYTES:
            raise DamagedError("the image file is too large")
        return payload

    def close(self) -> None:
        """Nothing is open between two frames."""


def decode_png16(payload: bytes) -> UInt16Array:
    """Return the (H, W) image in a 16-bit grey PNG file.

    Raises
    ------
    DamagedError
        It is no such file.
    """
    import cv2

    height, width = encoded_size(payload)
    is_png16 = payload.startswith(PNG_SIGNATURE) and tuple(payload[24:26]) == PNG_16_BIT_GREY
    is_sane = 0 < height * width <= min(MAX_PIXELS, max_pixels(payload))
    if not (is_png16 and is_sane and is_whole_image(payload)):
        raise DamagedError("no 16-bit grey PNG")
    try:
        image = cv2.imdecode(np.frombuffer(payload, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise DamagedError("the PNG is damaged") from error
    if image is None or image.dtype != np.uint16 or image.shape != (height, width):
        raise DamagedError("the PNG is damaged")
    return np.ascontiguousarray(image, np.uint16)


def _encoded(payload: bytes) -> EncodedImage:
    if payload.startswith(JPEG_SIGNATURE):
        return EncodedImage("jpeg", payload)
    if payload.startswith(PNG_SIGNATURE):
        return EncodedImage("png", payload)
    raise DamagedError("neither JPEG nor PNG")


def _info(
    path: Path,
    notes: dict[str, object],
    calibration: RgbdCalibration | None,
    times_ns: IntArray,
) -> SourceInfo:
    texts = {key: value for key, value in notes.items() if isinstance(value, str)}
    if texts:
        return replace(info_from_texts(texts, path.name), calibration=calibration)
    steps_ns = np.diff(times_ns)
    steps_ns = steps_ns[steps_ns > 0]
    rate_hz = 1e9 / float(np.median(steps_ns)) if len(steps_ns) else DEFAULT_RATE_HZ
    unit_m = TUM_UNIT_M if calibration is None else calibration.depth_unit_m
    return SourceInfo(depth_unit_m=unit_m, frame_rate_hz=rate_hz, calibration=calibration)
