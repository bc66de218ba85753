"""Limb segmentation: the thesis' tables 6.2 and 6.3, the hand, and the shipped models.

Each figure is the mean over labels of the share of right pixels. What was measured is kept in
``build/benchmarks/accuracy_limbs.json``: after a break the benchmark goes on there; remove the
file to measure anew. `ADIBAS_LIMB_FOLDS` (1 to 5) measures the first folds alone.
"""

import os
from collections.abc import Iterable, Iterator
from functools import partial

from adibas.data.limbs import FULL_BODY, UPPER_BODY
from adibas.forests.samples import TrainingImages
from adibas.limbs.model import CLUTTER, LimbModel
from adibas.limbs.segmentation import LimbParams
from adibas.limbs.training_set import TO_TORSO, Relabelled
from adibas.pipeline.limb_evaluation import evaluate_model
from adibas.pipeline.limb_segmenting import shipped_model
from adibas.simulation.limb_frames import FrameSettings
from benchmarks import accuracy_pose, limb_things
from benchmarks.limb_kept import MEAN, Confusions, Kept, gain_row, shares_of
from benchmarks.limb_sets import CLEAN, LIVE, UnseenFrames, mocap_poses
from benchmarks.limb_tables import N_FOLDS, TableEffort, hand_rows, table_rows
from benchmarks.table import Row

PARAMS = LimbParams(step=1)


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` a fold of 40 frames, and 10 unseen people."""
    folds = min(max(int(os.environ.get("ADIBAS_LIMB_FOLDS", N_FOLDS)), 1), N_FOLDS)
    effort = TableEffort(40, 15, 1) if quick else TableEffort(500, 63, folds)
    kept = Kept("quick" if quick else "whole")
    yield from _shipped_rows(10 if quick else 60, kept)
    yield from table_rows(effort, kept)
    yield from hand_rows(effort, kept)
    yield from limb_things.rows(quick=quick)
    yield from accuracy_pose.rows(quick=quick)


def _shipped_rows(n_frames: int, kept: Kept) -> Iterator[Row]:
    """Measure the shipped models on people, and on poses, that had no part in their training."""
    poses = list(mocap_poses())
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
            made = f"{model.created_utc}, lambda {PARAMS.smoothness:g}"
            counted = kept.get(f"{told}, {made}", partial(_shipped, images, model))
            found = {one: shares_of(images.labels, counts) for one, counts in counted.items()}
            yield Row(f"{told}: forest", found["forest"][MEAN], "%")
            if "network" in found:
                yield Row(f"{told}: with the network", found["network"][MEAN], "%")
            yield Row(f"{told}: with cut", found["cut"][MEAN], "%", goal, "goal >=")
            yield gain_row(told, found.get("network", found["forest"]), found["cut"])
            for label, share in found["cut"].items():
                if label != MEAN:
                    yield Row(f"{told}, with cut: {label}", share, "%")


def _shipped(images: TrainingImages, model: LimbModel) -> Confusions:
    """Count what every pixel that has depth is taken for; clutter is one of the labels."""
    result = evaluate_model(images, model, PARAMS, lambda _done, _all: None)
    steps = {"forest": result.forest, "network": result.network, "cut": result.cut}
    return {name: step.counts for name, step in steps.items() if step is not None}


def _relabelled(frames: UnseenFrames, model: LimbModel) -> TrainingImages:
    if model.labels is FULL_BODY:
        return frames
    return Relabelled(frames, (*UPPER_BODY.names, CLUTTER), TO_TORSO)
