"""A skeleton model from the clinic's own corrected sessions, and whether it is worth having.

Each capture whose markers the clinician named or corrected is an example. Before a model is given,
the examples of each fifth of the patients are named by a model of all others and by the shipped
one, so that a worse model is told and not written.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from adibas.clock import Clock, utc_now
from adibas.data.joints import JOINT_NAMES
from adibas.data.sessions import Capture
from adibas.errors import FileError
from adibas.measures.sight_plane import vertical_of
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import upright_turn
from adibas.pipeline.skeleton_training import LEAST_NAMES, learn_sets
from adibas.progress import Progress
from adibas.sessions import SessionStore
from adibas.skeleton.model import SkeletonModel
from adibas.skeleton.namer import Namer
from adibas.skeleton.points_csv import PointSet

MOST_PATIENTS = 1_000_000
N_FOLDS = 5
LEAST_EXAMPLES = 10
"""Fewer tell neither how shapes vary nor whether a model is any good."""
UNNAMED = "m"


@dataclass(frozen=True, slots=True)
class Example:
    """One corrected capture, and whose."""

    patient: str
    points: PointSet


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Of examples that the model had not seen: how many were named without a wrong name, and all.

    Attributes
    ----------
    n_examples : int
    right, wrong : int
        By the new model: entirely right; with a name that is wrong.
    shipped_right, shipped_wrong : int or None
        By the shipped one; None where it knows other names.
    """

    n_examples: int
    right: int
    wrong: int
    shipped_right: int | None
    shipped_wrong: int | None

    @property
    def is_worse(self) -> bool:
        """Say whether the shipped model names more sets right, or fewer wrong."""
        if self.shipped_right is None or self.shipped_wrong is None:
            return False
        return self.right < self.shipped_right or self.wrong > self.shipped_wrong


def corrected_examples(store: SessionStore, progress: Progress) -> tuple[Example, ...]:
    """Return the captures of all patients in whose markers something was corrected."""
    rows = store.patients.search("", limit=MOST_PATIENTS)
    found: list[Example] = []
    for number, row in enumerate(rows, 1):
        for session in store.sessions.of_patient(row.pseudonym):
            for capture in store.captures.of_session(session.session_id):
                points = _points(capture)
                if points is not None:
                    found.append(Example(row.pseudonym, points))
        progress(number, len(rows))
    return tuple(found)


def train_from_sessions(
    store: SessionStore, progress: Progress, clock: Clock = utc_now
) -> tuple[SkeletonModel, HeldOut]:
    """Learn a model from the corrected captures of a store, and hold it against the shipped one.

    Raises
    ------
    FileError
        There are too few corrected captures, or they name too few points.
    """
    examples = corrected_examples(store, progress)
    if len(examples) < LEAST_EXAMPLES:
        raise FileError(
            "There are {n} captures with corrected names, and a model needs {least}. Name the "
            "markers of more captures.",
            n=len(examples),
            least=LEAST_EXAMPLES,
        )
    names = _names(examples)
    source = {
        "source": "corrected captures of a clinic",
        "n_captures": len(examples),
        "n_patients": len({example.patient for example in examples}),
    }
    held_out = _held_out(names, examples)
    model = learn_sets("sessions", names, [one.points for one in examples], source, clock)
    checked = {**model.provenance, "held_out": {
        "n_examples": held_out.n_examples, "right": held_out.right, "wrong": held_out.wrong,
        "shipped_right": held_out.shipped_right, "shipped_wrong": held_out.shipped_wrong,
    }}  # fmt: skip
    return replace(model, provenance=checked), held_out


def _points(capture: Capture) -> PointSet | None:
    """Return the named markers of a capture, upright; None where nobody corrected it."""
    if capture.history.n_done == 0:
        return None
    named = [
        (marker.label, marker.position_m)
        for marker in capture.markers()
        if marker.position_m is not None and not _is_number(marker.label)
    ]
    if len(named) < LEAST_NAMES:
        return None
    labels = tuple(label for label, _ in named)
    positions_m = np.stack([position_m for _, position_m in named])
    upright_m = positions_m @ upright_turn(vertical_of(capture.calibration).up).T
    return PointSet(capture.capture_id, labels, labels, upright_m, capture.view)


def _is_number(label: str) -> bool:
    return label.startswith(UNNAMED) and label.removeprefix(UNNAMED).isdecimal()


def _names(examples: Sequence[Example]) -> tuple[str, ...]:
    found = {label for example in examples for label in example.points.labels}
    return JOINT_NAMES if found == set(JOINT_NAMES) else tuple(sorted(found))


def _held_out(names: tuple[str, ...], examples: Sequence[Example]) -> HeldOut:
    new = np.zeros(2, int)
    shipped = np.zeros(2, int)
    knows_names = names == shipped_namer().names
    for others, left_out in _folds(examples):
        model = learn_sets("sessions", names, [one.points for one in others], {}, utc_now)
        namer = Namer(model)
        for example in left_out:
            new += _judged(namer, example.points)
            if knows_names:
                shipped += _judged(shipped_namer(), example.points)
    return HeldOut(
        len(examples),
        int(new[0]),
        int(new[1]),
        int(shipped[0]) if knows_names else None,
        int(shipped[1]) if knows_names else None,
    )


def _folds(examples: Sequence[Example]) -> Iterator[tuple[list[Example], list[Example]]]:
    """Give the examples without and of each group of patients; of a single one, of captures."""
    patients = sorted({example.patient for example in examples})
    keys = (
        [patients.index(example.patient) for example in examples]
        if len(patients) > 1
        else list(range(len(examples)))
    )
    n_folds = min(N_FOLDS, len(set(keys)))
    for fold in range(n_folds):
        is_left_out = [key % n_folds == fold for key in keys]
        yield (
            [one for one, out in zip(examples, is_left_out, strict=True) if not out],
            [one for one, out in zip(examples, is_left_out, strict=True) if out],
        )


def _judged(namer: Namer, points: PointSet) -> np.ndarray[tuple[int], np.dtype[np.int_]]:
    """Return whether all names are right, and whether one is wrong: two numbers, 0 or 1."""
    found = namer.label(points.positions_m, points.view).names
    is_wrong = any(
        name is not None and name != label for name, label in zip(found, points.labels, strict=True)
    )
    return np.array([found == points.labels, is_wrong], int)
