"""Names of markers of simulated people who move, as a depth camera sees them, frame after frame.

People, clothes, furniture, sensors and movements that no model learned from; what is hidden in a
frame is missing in it. Each film is named as a whole, as a recording is: once with the body that is
found in the depth, once without.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator

import numpy as np

from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.marked_films import FILM_KINDS, MarkedFilm, marked_films
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import upright_turn
from adibas.skeleton.tracking import MovingPoints, name_movement
from benchmarks.accuracy_labelling import SEED
from benchmarks.labelling_names import NamesCount, seen_from
from benchmarks.table import Row

N_FILMS = 64
SHARE_OF_QUICK = 8


def rows(*, quick: bool) -> Iterable[Row]:
    """Name each film without the body and with it; `quick`: an eighth of them."""
    counts: defaultdict[tuple[str, str], NamesCount] = defaultdict(NamesCount)
    n_films = N_FILMS // SHARE_OF_QUICK if quick else N_FILMS
    for film in marked_films(SEED, n_films):
        for body in ("not known", "known"):
            count_film(counts[film.kind, body], film, knows_body=body == "known")
    for kind in FILM_KINDS:
        for body in ("not known", "known"):
            told = f"{kind}, frames of films as a depth camera sees them, seed {SEED}, body {body}"
            yield from counts[kind, body].rows(told)


def count_film(count: NamesCount, film: MarkedFilm, *, knows_body: bool) -> None:
    """Name a film, and count the names of each of its frames."""
    named = name_movement(shipped_namer(), _frames(film, knows_body=knows_body), film.view)
    for one, picture in zip(named, film.pictures, strict=True):
        count.add(one.names, picture.names)


def _frames(film: MarkedFilm, *, knows_body: bool) -> Iterator[MovingPoints]:
    for time_s, picture in zip(film.times_s.tolist(), film.pictures, strict=True):
        turn = RigidTransform(upright_turn(picture.up), np.zeros(3))
        body = seen_from(picture, turn) if knows_body else None
        yield MovingPoints(turn.apply(picture.points_m), time_s, body=body)
