"""Limb segmentation: the thesis' tables 6.2 and 6.3, the hand, and the shipped models.

Each figure is the mean over labels of the share of right pixels, in 5 folds. What was measured is
kept in ``build/benchmarks/accuracy_limbs.json``: after a break the benchmark goes on there; remove
the file to measure anew. `ADIBAS_LIMB_FOLDS` (1 to 5) measures the first folds alone.
"""

import json
import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np

from adibas.arrays import AnyArray, IntArray
from adibas.data.limbs import FULL_BODY, UPPER_BODY
from adibas.forests.params import ForestParams
from adibas.forests.training import TrainingImages, train_forest
from adibas.graphcut.boundary import depth_and_color
from adibas.limbs.evaluation import Confusion, confusion_of
from adibas.limbs.model import CLUTTER, LimbModel, model_of
from adibas.limbs.segmentation import LimbParams, cut_labels
from adibas.limbs.training_set import TO_TORSO, Chosen, Relabelled
from adibas.pipeline.limb_evaluation import N_FOLDS, evaluate_model
from adibas.pipeline.limb_segmenting import shipped_model
from adibas.simulation.limb_frames import FrameSettings
from benchmarks import accuracy_pose
from benchmarks.limb_sets import (
    CLEAN,
    LIVE,
    HandFrames,
    ThesisFrames,
    UnseenFrames,
    mocap_poses,
)
from benchmarks.table import Row

KEPT = Path(__file__).parents[1] / "build" / "benchmarks" / "accuracy_limbs.json"
SEED = 6200
KINECT_FOCAL_PX = 530.0
O_30, O_45, O_60 = (px / KINECT_FOCAL_PX for px in (30, 45, 60))
THESIS_FOREST = ForestParams(max_offset_m=O_60)
LABELS = ("torso", *(f"{side}_{part}" for side in ("left", "right")
                     for part in ("upper_arm", "lower_arm", "hand")))  # fmt: skip
"""In the order of the thesis' columns."""
TABLE_6_2: dict[str, tuple[ForestParams, tuple[float, ...]]] = {
    "100 f, O_max 30, depth 20": (
        replace(THESIS_FOREST, max_offset_m=O_30),
        (92.90, 73.29, 71.42, 57.75, 74.25, 76.26, 59.38, 72.18),
    ),
    "100 f, O_max 60, depth 20": (
        THESIS_FOREST,
        (94.17, 79.83, 77.69, 77.10, 81.04, 82.65, 80.17, 81.81),
    ),
    "80 f, O_max 60, depth 20": (
        replace(THESIS_FOREST, n_candidates=80),
        (94.22, 79.08, 76.46, 74.19, 81.24, 83.26, 79.05, 81.07),
    ),
    "60 f, O_max 60, depth 20": (
        replace(THESIS_FOREST, n_candidates=60),
        (94.09, 78.86, 75.86, 73.49, 79.43, 82.60, 78.08, 80.34),
    ),
    "100 f, O_max 60, depth 15": (
        replace(THESIS_FOREST, max_depth=15),
        (94.06, 79.81, 78.69, 76.59, 81.18, 83.10, 80.23, 81.95),
    ),
    "100 f, O_max 60, depth 10": (
        replace(THESIS_FOREST, max_depth=10),
        (91.83, 81.47, 78.98, 72.30, 83.00, 83.74, 76.85, 81.17),
    ),
    "60 f + 20 g, O_max 60, depth 20": (
        replace(THESIS_FOREST, n_candidates=60, n_gradient_candidates=20),
        (94.04, 77.73, 74.93, 71.97, 77.62, 81.22, 76.64, 79.17),
    ),
}
OMEGA_1, OMEGA_2 = (LimbParams(cut, 50.0, step=1) for cut in ("omega_1", "omega_2"))
TABLE_6_3: dict[str, tuple[LimbParams, bool, tuple[float, ...]]] = {
    "depth, Omega_1": (OMEGA_1, False, (98.86, 75.05, 82.87, 91.45, 77.57, 87.35, 93.96, 86.73)),
    "depth, Omega_2": (OMEGA_2, False, (98.86, 75.03, 83.36, 92.41, 77.54, 87.67, 94.20, 87.01)),
    "RGB+depth, Omega_1": (OMEGA_1, True, (99.02, 72.02, 81.86, 90.29, 76.56, 86.84, 92.14, 85.53)),
    "RGB+depth, Omega_2": (OMEGA_2, True, (99.02, 72.03, 81.95, 91.19, 76.53, 87.12, 92.12, 85.71)),
}
CUT_FOREST = "100 f, O_max 60, depth 20"
Cuts: TypeAlias = dict[str, tuple[LimbParams, bool]]
"""By name; whether colour counts."""
CUTS: Cuts = {
    **{name: (limbs, is_rgb) for name, (limbs, is_rgb, _) in TABLE_6_3.items()},
    "lambda 4": (LimbParams("omega_1", 4.0, step=1), False),
}
Confusions: TypeAlias = dict[str, IntArray]
Shares: TypeAlias = dict[str, float]
"""Percent of right pixels by label, and of their mean."""
MEAN = "mean per label"


@dataclass(frozen=True, slots=True)
class Effort:
    """How much is measured."""

    n_frames: int
    n_folds: int
    n_hands: int
    n_unseen: int
    name: str


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` a fold of 40 frames, and 10 unseen people."""
    folds = min(max(int(os.environ.get("ADIBAS_LIMB_FOLDS", N_FOLDS)), 1), N_FOLDS)
    whole = Effort(500, folds, 63, 60, "whole")
    effort = Effort(40, 1, 15, 10, "quick") if quick else whole
    kept = _Kept(effort)
    yield from _shipped_rows(effort, kept)
    yield from _table_rows(effort, kept)
    yield from _hand_rows(effort, kept)
    yield from accuracy_pose.rows(quick=quick)


class _Kept:
    """Confusions that were counted before, by name."""

    def __init__(self, effort: Effort) -> None:
        self._prefix = f"{effort.name}: "
        self._found: dict[str, dict[str, list[list[int]]]] = {}
        if KEPT.exists():
            self._found = json.loads(KEPT.read_text("utf-8"))

    def get(self, name: str, work: Callable[[], Confusions]) -> Confusions:
        """Return the confusions of `name`, counted now if they were not before."""
        key = self._prefix + name
        if key in self._found:
            return {one: np.array(counts) for one, counts in self._found[key].items()}
        counted = work()
        self._found[key] = {one: counts.tolist() for one, counts in counted.items()}
        KEPT.parent.mkdir(parents=True, exist_ok=True)
        unfinished = KEPT.with_suffix(".part")
        unfinished.write_text(json.dumps(self._found), "utf-8")
        unfinished.replace(KEPT)
        return counted

    def sum(self, works: dict[str, Callable[[], Confusions]]) -> Confusions:
        """Return the sum over several works."""
        total: Confusions = {}
        for name, work in works.items():
            for one, counts in self.get(name, work).items():
                total[one] = total[one] + counts if one in total else counts
        return total


def _table_rows(effort: Effort, kept: _Kept) -> Iterator[Row]:
    frames = ThesisFrames(effort.n_frames)
    told = f"{effort.n_frames} simulated frames, {effort.n_folds} of 5 folds"
    for name, (params, thesis) in TABLE_6_2.items():
        cuts = CUTS if name == CUT_FOREST else {}
        counted = kept.sum(
            {
                f"6.2 {name}, fold {fold}": partial(_fold, frames, params, fold, cuts)
                for fold in range(effort.n_folds)
            }
        )
        found = {one: _shares(frames.labels, counts) for one, counts in counted.items()}
        yield from _compared(f"table 6.2, {name} ({told})", found["forest"], thesis)
        for cut, (_, _, wanted) in TABLE_6_3.items() if cuts else ():
            yield from _compared(f"table 6.3, {cut}, lambda 50", found[cut], wanted)
            yield _gain(f"table 6.3, {cut}", found["forest"], found[cut])
        if cuts:
            yield _gain("lambda 4, depth, Omega_1", found["forest"], found["lambda 4"])


def _compared(name: str, found: Shares, thesis: tuple[float, ...]) -> Iterator[Row]:
    for label, wanted in zip((*LABELS, MEAN), thesis, strict=True):
        yield Row(f"{name}: {label}", found[label], "%", wanted, "thesis")


def _gain(name: str, forest: Shares, cut: Shares) -> Row:
    worse = [label for label in forest if label != MEAN and cut[label] < forest[label]]
    told = f"; worse for {', '.join(worse)}" if worse else "; no label is worse"
    gain = cut[MEAN] - forest[MEAN]
    return Row(f"{name}: gain of the cut over the forest{told}", gain, "points", 0, "goal >=")


def _fold(
    frames: ThesisFrames | HandFrames, params: ForestParams, fold: int, cuts: Cuts
) -> Confusions:
    """Train on four fifths of a set and test on the fifth, with cuts on the probabilities."""
    groups = _groups(len(frames))
    model = model_of(
        train_forest(Chosen(frames, np.flatnonzero(groups != fold)), params, SEED + fold)
    )
    n_labels = len(frames.labels)
    sums = {name: np.zeros((n_labels, n_labels), np.int64) for name in ("forest", *cuts)}
    for index in np.flatnonzero(groups == fold):
        depth_m, labels, focal_px = frames.read(int(index))
        mask = (labels > 0) & np.isfinite(depth_m)
        probabilities = model.forest.probabilities(depth_m, mask, focal_px)
        found: dict[str, AnyArray] = {"forest": probabilities.argmax(axis=1)}
        seen_m: AnyArray = np.where(mask, depth_m, np.nan)
        for name, (limbs, is_rgb) in cuts.items():
            picture = seen_m
            if is_rgb and isinstance(frames, ThesisFrames):
                picture = depth_and_color(seen_m, frames.color(int(index)))
            found[name] = cut_labels(picture, mask, probabilities, model, limbs)
        for name, one in found.items():
            sums[name] += confusion_of(frames.labels, labels[mask] - 1, one).counts
    return sums


def _shares(labels: tuple[str, ...], counts: IntArray) -> Shares:
    percent = 100 * Confusion(labels, counts).per_class
    shares = {
        label: float(one) for label, one in zip(labels, percent, strict=True) if np.isfinite(one)
    }
    return {**shares, MEAN: float(np.mean(list(shares.values())))}


def _groups(n_images: int) -> IntArray:
    order = np.random.default_rng(SEED).permutation(n_images)
    groups = np.empty(n_images, np.int64)
    groups[order] = np.arange(n_images) * N_FOLDS // n_images
    return groups


def _hand_rows(effort: Effort, kept: _Kept) -> Iterator[Row]:
    """Cross-validate on the hand: one tree of depth 15, 500 pixels, O_max 45."""
    frames = HandFrames(effort.n_hands)
    params = ForestParams(n_trees=1, max_depth=15, n_pixels=500, n_images=None, max_offset_m=O_45)

    cuts: Cuts = {"cut": (OMEGA_1, False)}
    counted = kept.sum(
        {
            f"hand, fold {fold}": partial(_fold, frames, params, fold, cuts)
            for fold in range(effort.n_folds)
        }
    )
    found = {one: _shares(frames.labels, counts) for one, counts in counted.items()}
    told = f"hand, {effort.n_hands} simulated frames, {effort.n_folds} of 5 folds"
    yield Row(f"{told}: forest", found["forest"][MEAN], "%", 58.5, "thesis")
    yield Row(f"{told}: with cut, Omega_1, lambda 50", found["cut"][MEAN], "%", 70.9, "thesis")
    yield _gain(told, found["forest"], found["cut"])


def _shipped_rows(effort: Effort, kept: _Kept) -> Iterator[Row]:
    """Measure the shipped models on people, and on poses, that had no part in their training."""
    n_frames, poses = effort.n_unseen, list(mocap_poses())
    sets: dict[str, tuple[UnseenFrames, float]] = {
        "unseen people, poses and masks as in training": (
            UnseenFrames(n_frames, 70_001, FrameSettings()),
            93.0,
        ),
        "unseen people, poses as in training, whole masks": (
            UnseenFrames(n_frames, 70_002, CLEAN),
            93.0,
        ),
    }
    if poses:
        sets["unseen people, poses of motion capture, whole masks"] = (
            UnseenFrames(n_frames, 70_003, LIVE, poses),
            87.0,
        )
    for labels in (FULL_BODY, UPPER_BODY):
        model = shipped_model(labels.name)
        for name, (frames, goal) in sets.items():
            images = _relabelled(frames, model)
            told = f"{labels.name}, {n_frames} {name}"
            made = model.forest.provenance.get("created_utc", "")
            counted = kept.get(f"{told}, {made}", partial(_shipped, images, model))
            found = {one: _shares(images.labels, counts) for one, counts in counted.items()}
            yield Row(f"{told}: forest", found["forest"][MEAN], "%")
            yield Row(f"{told}: with cut", found["cut"][MEAN], "%", goal, "goal >=")
            yield _gain(told, found["forest"], found["cut"])
            for label, share in found["cut"].items():
                if label != MEAN:
                    yield Row(f"{told}, with cut: {label}", share, "%")


def _shipped(images: TrainingImages, model: LimbModel) -> Confusions:
    """Count what every pixel that has depth is taken for; clutter is one of the labels."""
    result = evaluate_model(images, model, LimbParams(step=1), lambda _done, _all: None)
    return {"forest": result.forest.counts, "cut": result.cut.counts}


def _relabelled(frames: UnseenFrames, model: LimbModel) -> TrainingImages:
    if model.labels is FULL_BODY:
        return frames
    return Relabelled(frames, (*UPPER_BODY.names, CLUTTER), TO_TORSO)
