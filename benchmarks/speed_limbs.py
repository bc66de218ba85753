"""Limb segmentation: the cut beside PyMaxflow, the forest beside scikit-learn.

CPU time of all threads, so that what else a machine does counts less; both sides in turn. The
forest, which works on all cores, is timed by the clock, too, and scikit-learn has them then.
"""

import importlib
import importlib.util
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from adibas.arrays import AnyArray, BoolArray, Float32Array, FloatArray
from adibas.data.joints import BODY_PART_NAMES
from adibas.forests.candidates import draw_candidates
from adibas.forests.forest import Forest
from adibas.forests.params import ForestParams
from adibas.forests.training import train_forest
from benchmarks.limb_chain import chain_rows
from benchmarks.limb_cuts import OTHER_POSES, cut_rows
from benchmarks.limb_frames import FOCAL_PX, UPPER_BODY, LimbFrames
from benchmarks.limb_training import memory_rows, training_row
from benchmarks.table import Row
from benchmarks.works import Work, median_ms, medians_ms, spent_s

SEED = 6200
LABEL_SETS = {7: UPPER_BODY, 15: BODY_PART_NAMES}
FOREST_ROUNDS = 5
"""Times as many rounds as others have: they are short, and one halt would spoil two of three."""


@dataclass(frozen=True, slots=True)
class Effort:
    """How much is measured."""

    n_images: int
    n_cut_frames: int
    n_rounds: int
    n_trees: int
    set_sizes: tuple[int, ...]
    n_chain_frames: int
    n_training_frames: int


QUICK = Effort(12, 1, 1, 1, (50, 200), n_chain_frames=5, n_training_frames=24)
WHOLE = Effort(60, 8, 3, 3, (500, 2000, 8000), n_chain_frames=60, n_training_frames=2000)


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` a small forest, once, on small sets."""
    effort = QUICK if quick else WHOLE
    params = ForestParams(n_trees=effort.n_trees, n_images=None)
    for labels in LABEL_SETS.values():
        images = LimbFrames(effort.n_images, labels, SEED)
        forest = train_forest(images, params, SEED)
        yield from cut_rows(forest, effort.n_cut_frames, effort.n_rounds)
        if labels == BODY_PART_NAMES:
            yield from _forest_rows(images, forest, params, effort)
    yield from chain_rows(effort.n_chain_frames, effort.n_rounds)
    yield from memory_rows(effort.set_sizes)
    yield training_row(effort.n_training_frames)


def _forest_rows(
    images: LimbFrames, forest: Forest, params: ForestParams, effort: Effort
) -> Iterator[Row]:
    frames, n_rounds = LimbFrames(1, forest.labels, OTHER_POSES), effort.n_rounds * FOREST_ROUNDS
    depth_m, mask = frames.person(0)
    truth = frames.read(0)[1][mask] - 1
    ours: Work = partial(forest.probabilities, depth_m, mask, FOCAL_PX)
    size = f"{params.n_trees} trees of depth {params.max_depth}, {len(truth)} pixels"
    found = forest.probabilities(depth_m, mask, FOCAL_PX).argmax(axis=1)
    yield Row("share of right pixels, unseen pose", 100 * float((found == truth).mean()), "%")
    training_s = spent_s(partial(train_forest, images, params, SEED))
    name = f"forest training, {len(images)} images x {params.n_pixels} pixels"
    if importlib.util.find_spec("sklearn") is None:
        ours_ms = median_ms(ours, n_rounds)
        yield Row(f"forest, {size} (scikit-learn is not installed)", ours_ms, "ms CPU")
        yield Row(name, training_s, "s CPU")
        return
    peer = _ScikitPeer(images, params)
    works: list[Work] = [ours, partial(peer.probabilities, depth_m, mask)]
    ours_ms, peer_ms = medians_ms(works, n_rounds)
    yield Row(f"forest, {size}", ours_ms, "ms CPU", peer_ms, "scikit-learn with its features")
    peer.model.n_jobs = -1
    clock_ms, peer_clock_ms = medians_ms(works, n_rounds, time.perf_counter)
    name_by_clock = f"forest, {size}, by the clock, all cores"
    yield Row(name_by_clock, clock_ms, "ms", peer_clock_ms, "scikit-learn with its features")
    yield Row("same: times faster", peer_clock_ms / clock_ms, "", 20, "goal >=")
    peer.model.n_jobs = None
    values = peer.features(depth_m, mask)
    alone_ms = median_ms(partial(peer.model.predict_proba, values), n_rounds)
    yield Row(f"forest, {size}", ours_ms, "ms CPU", alone_ms, "scikit-learn, features given")
    right = peer.probabilities(depth_m, mask).argmax(axis=1) == truth
    yield Row("share of right pixels of scikit-learn", 100 * float(right.mean()), "%")
    yield Row(name, training_s, "s CPU", peer.training_s, "scikit-learn, 100 features in all")


class _ScikitPeer:
    """A forest of scikit-learn on dense depth comparisons: as many as one node here tries."""

    def __init__(self, images: LimbFrames, params: ForestParams) -> None:
        rng = np.random.default_rng(SEED)
        self._offsets_m = draw_candidates(rng, 1, params)[0][:, 1:].astype(np.float64)
        self._far_m = params.far_m
        ensemble: Any = importlib.import_module("sklearn.ensemble")
        self.model = ensemble.RandomForestClassifier(
            params.n_trees, max_depth=params.max_depth, criterion="entropy", random_state=SEED
        )
        self.training_s = spent_s(partial(self._train, images, rng, params))

    def _train(self, images: LimbFrames, rng: np.random.Generator, params: ForestParams) -> None:
        values, labels = zip(
            *(self._sample(images, n, rng, params) for n in range(len(images))), strict=True
        )
        self.model.fit(np.concatenate(values), np.concatenate(labels))

    def _sample(
        self, images: LimbFrames, index: int, rng: np.random.Generator, params: ForestParams
    ) -> tuple[FloatArray, AnyArray]:
        depth_m, labels, _ = images.read(index)
        pixels = np.argwhere(labels > 0)
        chosen = rng.choice(len(pixels), min(params.n_pixels, len(pixels)), replace=False)
        mask = np.zeros(labels.shape, bool)
        mask[tuple(pixels[chosen].T)] = True
        return self.features(depth_m, mask), labels[mask]

    def probabilities(self, depth_m: Float32Array, mask: BoolArray) -> AnyArray:
        """Compute features, then probabilities of the labels at the pixels of the mask."""
        return np.asarray(self.model.predict_proba(self.features(depth_m, mask)))

    def features(self, depth_m: Float32Array, mask: BoolArray) -> FloatArray:
        """Return the (N, F) values of equation 6.16, vectorised."""
        far = np.where(np.isfinite(depth_m), depth_m, self._far_m)
        height, width = depth_m.shape
        rows_, columns = np.nonzero(mask)
        scale = FOCAL_PX / far[mask]
        read = []
        for part in (0, 2):
            steps = np.floor(scale[:, None, None] * self._offsets_m[:, part : part + 2] + 0.5)
            row = rows_[:, None] + steps[:, :, 0].astype(np.int64)
            column = columns[:, None] + steps[:, :, 1].astype(np.int64)
            inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
            row, column = np.where(inside, row, 0), np.where(inside, column, 0)
            read.append(np.where(inside, far[row, column], self._far_m))
        values: FloatArray = (read[0] - read[1]).astype(np.float32)
        return values
