"""Folders of labelled depth images of simulated people, made on all cores.

Image ``i`` depends on the seed and ``i`` alone: making can stop and go on, on any number of cores.
"""

from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path

from adibas import __version__
from adibas.data.joints import BODY_PART_NAMES
from adibas.limbs.model import CLUTTER
from adibas.limbs.training_set import LABELS, FolderHeader, write_header, write_image
from adibas.progress import Progress
from adibas.simulation.device import DEPTH_UNIT_M
from adibas.simulation.limb_frames import FRAMES_A_PERSON, FrameSettings, LimbFrames

SIMULATED_LABELS = (*BODY_PART_NAMES, CLUTTER)


def simulate_folder(folder: Path, n_frames: int, seed: int, progress: Progress) -> None:
    """Write `n_frames` images to a folder; those that are there already stay.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    settings = FrameSettings()
    camera = LimbFrames(seed, settings).camera.intrinsics
    names = [image_name(index) for index in range(n_frames)]
    header = FolderHeader(
        SIMULATED_LABELS,
        DEPTH_UNIT_M,
        camera.fx,
        camera.fy,
        camera.cx,
        camera.cy,
        {name: f"p{index // FRAMES_A_PERSON:03d}" for index, name in enumerate(names)},
        {"simulator": __version__, "seed": seed, "settings": asdict(settings)},
    )
    write_header(folder, header)
    missing = [i for i, name in enumerate(names) if not (folder / f"{name}{LABELS}").exists()]
    people: dict[int, list[int]] = {}
    for index in missing:
        people.setdefault(index // FRAMES_A_PERSON, []).append(index)
    done = n_frames - len(missing)
    progress(done, n_frames)
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as processes:
        try:
            jobs = [processes.submit(_simulate, folder, seed, one) for one in people.values()]
            for finished in as_completed(jobs):
                done += finished.result()
                progress(done, n_frames)
        finally:
            processes.shutdown(cancel_futures=True)


def image_name(index: int) -> str:
    """Return the name of image `index` in a folder."""
    return f"{index:05d}"


def _simulate(folder: Path, seed: int, indices: list[int]) -> int:
    """Write the images of one person; return how many."""
    frames = LimbFrames(seed)
    for index in indices:
        frame = frames.frame(index)
        write_image(folder, image_name(index), frame.depth_mm, frame.labels)
    return len(indices)
