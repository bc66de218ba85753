"""Joints where there is nobody or half of somebody, and whether confidences are shares.

Scenes are of seeds that nothing was learned from or chosen on.
"""

from collections.abc import Iterator

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.limbs.model import LimbModel
from adibas.pipeline.reliability_file import shipped_reliability
from adibas.pipeline.reliability_training import said_joints
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.crowd_sensors import CrowdSensor
from adibas.simulation.crowds import CrowdScene
from adibas.simulation.lone_things import KINDS
from adibas.simulation.odd_plans import ODD_PLANS, pinhole
from benchmarks.pose_scenes import Counts, rows_of_band, watch
from benchmarks.table import Row

SEED = 7600
SAID_SEED = 7500
STEP = 3
HALVES = ("cut_left", "cut_right", "upper_body", "legs", "near")
SENSORS = ((320, 240, 57.0), (512, 424, 70.0), (848, 480, 87.0), (1280, 720, 70.0))
HOLES = (0.2, 0.5, 0.8)


def rows(*, quick: bool) -> Iterator[Row]:
    """Measure; with `quick` one seed."""
    model = shipped_model()
    n_seeds = 1 if quick else 6
    for name in ("empty", *KINDS):
        yield _things_row(model, name, n_seeds)
    for name in ("person", *HALVES):
        yield from _people_rows(model, name, name, None, n_seeds)
    for share in HOLES:
        told = f"person, {100 * share:.0f} % holes"
        yield from _people_rows(model, told, "person", CrowdSensor(None, share), n_seeds)
    for width, height, across_deg in SENSORS:
        told = f"person, {width}x{height}, {across_deg:.0f} degrees"
        camera = CrowdSensor(pinhole(width, height, across_deg))
        yield from _people_rows(model, told, "person", camera, n_seeds)
    yield from _calibration_rows(model, 1 if quick else 4)


def _things_row(model: LimbModel, name: str, n_seeds: int) -> Row:
    counts, n_frames = Counts(), 0
    for seed in range(SEED, SEED + n_seeds):
        scene = CrowdScene(ODD_PLANS[name], seed)
        n_frames += len(range(0, scene.n_frames, STEP))
        list(watch(scene, name, model, counts, STEP))
    share = 100.0 * counts.n_nobody / n_frames
    return Row(f"room, {name} alone ({n_frames} frames): taken for somebody", share, "%", 0, "goal")


def _people_rows(
    model: LimbModel, told: str, name: str, sensor: CrowdSensor | None, n_seeds: int
) -> Iterator[Row]:
    counts, seen = Counts(), []
    for seed in range(SEED, SEED + n_seeds):
        seen += list(watch(CrowdScene(ODD_PLANS[name], seed, sensor), name, model, counts, STEP))
    found = 100.0 * (1.0 - counts.n_missed / max(counts.n_expected, 1))
    yield Row(f"{told}: found, where a fifth is seen", found, "% of frames")
    yield from rows_of_band(told, seen)


def _calibration_rows(model: LimbModel, n_scenes: int) -> Iterator[Row]:
    said = list(said_joints(model, SAID_SEED, n_scenes, shipped_reliability()))
    is_right = np.array([one.is_right for one in said])
    before = np.array([one.raw for one in said])
    after = np.array([one.calibrated for one in said])
    kept = np.isfinite(after)
    told = f"confidence, {len(said)} joints of simulated people"
    yield Row(f"{told}: off, before", 100 * miscalibration(before, is_right), "%")
    yield Row(f"{told}: off, as said", 100 * miscalibration(after[kept], is_right[kept]), "%")
    yield Row(f"{told}: wrong among all, before", 100 * float((~is_right).mean()), "%")
    yield Row(f"{told}: wrong among said", 100 * float((~is_right[kept]).mean()), "%")
    lost = 100 * float((is_right & ~kept).sum() / is_right.sum())
    yield Row(f"{told}: right ones not said", lost, "%")
    for low in np.arange(0.5, 1.0, 0.1):
        here = kept & (after >= low) & (after < low + 0.1)
        if here.any():
            share = 100 * float(is_right[here].mean())
            name = f"{told}: said with {low:.1f} to {low + 0.1:.1f} ({here.sum()}), right"
            yield Row(name, share, "%", 100 * float(after[here].mean()), "said")


def miscalibration(confidences: FloatArray, is_right: BoolArray) -> float:
    """Return how far shares of right joints are from confidences, over ten bins (expected).

    Source: Naeini, Cooper & Hauskrecht, Obtaining well calibrated probabilities using Bayesian
    binning, AAAI 2015 (expected calibration error).
    """
    bins = np.minimum((10 * confidences).astype(np.int64), 9)
    off = [
        np.count_nonzero(bins == k)
        * abs(confidences[bins == k].mean() - is_right[bins == k].mean())
        for k in np.unique(bins)
    ]
    return float(sum(off)) / len(confidences)
