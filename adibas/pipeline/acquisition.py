"""The thread that reads a sensor: it only reads, hands over, and tries again what was lost."""

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from adibas.clock import NS_PER_S
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import AdibasError, SensorError
from adibas.pipeline.live_frames import SensorKind, SensorState
from adibas.recordings.ports import DropCount
from adibas.recordings.reading import no_whole_frame
from adibas.sensors.pace import Pacer
from adibas.sensors.ports import READ_TIMEOUT_S, DepthCamera, SensorOptions

Opener: TypeAlias = Callable[[str, SensorOptions], DepthCamera]

RETRY_S = 1.0
SILENCE_S = 1.0
"""A sensor that has given frames and gives none for so long is lost."""

SLICE_S = 0.25
"""`close` waits so long, at most, for a sensor that has not given its first frame."""

RATE_SPAN_S = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Arrival:
    """A frame as it came, the source that it is of, and how well frames come."""

    frame: SensorFrame
    info: SourceInfo
    frame_rate_hz: float
    n_dropped: int


@dataclass(frozen=True, slots=True)
class Source:
    """What is read.

    Attributes
    ----------
    text : str
        As `open_source` takes it.
    options : SensorOptions
        `is_paced` is left aside: everything is paced here.
    is_looping : bool
        Whether a recording begins anew at its end.
    """

    text: str
    options: SensorOptions
    is_looping: bool = True


class Acquisition:
    """Reads one source until it is stopped.

    Parameters
    ----------
    source : Source
        What to read.
    opener : callable
        Opens it, every time anew.
    arrive : callable
        Takes every `Arrival`; must not wait.
    tell : callable
        Takes every new `SensorState`.
    restart : callable
        Called where a recording begins anew.
    stop : Event
        Ends `run` soon after it is set.
    """

    def __init__(
        self,
        source: Source,
        opener: Opener,
        arrive: Callable[[Arrival], None],
        tell: Callable[[SensorState], None],
        restart: Callable[[], None],
        stop: threading.Event,
    ) -> None:
        self._source = source
        self._opener = opener
        self._arrive = arrive
        self._tell = tell
        self._restart = restart
        self._stop = stop
        self._told: tuple[SensorKind, str] = ("opening", "")
        self._rate = _RateMeter()
        self._n_dropped = 0
        self._end_ns: int | None = None
        self._next_sequence = 0

    def run(self) -> None:
        """Read until `stop` is set."""
        self._tell(SensorState("opening"))
        while not self._stop.is_set():
            try:
                has_ended = self._read_once()
            except SensorError as error:
                self._report("lost", error)
                self._rate = _RateMeter()
                self._stop.wait(RETRY_S)
            except AdibasError as error:
                self._report("ended", error)
                self._stop.wait()
            else:
                if has_ended:
                    self._finish()

    def _finish(self) -> None:
        """Begin anew, or wait for the end."""
        if self._end_ns is not None and self._source.is_looping:
            self._restart()
            return
        is_empty = self._end_ns is None
        self._report("ended", no_whole_frame(Path(self._source.text).name) if is_empty else None)
        self._stop.wait()

    def _report(
        self, kind: SensorKind, error: AdibasError | None, info: SourceInfo | None = None
    ) -> None:
        """Tell a state unless it is the one that was told last."""
        told = (kind, str(error or ""))
        if told != self._told and not self._stop.is_set():
            self._told = told
            self._tell(SensorState(kind, error, info))

    def _read_once(self) -> bool:
        """Read from opening to the end; return whether the end is the source's own."""
        options = replace(self._source.options, is_paced=False)
        with self._opener(self._source.text, options) as camera:
            if self._stop.is_set():
                return False
            pacer = None if camera.is_live else Pacer(sleep=self._pause)
            drops = DropCount()
            shift = _Shift(self._next_sequence, self._end_ns) if not camera.is_live else None
            n_dropped_before = self._n_dropped
            for given in self._frames(camera):
                frame = shift.applied(given) if shift else given
                if pacer is not None:
                    pacer.wait_for(frame.timestamp_ns)
                if self._stop.is_set():
                    return False
                drops.see(frame.sequence)
                self._n_dropped = n_dropped_before + drops.total
                self._report("live", None, camera.info)
                self._rate.see()
                self._arrive(Arrival(frame, camera.info, self._rate.rate_hz, self._n_dropped))
                self._end_ns = frame.timestamp_ns + round(NS_PER_S / camera.info.frame_rate_hz)
                self._next_sequence = frame.sequence + 1
        return not self._stop.is_set()

    def _frames(self, camera: DepthCamera) -> Iterator[SensorFrame]:
        frame = self._first_frame(camera) if camera.is_live else camera.read()
        while frame is not None:
            yield frame
            frame = camera.read(SILENCE_S) if camera.is_live else camera.read()

    def _first_frame(self, camera: DepthCamera) -> SensorFrame | None:
        """Wait for a sensor that starts its projector, in slices."""
        deadline_s = time.monotonic() + READ_TIMEOUT_S
        while True:
            try:
                return camera.read(SLICE_S)
            except SensorError:
                if time.monotonic() > deadline_s or self._stop.wait(SLICE_S):
                    raise

    def _pause(self, seconds: float) -> None:
        self._stop.wait(seconds)


class _Shift:
    """Moves the numbers and times of a recording on, so that they go on where it begins anew."""

    def __init__(self, next_sequence: int, next_ns: int | None) -> None:
        self._next_sequence = next_sequence
        self._next_ns = next_ns
        self._by: tuple[int, int] | None = None

    def applied(self, frame: SensorFrame) -> SensorFrame:
        """Return the frame with its new number and times; the first pass changes nothing."""
        if self._next_ns is None:
            return frame
        if self._by is None:
            self._by = self._next_sequence - frame.sequence, self._next_ns - frame.timestamp_ns
        n_frames, time_ns = self._by
        color_ns = frame.color_timestamp_ns
        return replace(
            frame,
            sequence=frame.sequence + n_frames,
            timestamp_ns=frame.timestamp_ns + time_ns,
            color_timestamp_ns=None if color_ns is None else color_ns + time_ns,
        )


class _RateMeter:
    """Frames a second over the last two seconds, by the computer's clock."""

    def __init__(self) -> None:
        self._times_s: deque[float] = deque()

    def see(self) -> None:
        """Note that a frame came now."""
        now_s = time.monotonic()
        self._times_s.append(now_s)
        while now_s - self._times_s[0] > RATE_SPAN_S:
            self._times_s.popleft()

    @property
    def rate_hz(self) -> float:
        """0 before two frames came."""
        if len(self._times_s) < 2:  # noqa: PLR2004  (a rate needs two)
            return 0.0
        return (len(self._times_s) - 1) / max(self._times_s[-1] - self._times_s[0], 1e-6)
