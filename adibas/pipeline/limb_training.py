"""From labelled depth images, of a folder or simulated, to a model; what broke off goes on."""

import shutil
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from adibas import __version__
from adibas.clock import Clock, to_text, utc_now
from adibas.data.limbs import FULL_BODY, LABEL_SETS, UPPER_BODY
from adibas.errors import LimbError
from adibas.files import DAMAGED_ARRAYS, written_whole
from adibas.forests.params import ForestParams
from adibas.forests.samples import Memory, PixelSample, TrainingImages
from adibas.forests.training import DrawPixels, Tree, join_trees, train_tree
from adibas.limbs.model import CLUTTER, LimbModel, load_model, merged, model_of, save_model
from adibas.limbs.training_folders import folders_of
from adibas.limbs.training_set import TO_TORSO, Mirrored, Relabelled, check_people
from adibas.pipeline.limb_simulator import SIMULATED_LABELS
from adibas.pipeline.unfinished_training import (
    Progress,
    check_same,
    origin_of,
    simulated_images,
    work_folder,
)

SHIPPED = ForestParams(
    n_trees=3,
    max_depth=24,
    n_images=None,
    n_pixels=1_200,
    evenness=0.5,
    n_candidates=30,
    max_offset_m=1.0,
    min_offset_m=0.05,
    pixel_share=0.5,
    min_pixels=400,
    shrinkage=50.0,
)
"""Many images with few pixels each: they differ more than pixels of one image (docs/limbs.md)."""
SHIPPED_FRAMES = 16_000
MEMORY = Memory(image_bytes=4 << 30)
"""Holds the images of the shipped models' training; more of them are read anew at every level."""


@dataclass(frozen=True, slots=True)
class TrainingRequest:
    """What to train.

    Attributes
    ----------
    out : Path
        The model; what is unfinished is kept in a folder beside it.
    folders : tuple of Path
        Of labelled images; without any they are simulated.
    labels : str
        One of `LABEL_SETS`, or empty for those of the images (full body of the simulator).
    n_frames : int
        To simulate.
    seed : int
    params : ForestParams
    cluster : str
        Address of a Dask scheduler; empty: this computer alone.
    """

    out: Path
    folders: tuple[Path, ...] = ()
    labels: str = ""
    n_frames: int = SHIPPED_FRAMES
    seed: int = 0
    params: ForestParams = SHIPPED
    cluster: str = ""


def train_model(request: TrainingRequest, progress: Progress, clock: Clock = utc_now) -> LimbModel:
    """Train a model and write it; after a break the same request goes on where it stood.

    Raises
    ------
    LimbError
        The images cannot be used, another training is unfinished there, or the cluster does
        not answer.
    FileError
        Something cannot be written.
    """
    with ExitStack() as stack:
        draw: DrawPixels = PixelSample
        if request.cluster:
            from adibas.pipeline.training_cluster import open_cluster

            draw = stack.enter_context(open_cluster(request.cluster)).draw
        return _trained(request, draw, progress, clock)


def _trained(
    request: TrainingRequest, draw: DrawPixels, progress: Progress, clock: Clock
) -> LimbModel:
    work = work_folder(request.out)
    labelled = folders_of(request.folders)
    labels = _labels_of(SIMULATED_LABELS if labelled is None else labelled.labels, request.labels)
    settings = {
        "version": __version__,
        "mirrored": not request.folders,
        "labels": list(labels),
        "seed": request.seed,
        "params": asdict(request.params),
        **origin_of(labelled, request.n_frames),
    }
    if labelled is not None:
        check_people(labelled)
    check_same(work, settings)
    images: TrainingImages = labelled or Mirrored(
        simulated_images(work, request.n_frames, request.seed, progress)
    )
    if images.labels != labels:
        images = Relabelled(images, labels, TO_TORSO)
    trees = [
        _grown(work, images, request, draw, number, progress)
        for number in range(request.params.n_trees)
    ]
    source = {**settings, "created_utc": to_text(clock())}
    model = model_of(join_trees(trees, images.labels, request.params, source).rounded())
    save_model(model, request.out)
    shutil.rmtree(work, ignore_errors=True)
    return model


def merge_model(source: Path, out: Path) -> LimbModel:
    """Make a model of the seven labels of the upper body out of one of the full body.

    Raises
    ------
    LimbError
        The model has other labels, or does not tell how many pixels it was trained on.
    FileError
        A file cannot be read or written.
    """
    model = load_model(source)
    model.require(FULL_BODY)
    if "label_pixels" not in model.forest.provenance:
        raise LimbError(
            "{file} does not tell how many pixels of each label it was trained on. Train it again.",
            file=source.name,
        )
    fewer = merged(model, UPPER_BODY, TO_TORSO)
    save_model(fewer, out)
    return fewer


def _labels_of(names: tuple[str, ...], wanted: str) -> tuple[str, ...]:
    """Return the labels to train: the images' own, or the seven that are made of the fifteen."""
    limbs = tuple(name for name in names if name != CLUTTER)
    rest = (CLUTTER,) if CLUTTER in names else ()
    if not wanted or LABEL_SETS[wanted].names == limbs:
        return names
    if LABEL_SETS[wanted] is UPPER_BODY and set(limbs) == set(FULL_BODY.names):
        return (*UPPER_BODY.names, *rest)
    raise LimbError(
        "The images have other labels than {wanted}: {found}. Choose other images or other labels.",
        wanted=wanted,
        found=", ".join(limbs),
    )


def _grown(
    work: Path,
    images: TrainingImages,
    request: TrainingRequest,
    draw: DrawPixels,
    number: int,
    progress: Progress,
) -> Tree:
    """Return tree `number`: from the break before, or grown now and kept."""
    path = work / f"tree-{number}.npz"
    n_levels = request.params.max_depth
    n_steps = request.params.n_trees * n_levels

    def tell(tree: int, level: int, _n_nodes: int) -> None:
        progress("training", tree * n_levels + level, n_steps)

    tree = _kept(path)
    if tree is None:
        tree = train_tree(images, request.params, (request.seed, number), MEMORY, tell, draw)
        with written_whole(path) as unfinished, unfinished.open("wb") as file:
            np.savez_compressed(file, child=tree.child, nodes=tree.nodes, counts=tree.counts)
    progress("training", (number + 1) * n_levels, n_steps)
    return tree


def _kept(path: Path) -> Tree | None:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return Tree(arrays["child"], arrays["nodes"], arrays["counts"])
    except (OSError, *DAMAGED_ARRAYS):
        return None
