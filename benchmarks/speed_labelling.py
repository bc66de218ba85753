"""How long naming takes: 15 joints by core and limbs, and nine or fifteen by shape context.

And a fit of an active shape model, whose points have names already.

Time of the thread's own processor clock: the median over sets, each named once after a first one
that compiles. People are simulated and not those of the training.
"""

import time
from collections.abc import Callable, Iterable, Sequence
from itertools import cycle, islice

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_simulator import simulate_shapes
from adibas.shapes.point_distribution import learn_distribution
from adibas.shapes.shape_context import match_shapes
from adibas.shapes.shape_fitting import fit_shape
from adibas.skeleton.starts import HEADINGS_RAD, turn_back
from benchmarks.table import Row

SEED = 2000
N_BODIES, N_POSES, N_SETS = 8, 20, 400
N_THESIS = 9
"""Points of the thesis' figure for shape context."""
THESIS_FIT_MS, THESIS_MATCH_MS = 300.0, 1500.0
FIT_SD_M = 0.02
"""Of a marker beside its joint."""


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` a tenth of the sets."""
    n_sets = N_SETS // 10 if quick else N_SETS
    people = simulate_shapes(2 if quick else N_BODIES, N_POSES, SEED, lambda _done, _all: None)
    rng = np.random.default_rng(SEED)
    namer = shipped_namer()
    for kind in ("standing", "seated", "moving"):
        chosen = people.shapes_m[np.array(people.kinds) == kind]
        if not len(chosen):
            continue
        for told in (True, False):
            sets = list(islice(_sets(chosen, rng), n_sets))

            def name(one: tuple[str, FloatArray], *, told: bool = told) -> object:
                return namer.label(one[1], one[0] if told else "")

            view = "view told" if told else "view not told"
            yield Row(
                f"names of 15 joints, {kind}, {view}, {n_sets} sets", _median_ms(name, sets), "ms",
                1.0, "goal <=",
            )  # fmt: skip
    half = len(people.shapes_m) // 2
    model = learn_distribution(JOINT_NAMES, people.shapes_m[:half])
    named = list(islice(cycle(people.shapes_m[half:]), n_sets))
    fit_ms = _median_ms(lambda points_m: fit_shape(model, points_m, FIT_SD_M), named)
    what = f"active shape model laid onto 15 named points, to the end, {n_sets} sets"
    yield Row(what, fit_ms, "ms", 1.0, "goal <=")
    yield Row(what, fit_ms, "ms", THESIS_FIT_MS, "thesis <")
    first = people.shapes_m[0, :, :2]
    for n_points in (N_THESIS, len(first)):
        flat = [one[:n_points, :2] for one in islice(cycle(people.shapes_m), n_sets)]

        def match(points: FloatArray, *, n_points: int = n_points) -> object:
            return match_shapes(first[:n_points], points[rng.permutation(n_points)])

        match_ms = _median_ms(match, flat)
        what = f"shape context, {n_points} points, three rounds with thin plates, {n_sets} sets"
        yield Row(what, match_ms, "ms", 3.0, "goal <=")
        if n_points == N_THESIS:
            yield Row(what, match_ms, "ms", THESIS_MATCH_MS, "thesis <")


def _sets(shapes_m: FloatArray, rng: np.random.Generator) -> Iterable[tuple[str, FloatArray]]:
    """Give a view and the shuffled points of somebody who shows it, without end."""
    for number, shape_m in enumerate(cycle(shapes_m)):
        view = list(HEADINGS_RAD)[number % len(HEADINGS_RAD)]
        turned = shape_m @ turn_back(HEADINGS_RAD[view] + rng.uniform(-0.35, 0.35))
        yield view, turned[rng.permutation(len(turned))]


def _median_ms(work: Callable[..., object], inputs: Sequence[object]) -> float:
    work(inputs[0])
    times_s = []
    for one in inputs:
        begin = time.thread_time()
        work(one)
        times_s.append(time.thread_time() - begin)
    return 1000 * float(np.median(times_s))
