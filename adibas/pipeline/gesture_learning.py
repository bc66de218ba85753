"""From examples of gestures to a model, and how well it knows those that it did not learn from.

One way for a folder of examples and for what an observer marked in a recording.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime

import numpy as np

from adibas import __version__
from adibas.arrays import FloatArray, IntArray
from adibas.data.coding import MS_PER_S, Occurrence
from adibas.data.events import TimedEvent
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.errors import GestureError
from adibas.gestures.descriptor import DESCRIBED_JOINTS, NECK, DescriptorParams, mirrored
from adibas.gestures.evaluation import Evaluation, leave_one_out
from adibas.gestures.model import GestureModel
from adibas.gestures.segments import Examples, at_one_length
from adibas.gestures.training import FEWEST, TrainingParams, check_examples, train
from adibas.gestures.weighting import weights_of_gestures
from adibas.pipeline.behaviour_activity import subject_of
from adibas.pipeline.gesture_examples import examples_of
from adibas.progress import Progress
from adibas.texts import message
from adibas.timeseries.dtw import cross_costs

EXAMPLE, PART = "example", "part"
MOST_PARTS = 20
"""Examples are left out one by one up to here; more are left out in so many parts."""
MIRROR_RATIO = 1.5
"""An example that is so much nearer to the mirror image is done with the other side."""
BRIDGED = 2.0
"""The alignment stretches and squeezes by this much at most."""

TOO_FEW_TO_TEST = message(
    "There are too few examples to leave one out and learn from the others: three of each gesture "
    "say how well it is known, more say it better."
)
UNEVEN = message(
    "The examples of {label} last from {shortest} to {longest} s: what takes more than "
    "twice as long is not taken for the same. Check their ends, or learn two gestures."
)
BOTH_SIDES = message(
    "Some examples of {label} look like the mirror image of others. If the side matters, learn a "
    "gesture for each; if it does not, mark several of both."
)
NOBODY_NAMED = message(
    "Examples that do not say which person of the recording they are of: {n}. The one who is seen "
    "longest is taken."
)
NOBODY_THERE = message("Examples at whose time nobody's joints were found are left out: {n}.")
WEIGHED_ALIKE = message(
    "All joints are weighed alike: with weights of their own, those who were left out are "
    "not clearly recognised better."
)
ALL_ALIKE = message(
    "No joint tells {label} from the rest: all count alike. Mark every one, within a longer "
    "recording."
)


@dataclass(frozen=True, slots=True, eq=False)
class Lesson:
    """What is learned from.

    Attributes
    ----------
    examples : Examples
    rule : str
        By what they are kept apart: ``subject``, ``recording`` or ``example``.
    notices : tuple of Sentence
    source : dict
        What of them goes into the model's provenance.
    """

    examples: Examples
    rule: str
    notices: tuple[Sentence, ...] = ()
    source: dict[str, object] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Trained:
    """A model, and what is to be said of it.

    Attributes
    ----------
    model : GestureModel
    n_examples : int
    weights : (labels, 14) array
        How well each of `DESCRIBED_JOINTS` tells each gesture from everything else; the sum of a
        row is 1. They explain; a model that uses weights has its own.
    notices : tuple of Sentence
    tested : Evaluation or None
        On examples that were left out; None where that was not asked for, or cannot be done.
    rule : str
        What was left out: one ``subject``, ``recording``, ``example``, or ``part`` of the examples.
    """

    model: GestureModel
    n_examples: int
    weights: FloatArray
    notices: tuple[Sentence, ...]
    tested: Evaluation | None = None
    rule: str = EXAMPLE


def learn(
    lesson: Lesson, params: TrainingParams, progress: Progress, *, is_tested: bool
) -> Trained:
    """Train on all examples; `is_tested`: leave each out in turn, too.

    Raises
    ------
    GestureError
        There are too few examples, or they cannot be used.
    """
    examples, descriptor = lesson.examples, DescriptorParams()
    model = train(examples, descriptor, params, progress)
    weights = weights_of_gestures(examples)
    notices = [*lesson.notices, *_uneven(examples), *_both_sides(examples)]
    notices += _alike(examples.labels, weights)
    if params.method == "weighted-dtw" and np.ptp(model.weights) == 0:
        notices.append(Sentence(WEIGHED_ALIKE))
    tested, rule = None, lesson.rule
    if is_tested:
        rule, groups = _left_out(examples, lesson.rule)
        if groups is None:
            notices.append(Sentence(TOO_FEW_TO_TEST))
        else:
            apart = replace(examples, groups=groups)
            tested = leave_one_out(apart, descriptor, params, progress)
    provenance: dict[str, object] = {
        "version": __version__,
        "created_utc": datetime.now(UTC).isoformat(timespec="seconds"),
        **lesson.source,
        "n_examples": len(examples.gestures),
        "n_streams": len(examples.streams),
        "n_groups": len(np.unique(examples.groups)),
        "split_by": lesson.rule,
        "is_isolated": examples.is_isolated,
        "training": asdict(params),
        "joint_weights": weights_document(examples.labels, weights),
    }
    if tested is not None:
        provenance["left_out"] = {"rule": rule, "accuracy": tested.accuracy}
    whole = replace(model, provenance=provenance)
    return Trained(whole, len(examples.gestures), weights, tuple(notices), tested, rule)


def weights_document(labels: Sequence[str], weights: FloatArray) -> dict[str, dict[str, float]]:
    """Return `Trained.weights` by gesture and joint."""
    return {
        label: {
            joint: round(float(weight), 4)
            for joint, weight in zip(DESCRIBED_JOINTS, row, strict=True)
        }
        for label, row in zip(labels, weights, strict=True)
    }


def marked_lesson(
    name: str,
    occurrences: Sequence[Occurrence],
    tracks: Sequence[SkeletonTrack],
    recording: str,
) -> Lesson:
    """Return what can be learned from events that an observer coded in a recording.

    Parameters
    ----------
    name : str
        Of the gesture from now on.
    occurrences : sequence of Occurrence
        Its examples.
    tracks : sequence of SkeletonTrack
        Joints of everybody; who is seen longest comes first.
    recording : str

    Raises
    ------
    GestureError
        There are too few examples, or they cannot be used.
    """
    known = {subject_of(track.person): track for track in tracks if track.seen[:, NECK].any()}
    if not known:
        raise GestureError(
            "{recording}: no neck is seen, from which all joints are measured. Record again with "
            "the whole upper body in view.",
            recording=recording,
        )
    lasting = [one for one in occurrences if one.duration_ms]
    if not lasting:
        raise GestureError(
            "{label} has no example with a begin and an end. Code it as a state, from where each "
            "one begins to where it ends.",
            label=name,
        )
    first = next(iter(known.values()))
    n_unnamed = sum(one.subject not in known for one in lasting) if len(known) > 1 else 0
    pairs = [(one, known.get(one.subject, first)) for one in lasting]
    seen = [(one, track) for one, track in pairs if _is_there(one, track)]
    told = ((n_unnamed, NOBODY_NAMED), (len(pairs) - len(seen), NOBODY_THERE))
    notices = tuple(Sentence(text, {"n": n}) for n, text in told if n)
    if not seen:
        raise GestureError(
            "Nobody's joints were found where {label} is marked. Mark examples in which the whole "
            "upper body is in view.",
            label=name,
        )
    examples, rule, more = examples_of(
        {(recording, track.person): track for track in known.values()},
        [_event(one, track, name, recording) for one, track in seen],
        DescriptorParams(),
    )
    check_examples(examples)
    return Lesson(examples, rule, (*notices, *more), {"source": "events marked by an observer"})


def _is_there(one: Occurrence, track: SkeletonTrack) -> bool:
    piece = track.between(one.begin_ms / MS_PER_S, one.end_ms / MS_PER_S)
    return bool(piece.seen[:, NECK].any())


def _event(one: Occurrence, track: SkeletonTrack, name: str, recording: str) -> TimedEvent:
    return TimedEvent(
        *(recording, name, one.begin_ms / MS_PER_S, one.end_ms / MS_PER_S),
        *(subject_of(track.person), track.person),
    )


def _left_out(examples: Examples, rule: str) -> tuple[str, IntArray | None]:
    """Return what is left out in turn; None where too little would be left to learn from."""
    single = np.arange(len(examples.gestures))
    parts = (EXAMPLE, single) if len(single) <= MOST_PARTS else (PART, single % MOST_PARTS)
    whole = parts if rule == EXAMPLE else (rule, examples.groups)
    for kind, groups in (whole, parts):
        if (replace(examples, groups=groups).fewest_left() >= FEWEST).all():
            return kind, groups
    return rule, None


def _uneven(examples: Examples) -> list[Sentence]:
    found = []
    for label, name in enumerate(examples.labels):
        lengths_s = [
            (one.end - one.begin + 1) / examples.streams[one.stream].rate_hz
            for one in examples.gestures
            if one.label == label
        ]
        shortest, longest = min(lengths_s), max(lengths_s)
        if longest > BRIDGED * shortest:
            told = {"label": name, "shortest": shortest, "longest": longest}
            found.append(Sentence(UNEVEN, told))
    return found


def _both_sides(examples: Examples) -> list[Sentence]:
    """Say which gestures have examples that are nearer to the mirror image of the first one."""
    found = []
    for label, name in enumerate(examples.labels):
        pieces = [
            at_one_length(examples.frames_of(one))
            for one in examples.gestures
            if one.label == label
        ]
        first, others = pieces[0], pieces[1:]
        as_is, exchanged = cross_costs(others, [first, mirrored(first)]).T
        with np.errstate(invalid="ignore"):
            if (as_is > MIRROR_RATIO * exchanged).any():
                found.append(Sentence(BOTH_SIDES, {"label": name}))
    return found


def _alike(labels: Sequence[str], weights: FloatArray) -> list[Sentence]:
    return [
        Sentence(ALL_ALIKE, {"label": label})
        for label, row in zip(labels, weights, strict=True)
        if np.ptp(row) == 0.0
    ]
