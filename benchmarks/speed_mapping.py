"""Mapping of a long walk through a simulated room: time and memory of each frame, and the path.

Time is told as it passed and as work of both cores, for another program may be running. A drawing
of both is left in `build/benchmarks`.
"""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from adibas.arrays import FloatArray
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.mapping import MappedRecording, MapRequest, map_recording
from benchmarks.mapping_steps import step_rows
from benchmarks.mapping_walk import FOLDER, walk
from benchmarks.process_memory import resident_memory_mib
from benchmarks.table import Row

N_FRAMES, QUICK_FRAMES = 1000, 60
N_CORES = 2
WINDOW = 50
SETTLED = 100
"""Frames after which memory is settled: kernels are loaded, key-frames are at their number."""


@dataclass(frozen=True, slots=True)
class Reached:
    """After a frame."""

    done: int
    wall_s: float
    cpu_s: float
    memory_mb: float


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` the begin of the walk, which closes no loop."""
    yield from step_rows(quick=quick)
    n_frames = QUICK_FRAMES if quick else N_FRAMES
    walked = walk(n_frames, N_FRAMES)
    map_recording(MapRequest(walked.path, frames=(0, 3)), lambda _done, _total: None)
    log = [_now(0)]
    mapped = map_recording(MapRequest(walked.path), lambda done, _total: log.append(_now(done)))
    following = [one for one in log if one.done <= n_frames]
    told = f"walk through a room, {n_frames} frames of 640x480"
    wall_s, cpu_s = (log[-1].wall_s - log[0].wall_s, log[-1].cpu_s - log[0].cpu_s)
    yield Row(f"{told}: all, as time passed", n_frames / wall_s, "frames/s", 10.0, "goal >=")
    yield Row(
        f"same: all, by the work of {N_CORES} cores",
        N_CORES * n_frames / cpu_s,
        "frames/s",
        10.0,
        "goal >=",
    )
    yield from _flatness("following", following)
    yield from _flatness("fusing", [following[-1], *(one for one in log if one.done > n_frames)])
    yield from _path(mapped, walked.camera_from_world)
    _draw(FOLDER / f"mapping-{n_frames}.png", log)
    yield from _second_round(n_frames)


def _second_round(n_frames: int) -> Iterator[Row]:
    """Go twice as fast, so that the second half shows what the first one has seen."""
    n_of_turn = n_frames // 2
    walked = walk(n_frames, n_of_turn)
    log = [_now(0)]
    map_recording(MapRequest(walked.path), lambda done, _total: log.append(_now(done)))
    told = f"twice round a room, {n_frames} frames, second round against first"
    for step, first in (("following", 0), ("fusing", n_frames)):
        ends = (log[first], log[first + n_of_turn], log[min(first + n_frames, len(log) - 1)])
        for name, row in (("work a frame", "cpu_s"), ("memory grown", "memory_mb")):
            before, after = (
                (getattr(end, row) - getattr(begin, row)) / n_of_turn
                for begin, end in pairwise(ends)
            )
            size, unit = (1e3, "ms") if row == "cpu_s" else (1.0, "MB a frame")
            yield Row(f"{told}: {step}, {name}", size * after, unit, size * before, "first round")


def _flatness(step: str, log: list[Reached]) -> Iterator[Row]:
    """Give the work per frame at the begin and at the end, and how memory grows between."""
    work_ms = _work_ms(log)
    window = min(WINDOW, len(work_ms) // 2)
    yield Row(f"same: {step}, work a frame, first {window}", float(work_ms[:window].mean()), "ms")
    yield Row(f"same: {step}, work a frame, last {window}", float(work_ms[-window:].mean()), "ms")
    yield Row(f"same: {step}, work a frame, largest", float(work_ms.max()), "ms")
    settled = log[min(SETTLED, len(log) // 2) :]
    grown_mb = settled[-1].memory_mb - settled[0].memory_mb
    yield Row(f"same: {step}, memory at its end", settled[-1].memory_mb, "MB")
    yield Row(f"same: {step}, memory grown", grown_mb / max(len(settled) - 1, 1), "MB a frame")


def _work_ms(log: list[Reached]) -> FloatArray:
    return 1e3 * np.diff([one.cpu_s for one in log])


def _path(mapped: MappedRecording, camera_from_world: tuple[RigidTransform, ...]) -> Iterator[Row]:
    """Give the error of the path, the first frame's camera being the same in both."""
    first = camera_from_world[0]
    truths = [first @ pose.inverse() for pose in camera_from_world]
    n_placed = len(mapped.world_from_camera)
    yield Row("same: frames placed", 100.0 * n_placed / len(truths), "%")
    if n_placed == len(truths):
        pairs = zip(mapped.world_from_camera, truths, strict=True)
        off_mm = [
            1e3 * float(np.linalg.norm(pose.translation_m - truth.translation_m))
            for pose, truth in pairs
        ]
        yield Row("same: path, root mean square error", float(np.sqrt(np.mean(np.square(off_mm)))),
                  "mm")  # fmt: skip
        yield Row("same: path, largest error", max(off_mm), "mm")
    yield Row("same: length of the path", mapped.path_m, "m")
    yield Row("same: key-frames", float(mapped.n_key_frames), "")
    yield Row("same: loops closed", float(mapped.n_loops), "")
    yield Row("same: loops that count nothing", float(mapped.n_wrong_loops), "")


def _now(done: int) -> Reached:
    return Reached(done, time.perf_counter(), time.process_time(), resident_memory_mib())


def _draw(path: Path, log: list[Reached]) -> None:
    """Draw work and memory of each frame into a PNG: followed first, then fused."""
    figure = Figure(figsize=(9, 6), layout="constrained")
    FigureCanvasAgg(figure)
    work, memory = figure.subplots(2, 1, sharex=True)
    done = [one.done for one in log]
    work.plot(done[1:], _work_ms(log), linewidth=0.5)
    work.set_ylabel("work of all cores, ms a frame")
    memory.plot(done, [one.memory_mb for one in log])
    memory.set_ylabel("memory (resident), MB")
    memory.set_ylim(bottom=0)
    memory.set_xlabel("frames followed, then fused")
    for axes in (work, memory):
        axes.grid(visible=True, alpha=0.3)
    figure.savefig(path, dpi=100)
