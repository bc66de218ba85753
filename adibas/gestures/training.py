"""From examples to a recogniser.

Thresholds are chosen on what models without the group (a subject, mostly) find in its streams, so
that nobody is measured against himself.

Source: thesis, equation 7.5 (leave one out); the false alarms that 7.5 does not see count, too.
"""

from dataclasses import dataclass, replace

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.errors import GestureError
from adibas.gestures.descriptor import DescriptorParams, mirrored
from adibas.gestures.hidden_markov import MarkovTraining
from adibas.gestures.likeness import LikenessParams, LikenessTraining
from adibas.gestures.mixtures import mixtures_of
from adibas.gestures.model import GestureModel, Method
from adibas.gestures.proposals import SHORTEST, chosen_examples
from adibas.gestures.segments import Examples, Segment, at_one_length
from adibas.gestures.thresholds import (
    best_threshold,
    f1_by_threshold,
    standard_error,
    target,
)
from adibas.gestures.weighting import N_JOINTS, cautious_weights
from adibas.progress import Progress
from adibas.timeseries.mixture_stream import MixtureModel

FEWEST = 2


@dataclass(frozen=True, slots=True)
class TrainingParams:
    """How a recogniser is trained.

    Attributes
    ----------
    method : str
        See `GestureModel`.
    most_examples : int
        Examples a gesture that are aligned with the stream. 12.
    most_others : int
        Segments without a gesture that the likeness learns from. 400: costs grow with the square.
    most_mirrored : int
        Examples in streams up to which the likeness also tries mirrored copies. 400: of more there
        are both sides, or the side matters.
    most_folds : int
        Groups are joined to so many when thresholds are chosen. 5.
    gate_slack : float
        A proposal may cost so much more than the dearest right one. 1.1.
    seed : int
        Of the choices above.
    """

    method: Method = "likeness"
    most_examples: int = 12
    most_others: int = 400
    most_mirrored: int = 400
    most_folds: int = 5
    gate_slack: float = 1.1
    seed: int = 0


def train(
    examples: Examples,
    descriptor: DescriptorParams,
    params: TrainingParams | None = None,
    progress: Progress = lambda _done, _total: None,
) -> GestureModel:
    """Train a recogniser.

    Raises
    ------
    GestureError
        There are too few examples, or they are too short.
    """
    params = params or TrainingParams()
    check_examples(examples)
    if params.method in ("likeness", "hmm"):
        return _judged(examples, descriptor, params, progress)
    if params.method == "weighted-dtw":
        return _weighted_where_better(examples, descriptor, params, progress)
    return _by_cost(examples, descriptor, params, progress)[0]


def _weighted_where_better(
    examples: Examples, descriptor: DescriptorParams, params: TrainingParams, progress: Progress
) -> GestureModel:
    """Weigh the joints for those gestures that are clearly recognised better with weights.

    In people who were left out, by more than one standard error of F1.
    """
    weighted, f1 = _by_cost(examples, descriptor, params, progress)
    plain, plain_f1 = _by_cost(examples, descriptor, replace(params, method="dtw"), progress)
    counts = np.array([_count(examples, label) for label in range(len(examples.labels))])
    is_weighed = f1 > plain_f1 + standard_error(plain_f1, counts)
    thresholds = np.where(is_weighed, weighted.thresholds, plain.thresholds)
    weights = np.where(is_weighed[:, None], weighted.weights, plain.weights)
    return replace(weighted, weights=weights, thresholds=thresholds, gates=thresholds)


def _judged(
    examples: Examples, descriptor: DescriptorParams, params: TrainingParams, progress: Progress
) -> GestureModel:
    """Return a recogniser that learned what the others' examples rightly and wrongly propose."""
    model, found, folds = _left_out(examples, descriptor, params, progress)
    return _with_judge(model, examples, params, found, folds)


def _by_cost(
    examples: Examples, descriptor: DescriptorParams, params: TrainingParams, progress: Progress
) -> tuple[GestureModel, FloatArray]:
    """Return a recogniser with thresholds, and F1 (labels,) in people who were left out."""
    model, found, _ = _left_out(examples, descriptor, params, progress)
    costs = np.array([proposal.cost for proposal in found])
    right = np.array([target(one, examples)[one.label] > 0 for one in found], bool)
    labels = np.array([proposal.label for proposal in found], np.int64)
    thresholds, f1 = np.zeros((2, len(examples.labels)))
    for label in range(len(examples.labels)):
        mine, n_wanted = labels == label, _count(examples, label)
        thresholds[label] = best_threshold(costs[mine], right[mine], n_wanted)
        f1[label] = f1_by_threshold(costs[mine], right[mine], n_wanted).max(initial=0.0)
    return replace(model, thresholds=thresholds, gates=thresholds), f1


def _left_out(
    examples: Examples, descriptor: DescriptorParams, params: TrainingParams, progress: Progress
) -> tuple[GestureModel, list[Segment], tuple[IntArray, IntArray]]:
    """Return a model without thresholds, and what is proposed in streams of those left out.

    Then the part of each example and of each proposal.
    """
    rng = np.random.default_rng(params.seed)
    folds = _folds(examples.groups, params.most_folds, rng)
    model = _draft(examples, descriptor, params, rng)
    found: list[Segment] = []
    fold_of: list[int] = []
    for fold in np.unique(folds):
        progress(int(fold), int(folds.max()) + 2)
        proposals = _held_out(examples, descriptor, params, folds == fold)
        found += proposals
        fold_of += [int(fold)] * len(proposals)
    return model, found, (folds, np.array(fold_of, np.int64))


def check_examples(examples: Examples) -> None:
    """Say in words what is wrong with examples.

    Raises
    ------
    GestureError
        None at all, only one of a gesture, or too short ones.
    """
    if not examples.gestures:
        raise GestureError("There are no examples of gestures. Mark some in events.csv.")
    for label, name in enumerate(examples.labels):
        n_examples = sum(gesture.label == label for gesture in examples.gestures)
        if n_examples < FEWEST:
            raise GestureError(
                "There is only one example of {label}: nothing says yet how much it may vary. "
                "Record at least two, better from several people.",
                label=name,
            )
    for gesture in examples.gestures:
        if gesture.end - gesture.begin + 1 < SHORTEST or not _is_seen(examples, gesture):
            raise GestureError(
                "An example of {label} at {at} s cannot be used: it is shorter than {n} frames, or "
                "most joints were not seen. Mark it again, or remove it.",
                label=examples.labels[gesture.label],
                at=round(examples.streams[gesture.stream].time_s(gesture.begin), 2),
                n=SHORTEST,
            )


def _is_seen(examples: Examples, gesture: Segment) -> bool:
    return bool(np.isfinite(examples.frames_of(gesture)).mean() >= 0.5)  # noqa: PLR2004


def _folds(groups: IntArray, most: int, rng: np.random.Generator) -> IntArray:
    if len(np.unique(groups)) == 1:  # of one person: each example is measured by the others
        groups = np.arange(len(groups))
    names = rng.permutation(np.unique(groups))
    place = {int(name): at % most for at, name in enumerate(names)}
    return np.array([place[int(group)] for group in groups], np.int64)


def _draft(
    examples: Examples,
    descriptor: DescriptorParams,
    params: TrainingParams,
    rng: np.random.Generator,
) -> GestureModel:
    """Return a model without thresholds."""
    labels = np.array([gesture.label for gesture in examples.gestures], np.int64)
    chosen = chosen_examples(examples.groups, labels, params.most_examples, rng)
    frames = [examples.frames_of(examples.gestures[index]) for index in chosen]
    weights = np.full((len(examples.labels), N_JOINTS), 1.0 / N_JOINTS)
    if params.method == "weighted-dtw":
        weights = cautious_weights(examples, chosen)
    mixtures: tuple[MixtureModel, ...] = ()
    if params.method == "gmm-dtw":
        mixtures = mixtures_of(frames, labels[chosen], len(examples.labels), rng)
    anything = np.full(len(examples.labels), np.inf)
    return GestureModel(
        params.method, examples.labels, descriptor, tuple(frames), labels[chosen],
        weights, anything, anything, mixtures=mixtures,
    )  # fmt: skip


def _held_out(
    examples: Examples, descriptor: DescriptorParams, params: TrainingParams, held: BoolArray
) -> list[Segment]:
    """Return what the others' examples propose in the streams of those held out."""
    gestures = list(zip(examples.gestures, held, strict=True))
    others = [gesture for gesture, is_held in gestures if not is_held]
    if not others:
        return []
    kept = examples.picked(~held)
    aligner = _draft(kept, descriptor, params, np.random.default_rng(params.seed)).aligner()
    found = []
    for stream in sorted({gesture.stream for gesture, is_held in gestures if is_held}):
        trained_here = [other for other in others if other.stream == stream]
        found += [
            proposal
            for proposal in aligner.proposals(examples.streams[stream].frames, stream)
            if not any(proposal.overlap(other) > 0 for other in trained_here)
        ]
    return found


def _count(examples: Examples, label: int) -> int:
    return sum(gesture.label == label for gesture in examples.gestures)


def _with_judge(
    model: GestureModel,
    examples: Examples,
    params: TrainingParams,
    found: list[Segment],
    folds: tuple[IntArray, IntArray],
) -> GestureModel:
    """Learn how much a segment is like each gesture, from examples and proposals."""
    n_labels = len(examples.labels)
    targets = np.array([target(one, examples) for one in [*examples.gestures, *found]])
    fold_of = np.concatenate(folds)
    n_given = len(examples.gestures)
    whole = np.arange(n_given)
    chosen = whole if examples.is_isolated else _balanced(targets, n_given, params)
    segments = [*examples.gestures, *found]
    pieces = [at_one_length(examples.frames_of(segments[index])) for index in chosen]
    if examples.is_isolated:
        # Sets of clips hold gestures that the side makes, such as a swipe to the left.
        params = replace(params, most_mirrored=0)
    best = _judging_of(pieces, targets[chosen], fold_of[chosen], chosen < n_given, params)
    is_right = targets[n_given:] > 0
    gates = np.array([_gate(label, found, is_right, params) for label in range(n_labels)])
    thresholds = np.full(n_labels, best.threshold)
    return replace(model, thresholds=thresholds, gates=gates, judge=best.training.fitted())


@dataclass(frozen=True, slots=True, eq=False)
class _Judging:
    """What was learned, and how it does on those who were left out."""

    training: LikenessTraining | MarkovTraining
    threshold: float
    f1: float


def _judging_of(
    pieces: list[FloatArray],
    targets: FloatArray,
    folds: IntArray,
    given: BoolArray,
    params: TrainingParams,
) -> _Judging:
    """Learn from the pieces; where examples are few, from mirrored copies as well.

    Some gestures are done with either side, and few people show it; with others the side makes
    the gesture. Copies are left out where who was left out is recognised worse with them, by more
    than one standard error; or where nothing is missed without them.
    """
    if params.method == "hmm":
        return _judging(MarkovTraining(pieces, targets, params.seed), targets, folds, given)
    training = LikenessTraining.of(pieces, targets, LikenessParams())
    plain = _judging(training, targets, folds, given)
    n_given = int(given.sum())
    if n_given > params.most_mirrored:
        return plain
    right = np.flatnonzero(targets.any(axis=1))
    more = [mirrored(pieces[index]) for index in right]
    training = LikenessTraining.of(
        [*pieces, *more], np.concatenate([targets, targets[right]]), LikenessParams()
    )
    both = _judging(training, targets, np.concatenate([folds, folds[right]]), given)
    return both if both.f1 > plain.f1 - standard_error(plain.f1, n_given) else plain


def _judging(
    training: LikenessTraining | MarkovTraining,
    targets: FloatArray,
    folds: IntArray,
    given: BoolArray,
) -> _Judging:
    """Judge the first pieces, of which `targets` and `given` tell; mirrored ones may follow."""
    n_pieces = len(targets)
    predicted = training.held_out(folds)[:n_pieces]
    costs = 1.0 - predicted.max(axis=1)
    right = targets[np.arange(n_pieces), predicted.argmax(axis=1)] > 0
    counted = given | ~right
    n_wanted = int(given.sum())
    return _Judging(
        training,
        best_threshold(costs[counted], right[counted], n_wanted),
        float(f1_by_threshold(costs[counted], right[counted], n_wanted).max()),
    )


def _balanced(targets: FloatArray, n_given: int, params: TrainingParams) -> IntArray:
    rng = np.random.default_rng(params.seed)
    others = n_given + np.flatnonzero(~targets[n_given:].any(axis=1))
    alike = n_given + np.flatnonzero(targets[n_given:].any(axis=1))
    parts = [rng.permutation(part)[: params.most_others] for part in (others, alike)]
    return np.sort(np.concatenate([np.arange(n_given), *parts]))


def _gate(label: int, found: list[Segment], is_right: BoolArray, params: TrainingParams) -> float:
    right = [
        one.cost
        for one, rows in zip(found, is_right, strict=True)
        if one.label == label and rows[label]
    ]
    return params.gate_slack * max(right) if right else float("inf")
