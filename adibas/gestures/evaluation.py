"""How well gestures are recognised in people who were not in the training.

Source: thesis, equation 7.7: what is not classified counts against us, and so does what is
classified more than once. F1 stands beside it, since 7.7 does not see false alarms.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.gestures.descriptor import DescriptorParams
from adibas.gestures.model import GestureModel
from adibas.gestures.segments import Examples, Segment
from adibas.gestures.thresholds import RIGHT_OVERLAP
from adibas.gestures.training import TrainingParams, train
from adibas.progress import Progress


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """What was found of what there was.

    Attributes
    ----------
    labels : tuple of str
    is_isolated : bool
    confusion : (labels, labels) integer array
        Row: what was done; column: what was reported. One gesture may be reported more than once.
    missed : (labels,) integer array
        Gestures for which nothing was reported.
    best_right : int
        Gestures whose best class is right.
    hits, n_reported, n_done : (labels,) integer arrays
        Reports that are right at an overlap of half, all reports, all gestures.
    begin_errors, end_errors : (k,) arrays
        Of the hits, in frames of the described stream.
    seconds : float
        Of stream that was looked at.
    """

    labels: tuple[str, ...]
    is_isolated: bool
    confusion: IntArray
    missed: IntArray
    best_right: int
    hits: IntArray
    n_reported: IntArray
    n_done: IntArray
    begin_errors: FloatArray
    end_errors: FloatArray
    seconds: float

    @property
    def accuracy(self) -> float:
        """Return the share of gestures whose best class is right."""
        return self.best_right / max(int(self.n_done.sum()), 1)

    @property
    def accuracy_7_7(self) -> float:
        """Return equation 7.7, percent."""
        total = int(self.missed.sum() + self.confusion.sum())
        return 100.0 * float(np.trace(self.confusion)) / max(total, 1)

    def accuracy_of(self, label: int) -> float:
        """Return the share of 7.7 that one gesture has in its own row, percent."""
        total = int(self.missed[label] + self.confusion[label].sum())
        return 100.0 * float(self.confusion[label, label]) / max(total, 1)

    @property
    def false_alarms(self) -> int:
        """Return how many reports are no hit."""
        return int((self.n_reported - self.hits).sum())

    def rates_of(self, labels: Sequence[int]) -> tuple[float, float, float]:
        """Return precision, recall and F1 of some gestures, pooled."""
        chosen = list(labels)
        hits, reported, done = (
            int(counts[chosen].sum()) for counts in (self.hits, self.n_reported, self.n_done)
        )
        precision, recall = hits / max(reported, 1), hits / max(done, 1)
        return precision, recall, 2.0 * hits / max(reported + done, 1)


def leave_one_out(
    examples: Examples,
    descriptor: DescriptorParams,
    params: TrainingParams,
    progress: Progress = lambda _done, _total: None,
) -> Evaluation:
    """Train without each group in turn, and test on it.

    Raises
    ------
    GestureError
        Too few examples are left for training.
    """
    groups = np.unique(examples.groups)
    parts = []
    for number, group in enumerate(groups):
        progress(number, len(groups))
        parts.append(one_left_out(examples, int(group), descriptor, params))
    return pooled(parts)


def one_left_out(
    examples: Examples, group: int, descriptor: DescriptorParams, params: TrainingParams
) -> Evaluation:
    """Train without one group, and test on it; see `leave_one_out`."""
    held = examples.groups == group
    model = train(examples.without(held), descriptor, params)
    return compare(model, examples.picked(held), examples.picked(~held))


def compare(model: GestureModel, examples: Examples, trained: Examples | None = None) -> Evaluation:
    """Compare what a model reports with what was done.

    Parameters
    ----------
    model : GestureModel
    examples : Examples
        Labels as in the model; streams without a gesture among them are left out.
    trained : Examples, optional
        What the model knows of the same streams: reports over it are not counted.
    """
    tally = _Tally(examples)
    for stream in sorted({gesture.stream for gesture in examples.gestures}):
        done = examples.in_stream(stream)
        track = examples.streams[stream]
        if examples.is_isolated:
            tally.add_sample(done[0], model.classify(examples.frames_of(done[0])))
        else:
            known = trained.in_stream(stream) if trained else ()
            found = [Segment(stream, s.label, s.begin, s.end, s.cost) for s in model.detect(track)]
            tally.add_stream(
                done, [one for one in found if not any(one.overlap(other) > 0 for other in known)]
            )
        tally.seconds += len(track.frames) / track.rate_hz
    return tally.result()


def pooled(parts: Sequence[Evaluation]) -> Evaluation:
    """Return the sum of several evaluations."""
    return Evaluation(
        parts[0].labels,
        parts[0].is_isolated,
        np.sum([part.confusion for part in parts], axis=0),
        np.sum([part.missed for part in parts], axis=0),
        sum(part.best_right for part in parts),
        np.sum([part.hits for part in parts], axis=0),
        np.sum([part.n_reported for part in parts], axis=0),
        np.sum([part.n_done for part in parts], axis=0),
        np.concatenate([part.begin_errors for part in parts]),
        np.concatenate([part.end_errors for part in parts]),
        sum(part.seconds for part in parts),
    )


class _Tally:
    """Counts while streams are tested."""

    def __init__(self, examples: Examples) -> None:
        n = len(examples.labels)
        self._examples = examples
        self._confusion = np.zeros((n, n), np.int64)
        self._missed, self._hits, self._reported, self._done = np.zeros((4, n), np.int64)
        self._best_right = 0
        self._begin_errors: list[int] = []
        self._end_errors: list[int] = []
        self.seconds = 0.0

    def add_sample(self, gesture: Segment, costs: FloatArray) -> None:
        """Count one isolated gesture; `costs` (labels,) as `GestureModel.classify` gives them."""
        best = int(np.argmin(costs))
        is_right = best == gesture.label and bool(np.isfinite(costs[best]))
        self._done[gesture.label] += 1
        self._best_right += int(is_right)
        if costs[best] > 1.0:
            self._missed[gesture.label] += 1
            return
        # As in a stream, where one movement is reported once: by its best class.
        self._confusion[gesture.label, best] += 1
        self._reported[best] += 1
        self._hits[best] += int(is_right)

    def add_stream(self, done: Sequence[Segment], found: Sequence[Segment]) -> None:
        """Count what was found in one stream beside what was done."""
        for gesture in done:
            near = [one for one in found if one.overlap(gesture) >= RIGHT_OVERLAP]
            self._done[gesture.label] += 1
            self._missed[gesture.label] += int(not near)
            for one in near:
                self._confusion[gesture.label, one.label] += 1
            if near:
                best = min(near, key=lambda one: one.cost)
                self._best_right += int(best.label == gesture.label)
        free = list(done)
        for one in sorted(found, key=lambda segment: segment.cost):
            self._reported[one.label] += 1
            hit = next((g for g in free if g.label == one.label
                        and one.overlap(g) >= RIGHT_OVERLAP), None)  # fmt: skip
            if hit is not None:
                free.remove(hit)
                self._hits[one.label] += 1
                self._begin_errors.append(abs(one.begin - hit.begin))
                self._end_errors.append(abs(one.end - hit.end))

    def result(self) -> Evaluation:
        """Return the counts."""
        return Evaluation(
            self._examples.labels, self._examples.is_isolated, self._confusion, self._missed,
            self._best_right, self._hits, self._reported, self._done,
            np.array(self._begin_errors, np.float64), np.array(self._end_errors, np.float64),
            self.seconds,
        )  # fmt: skip
