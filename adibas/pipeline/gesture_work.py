"""What `adibas gestures` does: train on a folder, detect in a recording, evaluate."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from adibas.data.events import TimedEvent
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import SkeletonTrack
from adibas.errors import GestureError
from adibas.gestures.descriptor import DescriptorParams
from adibas.gestures.evaluation import Evaluation, compare, leave_one_out
from adibas.gestures.model import GestureModel, described_for
from adibas.gestures.model_file import read_model
from adibas.gestures.segments import Examples
from adibas.gestures.training import FEWEST, TrainingParams, check_examples, train
from adibas.pipeline.found_joints import JointSource, find_joints
from adibas.pipeline.gesture_examples import EVENTS_FILE, read_examples, unseen_joints
from adibas.pipeline.gesture_learning import Lesson, Trained, learn
from adibas.progress import Progress
from adibas.recordings.joints_csv import recording_name
from adibas.texts import message

LEFT_OUT = {
    "subject": message("one person"),
    "recording": message("one recording"),
    "example": message("one of them"),
}
"""At a time, by what examples are kept apart."""


@dataclass(frozen=True, slots=True)
class Detected:
    """Events of one recording, and what is to be said of it."""

    events: tuple[TimedEvent, ...]
    notices: tuple[Sentence, ...]


@dataclass(frozen=True, slots=True)
class Evaluated:
    """An evaluation, how it was split, and what is to be said."""

    protocol: str
    groups: int
    result: Evaluation
    notices: tuple[Sentence, ...]


def train_on_folder(
    folder: Path, params: TrainingParams, progress: Progress, *, is_tested: bool = False
) -> Trained:
    """Train on all examples of a folder; `is_tested`: say how well that works, too.

    Raises
    ------
    GestureError, RecordingError
        The examples cannot be used.
    """
    examples, rule, notices = read_examples(folder, DescriptorParams())
    source: dict[str, object] = {
        "events_sha256": hashlib.sha256((folder / EVENTS_FILE).read_bytes()).hexdigest()
    }
    lesson = Lesson(examples, rule, notices, source)
    return learn(lesson, params, progress, is_tested=is_tested)


def detect_in_file(source: JointSource, model_path: Path, progress: Progress) -> Detected:
    """Find the gestures of a model in a table of joints, or in a recording.

    Raises
    ------
    GestureError, RecordingError, CalibrationError, LimbError
        A file cannot be used, or nobody is in it.
    """
    model = read_model(model_path)
    joints = find_joints(source, progress)
    file = source.path
    notices = [*joints.notices, *unseen_joints(file.name, joints.tracks)]
    events: list[TimedEvent] = []
    for track in joints.tracks:
        notices += _gaps(file, track, model.descriptor)
        events += detected_events(recording_name(file), track, [model])
    return Detected(tuple(sorted(events, key=lambda event: event.begin_s)), tuple(notices))


def detected_events(
    recording: str, track: SkeletonTrack, models: Sequence[GestureModel]
) -> tuple[TimedEvent, ...]:
    """Return what models find in a track, one model after the other."""
    return tuple(
        TimedEvent(
            recording,
            model.labels[found.label],
            described.time_s(found.begin),
            described.time_s(found.end),
            person=track.person,
            cost=found.cost,
        )
        for model, described in described_for(models, track)
        for found in model.detect(described)
    )


def evaluate_folder(
    folder: Path, test: Path | None, params: TrainingParams, progress: Progress
) -> Evaluated:
    """Leave one subject out of `folder`, or train on it and test on `test`.

    Raises
    ------
    GestureError, RecordingError
        The examples cannot be used.
    """
    descriptor = DescriptorParams()
    examples, rule, notices = read_examples(folder, descriptor)
    check_examples(examples)
    n_groups = len(np.unique(examples.groups))
    if test is None:
        _check_left(examples, rule)
        result = leave_one_out(examples, descriptor, params, progress)
        return Evaluated(f"leave-one-{rule}-out", n_groups, result, notices)
    model = train(examples, descriptor, params, progress)
    others, _, more = read_examples(test, descriptor, examples.labels)
    return Evaluated("train-test", n_groups, compare(model, others), (*notices, *more))


def _check_left(examples: Examples, rule: str) -> None:
    """See that enough of each gesture is left to learn from, whatever is left out."""
    for label, n_left in enumerate(examples.fewest_left()):
        if n_left < FEWEST:
            raise GestureError(
                "{label} cannot be evaluated: without {left_out} there are {n} of its {total} "
                "examples to learn from, and {least} are needed. Record it more often, better with "
                "more people, or give other examples with --test.",
                label=examples.labels[label],
                left_out=LEFT_OUT[rule],
                n=int(n_left),
                total=sum(gesture.label == label for gesture in examples.gestures),
                least=FEWEST,
            )


def evaluation_document(evaluated: Evaluated, params: TrainingParams) -> dict[str, object]:
    """Return an evaluation as plain values for JSON."""
    result = evaluated.result
    precision, recall, f1 = result.rates_of(range(len(result.labels)))
    return {
        "protocol": evaluated.protocol,
        "seed": params.seed,
        "method": params.method,
        "isolated": result.is_isolated,
        "n_groups": evaluated.groups,
        "n_samples": int(result.n_done.sum()),
        "accuracy": result.accuracy,
        "accuracy_7_7": result.accuracy_7_7,
        "not_classified": int(result.missed.sum()),
        "false_alarms": result.false_alarms,
        "false_alarms_per_hour": 3600.0 * result.false_alarms / max(result.seconds, 1e-9),
        "precision": precision,
        "recall": recall,
        "f1": f1,
        "labels": list(result.labels),
        "confusion": result.confusion.tolist(),
        "per_class": {label: _rates(result, number) for number, label in enumerate(result.labels)},
        "begin_error_frames": _median(result.begin_errors.tolist()),
        "end_error_frames": _median(result.end_errors.tolist()),
        "frames_per_second": DescriptorParams().rate_hz,
    }


def _rates(result: Evaluation, label: int) -> dict[str, float]:
    precision, recall, f1 = result.rates_of([label])
    return {
        "precision": precision,
        "recall": recall,
        "f1": f1,
        "accuracy_7_7": result.accuracy_of(label),
    }


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else 0.0


def _gaps(path: Path, track: SkeletonTrack, params: DescriptorParams) -> list[Sentence]:
    steps_s = np.diff(track.times_s)
    n_gaps = int((steps_s > params.longest_gap_s).sum())
    if not n_gaps:
        return []
    return [
        Sentence(
            message(
                "{file}: gaps of more than {longest} s in the joints: {n} (the longest {most} s); "
                "no gesture is looked for across them."
            ),
            {
                "file": path.name,
                "n": n_gaps,
                "longest": params.longest_gap_s,
                "most": float(steps_s.max()),
            },
        )
    ]
