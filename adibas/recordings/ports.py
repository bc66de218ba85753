"""What every format offers: frames in by number or time, frames out one after the other."""

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Literal, Protocol, Self

from adibas.arrays import IntArray
from adibas.errors import AdibasError, RecordingError
from adibas.recordings.part_file import nothing_kept

if TYPE_CHECKING:  # the store needs no array before it opens a recording
    from adibas.data.frames import SensorFrame, SourceInfo


class RecordingReader(Protocol):
    """A recording on the disk, larger than memory perhaps; for one thread at a time.

    Attributes
    ----------
    info : SourceInfo
        What holds for every frame; `n_dropped` counts what the sensor gave and the file lacks.
    timestamps_ns : (N,) int64 array
        `SensorFrame.timestamp_ns` of every frame, in the order of the file.
    notice : str or None
        A sentence for the user about what was lost of a cut file.
    """

    info: "SourceInfo"
    timestamps_ns: IntArray
    notice: str | None

    @abstractmethod
    def read(self, index: int) -> "SensorFrame":
        """Return frame `index`, counted from 0.

        Raises
        ------
        IndexError
            There is no such frame.
        RecordingError
            The frame is damaged, or the file cannot be read any more.
        """

    @abstractmethod
    def close(self) -> None:
        """Let go of the file."""

    def read_at(self, timestamp_ns: int) -> "SensorFrame":
        """Return the frame nearest to `timestamp_ns`; of two equally near the earlier one."""
        times_ns = self.timestamps_ns
        if len(times_ns) == 0:
            raise IndexError("the recording has no frames")
        wanted_ns = min(max(timestamp_ns, int(times_ns.min())), int(times_ns.max()))
        return self.read(int(abs(times_ns - wanted_ns).argmin()))

    def __len__(self) -> int:
        return len(self.timestamps_ns)

    def __iter__(self) -> "Iterator[SensorFrame]":
        return (self.read(index) for index in range(len(self)))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


@dataclass(frozen=True, slots=True)
class RecordingOptions:
    """How a recording is written.

    Attributes
    ----------
    color : "png" or "jpeg"
        How colour that comes as an array is stored: without loss (the default, for measuring) or
        small (for long recordings). Colour that comes encoded is kept byte by byte.
    jpeg_quality : int
        1-100; 95 changes a colour by about one grey level.
    is_plain : bool
        MCAP only: depth as plain 16-bit images that any Foxglove reader shows.
    is_live : bool
        After an exception keep what is whole (a sensor's frames come once) instead of removing it.
    """

    color: Literal["png", "jpeg"] = "png"
    jpeg_quality: int = 95
    is_plain: bool = False
    is_live: bool = True

    def __post_init__(self) -> None:
        if self.color not in ("png", "jpeg") or not 1 <= self.jpeg_quality <= 100:  # noqa: PLR2004
            raise ValueError(f"no such colour: {self.color}, quality {self.jpeg_quality}")


class RecordingWriter(Protocol):
    """A recording in the making; `path` gets its name when the recording is whole.

    As a context manager it is closed at the end. After an exception a live recording is closed
    too, with the frames that it has; any other is abandoned.
    """

    path: Path
    options: RecordingOptions
    n_frames: int

    @property
    @abstractmethod
    def n_dropped(self) -> int:
        """Frames that the sensor counted and that are not in the file, up to now."""

    @abstractmethod
    def write(self, frame: "SensorFrame") -> None:
        """Append `frame`.

        Raises
        ------
        RecordingError
            The disk is full, or the format cannot hold the frame; what is written stays readable.
        """

    @abstractmethod
    def count_dropped(self, n_frames: int) -> None:
        """Note frames that were lost without a gap in the sensor's count."""

    @abstractmethod
    def close(self) -> None:
        """Finish the recording and give it its name; a second call does nothing."""

    @abstractmethod
    def abandon(self) -> None:
        """Remove everything that was written."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self.options.is_live and error is not None:
            self._close_after(error)
        elif error is None:
            self._close_or_abandon()
        else:
            self.abandon()
            told = nothing_kept(error, self.path)
            if told is not error:
                raise told from error

    def _close_or_abandon(self) -> None:
        """Leave no unfinished file that can be made again."""
        try:
            self.close()
        except AdibasError as error:
            if self.options.is_live:
                raise
            self.abandon()
            raise nothing_kept(error, self.path) from error

    def _close_after(self, error: BaseException) -> None:
        """Keep what is whole; the first error is the one that the user must hear of."""
        try:
            self.close()
        except AdibasError as second:
            error.add_note(str(second))


class DropCount:
    """Counts frames that the sensor counted and that never came."""

    def __init__(self, n_known: int = 0) -> None:
        self._n_known = n_known
        self._n_missed = 0
        self._last_sequence: int | None = None

    def see(self, sequence: int) -> None:
        """Note that frame `sequence` came; a count that starts anew is no gap."""
        if self._last_sequence is not None and sequence > self._last_sequence:
            self._n_missed += sequence - self._last_sequence - 1
        self._last_sequence = sequence

    def add(self, n_frames: int) -> None:
        """Note frames that were lost without a gap."""
        if n_frames < 0:
            raise ValueError(f"n_frames must not be negative: {n_frames}")
        self._n_missed += n_frames

    @property
    def total(self) -> int:
        """What the source said at the beginning, or what was seen since, if that is more."""
        return max(self._n_known, self._n_missed)


def count_gaps(sequences: IntArray) -> int:
    """Return how many numbers are missing in the (N,) `sequences`."""
    steps = sequences[1:] - sequences[:-1]
    return int((steps[steps > 0] - 1).sum())


MAX_SEQUENCE = 2**32 - 1
MAX_TIMESTAMP_NS = 2**63 - 1


def check_frame(frame: "SensorFrame", file: str) -> None:
    """Refuse numbers that the formats cannot hold."""
    if frame.depth_raw is None and frame.color is None and frame.infrared_raw is None:
        raise ValueError("a frame needs an image")
    times_ns = (frame.timestamp_ns, frame.color_timestamp_ns or 0)
    if not (
        0 <= frame.sequence <= MAX_SEQUENCE and all(0 <= t <= MAX_TIMESTAMP_NS for t in times_ns)
    ):
        raise RecordingError(
            "{file} cannot hold frame {sequence} at {timestamp_ns} ns: its number must be below "
            "2^32 and its time must not be negative. Restart the sensor and record again.",
            file=file,
            sequence=frame.sequence,
            timestamp_ns=frame.timestamp_ns,
        )
