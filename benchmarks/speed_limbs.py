"""Limb segmentation: the cut beside PyMaxflow, the forest beside scikit-learn.

CPU time of all threads, so that what else a machine does counts less; both sides in turn. The
forest, which works on all cores, is timed by the clock, too, and scikit-learn has them then.
"""

import importlib
import importlib.util
import time
from collections.abc import Callable, Iterable, Iterator
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
from adibas.graphcut.boundary import boundary_weights
from adibas.graphcut.energy import (
    EnergyParams,
    LabelEnergy,
    equal_penalties,
    label_energy,
)
from adibas.graphcut.minimising import cheapest_labels, expand, minimise, start_labels, swap
from adibas.graphcut.neighbors import connect_pixels
from adibas.limbs.penalties import omega_2
from benchmarks.graph_cut_peer import pairs_of, peer_expand, peer_swap, plain_energy
from benchmarks.limb_chain import chain_rows
from benchmarks.limb_frames import FOCAL_PX, UPPER_BODY, LimbFrames
from benchmarks.limb_training import memory_rows, training_row
from benchmarks.table import Row

SEED = 6200
OTHER_POSES = 6201
LABEL_SETS = {7: UPPER_BODY, 15: BODY_PART_NAMES}
SMOOTHNESS = (10.0, 50.0)
CUT_GOAL = 4.0
"""How many times as fast as a loop with PyMaxflow a cut is to be, at equal energy."""
Work = Callable[[], object]


@dataclass(frozen=True, slots=True)
class Effort:
    """How much is measured."""

    n_images: int
    n_rounds: int
    n_trees: int
    set_sizes: tuple[int, ...]
    n_chain_frames: int
    n_training_frames: int


QUICK = Effort(12, 1, 1, (50, 200), n_chain_frames=5, n_training_frames=24)
WHOLE = Effort(60, 3, 3, (500, 2000, 8000), n_chain_frames=60, n_training_frames=2000)


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` a small forest, once, on small sets."""
    effort = QUICK if quick else WHOLE
    params = ForestParams(n_trees=effort.n_trees, n_images=None)
    for labels in LABEL_SETS.values():
        images = LimbFrames(effort.n_images, labels, SEED)
        forest = train_forest(images, params, SEED)
        yield from _cut_rows(forest, effort)
        if labels == BODY_PART_NAMES:
            yield from _forest_rows(images, forest, params, effort)
    yield from chain_rows(effort.n_chain_frames)
    yield from memory_rows(effort.set_sizes)
    yield training_row(effort.n_training_frames)


def _cut_rows(forest: Forest, effort: Effort) -> Iterator[Row]:
    """Cut an unseen frame by the forest's own probabilities, from either start."""
    frames = LimbFrames(1, forest.labels, OTHER_POSES)
    depth_m, mask = frames.person(0)
    probabilities = forest.probabilities(depth_m, mask, FOCAL_PX)
    n_labels = len(forest.labels)
    tables = {
        "Omega_1, expansion": equal_penalties(n_labels),
        "Omega_2, swap": omega_2(forest.labels),
    }
    for smoothness in SMOOTHNESS:
        for name, table in tables.items():
            graph = connect_pixels(mask)
            boundary = boundary_weights(graph, depth_m)
            params = EnergyParams(smoothness)
            energy = label_energy(graph, probabilities, boundary, table, params)
            title = f"{n_labels} labels, {graph.n_pixels} pixels, {name}, lambda {smoothness:g}"
            yield from _compare_cuts(title, energy, effort.n_rounds)
    yield _whole_cut(depth_m, mask, probabilities, effort.n_rounds)


def _compare_cuts(title: str, energy: LabelEnergy, n_rounds: int) -> Iterator[Row]:
    """Time both loops from the same labels, then each as it is used.

    The program's way seeks its start, within the time; a loop as one writes it with PyMaxflow
    begins from the likeliest labels.
    """
    ours_of, peer_of = (expand, peer_expand) if energy.is_metric else (swap, peer_swap)
    likeliest, start = cheapest_labels(energy), start_labels(energy)
    cases = {
        "both from likeliest labels": (partial(ours_of, energy, likeliest), likeliest),
        "both from our start": (partial(ours_of, energy, start), start),
        "each from its own start": (partial(minimise, energy), likeliest),
    }
    for starts, (ours, peer_start) in cases.items():
        peer = partial(peer_of, energy, peer_start)
        ours_ms, peer_ms = _medians_ms([ours, peer], n_rounds)
        name = f"{title}, {starts}"
        yield Row(f"cut of {name}", ours_ms, "ms CPU", peer_ms, "PyMaxflow loop")
        yield Row("same: times faster", peer_ms / ours_ms, "", CUT_GOAL, "goal >=")
        more = ours().energy - plain_energy(energy, pairs_of(energy), peer()[0])
        yield Row(f"energy more than PyMaxflow's, {name}", more, "units", 0, "goal <=")


def _whole_cut(
    depth_m: Float32Array, mask: BoolArray, probabilities: Float32Array, n_rounds: int
) -> Row:
    """Time everything from probabilities to labels, as it runs live."""

    def work() -> object:
        graph = connect_pixels(mask)
        table = equal_penalties(probabilities.shape[1])
        boundary = boundary_weights(graph, depth_m)
        energy = label_energy(graph, probabilities, boundary, table, EnergyParams(SMOOTHNESS[0]))
        return expand(energy)

    (spent_ms,) = _medians_ms([work], n_rounds)
    name = f"graph, energy, start and cut, {probabilities.shape[1]} labels"
    return Row(f"{name}, lambda {SMOOTHNESS[0]:g}", spent_ms, "ms CPU")


def _forest_rows(
    images: LimbFrames, forest: Forest, params: ForestParams, effort: Effort
) -> Iterator[Row]:
    frames = LimbFrames(1, forest.labels, OTHER_POSES)
    depth_m, mask = frames.person(0)
    truth = frames.read(0)[1][mask] - 1
    ours: Work = partial(forest.probabilities, depth_m, mask, FOCAL_PX)
    size = f"{params.n_trees} trees of depth {params.max_depth}, {len(truth)} pixels"
    found = forest.probabilities(depth_m, mask, FOCAL_PX).argmax(axis=1)
    yield Row("share of right pixels, unseen pose", 100 * float((found == truth).mean()), "%")
    training_s = _spent_s(partial(train_forest, images, params, SEED))
    name = f"forest training, {len(images)} images x {params.n_pixels} pixels"
    if importlib.util.find_spec("sklearn") is None:
        (ours_ms,) = _medians_ms([ours], effort.n_rounds)
        yield Row(f"forest, {size} (scikit-learn is not installed)", ours_ms, "ms CPU")
        yield Row(name, training_s, "s CPU")
        return
    peer = _ScikitPeer(images, params)
    works: list[Work] = [ours, partial(peer.probabilities, depth_m, mask)]
    ours_ms, peer_ms = _medians_ms(works, effort.n_rounds)
    yield Row(f"forest, {size}", ours_ms, "ms CPU", peer_ms, "scikit-learn with its features")
    peer.model.n_jobs = -1
    clock_ms, peer_clock_ms = _medians_ms(works, effort.n_rounds, time.perf_counter)
    name_by_clock = f"forest, {size}, by the clock, all cores"
    yield Row(name_by_clock, clock_ms, "ms", peer_clock_ms, "scikit-learn with its features")
    yield Row("same: times faster", peer_clock_ms / clock_ms, "", 20, "goal >=")
    peer.model.n_jobs = None
    values = peer.features(depth_m, mask)
    (alone_ms,) = _medians_ms([partial(peer.model.predict_proba, values)], effort.n_rounds)
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
        self.training_s = _spent_s(partial(self._train, images, rng, params))

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


def _spent_s(work: Work, clock: Callable[[], float] = time.process_time) -> float:
    begin = clock()
    work()
    return clock() - begin


def _medians_ms(
    works: list[Work], n_rounds: int, clock: Callable[[], float] = time.process_time
) -> list[float]:
    """Run works in turn after a first time; return the median time of each."""
    spent: list[list[float]] = [[] for _ in works]
    for _ in range(n_rounds + 1):
        for work, times_s in zip(works, spent, strict=True):
            times_s.append(_spent_s(work, clock))
    return [1e3 * float(np.median(times_s[1:])) for times_s in spent]
