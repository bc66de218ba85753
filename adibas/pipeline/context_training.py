"""A context network for a model of limbs: trained on images that its forest has not seen."""

import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from adibas import __version__
from adibas.clock import Clock, to_text, utc_now
from adibas.context.examples import ContextExample
from adibas.context.files import rounded
from adibas.context.training import ContextTrainer, ContextTraining
from adibas.data.joints import mirror_order
from adibas.errors import LimbError
from adibas.files import DAMAGED_ARRAYS, written_whole
from adibas.forests.forest import Forest
from adibas.forests.samples import TrainingImages
from adibas.limbs.context import context_example
from adibas.limbs.model import CONTEXT, LABEL_SHARES, LimbModel, load_model, save_model
from adibas.limbs.training_folders import folders_of
from adibas.limbs.training_set import check_people, nobody_with_depth
from adibas.pipeline.limb_simulator import SIMULATED_LABELS
from adibas.pipeline.unfinished_training import (
    IMAGES_SHA256,
    SIMULATOR,
    Progress,
    check_same,
    origin_of,
    simulated_images,
    work_folder,
)

_KEPT = "context.npz"
_LEAST_PIXELS = 200
"""Measured, of an image that something can be learned from."""


@dataclass(frozen=True, slots=True)
class ContextRequest:
    """What to train.

    Attributes
    ----------
    model : Path
        Whose forest is corrected; a network that it has already goes on learning.
    out : Path
        The model with the network; what is unfinished is kept in a folder beside it.
    folders : tuple of Path
        Of labelled images that the forest was not trained on; without any they are simulated.
    n_frames : int
        To simulate.
    seed : int
        Of what is random; of simulated images another one than the forest's.
    params : ContextTraining
    """

    model: Path
    out: Path
    folders: tuple[Path, ...] = ()
    n_frames: int = 64_000
    seed: int = 1
    params: ContextTraining = field(default_factory=ContextTraining)


def train_context_of(
    request: ContextRequest, progress: Progress, clock: Clock = utc_now
) -> LimbModel:
    """Train a network and write the model with it; after a break the same request goes on.

    Raises
    ------
    LimbError
        The images cannot be used, or another training is unfinished there.
    FileError
        A file cannot be read or written.
    """
    model = load_model(request.model)
    work = work_folder(request.out)
    labelled = folders_of(request.folders)
    params = request.params
    if model.context is not None:
        params = replace(params, widths=model.context.shape.widths)
    settings = {
        "version": __version__,
        "model_created_utc": model.created_utc,
        "seed": request.seed,
        "params": {**asdict(params), "widths": list(params.widths)},
        "before": model.forest.provenance.get(CONTEXT),
        **origin_of(labelled, request.n_frames),
    }
    _check_labels(model.forest, SIMULATED_LABELS if labelled is None else labelled.labels)
    _check_unseen(model.forest, settings)
    if labelled is not None:
        check_people(labelled, _LEAST_PIXELS)
    check_same(work, settings)
    images = labelled or simulated_images(work, request.n_frames, request.seed, progress)
    trainer = _trainer(images, model, params, progress)
    _run(trainer, work / _KEPT, params.n_passes, progress)
    shares = [float(f"{share:.4g}") for share in trainer.label_shares]
    learned = {**settings, LABEL_SHARES: shares}
    made = {CONTEXT: learned, "created_utc": to_text(clock())}
    provenance = {**model.forest.provenance, **made}
    forest = replace(model.forest, provenance=provenance)
    trained = replace(model, forest=forest, context=rounded(trainer.learned()))
    save_model(trained, request.out)
    shutil.rmtree(work, ignore_errors=True)
    return trained


def _check_labels(forest: Forest, found: tuple[str, ...]) -> None:
    if found != forest.labels:
        raise LimbError(
            "The images have other labels than the model ({found}). Choose images with its labels.",
            found=", ".join(found),
        )


def _check_unseen(forest: Forest, settings: Mapping[str, object]) -> None:
    """See that these are not the images of the forest's own training."""
    seen = forest.provenance
    if _fingerprints(seen) & _fingerprints(settings):
        raise LimbError(
            "The forest was trained on these images, and is surer of them than of others. "
            "Choose other images."
        )
    told = [(one.get("images"), one.get("seed")) for one in (seen, settings)]
    if told[0] == told[1] and settings["images"] == SIMULATOR:
        raise LimbError(
            "The forest was trained on these images, and is surer of them than of others. Choose "
            "other images, or another seed."
        )


def _fingerprints(settings: Mapping[str, object]) -> frozenset[str]:
    """Return those of each folder of images; none where people were simulated."""
    found = settings.get(IMAGES_SHA256)
    return frozenset(map(str, found)) if isinstance(found, list) else frozenset()


def _trainer(
    images: TrainingImages, model: LimbModel, params: ContextTraining, progress: Progress
) -> ContextTrainer:
    forest = model.forest
    examples: list[ContextExample] = []
    for index in range(len(images)):
        depth_m, labels, focal_px = images.read(index)
        if np.count_nonzero(np.isfinite(depth_m[labels > 0])) >= _LEAST_PIXELS:
            example = context_example(depth_m, labels, focal_px, forest)
            if example is not None:
                examples.append(example)
        progress("looking", index + 1, len(images))
    if not examples:
        raise nobody_with_depth()
    order = np.array(mirror_order(forest.labels))
    return ContextTrainer(examples, order, params, model.context)


def _run(trainer: ContextTrainer, kept: Path, n_passes: int, progress: Progress) -> None:
    try:
        with kept.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            trainer.go_on(arrays)
    except (OSError, *DAMAGED_ARRAYS):
        pass  # the first pass, or what was kept is cut: it begins anew
    while trainer.n_done < n_passes:
        trainer.run_pass(lambda done, total: progress("training", done, total))
        with written_whole(kept) as unfinished, unfinished.open("wb") as written:
            np.savez(written, allow_pickle=False, **trainer.kept())
