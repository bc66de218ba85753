"""Point sets of a file get names; the shipped model, or one of the clinic's own."""

import functools
import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from adibas.errors import FileError
from adibas.progress import Progress
from adibas.resources import resource_path
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.model_files import read_model
from adibas.skeleton.namer import Namer
from adibas.skeleton.points_csv import PointSet, read_points, write_points
from adibas.skeleton.postures import NearestPosture
from adibas.skeleton.tracking import MovingPoints, TrackedNames, name_movement

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


def shipped_knows(landmarks: Collection[str]) -> bool:
    """Say whether the shipped model names all of these landmarks, of which there are some."""
    return bool(landmarks) and set(landmarks) <= set(shipped_namer().names)


@dataclass(frozen=True, slots=True)
class LabelRequest:
    """What to name.

    Attributes
    ----------
    points : Path
        A file of point sets.
    model : Path or None
        None: the shipped one.
    view : str
        Of the shapes that tell none themselves, of a movement where no frame does; empty: the sides
        are inferred.
    frames_per_s : float or None
        The shapes are frames of one movement, in their order, so many a second; None: each stands
        for itself.
    holds_still : bool
        Whether the shapes are of people who hold still, as in a capture.
    with_posture : bool
        Whether each shape that stands for itself is told which posture it is nearest to.
    """

    points: Path
    model: Path | None = None
    view: str = ""
    frames_per_s: float | None = None
    holds_still: bool = False
    with_posture: bool = False


def label_file(request: LabelRequest, out: Path, progress: Progress) -> LabelledFile:
    """Name the points of a CSV file that have no name yet, and write them all to another.

    Raises
    ------
    FileError
        A file is missing or broken, or the model does not fit the points.
    """
    namer = shipped_namer() if request.model is None else Namer(read_model(request.model))
    if request.holds_still:
        namer = namer.holding_still()
    sets = read_points(request.points)
    labelled, confidences, guesses = [], [], []
    postures: list[NearestPosture] = []
    n_named = n_unsure = 0
    for done, (one, words) in enumerate(_all_words(namer, sets, request), 1):
        named = _with_given(one, words)
        labelled.append(named)
        confidences.append(
            [
                "" if given else f"{confidence:.{DIGITS}f}"
                for given, confidence in zip(one.labels, words.confidences, strict=True)
            ]
        )
        guesses.append([guess or "" for guess in words.guesses])
        if request.with_posture:
            heading_rad = words.heading_rad if isinstance(words, Labelling) else math.nan
            view = one.view or request.view
            postures.append(namer.posture(one.positions_m, view, heading_rad))
        n_named += sum(bool(label) for label in named.labels)
        n_unsure += sum(
            bool(guess) and not label
            for guess, label in zip(words.guesses, named.labels, strict=True)
        )
        progress(done, len(sets))
    columns = {"confidence": confidences, "guess": guesses, **_columns(labelled, postures)}
    write_points(labelled, out, columns)
    n_points = sum(len(one.points) for one in sets)
    return LabelledFile(len(sets), n_points, n_named, n_unsure)


def _columns(
    sets: Sequence[PointSet], postures: Sequence[NearestPosture]
) -> dict[str, list[list[str]]]:
    """Return the posture of each shape and how far from it, again for each of its points."""
    if not postures:
        return {}
    pairs = list(zip(sets, postures, strict=True))
    return {
        "posture": [[found.kind] * len(one.points) for one, found in pairs],
        "posture_distance": [
            [f"{found.distance:.{DIGITS}f}"] * len(one.points) for one, found in pairs
        ],
    }


def _all_words(
    namer: Namer, sets: Sequence[PointSet], request: LabelRequest
) -> Iterator[tuple[PointSet, Labelling | TrackedNames]]:
    """Give each set with what is said of its points; of a movement, by all other frames, too."""
    for one in sets:
        n_dimensions = one.positions_m.shape[1]
        if not namer.knows(n_dimensions):
            raise FileError(
                "{file}: the model knows no points with {n} coordinates. Train one with such "
                "shapes.",
                file=request.points.name,
                n=n_dimensions,
            )
    if request.frames_per_s is None:
        for one in sets:
            view = one.view or request.view
            yield one, namer.label(one.positions_m, view, one.diameters_m, one.labels)
        return
    if len({one.positions_m.shape[1] for one in sets}) > 1:
        raise FileError(
            "{file}: the frames of a movement must all have z_m, or none.",
            file=request.points.name,
        )
    frames = [
        MovingPoints(one.positions_m, number / request.frames_per_s, one.labels)
        for number, one in enumerate(sets)
    ]
    view = next((one.view for one in sets if one.view), request.view)
    yield from zip(sets, name_movement(namer, frames, view), strict=True)


def _with_given(one: PointSet, result: Labelling | TrackedNames) -> PointSet:
    """Keep the names that the file gives; none of them is given twice."""
    given = set(one.labels)
    labels = tuple(
        own or (name if name is not None and name not in given else "")
        for own, name in zip(one.labels, result.names, strict=True)
    )
    return replace(one, labels=labels)
