"""The lists of a TUM RGB-D folder: ``timestamp filename`` a line, ``#`` before comments.

Source: TUM RGB-D benchmark, file formats. Times are decimal seconds; they are kept to the
nanosecond and never pass through a floating-point number.
"""

from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import NamedTuple

import numpy as np

from adibas.arrays import IntArray
from adibas.clock import NS_PER_S
from adibas.errors import RecordingError
from adibas.files import is_there
from adibas.recordings.ports import MAX_TIMESTAMP_NS
from adibas.recordings.tum_regular import N_DECIMALS, parse_regular

MAX_LIST_BYTES = 64 * 1024 * 1024
DEPTH_LIST, COLOR_LIST, INFRARED_LIST = "depth.txt", "rgb.txt", "infrared.txt"


class ListedImage(NamedTuple):
    """One line of a list: when (ns), and which file of the folder."""

    time_ns: int
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class ImageList:
    """A whole list.

    Attributes
    ----------
    times_ns : (N,) array
    names : list of str
        Each once.
    """

    times_ns: IntArray
    names: list[str]

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, index: int) -> ListedImage:
        return ListedImage(int(self.times_ns[index]), self.names[index])


def format_list(title: str, images: list[ListedImage]) -> str:
    """Return the text of a list."""
    lines = [f"# {title}", "# timestamp filename"]
    lines += [
        f"{image.time_ns // NS_PER_S}.{image.time_ns % NS_PER_S:09d} {image.name}"
        for image in images
    ]
    return "\n".join(lines) + "\n"


def read_list(folder: Path, name: str) -> ImageList:
    """Return the lines of the list `name`; nothing if there is no such list.

    A name that is listed twice keeps its first place and gets its last time.

    Raises
    ------
    RecordingError
        The list cannot be read, a line makes no sense, or it points out of the folder.
    """
    data = _read_bytes(folder, name)
    times_ns, names = parse_regular(data) or _parse_lines(data, folder, name)
    last_place = dict(zip(names, range(len(names)), strict=True))
    if len(last_place) == len(names):
        return ImageList(times_ns, names)
    return ImageList(times_ns[list(last_place.values())], list(last_place))


def _read_bytes(folder: Path, name: str) -> bytes:
    path = folder / name
    if not is_there(path):
        return b""
    try:
        if path.stat().st_size > MAX_LIST_BYTES:
            raise _bad_list(folder, name, 1)
        return path.read_bytes()
    except OSError as error:
        raise RecordingError(
            "{file} cannot be read: {reason}. Check the folder.",
            file=f"{folder.name}/{name}",
            reason=error.strerror or str(error),
        ) from error


def _parse_lines(data: bytes, folder: Path, name: str) -> tuple[IntArray, list[str]]:
    """Return times and names one line after the other, or refuse the first bad line."""
    images = []
    for number, line in enumerate(data.decode("utf-8", "replace").splitlines(), 1):
        parts = line.split(maxsplit=2)
        if parts and parts[0][0] != "#":
            image = _parse_line(parts)
            if image is None:
                raise _bad_list(folder, name, number)
            images.append(image)
    times_ns = np.array([image.time_ns for image in images], np.int64)
    return times_ns, [image.name for image in images]


def _parse_line(parts: list[str]) -> ListedImage | None:
    if len(parts) < 2 or not parts[0].isascii() or not _stays_inside(parts[1]):  # noqa: PLR2004  (time and name)
        return None
    time_ns = _parse_time_ns(parts[0])
    return None if time_ns is None else ListedImage(time_ns, parts[1])


def _parse_time_ns(text: str) -> int | None:
    """Return decimal seconds as nanoseconds; None where that is no time."""
    whole, _, decimals = text.partition(".")
    if whole.isdecimal() and (decimals + "0").isdecimal():
        time_ns = int(whole[:20]) * NS_PER_S + int(decimals[:N_DECIMALS].ljust(N_DECIMALS, "0"))
        return time_ns if time_ns <= MAX_TIMESTAMP_NS and len(whole) <= len("9223372036") else None
    try:
        time_s = Decimal(text)
    except InvalidOperation:
        return None
    if not (time_s.is_finite() and 0 <= time_s < Decimal(MAX_TIMESTAMP_NS) / NS_PER_S):
        return None
    return int(time_s * NS_PER_S)


def _stays_inside(name: str) -> bool:
    """Say whether the path `name` is relative and never goes up."""
    is_windows_path = "\\" in name or ":" in name
    goes_up = name[0] == "/" or (".." in name and ".." in name.split("/"))
    return not (goes_up or is_windows_path or "\0" in name)


def _bad_list(folder: Path, name: str, line: int) -> RecordingError:
    return RecordingError(
        "{file} cannot be read: line {line} is no time and file name of this folder. Correct it, "
        "or remove it.",
        file=f"{folder.name}/{name}",
        line=line,
    )
