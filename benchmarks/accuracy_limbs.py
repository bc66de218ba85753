"""Limb segmentation: the thesis' tables 6.2 and 6.3, the hand, and the shipped models.

Each figure is the mean over labels of the share of right pixels. What was measured is kept in
``build/benchmarks/accuracy_limbs.json``: after a break the benchmark goes on there; remove the
file to measure anew. `ADIBAS_LIMB_FOLDS` (1 to 5) measures the first folds alone.

The shipped models are measured on 120 people, two frames each. A mean tells how sure it is: its
95 % interval is of means of blocks of five people drawn with replacement (Efron and Tibshirani, An
Introduction to the Bootstrap, 1993, section 13.3), since frames of a person are alike.
"""

import os
from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np

from adibas.arrays import IntArray
from adibas.data.limbs import FULL_BODY, UPPER_BODY
from adibas.forests.samples import TrainingImages
from adibas.limbs.model import CLUTTER, LimbModel
from adibas.limbs.segmentation import LimbParams
from adibas.limbs.training_set import TO_TORSO, Chosen, Relabelled
from adibas.pipeline.limb_evaluation import evaluate_model
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.limb_frames import FrameSettings
from benchmarks import accuracy_pose, limb_things
from benchmarks.limb_kept import MEAN, Confusions, Kept, gain_row, shares_of
from benchmarks.limb_sets import CLEAN, LIVE, UnseenFrames, mocap_poses
from benchmarks.limb_tables import N_FOLDS, TableEffort, hand_rows, table_rows
from benchmarks.table import Row

PARAMS = LimbParams(step=1)
BLOCK = 10
"""Frames of five people, which are counted and drawn together."""
N_DRAWS = 2000


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` a fold of 40 frames, and 5 unseen people."""
    folds = min(max(int(os.environ.get("ADIBAS_LIMB_FOLDS", N_FOLDS)), 1), N_FOLDS)
    effort = TableEffort(40, 15, 1) if quick else TableEffort(500, 63, folds)
    kept = Kept("quick" if quick else "whole")
    yield from _shipped_rows(10 if quick else 240, kept)
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
            told = f"{labels.name}, {n_frames} frames of {name}"
            made = f"{labels.name}, {name}, {model.created_utc}, lambda {PARAMS.smoothness:g}"
            blocks = [
                kept.get(f"{made}, frames {block}", partial(_shipped, images, block, model))
                for block in _blocks(n_frames)
            ]
            counted = {one: np.stack([block[one] for block in blocks]) for one in blocks[0]}
            found = {
                one: shares_of(images.labels, counts.sum(axis=0)) for one, counts in counted.items()
            }
            yield Row(f"{told}: forest", found["forest"][MEAN], "%")
            if "network" in found:
                yield Row(f"{told}: with the network", found["network"][MEAN], "%")
            yield Row(f"{told}: with cut", found["cut"][MEAN], "%", goal, "goal >=")
            low, high = _interval(images.labels, counted["cut"])
            yield Row(f"{told}: with cut, 95 % interval from", low, "%")
            yield Row(f"{told}: with cut, 95 % interval to", high, "%")
            yield gain_row(told, found.get("network", found["forest"]), found["cut"])
            for label, share in found["cut"].items():
                if label != MEAN:
                    yield Row(f"{told}, with cut: {label}", share, "%")


def _blocks(n_frames: int) -> list[range]:
    return [range(begin, min(begin + BLOCK, n_frames)) for begin in range(0, n_frames, BLOCK)]


def _interval(labels: tuple[str, ...], counts: IntArray) -> tuple[float, float]:
    """Return the 95 % interval of the mean per label, of (B, L, L) counts: B blocks are drawn."""
    n_blocks = len(counts)
    drawn = np.random.default_rng(0).integers(n_blocks, size=(N_DRAWS, n_blocks))
    means = [shares_of(labels, counts[chosen].sum(axis=0))[MEAN] for chosen in drawn]
    low, high = np.percentile(means, (2.5, 97.5))
    return float(low), float(high)


def _shipped(images: TrainingImages, frames: range, model: LimbModel) -> Confusions:
    """Count what every pixel that has depth is taken for; clutter is one of the labels."""
    chosen = Chosen(images, frames)
    result = evaluate_model(chosen, model, PARAMS, lambda _done, _all: None)
    steps = {"forest": result.forest, "network": result.network, "cut": result.cut}
    return {name: step.counts for name, step in steps.items() if step is not None}


def _relabelled(frames: UnseenFrames, model: LimbModel) -> TrainingImages:
    if model.labels is FULL_BODY:
        return frames
    return Relabelled(frames, (*UPPER_BODY.names, CLUTTER), TO_TORSO)
