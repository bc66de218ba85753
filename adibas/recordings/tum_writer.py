"""Writes TUM RGB-D folders: lists, images, and beside them what the format has no place for."""

import json
import os
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

from adibas.calibration.files import write_calibration
from adibas.data.frames import EncodedImage, SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.files import is_there
from adibas.recordings.decoding import encode_color, encode_png
from adibas.recordings.part_file import cannot_record
from adibas.recordings.ports import DropCount, RecordingOptions, RecordingWriter, check_frame
from adibas.recordings.source_info import calibration_to_keep, info_to_texts
from adibas.recordings.tum_lists import (
    COLOR_LIST,
    DEPTH_LIST,
    INFRARED_LIST,
    ListedImage,
    format_list,
)

NOTES_FILE = "adibas.json"
CALIBRATION_FILE = "calibration.json"
NOTED = ("sequence", "timestamp_ns", "depth", "color", "infrared")
"""Of each frame, one column each; columns are read several times as fast as rows."""
TITLES = {
    DEPTH_LIST: "depth images, 16-bit PNG",
    COLOR_LIST: "colour images",
    INFRARED_LIST: "infrared images, 16-bit PNG",
}


class TumWriter(RecordingWriter):
    """A folder in the making, hidden beside its place until it is whole."""

    def __init__(self, path: Path, info: SourceInfo, options: RecordingOptions) -> None:
        self.path = path
        self.options = options
        self.n_frames = 0
        self._info = info
        self._drops = DropCount(info.n_dropped)
        self._lists: dict[str, list[ListedImage]] = {name: [] for name in TITLES}
        self._frames: list[tuple[int | str | None, ...]] = []
        self._is_open = True
        if is_there(path) and not (path.is_dir() and not any(path.iterdir())):
            raise RecordingError(
                "The folder {file} exists already and is not empty. Choose another name.",
                file=path.name,
            )
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._part = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
        except OSError as error:
            raise cannot_record(path, error) from error

    @property
    def n_dropped(self) -> int:
        """Frames that the sensor counted and that are not in the folder, up to now."""
        return self._drops.total

    def count_dropped(self, n_frames: int) -> None:
        """Note frames that were lost without a gap in the sensor's count."""
        self._drops.add(n_frames)

    def write(self, frame: SensorFrame) -> None:
        """Append `frame`."""
        check_frame(frame, self.path.name)
        number = f"{self.n_frames:06d}"
        names: list[str | None] = [None, None, None]
        if frame.depth_raw is not None:
            payload = encode_png(frame.depth_raw)
            names[0] = self._add(DEPTH_LIST, f"depth/{number}.png", frame.timestamp_ns, payload)
        if frame.color is not None and frame.color_timestamp_ns is not None:
            image = encode_color(frame.color, self.options)
            name = f"rgb/{number}.{_suffix(image)}"
            names[1] = self._add(COLOR_LIST, name, frame.color_timestamp_ns, image.payload)
        if frame.infrared_raw is not None:
            payload = encode_png(frame.infrared_raw)
            name = f"infrared/{number}.png"
            names[2] = self._add(INFRARED_LIST, name, frame.timestamp_ns, payload)
        self._frames.append((frame.sequence, frame.timestamp_ns, *names))
        self._drops.see(frame.sequence)
        self.n_frames += 1

    def _add(self, list_name: str, name: str, time_ns: int, payload: bytes) -> str:
        """Write one image and list it; return its name."""
        self._write_image(name, payload)
        self._lists[list_name].append(ListedImage(time_ns, name))
        return name

    def _write_image(self, name: str, payload: bytes) -> None:
        path = self._part / name
        try:
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(payload)
        except OSError as error:
            raise cannot_record(self.path, error) from error

    def close(self) -> None:
        """Write the lists and give the folder its name."""
        if not self._is_open:
            return
        self._is_open = False
        try:
            self._write_texts()
            calibration = calibration_to_keep(self._info)
            if calibration is not None:
                write_calibration(self._part / CALIBRATION_FILE, calibration)
            self._part.chmod(0o777 & ~_umask())
            self._part.replace(self.path)
        except OSError as error:
            raise cannot_record(self.path, error) from error
        finally:
            shutil.rmtree(self._part, ignore_errors=True)

    def _write_texts(self) -> None:
        for name, images in self._lists.items():
            if images:
                text = format_list(TITLES[name], images)
                (self._part / name).write_text(text, encoding="utf-8")
        info = replace(self._info, calibration=None, n_dropped=self.n_dropped)
        columns = zip(*self._frames, strict=True) if self._frames else ([] for _ in NOTED)
        notes = {**info_to_texts(info), "frames": dict(zip(NOTED, columns, strict=True))}
        (self._part / NOTES_FILE).write_text(json.dumps(notes), encoding="utf-8")

    def abandon(self) -> None:
        """Remove everything that was written."""
        self._is_open = False
        shutil.rmtree(self._part, ignore_errors=True)


def _suffix(image: EncodedImage) -> str:
    return "jpg" if image.encoding == "jpeg" else "png"


def _umask() -> int:
    """Return the permissions that a new folder must not have; mkdtemp gives fewer."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
