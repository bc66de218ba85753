"""Gestures: the thesis' table 7.3 on simulated skeletons, and real sets, one subject left out.

With ADIBAS_BENCHMARK_RESULTS=FILE the table's every method and actor is kept in that file as it is
done, and what stands there is not done again.
"""

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from adibas.gestures.descriptor import DescriptorParams
from adibas.gestures.evaluation import Evaluation, leave_one_out
from adibas.gestures.model import Method
from adibas.gestures.segments import Examples
from adibas.gestures.training import TrainingParams
from adibas.pipeline.gesture_examples import examples_of
from adibas.timeseries.dtw import pairwise_costs
from benchmarks.gesture_actors import GESTURES, streams
from benchmarks.kept_folds import kept_leave_one_out
from benchmarks.skeleton_sets import SkeletonSet, msr_action3d, utd_mhad, utkinect
from benchmarks.table import Row

SEED = 4100
REAL_DATA = "ADIBAS_REAL_DATA"
DESCRIPTOR = DescriptorParams()
THESIS = {
    "jump": (68.0, 68.0),
    "bend": (63.4, 68.0),
    "clap": (42.0, 55.0),
    "greet": (64.2, 73.0),
    "note": (68.0, 76.0),
}
"""Plain, and with joint weights (table 7.3)."""

THREE = ("waveHands", "clapHands", "pickUp")
MSR_FOUR = ("a01", "a10", "a11", "a13")
N_CONFIGURATIONS = 165
"""Looked at on the real sets before these defaults were chosen. On isolated sets 95: 5 descriptors,
90 distances and kernels. On streams 70: 4 descriptors, 6 kernels x 9 thresholds, 8 methods, targets
by overlap, and mirrored copies by three rules."""


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` few actors, and of the real sets only the streams."""
    yield Row("configurations tried on the real sets", N_CONFIGURATIONS, "")
    yield from _simulated(quick=quick)
    folder = os.environ.get(REAL_DATA)
    if folder is None:
        return
    yield from _continuous(Path(folder))
    if not quick:
        yield from _isolated(Path(folder), msr_action3d, 81.0)
        yield from _isolated(Path(folder), utd_mhad, 88.0)


def _simulated(*, quick: bool) -> Iterator[Row]:
    n_actors, n_each = (4, 4) if quick else (10, 20)
    kept = os.environ.get("ADIBAS_BENCHMARK_RESULTS")
    file = Path(kept) if kept and not quick else None

    @cache
    def examples() -> Examples:
        return examples_of(*streams(n_actors, n_each, SEED), DESCRIPTOR)[0]

    told = f"{n_actors} actors x {5 * n_each}, seed {SEED}{', quick' if quick else ''}"
    compared: tuple[tuple[Method, int, str], ...] = (
        ("table-7.1", 0, "thesis, plain"),
        ("dtw", 0, "thesis, plain"),
        ("weighted-dtw", 1, "thesis, weighted"),
        ("gmm-dtw", 1, "thesis, weighted"),
        ("hmm", 1, "thesis, weighted"),
        ("likeness", 1, "thesis, weighted"),
    )
    for method, column, whose in compared:
        params = TrainingParams(method=method, seed=SEED)
        result = kept_leave_one_out(told, n_actors, examples, DESCRIPTOR, params, file)
        for gesture in GESTURES:
            found = result.accuracy_of(result.labels.index(gesture))
            name = f"{method}, {gesture}: A by 7.7 ({told})"
            yield Row(name, found, "%", THESIS[gesture][column], whose)
        yield Row(f"{method}: global 7.7", result.accuracy_7_7, "%")
        yield from _rates(method, result)


def _rates(name: str, result: Evaluation) -> Iterator[Row]:
    precision, recall, f1 = result.rates_of(range(len(result.labels)))
    yield Row(f"{name}: F1 at overlap 0.5, all pooled", f1, "")
    yield Row(f"{name}: precision", precision, "")
    yield Row(f"{name}: recall", recall, "")
    alarms = 3600.0 * result.false_alarms / max(result.seconds, 1.0)
    yield Row(f"{name}: false alarms an hour", alarms, "")


def _examples(recorded: SkeletonSet) -> Examples:
    tracks = {(name, 1): track for name, track in recorded.tracks.items()}
    return examples_of(tracks, recorded.events, DESCRIPTOR)[0]


def _continuous(folder: Path) -> Iterator[Row]:
    recorded = utkinect(folder)
    examples = _examples(recorded)
    methods: tuple[Method, ...] = (
        *("likeness", "hmm", "dtw", "weighted-dtw", "gmm-dtw"),
        "table-7.1",
    )
    for method in methods:
        result = leave_one_out(examples, DESCRIPTOR, TrainingParams(method=method))
        three = [result.labels.index(label) for label in THREE]
        name = f"{recorded.name} streams, {method}"
        goals = (0.70, 0.55) if method == "likeness" else (None, None)
        yield Row(f"{name}: F1 of wave, clap, pick up", result.rates_of(three)[2], "", goals[0],
                  "goal >=" if goals[0] else "")  # fmt: skip
        yield Row(f"{name}: F1 of all ten", result.rates_of(range(len(result.labels)))[2], "",
                  goals[1], "goal >=" if goals[1] else "")  # fmt: skip
        yield Row(f"{name}: 1-best accuracy", 100 * result.accuracy, "%")
        if len(result.begin_errors):
            yield Row(f"{name}: median begin error", float(np.median(result.begin_errors)),
                      "frames at 15/s", 6.0, "goal <=")  # fmt: skip
            yield Row(f"{name}: median end error", float(np.median(result.end_errors)),
                      "frames at 15/s", 10.0, "goal <=")  # fmt: skip
        alarms = 3600.0 * result.false_alarms / result.seconds
        yield Row(f"{name}: false alarms an hour", alarms, "")


def _isolated(folder: Path, read: Callable[[Path], SkeletonSet], goal: float) -> Iterator[Row]:
    recorded = read(folder)
    examples = _examples(recorded)
    nearest = 100 * nearest_neighbour(examples)
    methods: tuple[Method, ...] = ("likeness", "hmm", "dtw", "weighted-dtw", "gmm-dtw")
    for method in methods:
        result = leave_one_out(examples, DESCRIPTOR, TrainingParams(method=method))
        name = f"{recorded.name}, {len(result.labels)} classes, {method}"
        yield Row(name, 100 * result.accuracy, "%", nearest, "1-NN alignment, same split")
        if method == "likeness":
            yield Row(name, 100 * result.accuracy, "%", goal, "goal >=")
        if method == "likeness" and recorded.name.startswith("MSR"):
            four = [result.labels.index(label) for label in MSR_FOUR]
            recall = 100 * result.rates_of(four)[1]
            yield Row(f"{name}: recall of clap, waves, bend, below the threshold", recall, "%")
            yield from _four_alone(recorded)


def _four_alone(recorded: SkeletonSet) -> Iterator[Row]:
    """Yield how well clap, both waves and bend are told from each other."""
    events = tuple(one for one in recorded.events if one.label in MSR_FOUR)
    tracks = {one.recording: recorded.tracks[one.recording] for one in events}
    examples = _examples(replace(recorded, tracks=tracks, events=events))
    result = leave_one_out(examples, DESCRIPTOR, TrainingParams())
    name = f"{recorded.name}, clap, waves and bend alone ({len(events)} clips), likeness"
    yield Row(name, 100 * result.accuracy, "%", 98.0, "goal >=")
    yield Row(name, 100 * result.accuracy, "%", 100 * nearest_neighbour(examples),
              "1-NN alignment, same split")  # fmt: skip


def nearest_neighbour(examples: Examples) -> float:
    """Return the share of gestures whose nearest gesture of another group is of the same kind."""
    costs = pairwise_costs([examples.frames_of(gesture) for gesture in examples.gestures])
    labels = np.array([gesture.label for gesture in examples.gestures])
    costs[examples.groups[:, None] == examples.groups[None]] = np.inf
    return float((labels[costs.argmin(axis=1)] == labels).mean())
