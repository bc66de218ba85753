"""Live frames into a recording: one thread reads, one writes, and nothing is lost in silence."""

import queue
import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path

from adibas.clock import NS_PER_S
from adibas.data.frames import SensorFrame
from adibas.errors import AdibasError, SensorError
from adibas.progress import Progress
from adibas.recordings import RecordingOptions, RecordingWriter, create_recording
from adibas.recordings.part_file import nothing_kept
from adibas.sensors.ports import DepthCamera
from adibas.texts import describe, message

QUEUE_FRAMES = 60
"""Two seconds, about 270 MB at 1280 x 1024: outlasts a pause of the disk."""

POLL_S = 0.1
CLOCK_GRACE_S = 1.0
"""A sensor whose clock stands still or jumps back is stopped by the computer's, this much later."""


@dataclass(frozen=True, slots=True)
class RecordingSummary:
    """What became of a recording.

    Attributes
    ----------
    path : Path
        Where it lies.
    n_frames : int
        Frames in it.
    n_dropped : int
        Frames that the sensor counted and that are not in it: lost on the cable, or because the
        disk was too slow.
    seconds : float
        From the first frame to the end of the last one, by the sensor's clock.
    """

    path: Path
    n_frames: int
    n_dropped: int
    seconds: float


def record(
    camera: DepthCamera,
    path: Path,
    *,
    seconds: float | None = None,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
    options: RecordingOptions | None = None,
) -> RecordingSummary:
    """Record `camera` until the time is over, the source ends, `stop` is set, or Ctrl-C.

    Parameters
    ----------
    camera : DepthCamera
        Open; it is left open.
    path : Path
        Of the recording; its end chooses the format.
    seconds : float, optional
        How long, by the sensor's clock.
    progress : callable, optional
        Told ten times a second how far it is.
    stop : Event, optional
        Set it from anywhere to finish.
    options : RecordingOptions, optional
        How the frames are stored.

    Raises
    ------
    AdibasError
        The sensor was unplugged, the disk is full, ...: the recording was finished with the frames
        that had come, and the error says where it lies.
    """
    writer = create_recording(path, camera.info, options)
    transfer = _Transfer(camera, writer, seconds, stop or threading.Event())
    try:
        with writer:
            _run(transfer, writer, progress or _say_nothing)
    except AdibasError as error:
        placed = _with_place(error, path, transfer.n_written)
        if placed is error:
            raise
        raise placed from error
    return RecordingSummary(path, transfer.n_written, writer.n_dropped, transfer.duration_s())


def _run(transfer: "_Transfer", writer: RecordingWriter, progress: Progress) -> None:
    try:
        transfer.run(progress)
    finally:
        if transfer.n_written == 0:
            writer.abandon()
    if transfer.n_written == 0:
        raise SensorError("Nothing was recorded: no frame had come yet. Record for longer.")


class _Transfer:
    """Frames on their way from a camera into a file."""

    def __init__(
        self,
        camera: DepthCamera,
        writer: RecordingWriter,
        seconds: float | None,
        stop: threading.Event,
    ) -> None:
        self._camera = camera
        self._writer = writer
        self._seconds = seconds
        self._stop = stop
        self._is_read = threading.Event()
        self._is_written = threading.Event()
        self._queue: queue.Queue[SensorFrame] = queue.Queue(QUEUE_FRAMES)
        self._n_lost_last = 0
        self._first_ns: int | None = None
        self._last_ns = 0
        self._begin_s = 0.0
        self.n_written = 0

    def run(self, progress: Progress) -> None:
        """Carry frames over until the end; raise what went wrong in either thread."""
        with ThreadPoolExecutor(2, thread_name_prefix="record") as pool:
            reading = pool.submit(self._read_all)
            writing = pool.submit(self._write_all)
            self._watch([reading, writing], progress)
        self._writer.count_dropped(self._n_lost_last)
        writing.result()
        reading.result()

    def duration_s(self) -> float:
        """Return the seconds from the first frame to the end of the last one."""
        if self._first_ns is None:
            return 0.0
        period_s = 1.0 / self._camera.info.frame_rate_hz
        return (self._last_ns - self._first_ns) / NS_PER_S + period_s

    def _watch(self, threads: list[Future[None]], progress: Progress) -> None:
        """Return when both threads are done; Ctrl-C, at any moment of it, makes them finish."""
        n_expected = round((self._seconds or 0.0) * self._camera.info.frame_rate_hz)
        while True:
            try:
                while not all(thread.done() for thread in threads):
                    wait(threads, timeout=POLL_S)
                    progress(self.n_written, n_expected)
            except KeyboardInterrupt:
                self._stop.set()
            else:
                return

    def _read_all(self) -> None:
        try:
            while not (self._stop.is_set() or self._is_written.is_set()):
                frame = self._camera.read()
                if frame is None or self._is_over(frame):
                    return
                self._hand_over(frame)
        finally:
            self._is_read.set()

    def _is_over(self, frame: SensorFrame) -> bool:
        now_s = time.monotonic()
        if self._first_ns is None:
            self._first_ns, self._begin_s = frame.timestamp_ns, now_s
        if self._seconds is None:
            return False
        elapsed_s = (frame.timestamp_ns - self._first_ns) / NS_PER_S
        is_late = now_s - self._begin_s >= self._seconds + CLOCK_GRACE_S
        return elapsed_s >= self._seconds or (self._camera.is_live and is_late)

    def _hand_over(self, frame: SensorFrame) -> None:
        """Queue `frame`; a file or the simulator waits for room, a live sensor cannot."""
        while not self._is_written.is_set():
            try:
                self._queue.put(frame, timeout=0 if self._camera.is_live else POLL_S)
            except queue.Full:
                if self._camera.is_live:
                    # The next frame that is written shows the gap; at the end none comes.
                    self._n_lost_last += 1
                    return
            else:
                self._n_lost_last = 0
                return

    def _write_all(self) -> None:
        try:
            while True:
                try:
                    frame = self._queue.get(timeout=POLL_S)
                except queue.Empty:
                    if self._is_read.is_set() and self._queue.empty():
                        return
                    continue
                self._writer.write(frame)
                self._last_ns = frame.timestamp_ns
                self.n_written += 1
        finally:
            self._is_written.set()  # before everything is read: writing failed


def _with_place(error: AdibasError, path: Path, n_frames: int) -> BaseException:
    """Return `error` with where the recording lies, or as it is where there is none."""
    if n_frames == 0:
        return nothing_kept(error, path)
    is_finished = not getattr(error, "__notes__", ())
    if not is_finished:
        return error
    if "kept" in error.fields:
        if path.with_name(str(error.fields["kept"])).exists():
            return error  # the end could not be written, and the file has no other name
        return type(error)(error.message_id, **error.fields | {"kept": path.name})
    return type(error)(
        message("{problem} The {n_frames} frames that came before are kept in {path}."),
        problem=describe(error),
        n_frames=n_frames,
        path=path,
    )


def _say_nothing(_n_frames: int, _n_expected: int) -> None:
    """Report to nobody."""
