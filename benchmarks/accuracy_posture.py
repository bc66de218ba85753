"""The thesis' 200 analyses with the 15 joints, through the whole chain: found, named, measured.

Stickers of 8 mm at 2 m, a burst of 30 frames; light, room, clothes and sensor differ in each, and
each sensor was calibrated on boards. The view is told, the names are the program's own. Every
seventh analysis again with each of the variants, which begin with the second, the third and so on:
scenes and sensors in which all is easy by chance are not easy for all variants. With
ADIBAS_BENCHMARK_RESULTS=FILE every analysis is kept in that file as it is done, and one that stands
there is not done again.

"Against what it states": the root mean square error by the root mean square of the standard errors
that the program gives, which follow from its model of noise and skin by generalised least squares.
For normal noise no unbiased estimate from the same pixels has a smaller variance (Cramer-Rao), so
that 1 is the bound of the model, and more is what the model does not know.
"""

import math
import os
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from adibas.arrays import FloatArray
from benchmarks.posture_trial import Z_95, Analysis, Result, analyse, analyses, run_all
from benchmarks.posture_variants import changed, variants
from benchmarks.table import Row

SEED = int(os.environ.get("ADIBAS_BENCHMARK_SEED", "0"))
N_PROCESSES = 2
N_FRAMES, QUICK_FRAMES, QUICK_STEP = 30, 5, 67
VARIANT_STEP = 7
"""Prime to repeats and postures, so that all are met; one of 400 markers is 0.25 %."""
SIDES_M = ((0.0, 0.1), (0.1, 0.25), (0.25, math.inf))
STRAIGHT_RAD = math.radians(5.0)
THESIS_FOUND = 76.3
PUBLISHED = {"thesis": (2.3, 3.7), "SAPO, on an object": (1.8, 0.11)}
"""Mean errors in mm and degrees; SAPO: Ferreira et al. 2010, 10.1590/S1807-59322010000700005."""


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` three analyses of five frames, which no file keeps."""
    wanted = analyses(SEED, QUICK_FRAMES if quick else N_FRAMES)[:: QUICK_STEP if quick else 1]
    kept = os.environ.get("ADIBAS_BENCHMARK_RESULTS")
    file = Path(kept) if kept and not quick else None
    told = f"{len(wanted)} analyses, {wanted[0].n_frames} frames, seed {SEED}"
    results = run_all(wanted, file, _in_processes)
    yield from _analysed(told, results)
    yield from _published(told, results)
    together: list[Result] = []
    for place, variant in enumerate(variants(), 1):
        chosen = wanted[:1] if quick else wanted[place % VARIANT_STEP :: VARIANT_STEP]
        told = f"{variant.name}, {len(chosen)} analyses, seed {SEED}"
        results = run_all(changed(chosen, variant, place), file, _in_processes)
        yield from _analysed(told, results)
        together += results
    yield from _analysed(f"all variants, {len(together)} analyses, seed {SEED}", together)


def _published(told: str, results: Sequence[Result]) -> Iterator[Row]:
    """Give our figures of the 200 analyses beside those that were published."""
    n_visible = sum(one.n_visible for one in results)
    named = 100 * sum(one.n_named for one in results) / max(n_visible, 1)
    off_mm = 1000 * float(np.abs(_joined([one.distances for one in results])[:, 0]).mean())
    off_rad = float(np.abs(_joined([one.angles for one in results])[:, 0]).mean())
    yield Row(f"{told}: found and named, as published", named, "%", THESIS_FOUND, "thesis")
    for whose, (least_mm, least_deg) in PUBLISHED.items():
        yield Row(f"{told}: distances, mean error, as published", off_mm, "mm", least_mm, whose)
        off_deg = math.degrees(off_rad)
        yield Row(f"{told}: angles, mean error, as published", off_deg, "deg", least_deg, whose)


def _analysed(told: str, results: Sequence[Result]) -> Iterator[Row]:
    n_visible = sum(one.n_visible for one in results)
    named = 100 * sum(one.n_named for one in results) / max(n_visible, 1)
    yield Row(f"{told}: found and named of {n_visible} visible", named, "%", 99.0, "goal >=")
    yield Row(
        f"{told}: with a wrong name", sum(one.n_wrong for one in results), "markers", 0, "goal"
    )
    distances = _joined([one.distances for one in results])
    yield from _rows(f"{told}: distances", 1000 * distances[:, :2], "mm", 0.6)
    angles = _joined([one.angles for one in results])
    angles[:, :2] = np.degrees(angles[:, :2])
    yield from _rows(f"{told}: angles", angles[:, :2], "deg", 0.25)
    for low_m, high_m in SIDES_M:
        chosen = (angles[:, 2] >= low_m) & (angles[:, 2] < high_m)
        side = f"shortest side {1000 * low_m:.0f} mm" + (
            " or more" if math.isinf(high_m) else f" to {1000 * high_m:.0f} mm"
        )
        yield from _rows(f"{told}: angles, {side}", angles[chosen][:, :2], "deg", 0.25)
    is_straight = math.pi - angles[:, 3] < STRAIGHT_RAD
    yield from _rows(f"{told}: angles near 180 deg", angles[is_straight][:, :2], "deg", None)
    flat = np.degrees(_joined([one.angles_in_image for one in results])[:, 0])
    told = f"{told}: angles in the image plane ({len(flat)}): mean error"
    yield Row(told, float(np.abs(flat).mean()) if len(flat) else math.nan, "deg", 0.10, "goal <=")


def _in_processes(missing: Sequence[Analysis]) -> Iterator[Result]:
    with ProcessPoolExecutor(N_PROCESSES, mp_context=get_context("spawn")) as pool:
        yield from pool.map(analyse, missing)


def _joined(parts: Sequence[list[list[float]]]) -> FloatArray:
    return np.array([row for part in parts for row in part], float).reshape(-1, 4)


def _rows(told: str, errors: FloatArray, unit: str, goal: float | None) -> Iterator[Row]:
    """Give mean absolute error, its ratio to what is stated, and how often intervals hold."""
    if not len(errors):
        return
    off, stated = errors.T
    whose = "" if goal is None else "goal <="
    yield Row(f"{told} ({len(off)}): mean error", float(np.abs(off).mean()), unit, goal, whose)
    rms, stated_rms = math.sqrt((off**2).mean()), math.sqrt((stated**2).mean())
    yield Row(f"{told}: root mean square error", rms, unit)
    yield Row(f"{told}: against what it states", rms / stated_rms, "", 1.5, "goal <=")
    held = 100 * float((np.abs(off) <= Z_95 * stated).mean())
    yield Row(f"{told}: intervals that hold the truth", held, "%", 95.0, "93 to 97")
