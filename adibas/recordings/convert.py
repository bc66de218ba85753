"""One recording format into another, without a change to what was measured."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from adibas.data.frames import SensorFrame
from adibas.errors import RecordingError
from adibas.progress import Progress
from adibas.recordings import create_recording, open_recording
from adibas.recordings.part_file import cannot_record, part_paths
from adibas.recordings.ports import RecordingOptions, RecordingReader


@dataclass(frozen=True, slots=True)
class ConversionSummary:
    """What was written; `notice` says what the source had lost."""

    n_frames: int
    n_dropped: int
    notice: str | None


def convert(
    source: Path,
    target: Path,
    *,
    plain: bool = False,
    progress: Progress | None = None,
) -> ConversionSummary:
    """Write the recording `source` as `target`, whose name chooses the format.

    Depth, numbers, times, unit, dropped frames and calibration stay the same; colour keeps its
    bytes where the target has its encoding, and its pixels where not. (.oni plays times in
    microseconds; the nanoseconds stand behind its end.)

    Parameters
    ----------
    plain : bool
        MCAP only: depth as 16-bit images that any Foxglove reader shows.
    progress : callable, optional
        Called with (frames done, frames in all).

    Raises
    ------
    RecordingError
        The source is damaged, the target cannot hold it, or the disk is full. No target is left.
    """
    if _is_same(source, target):
        raise RecordingError(
            "{file} cannot be converted into itself. Choose another name.", file=target.name
        )
    if plain and target.suffix.lower() != ".mcap":
        raise RecordingError(
            "{file} cannot be plain: only MCAP has two ways to keep depth. Choose a name that ends "
            "in .mcap.",
            file=target.name,
        )
    with open_recording(source) as reader:
        return write_all(reader, target, plain=plain, progress=progress)


def write_all(
    reader: RecordingReader,
    target: Path,
    *,
    plain: bool = False,
    depth_only: bool = False,
    progress: Progress | None = None,
) -> ConversionSummary:
    """Write the frames of an open recording as `target`, as `convert` does.

    Parameters
    ----------
    depth_only : bool
        Leave colour and infrared out, in which a face is seen, and frames that have nothing else.

    Raises
    ------
    RecordingError
        A frame is damaged, the target cannot hold it, or the disk is full. No target is left.
    """
    options = RecordingOptions(is_plain=plain, is_live=False)
    with create_recording(target, reader.info, options) as writer:
        for number, frame in enumerate(reader, 1):
            if not depth_only:
                writer.write(frame)
            elif frame.depth_raw is not None:
                writer.write(_depth_of(frame))
            if progress is not None:
                progress(number, len(reader))
        if depth_only and not writer.n_frames:
            raise RecordingError(
                "{file} would hold nothing: there is no depth in the recording. Export it with "
                "pictures as they are, or not at all.",
                file=target.name,
            )
    return ConversionSummary(writer.n_frames, writer.n_dropped, reader.notice)


def _depth_of(frame: SensorFrame) -> SensorFrame:
    return replace(frame, color=None, color_timestamp_ns=None, infrared_raw=None)


def remove_unfinished_copies(reader: RecordingReader, target: Path) -> None:
    """Remove what a killed process left of writing the same recording as `target`.

    Frames of another recording stay. Not for a reader of such a file itself.

    Raises
    ------
    RecordingError
        It may not be removed.
    """
    for part in part_paths(target):
        if _begins_as(part, reader):
            try:
                part.unlink()
            except OSError as error:
                raise cannot_record(part, error) from error


def _begins_as(part: Path, reader: RecordingReader) -> bool:
    """Say whether all frames of a part file are the first ones of this recording."""
    try:
        with open_recording(part) as begun:
            times_ns = begun.timestamps_ns
    except RecordingError:
        return False
    n_frames = len(times_ns)
    return n_frames > 0 and np.array_equal(times_ns, reader.timestamps_ns[:n_frames])


def _is_same(source: Path, target: Path) -> bool:
    return target.exists() and source.exists() and source.samefile(target)
