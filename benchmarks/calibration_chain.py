"""Whole calibrations of rendered pictures: intervals beside the truth; what novices do wrong."""

import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.verdict import ScaleCheck
from adibas.data.calibration_verdict import Grade
from adibas.data.camera_fit import CameraFit
from adibas.pipeline.calibrating import NamedImage, calibrate_camera, fit_searched, judged
from adibas.simulation.boards_novice import MISTAKES, Mistake, NoviceSet, novice_set
from adibas.simulation.device import draw_device
from benchmarks.calibration_fitting import binomial_interval, intervals_held
from benchmarks.calibration_rendered import BOARD, N_VIEWS, SEED, rendered_set
from benchmarks.table import Row

N_PROCESSES = 2
DEPTH_BIAS_M = 0.02
"""Of an uncalibrated depth camera, and what the verdict allows for it."""
GRADES = {Grade.GOOD: "good", Grade.USABLE: "usable", Grade.REPEAT: "repeat"}


@dataclass(frozen=True, slots=True, eq=False)
class ChainTrial:
    """One calibration of one simulated device.

    Attributes
    ----------
    squared_px : (n,) array
        Squared distance of each corner from the truth.
    held : dict
        Parameter to whether its 95 % interval holds the truth.
    n_found : int
        Pictures in which the board was found.
    grade : Grade
        The verdict.
    """

    squared_px: FloatArray
    held: dict[str, bool]
    n_found: int
    grade: Grade


def run_trial(seed: int) -> ChainTrial:
    """Render 20 pictures at 1280x1024, find the board, fit the camera, judge it."""
    pictures = rendered_set(seed)
    outcome = fit_searched(pictures.images, BOARD)
    held = {} if outcome.fit is None else intervals_held(outcome.fit, pictures.camera)
    n_found = sum(image.search.corners is not None for image in pictures.images)
    return ChainTrial(pictures.squared_px, held, n_found, outcome.verdict.grade)


def rows(*, quick: bool) -> Iterator[Row]:
    """Measure; with `quick` two calibrations."""
    n = 2 if quick else 1000
    with ProcessPoolExecutor(N_PROCESSES, get_context("spawn")) as pool:
        trials = list(pool.map(run_trial, range(n), chunksize=5))
        told = f"{n} calibrations of {N_VIEWS} rendered pictures 1280x1024, seed {SEED}"
        yield from _trial_rows(trials, told)
        for mistake, grade, reasons, held in pool.map(_novice, MISTAKES):
            name = mistake.replace("_", " ")
            told = f"{grade} ({', '.join(reasons)})" if reasons else grade
            yield Row(f"a novice's mistake: {name}, verdict {told}: reasons", len(reasons), "")
            if grade == GRADES[Grade.GOOD]:
                yield Row(f"a novice's mistake: {name}: intervals that hold", held, "%")


def _trial_rows(trials: list[ChainTrial], told: str) -> Iterator[Row]:
    squares = np.concatenate([trial.squared_px for trial in trials])
    rms_px = math.sqrt(float(squares.mean()))
    found = sum(trial.n_found for trial in trials) / (N_VIEWS * len(trials))
    yield Row(f"{told}: boards found", 100.0 * found, "%")
    yield Row(f"{told}: corners, rms over points", rms_px, "px", 0.06, "goal <=")
    good = np.mean([trial.grade is Grade.GOOD for trial in trials])
    yield Row(f"{told}: called good", 100.0 * float(good), "%")
    names = sorted({name for trial in trials for name in trial.held})
    for name in (*names, "all"):
        hits = [
            is_held
            for trial in trials
            for parameter, is_held in trial.held.items()
            if name in (parameter, "all")
        ]
        low, high = binomial_interval(sum(hits), len(hits))
        label = f"{told}: 95 % interval of {name} holds the truth ({low:.1f}-{high:.1f})"
        yield Row(label, 100.0 * float(np.mean(hits)), "%", 95.0, "goal 93-97")


def _novice(mistake: Mistake) -> tuple[str, str, list[str], float]:
    """Return the mistake, the verdict, its reasons, and the share of intervals that hold."""
    camera = draw_device(1).color
    rng = np.random.default_rng([SEED, 1])
    attempt = novice_set(mistake, rng, BOARD, camera)
    images = [
        NamedImage(f"{i:02d}", picture.image)
        for i, picture in enumerate(attempt.pictures(camera, rng))
    ]
    outcome = calibrate_camera(images, attempt.told_board)
    if outcome is None:
        raise ValueError("nothing stops this calibration")
    if outcome.fit is not None:
        outcome = judged(outcome, tuple(_by_depth(attempt, outcome.fit)))
    held = {} if outcome.fit is None else intervals_held(outcome.fit, camera)
    share = 100.0 * float(np.mean(list(held.values()))) if held else math.nan
    reasons = [finding.reason.value for finding in outcome.verdict.findings]
    return mistake, GRADES[outcome.verdict.grade], reasons, share


def _by_depth(attempt: NoviceSet, fit: CameraFit) -> Iterator[ScaleCheck]:
    """Compare where the boards' middles are with where a depth camera 2 cm off sees them."""
    for view in fit.views:
        shown = attempt.shots[int(view.image)][0][0]
        true_m = shown.camera_from_board.apply(shown.board.points_m().mean(axis=0))
        seen_m = view.camera_from_board.apply(attempt.told_board.points_m().mean(axis=0))
        by_depth_m = float(true_m[2]) + DEPTH_BIAS_M
        yield ScaleCheck(by_depth_m, float(seen_m[2]), DEPTH_BIAS_M)
