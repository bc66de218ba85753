"""Several recordings of one camera, one after another, as a single one: hours in pieces."""

from bisect import bisect_right
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace

import numpy as np

from adibas.clock import NS_PER_S
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.recordings.ports import RecordingReader

SEAM_NS = NS_PER_S
"""From the last frame of a part to the first of the next one: longer than any gap that is bridged,
so that nothing is found across it. How long the camera really rested is left aside, since that
time was not observed."""


class JoinedRecording(RecordingReader):
    """Frames of all parts on the clock of the first one; closes the parts with itself.

    Parameters
    ----------
    parts : sequence of RecordingReader
        One at least, in the order of time.
    names : sequence of str
        Of the parts, for errors.

    Raises
    ------
    RecordingError
        A part has no frames, or is of another camera.
    """

    def __init__(self, parts: Sequence[RecordingReader], names: Sequence[str]) -> None:
        self._parts = tuple(parts)
        first = parts[0].info
        for part, name in zip(parts, names, strict=True):
            _check(part, name, first)
        self.info = replace(first, n_dropped=sum(part.info.n_dropped for part in parts))
        self._shifts_ns = _shifts_ns(parts)
        self.timestamps_ns = np.concatenate(
            [
                np.asarray(part.timestamps_ns, np.int64) + shift_ns
                for part, shift_ns in zip(parts, self._shifts_ns, strict=True)
            ]
        )
        lengths = np.cumsum([0, *(len(part) for part in parts)])
        self._begins = [int(begin) for begin in lengths[:-1]]
        notices = [part.notice for part in parts if part.notice]
        self.notice = " ".join(notices) or None

    @property
    def begins_ns(self) -> tuple[int, ...]:
        """When each part begins, on the clock of the whole."""
        return tuple(
            int(np.min(part.timestamps_ns)) + shift_ns
            for part, shift_ns in zip(self._parts, self._shifts_ns, strict=True)
        )

    def read(self, index: int) -> SensorFrame:
        """Return frame `index`, counted from 0 over all parts.

        Raises
        ------
        IndexError
            There is no such frame.
        RecordingError
            The frame is damaged, or a file cannot be read any more.
        """
        if not 0 <= index < len(self):
            raise IndexError(f"frame {index} of {len(self)}")
        number = bisect_right(self._begins, index) - 1
        frame = self._parts[number].read(index - self._begins[number])
        shift_ns, color_ns = self._shifts_ns[number], frame.color_timestamp_ns
        return replace(
            frame,
            sequence=index,
            timestamp_ns=frame.timestamp_ns + shift_ns,
            color_timestamp_ns=None if color_ns is None else color_ns + shift_ns,
        )

    def close(self) -> None:
        """Let go of all files, also where one of them fails."""
        with ExitStack() as parts:
            for part in self._parts:
                parts.callback(part.close)


def begins_ns_of(reader: RecordingReader) -> tuple[int, ...]:
    """Return when each part of a recording begins; of a single one nothing."""
    return reader.begins_ns if isinstance(reader, JoinedRecording) else ()


def _shifts_ns(parts: Sequence[RecordingReader]) -> list[int]:
    shifts_ns = [0]
    end_ns = int(np.max(parts[0].timestamps_ns))
    for part in parts[1:]:
        shift_ns = end_ns + SEAM_NS - int(np.min(part.timestamps_ns))
        shifts_ns.append(shift_ns)
        end_ns = int(np.max(part.timestamps_ns)) + shift_ns
    return shifts_ns


def _check(part: RecordingReader, name: str, first: SourceInfo) -> None:
    if not len(part):
        raise RecordingError("{file} has no frames. Choose another recording.", file=name)
    if _camera(part.info) != _camera(first):
        raise RecordingError(
            "{file} is of another camera than the recording before it, or was calibrated anew: "
            "they cannot be watched as one. Open it by itself.",
            file=name,
        )


def _camera(info: SourceInfo) -> tuple[object, ...]:
    """Return what depth means: where its pixels look, and how far its counts reach."""
    known = info.calibration
    depth = None if known is None else (known.depth, known.depth_bias)
    return info.sensor_serial, info.depth_unit_m, info.is_depth_registered, depth
