"""Names of markers of simulated people who move, as a depth camera sees them, frame after frame.

People, clothes, furniture, sensors and movements that no model learned from; what is hidden in a
frame is missing in it. Each film is named as a whole, as a recording is: once with the body that is
found in the depth, once without.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields

import numpy as np

from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.marked_films import FILM_KINDS, MarkedFilm, marked_films
from adibas.pipeline.marked_people import MarkedPicture
from adibas.pipeline.seen_body import body_in, body_odds
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import upright_turn
from adibas.skeleton.body_marks import BodyOdds
from adibas.skeleton.tracking import MovingPoints, SeenFrom, name_movement
from benchmarks.accuracy_labelling import SEED
from benchmarks.table import Row

N_FILMS = 64
SHARE_OF_QUICK = 8


@dataclass(slots=True)
class Count:
    """What became of the frames of one kind of film."""

    n_frames: int = 0
    n_with_wrong: int = 0
    n_markers: int = 0
    n_right: int = 0
    n_wrong: int = 0

    def add(self, names: tuple[str | None, ...], truth: tuple[str, ...]) -> None:
        """Count one frame."""
        n_right = sum(name == own for name, own in zip(names, truth, strict=True))
        n_wrong = sum(name is not None for name in names) - n_right
        self.n_frames += 1
        self.n_with_wrong += n_wrong > 0
        self.n_markers += len(truth)
        self.n_right += n_right
        self.n_wrong += n_wrong

    def __iadd__(self, other: "Count") -> "Count":
        for field in fields(self):
            setattr(self, field.name, getattr(self, field.name) + getattr(other, field.name))
        return self

    def rows(self, told: str) -> Iterator[Row]:
        """Give the shares."""
        for what, n, of in (
            (f"right names of {self.n_markers}", self.n_right, self.n_markers),
            (f"wrong names of {self.n_markers}", self.n_wrong, self.n_markers),
            (f"frames of {self.n_frames} with a wrong name", self.n_with_wrong, self.n_frames),
        ):
            yield Row(f"{told}: {what}", 100 * n / max(of, 1), "%")


def rows(*, quick: bool) -> Iterable[Row]:
    """Name each film without the body and with it; `quick`: an eighth of them."""
    counts: defaultdict[tuple[str, str], Count] = defaultdict(Count)
    n_films = N_FILMS // SHARE_OF_QUICK if quick else N_FILMS
    for film in marked_films(SEED, n_films):
        for body in ("not known", "known"):
            counts[film.kind, body] += count_of(film, knows_body=body == "known")
    for kind in FILM_KINDS:
        for body in ("not known", "known"):
            told = f"{kind}, films as a depth camera sees them, seed {SEED}, body {body}"
            yield from counts[kind, body].rows(told)


def count_of(film: MarkedFilm, *, knows_body: bool) -> Count:
    """Name a film, and compare with the names of its markers."""
    count = Count()
    named = name_movement(shipped_namer(), _frames(film, knows_body=knows_body), film.view)
    for one, picture in zip(named, film.pictures, strict=True):
        count.add(one.names, picture.names)
    return count


def _frames(film: MarkedFilm, *, knows_body: bool) -> Iterator[MovingPoints]:
    for time_s, picture in zip(film.times_s.tolist(), film.pictures, strict=True):
        turn = RigidTransform(upright_turn(picture.up), np.zeros(3))
        body = _seen_from(picture, turn) if knows_body else None
        yield MovingPoints(turn.apply(picture.points_m), time_s, body=body)


def _seen_from(picture: MarkedPicture, upright: RigidTransform) -> SeenFrom:
    def told(view: str) -> BodyOdds | None:
        body = body_in(picture.depth_m, picture.mask, view, picture.camera)
        return None if body is None else body_odds(body, view, upright)

    return told
