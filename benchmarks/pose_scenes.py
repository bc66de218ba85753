"""Joints in crowded simulated scenes, by how much of the person is seen.

Children at tables, furniture before people, passers-by and crossings: how many joints are near,
invented or lost, and who is taken for whom.
"""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from adibas.arrays import BoolArray, Float32Array
from adibas.clock import NS_PER_S
from adibas.data.frames import depth_in_metres
from adibas.data.limbs import FULL_BODY, NO_LABEL, LimbParts
from adibas.limbs.model import LimbModel, load_model
from adibas.pipeline.person_judge import person_judge
from adibas.pipeline.pose_following import (
    PersonNow,
    PoseEstimator,
    Segmenter,
    forest_segmenter,
)
from adibas.pipeline.pose_model import joint_model_for
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.crowds import CrowdFrame, CrowdScene, crowd_names, open_crowd
from benchmarks.pose_real import MODEL, NEAR_M
from benchmarks.table import Row

SEEDS = range(100, 104)
SHARES = (0.2, 0.5, 0.8, 1.01)
LEAST_SHARE = 0.2
"""Of a person, from which on not being found counts as missed."""


@dataclass(frozen=True, slots=True)
class Seen:
    """One joint of one person in one frame.

    Attributes
    ----------
    scene : str
    share : float
        Of the person that is visible.
    is_in_view : bool
    error_m : float
        NaN: said to be not seen.
    """

    scene: str
    share: float
    is_in_view: bool
    error_m: float


@dataclass(slots=True)
class Counts:
    """Of one scene."""

    n_missed: int = 0
    n_expected: int = 0
    n_nobody: int = 0
    n_switches: int = 0


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` one seed and every third frame."""
    chosen = os.environ.get(MODEL)
    model = shipped_model() if chosen is None else load_model(Path(chosen))
    seeds = SEEDS[:1] if quick else SEEDS
    step = 3 if quick else 1
    for told, used in (("shipped model", model), ("true parts", None)):
        seen: list[Seen] = []
        counts = {name: Counts() for name in crowd_names()}
        for name in crowd_names():
            for seed in seeds:
                seen += watch(open_crowd(name, seed), name, used, counts[name], step)
        yield from _rows_of(told, seen, counts, len(seeds))


def _rows_of(told: str, seen: list[Seen], counts: dict[str, Counts], n_seeds: int) -> Iterator[Row]:
    for low, high in pairwise(SHARES):
        band = [one for one in seen if low <= one.share < high]
        name = f"{told}, {100 * low:.0f} to {min(100, 100 * high):.0f} % of the person seen"
        yield from rows_of_band(name, band)
    for name, count in counts.items():
        mine = [one for one in seen if one.scene == name and one.share >= LEAST_SHARE]
        yield from rows_of_band(f"{told}, {name} ({n_seeds} seeds)", mine)
        missed = 100.0 * count.n_missed / max(count.n_expected, 1)
        yield Row(f"{told}, {name}: people not found", missed, "% of frames")
        yield Row(f"{told}, {name}: identity switches", count.n_switches, "", 0, "goal")
        yield Row(f"{told}, {name}: things taken for people", count.n_nobody, "frames", 0, "goal")


def rows_of_band(name: str, seen: list[Seen]) -> Iterator[Row]:
    """Yield how many joints are near, and how many that nobody sees are invented."""
    errors_m = np.array([one.error_m for one in seen if one.is_in_view])
    hidden_m = np.array([one.error_m for one in seen if not one.is_in_view])
    if len(errors_m):
        near = 100.0 * float((errors_m < NEAR_M).mean())
        yield Row(f"{name}: joints in view within 10 cm ({len(errors_m)})", near, "%")
    if len(hidden_m):
        wrong = 100.0 * float((hidden_m >= NEAR_M).mean())
        yield Row(f"{name}: hidden joints invented, over 10 cm off ({len(hidden_m)})", wrong, "%")


def watch(
    scene: CrowdScene, name: str, model: LimbModel | None, counts: Counts, step: int
) -> Iterator[Seen]:
    """Yield the joints of every `step`-th frame, and count people; None: with the true parts."""
    calibration = scene.info.calibration
    if calibration is None or calibration.depth is None:
        raise ValueError("a simulated scene has a calibrated depth camera")
    parts = _TrueParts()
    segmenter: Segmenter = parts
    if model is not None:
        segmenter = forest_segmenter(model, calibration.depth)
    judge = None if model is None else person_judge(model, calibration.depth)
    joints = None if model is None else joint_model_for(model)
    estimator = PoseEstimator(
        calibration.depth, segmenter, calibration.floor, joints=joints, judge=judge
    )
    numbers: dict[int, int] = {}
    for index in range(0, scene.n_frames, step):
        parts.frame = frame = scene.frame(index)
        raw = frame.sensor_frame.depth_raw
        if raw is None:
            raise ValueError("a simulated frame has depth")
        depth_m = calibration.corrected_depth(depth_in_metres(raw, scene.info.depth_unit_m))
        now = estimator.look(
            np.ascontiguousarray(depth_m, np.float32), frame.sensor_frame.timestamp_ns / NS_PER_S
        )
        yield from _judged(name, frame, now.people, numbers, counts)


def _judged(
    name: str,
    frame: CrowdFrame,
    people: tuple[PersonNow, ...],
    numbers: dict[int, int],
    counts: Counts,
) -> Iterator[Seen]:
    found = {}
    for one in people:
        shown = np.bincount(frame.owners[one.pixels], minlength=len(frame.people) + 1)
        who = int(shown.argmax())
        if who == 0:
            counts.n_nobody += 1
            continue
        found[who] = one
        counts.n_switches += numbers.get(who, one.person) != one.person
        numbers[who] = one.person
    for person in frame.people:
        mine = found.get(person.person)
        if person.visible_share >= LEAST_SHARE:
            counts.n_expected += 1
            counts.n_missed += mine is None
        if mine is None:
            continue
        errors_m = np.linalg.norm(mine.joints.joints_m - person.joints_m, axis=1)
        for is_in_view, error_m in zip(person.in_view, errors_m, strict=True):
            yield Seen(name, person.visible_share, bool(is_in_view), float(error_m))


class _TrueParts:
    """Says what the simulator knows, in place of a forest."""

    frame: CrowdFrame | None = None

    def __call__(self, _depth_m: Float32Array, pixels: BoolArray) -> LimbParts:
        if self.frame is None:
            raise ValueError("no frame was given yet")
        labels = self.frame.labels.astype(np.int16)
        chosen = np.where(pixels, labels - 1, NO_LABEL).astype(np.int16)
        probabilities = np.zeros((int(pixels.sum()), len(FULL_BODY)), np.float32)
        of_pixel = chosen[pixels]
        is_limb = of_pixel >= 0
        probabilities[np.flatnonzero(is_limb), of_pixel[is_limb]] = 1.0
        return LimbParts(FULL_BODY, pixels.copy(), probabilities, chosen)
