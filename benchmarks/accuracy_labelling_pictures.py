"""Names of markers that a depth camera sees on simulated people, with what it sees of the body.

People, clothes, furniture, sensors and poses that no model learned from; what is hidden in the
picture is missing. Once the namer knows the body that is found in the depth, once it does not.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable

import numpy as np

from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.marked_people import KINDS, marked_pictures
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import upright_turn
from benchmarks.accuracy_labelling import SEED
from benchmarks.labelling_names import NamesCount, seen_from
from benchmarks.table import Row

N_PICTURES = 1600
LEAST_MARKERS = 5
SIDES = {"anterior": "all from the front", "posterior": "all from behind"}
ASIDE = "all from a side"


def rows(*, quick: bool) -> Iterable[Row]:
    """Name the markers of each picture without the body and with it; `quick`: of a twentieth."""
    counts: defaultdict[tuple[str, str], NamesCount] = defaultdict(NamesCount)
    n_found: Counter[tuple[str, str]] = Counter()
    namer = shipped_namer().holding_still()
    for picture in marked_pictures(SEED, N_PICTURES // 20 if quick else N_PICTURES):
        if len(picture.names) < LEAST_MARKERS:
            continue
        turn = RigidTransform(upright_turn(picture.up), np.zeros(3))
        points_m = turn.apply(picture.points_m)
        odds = seen_from(picture, turn)(picture.view)
        for body, known in (("not known", None), ("known", odds)):
            teller = namer if known is None else namer.who_sees(known)
            names = teller.label(points_m, picture.view).names
            for group in (picture.kind, SIDES.get(picture.view, ASIDE)):
                counts[group, body].add(names, picture.names)
                n_found[group, body] += known is not None
    for group in (*KINDS, *SIDES.values(), ASIDE):
        for body in ("not known", "known"):
            told = f"{group}, as a depth camera sees them, seed {SEED}, body {body}"
            count = counts[group, body]
            yield from count.rows(told)
            share = 100 * n_found[group, body] / max(count.n_sets, 1)
            yield Row(f"{told}: a body is known", share, "%")
