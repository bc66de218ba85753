"""Reads TUM RGB-D folders: our own, those of the benchmark, and others written like them."""

import json
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from adibas.arrays import UInt16Array
from adibas.calibration.files import read_calibration
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.recordings.association import associate
from adibas.recordings.decoding import (
    JPEG_SIGNATURE,
    PNG_SIGNATURE,
    encoded_size,
    is_whole_image,
    max_pixels,
)
from adibas.recordings.ports import MAX_SEQUENCE, MAX_TIMESTAMP_NS, RecordingReader
from adibas.recordings.reading import DamagedError, cannot_read, damaged_frame
from adibas.recordings.rvl import MAX_PIXELS
from adibas.recordings.source_info import info_from_texts
from adibas.recordings.tum_lists import (
    COLOR_LIST,
    DEPTH_LIST,
    INFRARED_LIST,
    ListedImage,
    read_list,
)
from adibas.recordings.tum_writer import CALIBRATION_FILE, NOTES_FILE

TUM_UNIT_M = 1 / 5000
"""The benchmark's own scale; it holds where neither file beside the lists says otherwise."""
DEFAULT_RATE_HZ = 30.0
MAX_NOTES_BYTES = 64 * 1024 * 1024
MAX_IMAGE_BYTES = 1 << 28
PNG_16_BIT_GREY = (16, 0)


class _Frame(NamedTuple):
    sequence: int
    time_ns: int
    depth: ListedImage | None
    color: ListedImage | None
    infrared: ListedImage | None


class TumReader(RecordingReader):
    """A folder with ``rgb.txt`` or ``depth.txt``; the lists decide what belongs to it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.notice = None
        notes = _read_notes(path / NOTES_FILE)
        self._frames = _frames(path, notes)
        times_ns = [frame.time_ns for frame in self._frames]
        self.timestamps_ns = np.array(times_ns, np.int64)
        self.timestamps_ns.flags.writeable = False
        beside = path / CALIBRATION_FILE
        calibration = read_calibration(beside) if beside.is_file() else None
        self.info = _info(path, notes, calibration, self.timestamps_ns)

    def read(self, index: int) -> SensorFrame:
        """Return frame `index`, counted from 0."""
        if not 0 <= index < len(self._frames):
            raise IndexError(f"no frame {index} among {len(self._frames)}")
        frame = self._frames[index]
        try:
            return SensorFrame(
                sequence=frame.sequence,
                timestamp_ns=frame.time_ns,
                depth_raw=decode_png16(self._load(frame.depth)) if frame.depth else None,
                color=_encoded(self._load(frame.color)) if frame.color else None,
                color_timestamp_ns=frame.color.time_ns if frame.color else None,
                infrared_raw=decode_png16(self._load(frame.infrared)) if frame.infrared else None,
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


def _read_notes(path: Path) -> dict[str, object]:
    """Return what our writer noted; nothing in folders of others."""
    if not path.is_file():
        return {}
    try:
        with path.open("rb") as file:
            notes = json.loads(file.read(MAX_NOTES_BYTES))
    except OSError as error:
        raise cannot_read(path.name, error) from error
    except (ValueError, RecursionError) as error:
        raise _bad_notes() from error
    if not isinstance(notes, dict):
        raise _bad_notes()
    return notes


def _bad_notes() -> RecordingError:
    return RecordingError(
        "{file} is damaged. Restore it from a copy, or remove it: then frames are numbered anew.",
        file=NOTES_FILE,
    )


def _frames(path: Path, notes: dict[str, object]) -> list[_Frame]:
    """Return the frames of the lists: first as the notes pair them, the rest by time."""
    depth = {image.name: image for image in read_list(path, DEPTH_LIST)}
    color = {image.name: image for image in read_list(path, COLOR_LIST)}
    infrared = {image.name: image for image in read_list(path, INFRARED_LIST)}
    frames = []
    rows = notes.get("frames", [])
    for row in rows if isinstance(rows, list) else ():
        if not _is_row(row):
            raise _bad_notes()
        sequence, noted_ns, *names = row
        lists = (depth, color, infrared)
        images = [listed.pop(name, None) for listed, name in zip(lists, names, strict=True)]
        if any(images):
            of_depth = images[0] or images[2]
            time_ns = noted_ns if of_depth is None else of_depth.time_ns
            frames.append(_Frame(sequence, time_ns, *images))
    frames += _pair_by_time(list(depth.values()), list(color.values()), len(frames))
    return frames


def _is_row(row: object) -> bool:
    """Say whether `row` is (sequence, time in ns, three names or None)."""
    if not (isinstance(row, list) and len(row) == 5):  # noqa: PLR2004
        return False
    sequence, time_ns, *names = row
    are_numbers = isinstance(sequence, int) and isinstance(time_ns, int)
    in_range = are_numbers and 0 <= sequence <= MAX_SEQUENCE and 0 <= time_ns <= MAX_TIMESTAMP_NS
    return in_range and all(name is None or isinstance(name, str) for name in names)


def _pair_by_time(
    depth: list[ListedImage], color: list[ListedImage], first_sequence: int
) -> list[_Frame]:
    pairs = associate(
        np.array([image.time_ns for image in depth], np.int64),
        np.array([image.time_ns for image in color], np.int64),
    )
    frames = []
    for number, (i, j) in enumerate(pairs):
        of_depth = None if i is None else depth[i]
        of_color = None if j is None else color[j]
        first = of_depth or of_color
        time_ns = 0 if first is None else first.time_ns
        frames.append(_Frame(first_sequence + number, time_ns, of_depth, of_color, None))
    return frames


def _info(
    path: Path,
    notes: dict[str, object],
    calibration: RgbdCalibration | None,
    times_ns: np.ndarray[tuple[int], np.dtype[np.int64]],
) -> SourceInfo:
    texts = {key: value for key, value in notes.items() if isinstance(value, str)}
    if texts:
        return replace(info_from_texts(texts, path.name), calibration=calibration)
    steps_ns = np.diff(times_ns)
    steps_ns = steps_ns[steps_ns > 0]
    rate_hz = 1e9 / float(np.median(steps_ns)) if len(steps_ns) else DEFAULT_RATE_HZ
    unit_m = TUM_UNIT_M if calibration is None else calibration.depth_unit_m
    return SourceInfo(depth_unit_m=unit_m, frame_rate_hz=rate_hz, calibration=calibration)
