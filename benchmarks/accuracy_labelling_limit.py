"""How many of the sets of `accuracy labelling` a judge that knows the simulator names right.

Standing sets with two hidden and two spurious points, and seated ones; see `labelling_judge`. The
sets are those of the other benchmark, and none of the judge's people is in them. "Expected": the
mean probability that the judge gives to what it says, which would be the share of right ones if the
simulator were the judge's mixture: where both agree, more knowledge of people would tell no more.
"""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from adibas.arrays import FloatArray
from adibas.pipeline.skeleton_simulator import simulate_shapes
from benchmarks.accuracy_labelling import N_BODIES, N_POSES, SEED
from benchmarks.labelling_judge import Judge, Ways, probabilities
from benchmarks.labelling_sets import marker_sets
from benchmarks.table import Row

JUDGE_PEOPLE, JUDGE_POSES, JUDGE_SEED = 240, 40, 77_000
N_COMPONENTS = 6


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` on a twentieth of the sets, by a judge who saw as many people."""
    share = 20 if quick else 1
    n_people = JUDGE_PEOPLE // share
    people = simulate_shapes(max(N_BODIES // share, 3), N_POSES, SEED, lambda _done, _all: None)
    for kind, n_changed, goal in (("standing", 2, 98.0), ("seated", 0, 99.5)):
        judge = Judge(kind, n_people, JUDGE_POSES, N_COMPONENTS, JUDGE_SEED)
        shapes_m = people.shapes_m[np.array(people.kinds) == kind]
        sets = marker_sets(shapes_m, len(shapes_m), n_changed, SEED)
        weighed = [judge.weigh(one) for one in sets]
        told = f"{kind}, judge of {n_people} people, seed {SEED}"
        if n_changed:
            told = f"{told}, {n_changed} missing and {n_changed} spurious"
        yield from _rows(f"{told}, by places", weighed, [one.log_odds for one in weighed], goal)
        if not n_changed:
            continue
        for name, log_odds in _with_more(weighed):
            yield from _rows(f"{told}, {name}", weighed, log_odds, goal)


def _with_more(weighed: Sequence[Ways]) -> Iterator[tuple[str, list[FloatArray]]]:
    """Give the log odds where more is told than places."""
    yield "sizes measured", [one.log_odds + one.log_sizes for one in weighed]
    told = "told how many are missing"
    yield f"by places, {told}", [one.log_odds + one.is_as_many for one in weighed]
    yield (
        f"sizes measured, {told}",
        [one.log_odds + one.log_sizes + one.is_as_many for one in weighed],
    )


def _rows(
    told: str, weighed: Sequence[Ways], log_odds: Sequence[FloatArray], goal: float
) -> Iterator[Row]:
    right = np.mean([one.argmax() == 0 for one in log_odds])
    expected = np.mean([probabilities(one).max() for one in log_odds])
    yield Row(f"{told}: right of {len(weighed)}", 100 * float(right), "%", goal, "goal >=")
    yield Row(f"{told}: expected", 100 * float(expected), "%")
