"""Names of markers that a depth camera sees on simulated people, with what it sees of the body.

People, clothes, furniture, sensors and poses that no model learned from; what is hidden in the
picture is missing. Once the namer knows the body that is found in the depth, once it does not.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.marked_people import KINDS, MarkedPicture, marked_pictures
from adibas.pipeline.seen_body import body_in, body_odds
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import upright_turn
from adibas.skeleton.namer import Namer
from benchmarks.accuracy_labelling import SEED
from benchmarks.table import Row

N_PICTURES = 1600
LEAST_MARKERS = 5
SIDES = {"anterior": "all from the front", "posterior": "all from behind"}
ASIDE = "all from a side"


@dataclass(slots=True)
class _Count:
    """What became of the pictures of one group."""

    n: int = 0
    n_whole: int = 0
    n_with_wrong: int = 0
    n_markers: int = 0
    n_right: int = 0
    n_wrong: int = 0
    n_found: int = 0

    def add(self, names: tuple[str | None, ...], truth: tuple[str, ...], *, is_found: bool) -> None:
        """Count one picture."""
        right = [name == own for name, own in zip(names, truth, strict=True)]
        self.n += 1
        self.n_whole += all(right)
        n_wrong = sum(name is not None for name in names) - sum(right)
        self.n_with_wrong += n_wrong > 0
        self.n_markers += len(truth)
        self.n_right += sum(right)
        self.n_wrong += n_wrong
        self.n_found += is_found

    def rows(self, told: str) -> Iterator[Row]:
        """Give the shares."""
        for what, n, of in (
            (f"entirely right of {self.n}", self.n_whole, self.n),
            ("with a wrong name", self.n_with_wrong, self.n),
            (f"right names of {self.n_markers}", self.n_right, self.n_markers),
            (f"wrong names of {self.n_markers}", self.n_wrong, self.n_markers),
            ("a body is known", self.n_found, self.n),
        ):
            yield Row(f"{told}: {what}", 100 * n / max(of, 1), "%")


def rows(*, quick: bool) -> Iterable[Row]:
    """Name the markers of each picture without the body and with it; `quick`: of a twentieth."""
    counts: defaultdict[tuple[str, str], _Count] = defaultdict(_Count)
    namer = shipped_namer().holding_still()
    for picture in marked_pictures(SEED, N_PICTURES // 20 if quick else N_PICTURES):
        if len(picture.names) < LEAST_MARKERS:
            continue
        turn = RigidTransform(upright_turn(picture.up), np.zeros(3))
        points_m = turn.apply(picture.points_m)
        who_sees = _who_sees(namer, picture, turn)
        for body, one in (("not known", None), ("known", who_sees)):
            names = (one or namer).label(points_m, picture.view).names
            for group in (picture.kind, SIDES.get(picture.view, ASIDE)):
                counts[group, body].add(names, picture.names, is_found=one is not None)
    for group in (*KINDS, *SIDES.values(), ASIDE):
        for body in ("not known", "known"):
            told = f"{group}, as a depth camera sees them, seed {SEED}, body {body}"
            yield from counts[group, body].rows(told)


def _who_sees(namer: Namer, picture: MarkedPicture, upright: RigidTransform) -> Namer | None:
    body = body_in(picture.depth_m, picture.mask, picture.view, picture.camera)
    return None if body is None else namer.who_sees(body_odds(body, picture.view, upright))
