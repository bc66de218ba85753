"""The thesis' tables 6.2 and 6.3 and its hand, row by row, in 5 folds, beside its figures."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from adibas.arrays import AnyArray, BoolArray, Float32Array, IntArray
from adibas.forests.params import ForestParams
from adibas.forests.training import train_forest
from adibas.graphcut.boundary import depth_and_color
from adibas.limbs.evaluation import confusion_of
from adibas.limbs.model import LimbModel, model_of
from adibas.limbs.segmentation import LimbParams, cut_labels
from adibas.limbs.training_set import Chosen
from benchmarks.limb_film import ThesisFrames, depth_of_body
from benchmarks.limb_kept import MEAN, Confusions, Kept, Shares, gain_row, shares_of
from benchmarks.limb_sets import HandFrames
from benchmarks.table import Row

SEED = 6200
N_FOLDS = 5
KINECT_FOCAL_PX = 530.0
O_30, O_45, O_60 = (px / KINECT_FOCAL_PX for px in (30, 45, 60))
THESIS_FOREST = ForestParams(max_offset_m=O_60)
HAND_FOREST = ForestParams(n_trees=1, max_depth=15, n_pixels=500, n_images=None, max_offset_m=O_45)
LABELS = ("torso", *(f"{side}_{part}" for side in ("left", "right")
                     for part in ("upper_arm", "lower_arm", "hand")))  # fmt: skip
"""In the order of the thesis' columns."""
Figures = tuple[float, ...]
"""The thesis', percent: of `LABELS`, then their mean."""
TABLE_6_2: Mapping[str, tuple[ForestParams, Figures]] = {
    "100 f, O_max 60, depth 20": (
        THESIS_FOREST,
        (94.17, 79.83, 77.69, 77.10, 81.04, 82.65, 80.17, 81.81),
    ),
    "100 f, O_max 30, depth 20": (
        replace(THESIS_FOREST, max_offset_m=O_30),
        (92.90, 73.29, 71.42, 57.75, 74.25, 76.26, 59.38, 72.18),
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
"""The first row is the forest that table 6.3 cuts."""
OMEGA_1, OMEGA_2 = (LimbParams(cut, 50.0, step=1) for cut in ("omega_1", "omega_2"))
WEAK = LimbParams("omega_1", 4.0, step=1)
TABLE_6_3: Mapping[str, tuple[LimbParams, bool, Figures]] = {
    "depth, Omega_1": (OMEGA_1, False, (98.86, 75.05, 82.87, 91.45, 77.57, 87.35, 93.96, 86.73)),
    "depth, Omega_2": (OMEGA_2, False, (98.86, 75.03, 83.36, 92.41, 77.54, 87.67, 94.20, 87.01)),
    "RGB+depth, Omega_1": (OMEGA_1, True, (99.02, 72.02, 81.86, 90.29, 76.56, 86.84, 92.14, 85.53)),
    "RGB+depth, Omega_2": (OMEGA_2, True, (99.02, 72.03, 81.95, 91.19, 76.53, 87.12, 92.12, 85.71)),
}
"""How it cuts, whether colour counts, and the thesis' figures. It prints 0.7503 for 75.03."""
Cuts = Mapping[str, tuple[LimbParams, bool]]
ALWAYS: Cuts = {
    "depth, Omega_1, lambda 50": (OMEGA_1, False),
    "depth, Omega_1, lambda 4": (WEAK, False),
}
"""What every forest is followed by: the thesis' cut, and that of the shipped models."""
FOUR: Cuts = {
    **{f"{name}, lambda 50": (limbs, is_rgb) for name, (limbs, is_rgb, _) in TABLE_6_3.items()},
    **ALWAYS,
}


@dataclass(frozen=True, slots=True)
class TableEffort:
    """How much is measured."""

    n_frames: int
    n_hands: int
    n_folds: int

    @property
    def told(self) -> str:
        """Return it for the name of a row."""
        return f"{self.n_frames} frames, {self.n_folds} of {N_FOLDS} folds"


def table_rows(effort: TableEffort, kept: Kept) -> Iterator[Row]:
    """Measure both tables on frames of film, then the forest of 6.3 on frames that differ more."""
    film = ThesisFrames(effort.n_frames, is_film=True)
    told = f"film, {effort.told}"
    for number, (name, (params, thesis)) in enumerate(TABLE_6_2.items()):
        cuts = ALWAYS if number else FOUR
        found = _measured(kept, f"film, {name}", film, params, (cuts, effort.n_folds))
        yield from _compared(f"table 6.2, {name} ({told})", found["forest"], thesis)
        yield from _cut_rows(f"{name} ({told})", found, cuts)
    drawn = ThesisFrames(effort.n_frames, is_film=False)
    name, (params, thesis) = next(iter(TABLE_6_2.items()))
    found = _measured(kept, f"drawn, {name}", drawn, params, (FOUR, effort.n_folds))
    told = f"{name} (each frame a pose of its own, {effort.told})"
    yield from _compared(f"table 6.2, {told}", found["forest"], thesis)
    yield from _cut_rows(told, found, FOUR)


def hand_rows(effort: TableEffort, kept: Kept) -> Iterator[Row]:
    """Cross-validate on the hand: one tree of depth 15, 500 pixels, O_max 45."""
    frames = HandFrames(effort.n_hands)
    cuts: Cuts = {"cut": (OMEGA_1, False)}
    found = _measured(kept, "hand", frames, HAND_FOREST, (cuts, effort.n_folds))
    told = f"hand, {effort.n_hands} simulated frames, {effort.n_folds} of {N_FOLDS} folds"
    yield Row(f"{told}: forest", found["forest"][MEAN], "%", 58.5, "thesis")
    yield Row(f"{told}: with cut, Omega_1, lambda 50", found["cut"][MEAN], "%", 70.9, "thesis")
    yield gain_row(told, found["forest"], found["cut"])


def _cut_rows(told: str, found: Mapping[str, Shares], cuts: Cuts) -> Iterator[Row]:
    of_thesis = {f"{name}, lambda 50": figures for name, (_, _, figures) in TABLE_6_3.items()}
    for cut in cuts:
        name = f"table 6.3, {cut} on {told}"
        if cuts is FOUR and cut in of_thesis:
            yield from _compared(name, found[cut], of_thesis[cut])
        else:
            yield Row(f"{name}: {MEAN}", found[cut][MEAN], "%")
        yield gain_row(name, found["forest"], found[cut])


def _compared(name: str, found: Shares, thesis: Figures) -> Iterator[Row]:
    for label, wanted in zip((*LABELS, MEAN), thesis, strict=True):
        yield Row(f"{name}: {label}", found[label], "%", wanted, "thesis")


def _measured(
    kept: Kept,
    name: str,
    frames: ThesisFrames | HandFrames,
    params: ForestParams,
    how: tuple[Cuts, int],
) -> dict[str, Shares]:
    cuts, n_folds = how
    works: dict[str, Callable[[], Confusions]] = {
        f"{name}, fold {fold}": partial(_fold, frames, params, fold, cuts)
        for fold in range(n_folds)
    }
    counted = kept.sum(works)
    return {one: shares_of(frames.labels, counts) for one, counts in counted.items()}


def _fold(
    frames: ThesisFrames | HandFrames, params: ForestParams, fold: int, cuts: Cuts
) -> Confusions:
    """Train on four fifths of a set and test on the fifth, with cuts on the probabilities."""
    groups = _groups(len(frames))
    training = Chosen(frames, np.flatnonzero(groups != fold))
    model = model_of(train_forest(training, params, SEED + fold))
    n_labels = len(frames.labels)
    sums = {name: np.zeros((n_labels, n_labels), np.int64) for name in ("forest", *cuts)}
    for index in np.flatnonzero(groups == fold):
        depth_m, labels, focal_px = frames.read(int(index))
        mask = (labels > 0) & np.isfinite(depth_m)
        probabilities = model.forest.probabilities(depth_m, mask, focal_px)
        found = {"forest": probabilities.argmax(axis=1)}
        for name, (limbs, is_rgb) in cuts.items():
            picture: AnyArray = depth_of_body(depth_m, labels)
            if is_rgb and isinstance(frames, ThesisFrames):
                picture = depth_and_color(picture, frames.color(int(index)))
            found[name] = _cut(picture, mask, probabilities, model, limbs)
        for name, one in found.items():
            sums[name] += confusion_of(frames.labels, labels[mask] - 1, one).counts
    return sums


def _cut(
    picture: AnyArray,
    mask: BoolArray,
    probabilities: Float32Array,
    model: LimbModel,
    limbs: LimbParams,
) -> IntArray:
    return np.asarray(cut_labels(picture, mask, probabilities, model, limbs), np.int64)


def _groups(n_images: int) -> IntArray:
    order = np.random.default_rng(SEED).permutation(n_images)
    groups = np.empty(n_images, np.int64)
    groups[order] = np.arange(n_images) * N_FOLDS // n_images
    return groups
