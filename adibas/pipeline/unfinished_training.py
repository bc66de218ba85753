"""What a training leaves beside its model until it is done: settings, images, what is learned."""

import json
from collections.abc import Callable
from pathlib import Path

from adibas.errors import LimbError
from adibas.files import DAMAGED_JSON, written_whole
from adibas.limbs.training_folders import LimbFolders
from adibas.limbs.training_set import LimbFolder
from adibas.pipeline.limb_simulator import simulate_folder

IMAGES_SHA256 = "images_sha256"
"""Setting of a training on folders: each one's fingerprint; of simulated people the seed tells."""
SIMULATOR = "simulator"
Progress = Callable[[str, int, int], None]
"""Told the step (``simulating``, ``training``), what is done and all there is."""
_UNFINISHED = ".training"
_SETTINGS = "settings.json"
_FRAMES = "frames"


def work_folder(model: Path) -> Path:
    """Return where an unfinished training of a model lies."""
    return model.with_name(model.name + _UNFINISHED)


def simulated_images(work: Path, n_frames: int, seed: int, progress: Progress) -> LimbFolder:
    """Return images of simulated people; those that were made before a break stay.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    frames = work / _FRAMES
    simulate_folder(frames, n_frames, seed, lambda done, total: progress("simulating", done, total))
    return LimbFolder(frames)


def origin_of(labelled: LimbFolders | None, n_simulated: int) -> dict[str, object]:
    """Return the settings that tell which images these are; None: so many simulated ones.

    Raises
    ------
    LimbError
        A folder cannot be read.
    """
    if labelled is None:
        return {"images": SIMULATOR, "n_images": n_simulated}
    return {
        "images": list(labelled.titles),
        "n_images": len(labelled),
        IMAGES_SHA256: list(labelled.sha256s()),
    }


def check_same(work: Path, settings: dict[str, object]) -> None:
    """Keep the settings, or see that an unfinished training has the same ones.

    Raises
    ------
    LimbError
        It has others.
    FileError
        They cannot be written.
    """
    path = work / _SETTINGS
    if not path.exists():
        with written_whole(path) as unfinished:
            unfinished.write_text(json.dumps(settings, indent=1), "utf-8")
        return
    try:
        before = json.loads(path.read_text("utf-8"))
    except (OSError, *DAMAGED_JSON):
        before = None
    if before != settings:
        raise LimbError(
            "An unfinished training with other settings or images lies in {folder}. Finish it with "
            "the same ones, or remove that folder.",
            folder=work.name,
        )
