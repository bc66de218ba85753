"""Names of markers of simulated people who move, as a depth camera sees them, frame after frame.

People, clothes, furniture, sensors and movements that no model learned from; what is hidden in a
frame is missing in it. Each film is named as a whole, as a recording is: with the body that is
found in the depth, without, and with it where nobody declared the view; and as it goes on, as the
live view does, which knows nothing of later frames and takes the view for what was declared.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias

import numpy as np

from adibas.data.joints import JOINT_NAMES
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.marked_films import FILM_KINDS, MarkedFilm, marked_films
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import upright_turn
from adibas.skeleton.first_view import first_view
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.namer import Namer
from adibas.skeleton.tracking import MovingPoints, NamesSoFar, name_movement
from benchmarks.accuracy_labelling import SEED
from benchmarks.labelling_names import NamesCount, seen_from
from benchmarks.table import Row

Names: TypeAlias = tuple[str | None, ...]

N_FILMS = 64
SHARE_OF_QUICK = 8


def rows(*, quick: bool) -> Iterable[Row]:
    """Name each film in each of `WAYS`; `quick`: an eighth of them."""
    counts: defaultdict[tuple[str, str], NamesCount] = defaultdict(NamesCount)
    n_films = N_FILMS // SHARE_OF_QUICK if quick else N_FILMS
    for film in marked_films(SEED, n_films):
        for way in WAYS:
            count_film(counts[film.kind, way], film, way)
    for kind in FILM_KINDS:
        for way in WAYS:
            told = f"{kind}, frames of films as a depth camera sees them, seed {SEED}, {way}"
            yield from counts[kind, way].rows(told)


def count_film(count: NamesCount, film: MarkedFilm, way: str) -> None:
    """Name a film in one of `WAYS`, and count the names of each of its frames."""
    for names, picture in zip(WAYS[way](film), film.pictures, strict=True):
        count.add(names, picture.names)


def _by_places(film: MarkedFilm) -> list[Names]:
    return _named(film, film.view, knows_body=False)


def _by_body(film: MarkedFilm) -> list[Names]:
    return _named(film, film.view, knows_body=True)


def _undeclared(film: MarkedFilm) -> list[Names]:
    """Name a film as a recording of which nobody declared the view."""
    told = first_view(shipped_namer(), _frames(film, knows_body=False))
    return _named(film, "" if told is None else told.view, knows_body=True)


def _named(film: MarkedFilm, view: str, *, knows_body: bool) -> list[Names]:
    named = name_movement(shipped_namer(), _frames(film, knows_body=knows_body), view)
    return [one.names for one in named]


def _alone(film: MarkedFilm) -> list[Names]:
    return [labelling.names for _frame, labelling in _each_alone(film)]


def _live(film: MarkedFilm) -> list[Names]:
    so_far = NamesSoFar(JOINT_NAMES)
    return [
        so_far.hear(frame.points_m, frame.time_s, labelling).names
        for frame, labelling in _each_alone(film)
    ]


WAYS: dict[str, Callable[[MarkedFilm], list[Names]]] = {
    "body not known": _by_places,
    "body known": _by_body,
    "view not declared, body known": _undeclared,
    "each frame alone, body known": _alone,
    "live, body known": _live,
}


def _each_alone(film: MarkedFilm) -> Iterator[tuple[MovingPoints, Labelling]]:
    """Give what each frame says by itself, as in the live view."""
    namer = shipped_namer().holding_still()
    for frame in _frames(film, knows_body=True):
        knowing = _knowing(namer, frame, film.view)
        yield frame, knowing.label(frame.points_m, film.view)


def _knowing(namer: Namer, frame: MovingPoints, view: str) -> Namer:
    """Return who names a frame live: of all 15 markers places tell enough."""
    if frame.body is None or not 0 < len(frame.points_m) < len(JOINT_NAMES):
        return namer
    odds = frame.body(view)
    return namer if odds is None else namer.who_sees(odds)


def _frames(film: MarkedFilm, *, knows_body: bool) -> Iterator[MovingPoints]:
    for time_s, picture in zip(film.times_s.tolist(), film.pictures, strict=True):
        turn = RigidTransform(upright_turn(picture.up), np.zeros(3))
        body = seen_from(picture, turn) if knows_body else None
        yield MovingPoints(turn.apply(picture.points_m), time_s, body=body)
