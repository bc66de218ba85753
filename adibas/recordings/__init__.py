"""Recordings of a depth camera: the native MCAP, OpenNI2's .oni and TUM RGB-D folders.

The functions load the format that they need when they are called.
"""

from pathlib import Path
from typing import TYPE_CHECKING

from adibas.errors import RecordingError
from adibas.files import is_there
from adibas.recordings.part_file import part_path_of
from adibas.recordings.ports import RecordingOptions, RecordingReader, RecordingWriter
from adibas.recordings.reading import cannot_read

if TYPE_CHECKING:  # the store needs no array before it opens a recording
    from adibas.data.frames import SourceInfo

MCAP_MAGIC = b"\x89MCAP0\r\n"
ONI_MAGIC = b"NI10"
TUM_LISTS = ("depth.txt", "rgb.txt", "infrared.txt")
RECORDING_ENDINGS = (".mcap", ".oni")


def is_named_like_recording(path: Path) -> bool:
    """Say whether a name promises a recording; what it is, its content tells."""
    return path.suffix.lower() in RECORDING_ENDINGS


def open_recording(path: Path) -> RecordingReader:
    """Open a recording; its content tells the format, not its name.

    Raises
    ------
    RecordingError
        There is no such file, or it is no recording, or it is damaged.
    """
    if _is_tum_folder(path):
        from adibas.recordings.tum_reader import TumReader

        return TumReader(path)
    head = _first_bytes(path)
    if head == MCAP_MAGIC:
        from adibas.recordings.mcap_reader import McapReader

        return McapReader(path)
    if head.startswith(ONI_MAGIC):
        from adibas.recordings.oni_reader import OniReader

        return OniReader(path)
    raise RecordingError(
        "{file} is no recording. Choose an .mcap or .oni file, or a folder with rgb.txt or "
        "depth.txt.",
        file=path.name or str(path),
    )


def _is_tum_folder(path: Path) -> bool:
    try:
        return any((path / name).is_file() for name in TUM_LISTS)
    except OSError as error:
        raise cannot_read(path.name, error) from error


def _first_bytes(path: Path) -> bytes:
    """Return the beginning of a file, nothing of a folder."""
    if not is_there(path) and is_there(part_path_of(path)):
        raise RecordingError(
            "{file} was never finished. What was recorded of it is in {part}: open that file.",
            file=path.name,
            part=part_path_of(path).name,
        )
    try:
        if path.is_dir():
            return b""
        with path.open("rb") as file:
            return file.read(len(MCAP_MAGIC))
    except OSError as error:
        raise cannot_read(path.name, error) from error


def create_recording(
    path: Path, info: "SourceInfo", options: RecordingOptions | None = None
) -> RecordingWriter:
    """Begin a recording; the end of its name chooses the format, none means a TUM folder.

    Raises
    ------
    RecordingError
        The format does not exist or cannot hold such frames, or the place cannot be written.
    """
    chosen = options or RecordingOptions()
    suffix = path.suffix.lower()
    if suffix == ".mcap":
        from adibas.recordings.mcap_writer import McapWriter

        return McapWriter(path, info, chosen)
    if suffix == ".oni":
        from adibas.recordings.oni_writer import OniWriter

        return OniWriter(path, info, chosen)
    if not suffix:
        from adibas.recordings.tum_writer import TumWriter

        return TumWriter(path, info, chosen)
    raise RecordingError(
        "{file} cannot be written: its format is unknown. Choose a name that ends in .mcap or "
        ".oni, or a folder's name without an ending.",
        file=path.name,
    )


__all__ = [
    "RecordingOptions",
    "RecordingReader",
    "RecordingWriter",
    "create_recording",
    "open_recording",
]
