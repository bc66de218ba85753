"""A skeleton model from the clinic's own corrected sessions, and whether it is worth having.

Each capture whose markers the clinician named or corrected is an example. Before a model is given,
the examples of each fifth of the patients are named by a model of all others and by the shipped
one, so that a worse model is told and not written.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from adibas.clock import Clock, utc_now
from adibas.data.joints import JOINT_NAMES
from adibas.errors import FileError
from adibas.pipeline.skeleton_examples import (
    Example,
    LandmarkSet,
    corrected_sets,
    examples_of,
    landmarks_of,
)
from adibas.pipeline.skeleton_labelling import shipped_knows, shipped_namer
from adibas.pipeline.skeleton_training import LEAST_NAMES, learn_sets
from adibas.progress import Progress
from adibas.sessions import SessionStore
from adibas.sessions.roles import Permission
from adibas.shapes.point_distribution import LEAST_SHAPES
from adibas.skeleton.model import SkeletonModel
from adibas.skeleton.namer import Namer
from adibas.skeleton.points_csv import PointSet

N_FOLDS = 5
LEAST_EXAMPLES = 10
"""Fewer tell neither how shapes vary nor whether a model is any good."""
LEAST_SHARE = 0.5
"""Of the examples that show a landmark: what fewer have is not learned."""


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

    def check(self) -> None:
        """Refuse a model that is not worth having.

        Raises
        ------
        FileError
            The shipped model is better, or more sets get a wrong name than all right ones.
        """
        if self.is_worse:
            raise FileError(
                "The shipped model names these captures better: {right} of {n} right, against "
                "{own}. Nothing is written. Name the markers of more captures.",
                right=self.shipped_right,
                n=self.n_examples,
                own=self.right,
            )
        if self.wrong > self.right:
            raise FileError(
                "Of {n} captures that the model had not seen it named {right} right and {wrong} "
                "with a mistake. Nothing is written. Name the markers of more captures.",
                n=self.n_examples,
                right=self.right,
                wrong=self.wrong,
            )


def train_from_sessions(
    store: SessionStore,
    progress: Progress,
    which: LandmarkSet | None = None,
    clock: Clock = utc_now,
) -> tuple[SkeletonModel, HeldOut]:
    """Learn a model from the corrected captures of a store, and hold it against the shipped one.

    Parameters
    ----------
    progress : callable
        Told (captures done, captures in all) while they are read, then while they are learned.
    which : LandmarkSet or None
        Whose captures; None where the store has those of one set alone.

    Raises
    ------
    FileError
        There are too few corrected captures, or they name too few points; or there are several
        sets, and none is chosen.
    NotAllowedError
        Who has the store open is no administrator.
    """
    store.require(Permission.CHANGE_PROTOCOLS)
    begun_utc = clock()
    found = corrected_sets(store)
    which = _only_one(found) if which is None else which
    examples = examples_of(store, which, found.get(which, ()), progress)
    if len(examples) < LEAST_EXAMPLES:
        raise FileError(
            "There are {n} captures with corrected names, and a model needs {least}. Name the "
            "markers of more captures.",
            n=len(examples),
            least=LEAST_EXAMPLES,
        )
    names = _names(which, examples)
    examples = tuple(replace(one, points=_only(names, one.points)) for one in examples)
    _check_whole(names, examples)
    store.note_export("training of names", *sorted({example.patient for example in examples}))
    held_out = _held_out(names, examples, progress)
    source = {
        "source": "corrected captures of a clinic",
        "protocol": which.protocol,
        "view": which.view,
        "n_captures": len(examples),
        "n_patients": len({example.patient for example in examples}),
        "held_out": {
            "n_examples": held_out.n_examples,
            "right": held_out.right,
            "wrong": held_out.wrong,
            "shipped_right": held_out.shipped_right,
            "shipped_wrong": held_out.shipped_wrong,
        },
    }
    points = [one.points for one in examples]
    return learn_sets("sessions", names, points, source, lambda: begun_utc), held_out


def _only_one(found: Mapping[LandmarkSet, Sequence[object]]) -> LandmarkSet:
    """Return the one set that has captures enough; else the one with most."""
    rich = [one for one, captures in found.items() if len(captures) >= LEAST_EXAMPLES]
    if len(rich) > 1:
        raise FileError(
            "The corrected captures mark different places: {sets}. Choose one with --protocol and "
            "--view.",
            sets=", ".join(" ".join(filter(None, (one.protocol, one.view))) or "-" for one in rich),
        )
    return max(found, key=lambda one: len(found[one]), default=LandmarkSet())


def _names(which: LandmarkSet, examples: Sequence[Example]) -> tuple[str, ...]:
    """Return the landmarks to learn: what the shipped model knows, or what enough examples show."""
    counts = Counter(label for example in examples for label in example.points.labels)
    if set(counts) == set(JOINT_NAMES) or shipped_knows(landmarks_of(which)):
        return shipped_namer().names
    least = LEAST_SHARE * len(examples)
    return tuple(sorted(label for label, n_shown in counts.items() if n_shown >= least))


def _check_whole(names: tuple[str, ...], examples: Sequence[Example]) -> None:
    """Refuse examples of which too few show all names; each fold has to learn without a part."""
    is_whole = {id(one): set(names) <= set(one.points.labels) for one in examples}
    n_least = min(sum(is_whole[id(one)] for one in others) for others, _out in _folds(examples))
    if n_least < LEAST_SHAPES or len(names) < LEAST_NAMES:
        raise FileError(
            "Of {n} corrected captures {n_whole} show all of these {n_names} landmarks, and a "
            "model needs more: {names}. Name all landmarks in each capture.",
            n=len(examples),
            n_whole=sum(is_whole.values()),
            n_names=len(names),
            names=", ".join(names),
        )


def _only(names: tuple[str, ...], points: PointSet) -> PointSet:
    """Return the points without the labels that are not learned."""
    labels = tuple(label if label in names else "" for label in points.labels)
    return replace(points, labels=labels)


def _held_out(names: tuple[str, ...], examples: Sequence[Example], progress: Progress) -> HeldOut:
    new = np.zeros(2, int)
    shipped = np.zeros(2, int)
    knows_names = names == shipped_namer().names
    n_done = 0
    for others, left_out in _folds(examples):
        progress(n_done, len(examples))
        model = learn_sets("sessions", names, [one.points for one in others], {}, utc_now)
        namer = Namer(model).holding_still()
        for example in left_out:
            new += _judged(namer, example.points)
            if knows_names:
                shipped += _judged(shipped_namer().holding_still(), example.points)
            n_done += 1
            progress(n_done, len(examples))
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
    found = tuple(name or "" for name in namer.label(points.positions_m, points.view).names)
    pairs = zip(found, points.labels, strict=True)
    is_wrong = any(name and name != label for name, label in pairs)
    return np.array([found == points.labels, is_wrong], int)
