"""A model's accuracy on labelled images: its own, or of those that are trained for the purpose."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

import cv2
import numpy as np

from adibas.arrays import AnyArray, BoolArray, Float32Array, IntArray, UInt8Array
from adibas.data.limbs import FULL_BODY, UPPER_BODY
from adibas.errors import LimbError
from adibas.files import written_whole
from adibas.forests.params import ForestParams
from adibas.forests.samples import TrainingImages
from adibas.forests.training import train_forest
from adibas.limbs.cells import PersonView
from adibas.limbs.context import forest_probabilities, limb_probabilities
from adibas.limbs.evaluation import Confusion, confusion_of, no_confusion
from adibas.limbs.model import CLUTTER, LimbModel, load_model, model_of
from adibas.limbs.segmentation import LimbParams, cut_labels
from adibas.limbs.training_folders import LimbFolders
from adibas.limbs.training_set import Chosen, check_people
from adibas.pipeline.limb_pictures import limb_picture
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.progress import Progress

Split: TypeAlias = Literal["folds", "people"]
Shipped: TypeAlias = Literal["shipped"]
N_FOLDS = 5
WHOLE = LimbParams(step=1)
"""Every pixel is labelled, as in the thesis."""


@dataclass(frozen=True, slots=True)
class EvaluationParams:
    """How a set is split and what is trained.

    Attributes
    ----------
    split : str
        ``folds``: five, drawn at random; ``people``: each person once is left out.
    seed : int
    forest : ForestParams
    limbs : LimbParams
    """

    split: Split = "folds"
    seed: int = 0
    forest: ForestParams = field(default_factory=ForestParams)
    limbs: LimbParams = WHOLE


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """One image as the forest, the network behind it and the cut label it; 1 to K, 0 = none."""

    index: int
    depth_m: Float32Array
    truth: UInt8Array
    by_forest: UInt8Array
    by_network: UInt8Array | None
    """None: the model has no network."""
    by_cut: UInt8Array


@dataclass(frozen=True, slots=True, eq=False)
class LimbEvaluation:
    """What came out.

    Attributes
    ----------
    protocol : str
    n_groups, n_images : int
    forest : Confusion
        Of the labels that the forest alone finds likeliest.
    network : Confusion or None
        Of those that the network behind it does; None: the model has none.
    cut : Confusion
        After the graph cut.
    """

    protocol: str
    n_groups: int
    n_images: int
    forest: Confusion
    network: Confusion | None
    cut: Confusion

    @property
    def before_cut(self) -> Confusion:
        """Return what the cut begins with."""
        return self.forest if self.network is None else self.network


def judge(
    images: TrainingImages, indices: Sequence[int] | IntArray, model: LimbModel, params: LimbParams
) -> Iterator[Judged]:
    """Label the images by a model with the same labels, or those and `CLUTTER`."""
    for index in indices:
        depth_m, truth, focal_px = images.read(int(index))
        mask = truth > 0
        view = PersonView(depth_m, mask, mask, focal_px)
        by_forest = _image(mask, forest_probabilities(view, model).argmax(axis=1))
        probabilities = limb_probabilities(view, model)
        has_network = model.context is not None
        by_network = _image(mask, probabilities.argmax(axis=1)) if has_network else None
        picture = np.where(mask, depth_m, np.nan)
        cut = cut_labels(picture, mask, probabilities, model, params)
        yield Judged(int(index), depth_m, truth, by_forest, by_network, _image(mask, cut))


def _image(mask: BoolArray, labels: AnyArray) -> UInt8Array:
    image = np.zeros(mask.shape, np.uint8)
    image[mask] = labels + 1
    return image


def evaluate_model(
    images: TrainingImages,
    model: LimbModel,
    params: LimbParams,
    progress: Progress,
    show: Callable[[Judged], None] | None = None,
) -> LimbEvaluation:
    """Evaluate one model on all images.

    Images of limbs alone do for a model that knows `CLUTTER`, too: what it takes for clutter is
    wrong then.

    Raises
    ------
    LimbError
        The model has other labels than the images, or nobody with depth is in them.
    """
    if images.labels not in (model.names, model.labels.names):
        raise LimbError(
            "The model has other labels than the images ({found}). Choose a model that was "
            "trained for these.",
            found=", ".join(images.labels),
        )
    check_people(images)
    counts = _Counts(model.names, has_network=model.context is not None)
    for done, judged in enumerate(judge(images, range(len(images)), model, params), start=1):
        counts.add(judged)
        if show is not None:
            show(judged)
        progress(done, len(images))
    return counts.evaluation("model", 1)


def evaluate_folders(
    folders: Sequence[Path],
    model: Path | Shipped | None,
    params: EvaluationParams,
    pictures: Path | None,
    progress: Progress,
) -> LimbEvaluation:
    """Evaluate a model on the images of folders, or models that are trained on parts of it.

    Parameters
    ----------
    folders : sequence of Path
    model : Path, "shipped" or None
        "shipped": the one of the images' labels that comes with the program; None: see
        `cross_validate`.
    params : EvaluationParams
    pictures : Path or None
        Folder for a picture of each image: truth, forest, network if any, and cut side by side.
    progress : function

    Raises
    ------
    LimbError, FileError
        The images or the model cannot be used, or the pictures not be written.
    """
    images = LimbFolders(folders)

    def show(judged: Judged) -> None:
        if pictures is not None:
            _write_picture(pictures / f"{images.names[judged.index]}.png", judged)

    if model is None:
        return cross_validate(images, params, progress, show)
    chosen = _shipped_for(images) if model == "shipped" else load_model(model)
    return evaluate_model(images, chosen, params.limbs, progress, show)


def _shipped_for(images: TrainingImages) -> LimbModel:
    names = images.labels[:-1] if images.labels[-1] == CLUTTER else images.labels
    return shipped_model(UPPER_BODY.name if names == UPPER_BODY.names else FULL_BODY.name)


def _write_picture(path: Path, judged: Judged) -> None:
    steps = (judged.truth, judged.by_forest, judged.by_network, judged.by_cut)
    shown = [limb_picture(judged.depth_m, labels) for labels in steps if labels is not None]
    payload: AnyArray = cv2.imencode(".png", np.hstack(shown)[..., ::-1])[1]
    with written_whole(path) as unfinished:
        unfinished.write_bytes(payload.tobytes())


def cross_validate(
    images: LimbFolders,
    params: EvaluationParams,
    progress: Progress,
    show: Callable[[Judged], None] | None = None,
) -> LimbEvaluation:
    """Train on all groups of images but one and test on that, for each group.

    Raises
    ------
    LimbError
        There is only one group, or nobody with depth in the others.
    """
    groups = groups_of(images, params)
    n_groups = int(groups.max()) + 1
    if n_groups < 2:  # noqa: PLR2004
        raise LimbError("There is only one group of images, which leaves nothing to train on.")
    counts = _Counts(images.labels, has_network=False)
    for group in range(n_groups):
        progress(group, n_groups)
        rest = Chosen(images, np.flatnonzero(groups != group))
        check_people(rest)
        model = model_of(train_forest(rest, params.forest, params.seed + group))
        for judged in judge(images, np.flatnonzero(groups == group), model, params.limbs):
            counts.add(judged)
            if show is not None:
                show(judged)
    progress(n_groups, n_groups)
    protocol = "5-fold" if params.split == "folds" else "leave-one-person-out"
    return counts.evaluation(protocol, n_groups)


def groups_of(images: LimbFolders, params: EvaluationParams) -> IntArray:
    """Return the group of each image.

    Raises
    ------
    LimbError
        People are to be left out, and a folder does not say who is in each image.
    """
    if params.split == "people":
        return np.unique(np.array(images.people), return_inverse=True)[1].astype(np.int64)
    order = np.random.default_rng(params.seed).permutation(len(images))
    groups = np.empty(len(images), np.int64)
    groups[order] = np.arange(len(images)) * min(N_FOLDS, len(images)) // len(images)
    return groups


class _Counts:
    """Sums over images."""

    def __init__(self, labels: tuple[str, ...], *, has_network: bool) -> None:
        self._forest = self._cut = no_confusion(labels)
        self._network = no_confusion(labels) if has_network else None
        self._n_images = 0

    def add(self, judged: Judged) -> None:
        # Without depth the forest knows nothing, and the cut would be praised for its guess.
        is_known = (judged.truth > 0) & np.isfinite(judged.depth_m)
        truth = judged.truth[is_known] - 1
        labels = self._forest.labels
        self._forest += confusion_of(labels, truth, judged.by_forest[is_known] - 1)
        if self._network is not None and judged.by_network is not None:
            self._network += confusion_of(labels, truth, judged.by_network[is_known] - 1)
        self._cut += confusion_of(labels, truth, judged.by_cut[is_known] - 1)
        self._n_images += 1

    def evaluation(self, protocol: str, n_groups: int) -> LimbEvaluation:
        counted = (self._forest, self._network, self._cut)
        return LimbEvaluation(protocol, n_groups, self._n_images, *counted)
