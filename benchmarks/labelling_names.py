"""What becomes of the names of markers that a depth camera sees on simulated people."""

from collections.abc import Iterator
from dataclasses import dataclass

from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.marked_people import MarkedPicture
from adibas.pipeline.seen_body import body_in, body_odds
from adibas.skeleton.body_marks import BodyOdds
from adibas.skeleton.tracking import SeenFrom
from benchmarks.table import Row


@dataclass(slots=True)
class NamesCount:
    """Sets of markers, single pictures or the frames of films, and their names."""

    n_sets: int = 0
    n_whole: int = 0
    n_with_wrong: int = 0
    n_markers: int = 0
    n_right: int = 0
    n_wrong: int = 0

    def add(self, names: tuple[str | None, ...], truth: tuple[str, ...]) -> None:
        """Count one set."""
        n_right = sum(name == own for name, own in zip(names, truth, strict=True))
        n_wrong = sum(name is not None for name in names) - n_right
        self.n_sets += 1
        self.n_whole += n_right == len(truth)
        self.n_with_wrong += n_wrong > 0
        self.n_markers += len(truth)
        self.n_right += n_right
        self.n_wrong += n_wrong

    def rows(self, told: str) -> Iterator[Row]:
        """Give the shares."""
        for what, n, of in (
            (f"entirely right of {self.n_sets}", self.n_whole, self.n_sets),
            ("with a wrong name", self.n_with_wrong, self.n_sets),
            (f"right names of {self.n_markers}", self.n_right, self.n_markers),
            (f"wrong names of {self.n_markers}", self.n_wrong, self.n_markers),
        ):
            yield Row(f"{told}: {what}", 100 * n / max(of, 1), "%")


def seen_from(picture: MarkedPicture, upright: RigidTransform) -> SeenFrom:
    """Return what tells of the body in a picture; `upright` from its camera's axes."""

    def told(view: str) -> BodyOdds | None:
        body = body_in(picture.depth_m, picture.mask, view, picture.camera)
        return None if body is None else body_odds(body, view, upright)

    return told
