"""What all readers say when a file, or a frame of it, cannot be read."""

from pathlib import Path
from typing import BinaryIO

from adibas.errors import RecordingError
from adibas.texts import translate_plural


class DamagedError(ValueError):
    """Some bytes make no sense; a reader turns it into a sentence with the file's name."""


def open_to_read(path: Path) -> BinaryIO:
    """Open the file `path`, or say in words why that fails."""
    try:
        return path.open("rb")
    except OSError as error:
        raise cannot_read(path.name, error) from error


def cannot_read(file: str, error: OSError) -> RecordingError:
    """Say why the file cannot be read."""
    return RecordingError(
        "{file} cannot be read: {reason}. Check the name, and that the disk is connected.",
        file=file,
        reason=error.strerror or str(error),
    )


def no_whole_frame(file: str) -> RecordingError:
    """Say that the file was cut before its first frame ended."""
    return RecordingError("{file} holds no whole frame. Record the session again.", file=file)


def damaged_frame(file: str, index: int) -> RecordingError:
    """Say which frame (counted from 0) is damaged."""
    return RecordingError(
        "Frame {index} of {file} is damaged. Leave it out, or restore the file from a copy.",
        file=file,
        index=index,
    )


def describe_loss(file: str, n_lost_bytes: int, n_frames: int) -> str:
    """Return the notice of a recording that was cut."""
    if n_lost_bytes == 0:
        text = translate_plural(
            "The recording of {file} was interrupted; its {n_frames} frame is there.",
            "The recording of {file} was interrupted; all its {n_frames} frames are there.",
            n_frames,
        )
    else:
        text = translate_plural(
            "{file} is cut: its last {n_bytes} bytes are no whole frame and are left out. The "
            "{n_frames} frame before them is there.",
            "{file} is cut: its last {n_bytes} bytes are no whole frame and are left out. The "
            "{n_frames} frames before them are there.",
            n_frames,
        )
    return text.format(file=file, n_bytes=n_lost_bytes, n_frames=n_frames)
