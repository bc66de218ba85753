"""Time warping beside its peers, in turn in one run, and what a stream costs."""

import importlib
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.skeleton_track import track_of
from adibas.recordings.joints_csv import SUFFIX, write_joints_csv
from adibas.timeseries.dtw import pairwise_costs
from adibas.timeseries.stream import StreamAligner
from benchmarks.gesture_actors import streams
from benchmarks.gesture_lengths import (
    EXAMPLE_FRAMES,
    FRAMES_A_MINUTE,
    N_EXAMPLES,
    length_rows,
)
from benchmarks.speed_registration import medians_ms
from benchmarks.table import Row

MODEL_FRAMES, N_NUMBERS, STREAM_FRAMES = 60, 42, 10_000
N_SEQUENCES = 200
N_LIVE = 100
HOUR_HZ = 30
SEED = 1


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` shorter streams and fewer sequences."""
    rng = np.random.default_rng(SEED)
    n_rounds = 3 if quick else 15
    yield from _begin_to_end(rng, STREAM_FRAMES // (10 if quick else 1), n_rounds)
    yield from _live(rng)
    yield from _pairs(rng, 40 if quick else N_SEQUENCES, n_rounds)
    yield from _lengths(quick=quick)
    if not quick:
        yield from _hour()


def _peer(name: str) -> ModuleType | None:
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def _walk(rng: np.random.Generator, n_frames: int) -> FloatArray:
    return np.asarray(np.cumsum(rng.normal(0.0, 0.1, (n_frames, N_NUMBERS)), axis=0))


def _begin_to_end(rng: np.random.Generator, n_frames: int, n_rounds: int) -> Iterator[Row]:
    model, stream = _walk(rng, MODEL_FRAMES), _walk(rng, n_frames)
    free, sloped = StreamAligner([model], steps="free"), StreamAligner([model])

    def run(aligner: StreamAligner) -> Callable[[], object]:
        def work() -> object:
            aligner.reset()
            return aligner.feed(stream)

        return work

    works = [run(free), run(sloped)]
    if peer := _peer("dtaidistance.dtw_ndim"):
        anywhere = [0, 0, n_frames, n_frames]
        works.append(lambda: peer.warping_paths_fast(model, stream, psi=anywhere))
    times_ms = _processor_medians_ms(works, n_rounds)
    told = f"begin to end, {MODEL_FRAMES} x {N_NUMBERS} in {n_frames} frames"
    reference = times_ms[2] if peer else None
    whose = "dtaidistance" if peer else ""
    yield Row(f"{told}, free steps", times_ms[0], "ms", reference, whose)
    yield Row(f"{told}, limited slope", times_ms[1], "ms", reference, whose)
    per_frame_us = 1e3 * times_ms[1] / n_frames
    yield Row("stream, a frame and model, limited slope", per_frame_us, "us", 2.0, "goal <=")


def _processor_medians_ms(works: list[Callable[[], object]], n_rounds: int) -> list[float]:
    """Like `medians_ms`, in processor time: fair where one thread works on a busy machine."""
    times_s: list[list[float]] = [[] for _ in works]
    for _ in range(n_rounds + 1):
        for work, spent in zip(works, times_s, strict=True):
            start = time.process_time()
            work()
            spent.append(time.process_time() - start)
    return [1e3 * float(np.median(spent[1:])) for spent in times_s]


def _live(rng: np.random.Generator) -> Iterator[Row]:
    models = [_walk(rng, MODEL_FRAMES) for _ in range(N_LIVE)]
    aligner = StreamAligner(models)
    frames = _walk(rng, 60)
    aligner.feed(frames[:1])
    start = time.thread_time()
    for frame in frames:
        aligner.feed(frame[None])
    spent_s = (time.thread_time() - start) / len(frames)
    share = 100 * 30 * spent_s
    yield Row(f"{N_LIVE} models live at 30 frames/s", share, "% of a core", 10.0, "goal <=")


def _pairs(rng: np.random.Generator, n_sequences: int, n_rounds: int) -> Iterator[Row]:
    sequences = [_walk(rng, MODEL_FRAMES) for _ in range(n_sequences)]
    works: list[Callable[[], object]] = [lambda: pairwise_costs(sequences, is_squared=True)]
    if peer := _peer("dtaidistance.dtw_ndim"):
        works.append(lambda: peer.distance_matrix_fast(sequences, parallel=True))
    times_ms = medians_ms(works, n_rounds)
    yield Row(
        f"all pairs of {n_sequences} sequences {MODEL_FRAMES} x {N_NUMBERS}, all threads",
        times_ms[0],
        "ms",
        times_ms[1] if peer else None,
        "dtaidistance" if peer else "",
    )
    if peer:
        ours, theirs = (np.asarray(work()) for work in works)
        upper = np.triu_indices(n_sequences, 1)
        yield Row("same: largest difference", float(abs(ours - theirs)[upper].max()), "")


def _lengths(*, quick: bool) -> Iterator[Row]:
    """Yield what hours of stream cost."""
    rng = np.random.default_rng(SEED)
    examples = [_walk(rng, EXAMPLE_FRAMES) for _ in range(N_EXAMPLES)]
    yield from length_rows(examples, _walk(rng, FRAMES_A_MINUTE), quick=quick)


def _hour() -> Iterator[Row]:
    """Yield what a whole analysis of 108,000 frames takes, from the file to the timeline."""
    tracks, _events = streams(1, 6, SEED)
    joints_m = next(iter(tracks.values())).joints_m
    n_frames = HOUR_HZ * 3600
    to_and_fro = np.concatenate([joints_m, joints_m[-2:0:-1]])
    places = np.arange(n_frames) // 2 % len(to_and_fro)
    track = track_of(np.arange(n_frames) / HOUR_HZ, to_and_fro[places])
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / f"hour{SUFFIX}"
        write_joints_csv(path, [track])
        done = subprocess.run(  # noqa: S603  (our own module)
            [sys.executable, "-m", "benchmarks.behaviour_probe", str(path)],
            capture_output=True,
            check=True,
            text=True,
        )
    found = json.loads(done.stdout)
    told = f"an hour of joints ({n_frames} frames), five gestures, activity"
    yield Row(f"{told}: processor time", found["seconds"], "s", 60.0, "goal <=")
    yield Row(f"{told}: memory at most", found["mb"], "MB", 500.0, "goal <=")
