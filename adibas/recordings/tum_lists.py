"""The lists of a TUM RGB-D folder: ``timestamp filename`` a line, ``#`` before comments.

Source: TUM RGB-D benchmark, file formats. Times are decimal seconds; they are kept to the
nanosecond and never pass through a floating-point number.
"""

from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import NamedTuple

from adibas.errors import RecordingError
from adibas.recordings.ports import MAX_TIMESTAMP_NS

NS_PER_S = 1_000_000_000
N_DECIMALS = 9
MAX_LIST_BYTES = 64 * 1024 * 1024
DEPTH_LIST, COLOR_LIST, INFRARED_LIST = "depth.txt", "rgb.txt", "infrared.txt"


class ListedImage(NamedTuple):
    """One line of a list: when (ns), and which file of the folder."""

    time_ns: int
    name: str


def format_list(title: str, images: list[ListedImage]) -> str:
    """Return the text of a list."""
    lines = [f"# {title}", "# timestamp filename"]
    lines += [
        f"{image.time_ns // NS_PER_S}.{image.time_ns % NS_PER_S:09d} {image.name}"
        for image in images
    ]
    return "\n".join(lines) + "\n"


def read_list(folder: Path, name: str) -> list[ListedImage]:
    """Return the lines of the list `name`; nothing if there is no such list.

    Raises
    ------
    RecordingError
        The list cannot be read, a line makes no sense, or it points out of the folder.
    """
    path = folder / name
    if not path.is_file():
        return []
    try:
        if path.stat().st_size > MAX_LIST_BYTES:
            raise _bad_list(folder, name, 1)
        lines = path.read_bytes().decode("utf-8", "replace").splitlines()
    except OSError as error:
        raise RecordingError(
            "{file} cannot be read: {reason}. Check the folder.",
            file=f"{folder.name}/{name}",
            reason=error.strerror or str(error),
        ) from error
    images = []
    for number, line in enumerate(lines, 1):
        parts = line.split(maxsplit=2)
        if parts and parts[0][0] != "#":
            image = _parse_line(parts)
            if image is None:
                raise _bad_list(folder, name, number)
            images.append(image)
    return images


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
