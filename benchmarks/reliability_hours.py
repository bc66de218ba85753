"""Hours of the live view at 30 frames/s: what it takes of memory, and whether frames keep time.

In real time, in one go: what eight hours do to a process cannot be put together from parts. The
samples of an interrupted run stay beside its picture in ``build/reliability``.
"""

import json
import os
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from adibas.clock import NS_PER_S
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.pipeline.live import LiveFrame, LiveView, SensorState
from adibas.recordings import create_recording
from adibas.sensors.ports import DepthCamera, SensorOptions
from adibas.sensors.sources import open_source
from benchmarks.hours_picture import draw_hours
from benchmarks.long_run import Run
from benchmarks.table import Row

WHOLE_HOURS, QUICK_HOURS = 8.0, 0.004
FRAME_RATE_HZ = 30.0
SOURCE = "simulator:standing"
OPTIONS = SensorOptions(color_size=(640, 480))
N_RENDERED = 60
"""Frames that are rendered beforehand: the sensor's part must not take the program's time."""
SECONDS_BETWEEN_SAMPLES = 5.0
SECONDS_BETWEEN_BURSTS = 300.0
BURST_FRAMES = 30
SETTLED_SHARE = 0.1
"""Of the run, at its beginning, in which caches and compiled code may still grow."""


@dataclass(frozen=True, slots=True)
class Sample:
    """How the process fares at one moment.

    Attributes
    ----------
    elapsed_s : float
        Since the first frame, by the computer's steady clock.
    memory_mb : float
        Resident set.
    n_frames : int
        That came from the source.
    n_looked_at : int
        That were looked at; the others were skipped for a newer one.
    drift_s : float
        Timestamp of the newest frame, from the first one, less the elapsed time at its coming.
    n_files, n_threads : int
        Open in the process.
    """

    elapsed_s: float
    memory_mb: float
    n_frames: int
    n_looked_at: int
    drift_s: float
    n_files: int
    n_threads: int


def rows(run: Run) -> Iterable[Row]:
    """Run for the hours that are asked for, eight by default."""
    hours = QUICK_HOURS if run.is_quick else run.amount or WHOLE_HOURS
    name = "quick" if run.is_quick else "hours"
    run.folder.mkdir(parents=True, exist_ok=True)
    samples: list[Sample] = []
    n_bursts = 0
    with (run.folder / f"{name}.jsonl").open("w", encoding="utf-8") as file:
        for sample, n_bursts in _samples(3600 * hours):  # noqa: B007  (the last is told)
            samples.append(sample)
            file.write(json.dumps(asdict(sample)) + "\n")
            file.flush()
            run.progress(round(sample.elapsed_s), round(3600 * hours))
    draw_hours(run.folder / f"{name}.png", samples)
    yield from _told(samples, n_bursts)


def _told(samples: list[Sample], n_bursts: int) -> Iterator[Row]:
    last = samples[-1]
    settled = [one for one in samples if one.elapsed_s >= SETTLED_SHARE * last.elapsed_s]
    n_expected = int(last.elapsed_s * FRAME_RATE_HZ) + 1
    hours = np.array([one.elapsed_s / 3600 for one in settled])
    memory_mb = np.array([one.memory_mb for one in settled])
    after = f"in {last.elapsed_s / 3600:.2f} h of {SOURCE} at {FRAME_RATE_HZ:g} frames/s"
    yield Row(f"hours of {WHOLE_HOURS:g}", last.elapsed_s / 3600, "h", WHOLE_HOURS, "goal")
    yield Row(f"frames that came {after}", last.n_frames, "frames", n_expected, "by the clock")
    yield Row("looked at, the newest each time", last.n_looked_at, "frames")
    yield Row(f"bursts of {BURST_FRAMES} frames written meanwhile", n_bursts, "bursts")
    yield Row("largest drift of timestamps", max(abs(s.drift_s) for s in samples), "s", 1, "goal <")
    yield Row("drift at the end", last.drift_s, "s")
    yield Row("memory when settled, median", float(np.median(memory_mb)), "MB")
    yield Row("largest memory", max(one.memory_mb for one in samples), "MB")
    growth = float(np.polyfit(hours, memory_mb, 1)[0]) if len(settled) > 2 else 0.0
    yield Row("its growth, line through the settled part", growth, "MB/h", 5, "goal <")
    yield Row("open files more than when settled", last.n_files - settled[0].n_files, "files", 0)
    yield Row("threads more than when settled", last.n_threads - settled[0].n_threads, "threads", 0)


class _Watch:
    """Counts what the source gives and what the view tells."""

    def __init__(self) -> None:
        self.n_frames = self.n_looked_at = 0
        self.first_s = self.drift_s = 0.0
        self._first_ns = 0
        self.is_live, self.problems = threading.Event(), list[str]()

    def open(self, text: str, options: SensorOptions) -> DepthCamera:
        """Open the simulator, whose frames are counted."""
        with open_source(text, options) as camera:
            frames = [frame for _ in range(N_RENDERED) if (frame := camera.read()) is not None]
            return _RoundAndRound(camera.info, frames, self)

    def see(self, frame: SensorFrame) -> None:
        """Note one that is about to be waited for: the next call comes when it is due."""
        now_s = time.monotonic()
        if self.n_frames == 0:
            self._first_ns, self.first_s = frame.timestamp_ns, now_s
        self.n_frames += 1
        self.drift_s = (frame.timestamp_ns - self._first_ns) / NS_PER_S - (now_s - self.first_s)

    def frame_arrived(self, frame: LiveFrame) -> None:
        """Take a frame that was looked at."""
        self.n_looked_at += frame.sequence >= 0

    def state_changed(self, state: SensorState) -> None:
        """Take how the source fares."""
        if state.kind == "live":
            self.is_live.set()
        if state.error is not None:
            self.problems.append(str(state.error))


class _RoundAndRound(DepthCamera):
    """Gives the same frames to and fro for ever, with numbers and times that go on.

    Each is counted when the next one is asked for: by then it was waited for and shown.
    """

    is_live = False

    def __init__(self, info: SourceInfo, frames: list[SensorFrame], watch: _Watch) -> None:
        self._info, self._watch = info, watch
        self._frames = [*frames, *frames[-2:0:-1]]
        self._given: SensorFrame | None = None
        self._next = 0

    @property
    def info(self) -> SourceInfo:
        """The simulator's."""
        return self._info

    def read(self, timeout_s: float = 0.0) -> SensorFrame:  # noqa: ARG002
        """Return the next frame."""
        if self._given is not None:
            self._watch.see(self._given)
        time_ns = round(self._next * NS_PER_S / FRAME_RATE_HZ)
        frame = self._frames[self._next % len(self._frames)]
        self._given = replace(
            frame, sequence=self._next, timestamp_ns=time_ns, color_timestamp_ns=time_ns
        )
        self._next += 1
        return self._given

    def close(self) -> None:
        """Do nothing: there is no sensor to give back."""


def _samples(seconds: float) -> Iterator[tuple[Sample, int]]:
    """Give a sample, and how many bursts were written, again and again."""
    watch = _Watch()
    with _opened(watch) as view, tempfile.TemporaryDirectory() as folder:
        start_s = next_burst_s = time.monotonic()
        n_bursts = 0
        while (elapsed_s := time.monotonic() - start_s) < seconds:
            time.sleep(min(SECONDS_BETWEEN_SAMPLES, seconds - elapsed_s))
            if time.monotonic() >= next_burst_s:
                _write_burst(view, Path(folder) / "burst.mcap")
                n_bursts += 1
                next_burst_s = time.monotonic() + SECONDS_BETWEEN_BURSTS
            yield _sample(watch), n_bursts
    if watch.problems:
        raise RuntimeError(f"the live view told: {watch.problems}")


@contextmanager
def _opened(watch: _Watch) -> Iterator[LiveView]:
    view = LiveView(watch, opener=watch.open)
    view.open(SOURCE, OPTIONS)
    try:
        if not watch.is_live.wait(120):
            raise RuntimeError(f"no frame came: {watch.problems}")
        yield view
    finally:
        view.close()


def _write_burst(view: LiveView, path: Path) -> None:
    info = view.state.info
    if info is None:
        raise RuntimeError("the live view has lost the simulator")
    writer = create_recording(path, info)
    with writer:
        view.capture(BURST_FRAMES, writer).result(120)
    path.unlink()


def _sample(watch: _Watch) -> Sample:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return Sample(
        elapsed_s=time.monotonic() - watch.first_s,
        memory_mb=pages * os.sysconf("SC_PAGESIZE") / 2**20,
        n_frames=watch.n_frames,
        n_looked_at=watch.n_looked_at,
        drift_s=watch.drift_s,
        n_files=len(os.listdir("/proc/self/fd")),  # noqa: PTH208  (no paths are needed)
        n_threads=threading.active_count(),
    )
