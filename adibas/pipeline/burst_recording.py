"""One burst of a live sensor on its way into a recording; nothing of it is dropped."""

import queue
import threading
from collections.abc import Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import RgbdFrame, SensorFrame, SourceInfo
from adibas.errors import RecordingError
from adibas.progress import Progress
from adibas.recordings import RecordingWriter
from adibas.recordings.decoding import to_rgbd
from adibas.recordings.ports import count_gaps

QUEUE_FRAMES = 60
"""Two seconds, about 270 MB at 1280 x 1024: outlasts a pause of the disk."""


@dataclass(frozen=True, slots=True, eq=False)
class Burst:
    """Consecutive frames of one sensor, all of them in a recording as well.

    Attributes
    ----------
    frames : tuple of SensorFrame
        As the sensor gave them; none where they were written only.
    info : SourceInfo
        Of the sensor.
    calibration : RgbdCalibration or None
        In use when the burst was taken: the user's, else the sensor's.
    n_restarts : int
        How often a recording that is played in a loop began anew inside the burst.
    """

    frames: tuple[SensorFrame, ...]
    info: SourceInfo
    calibration: RgbdCalibration | None
    n_restarts: int = 0

    @property
    def timestamp_ns(self) -> int:
        """Sensor clock of the first frame."""
        return self.frames[0].timestamp_ns

    @property
    def n_dropped(self) -> int:
        """Frames between the first and the last one that the sensor counted and that lack."""
        return count_gaps(np.array([frame.sequence for frame in self.frames], np.int64))

    def __len__(self) -> int:
        return len(self.frames)

    def frame(self, index: int) -> RgbdFrame:
        """Return a frame in metres.

        Raises
        ------
        RecordingError
            It lacks depth or colour, or its colour image is damaged.
        """
        return to_rgbd(self.frames[index], self.info)

    def __iter__(self) -> Iterator[RgbdFrame]:
        return (self.frame(index) for index in range(len(self)))


class BurstRecording:
    """Takes frames from the thread that reads the sensor, and writes them in another.

    Parameters
    ----------
    n_frames : int
        At least 1.
    writer : RecordingWriter
        Open; it stays open, and is untouched once `future` is done.
    calibration : RgbdCalibration or None
        In use.
    progress : callable or None
        Told in the writer's thread of every frame that was written.
    keeps_frames : bool
        Whether the frames stay in memory for whoever looks at them next.
    """

    def __init__(
        self,
        n_frames: int,
        writer: RecordingWriter,
        calibration: RgbdCalibration | None,
        progress: Progress | None = None,
        *,
        keeps_frames: bool = True,
    ) -> None:
        if n_frames < 1:
            raise ValueError(f"a burst has one frame at least, got {n_frames}")
        self._n_frames = n_frames
        self._writer = writer
        self._calibration = calibration
        self._progress = progress or _say_nothing
        self._keeps_frames = keeps_frames
        self._queue: queue.SimpleQueue[SensorFrame | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._failure: BaseException | None = None
        self._info = SourceInfo()
        self._has_ended = False
        self._n_taken = 0
        self._n_restarts = 0
        self._future: Future[Burst] | None = None

    def start(self, pool: ThreadPoolExecutor) -> Future[Burst]:
        """Begin to write in a thread of `pool`."""
        self._future = pool.submit(self._write_all)
        return self._future

    @property
    def is_done(self) -> bool:
        """Whether its future is done."""
        return self._future is not None and self._future.done()

    @property
    def wants_more(self) -> bool:
        """Whether the next frame belongs to the burst."""
        is_open = self._failure is None and not self._has_ended
        return is_open and self._n_taken < self._n_frames

    def take(self, frame: SensorFrame, info: SourceInfo) -> None:
        """Take the next frame; never waits."""
        if not self.wants_more:
            return
        if self._queue.qsize() >= QUEUE_FRAMES:
            self.fail(
                RecordingError(
                    "The burst was stopped: {n_frames} frames wait for the disk, which is too "
                    "slow. Close other programs and take it again, with fewer frames.",
                    n_frames=QUEUE_FRAMES,
                )
            )
            return
        self._info = info
        self._n_taken += 1
        self._queue.put(frame)

    def note_restart(self) -> None:
        """Note that the recording that is played begins anew."""
        if 0 < self._n_taken < self._n_frames:
            self._n_restarts += 1

    def fail(self, error: BaseException) -> None:
        """Give up, unless every frame has come; the first error is the one that is told."""
        with self._lock:
            if not self.wants_more:
                return
            self._failure = error
        self._queue.put(None)

    def cancel(self) -> None:
        """Give up because the user wants it."""
        with self._lock:
            self._failure = self._failure or CancelledError()
        self._queue.put(None)

    def _write_all(self) -> Burst:
        frames: list[SensorFrame] = []
        try:
            for done in range(1, self._n_frames + 1):
                frame = self._next_frame()
                self._writer.write(frame)
                if self._keeps_frames:
                    frames.append(frame)
                self._progress(done, self._n_frames)
        finally:
            self._has_ended = True  # no more frames are taken
        return Burst(tuple(frames), self._info, self._calibration, self._n_restarts)

    def _next_frame(self) -> SensorFrame:
        frame = self._queue.get()
        if frame is None or self._failure is not None:
            raise self._failure or CancelledError()
        return frame


def _say_nothing(_n_frames: int, _n_expected: int) -> None:
    """Report to nobody."""
