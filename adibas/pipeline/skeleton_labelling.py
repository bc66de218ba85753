"""Point sets of a file get names; the shipped model, or one of the clinic's own."""

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from adibas.errors import FileError
from adibas.resources import resource_path
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.model_files import read_model
from adibas.skeleton.namer import Namer
from adibas.skeleton.points_csv import PointSet, read_points, write_points

Progress = Callable[[int, int], None]

DIGITS = 3


@dataclass(frozen=True, slots=True)
class LabelledFile:
    """What was named.

    Attributes
    ----------
    n_shapes, n_points : int
    n_named : int
        Points that got a name or had one.
    n_unsure : int
        Points that most probably have a name, but not surely enough.
    """

    n_shapes: int
    n_points: int
    n_named: int
    n_unsure: int


@functools.cache
def shipped_namer() -> Namer:
    """Return the namer of the 15 joints that is part of the program; it is read once."""
    return Namer(read_model(resource_path("models", "skeleton.json")))


def label_file(
    path: Path, model: Path | None, view: str, out: Path, progress: Progress
) -> LabelledFile:
    """Name the points of a CSV file that have no name yet, and write them all to another.

    Parameters
    ----------
    model : Path or None
        None: the shipped one.
    view : str
        Of the shapes that tell none themselves; empty: the sides are inferred.

    Raises
    ------
    FileError
        A file is missing or broken, or the model does not fit the points.
    """
    namer = shipped_namer() if model is None else Namer(read_model(model))
    sets = read_points(path)
    labelled, confidences, guesses = [], [], []
    n_named = n_unsure = 0
    for done, one in enumerate(sets, 1):
        if not namer.knows(one.positions_m.shape[1]):
            raise FileError(
                "{file}: the model knows no points with {n} coordinates. Train one with such "
                "shapes.",
                file=path.name,
                n=one.positions_m.shape[1],
            )
        result = namer.label(one.positions_m, one.view or view)
        named = _with_given(one, result)
        labelled.append(named)
        confidences.append(
            [
                "" if given else f"{confidence:.{DIGITS}f}"
                for given, confidence in zip(one.labels, result.confidences, strict=True)
            ]
        )
        guesses.append([guess or "" for guess in result.guesses])
        n_named += sum(bool(label) for label in named.labels)
        n_unsure += sum(
            bool(guess) and not label
            for guess, label in zip(result.guesses, named.labels, strict=True)
        )
        progress(done, len(sets))
    write_points(labelled, out, {"confidence": confidences, "guess": guesses})
    n_points = sum(len(one.points) for one in sets)
    return LabelledFile(len(sets), n_points, n_named, n_unsure)


def _with_given(one: PointSet, result: Labelling) -> PointSet:
    """Keep the names that the file gives; none of them is given twice."""
    given = set(one.labels)
    labels = tuple(
        own or (name if name is not None and name not in given else "")
        for own, name in zip(one.labels, result.names, strict=True)
    )
    return replace(one, labels=labels)
