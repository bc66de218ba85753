"""Who is refused: things and animals without people (all should be), and people (nobody should).

Simulated ones are of seeds that nothing was learned from; real people are those of UTD-MHAD.
"""

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from adibas.arrays import AnyArray, BoolArray, Float32Array
from adibas.limbs.judging import judge_mask
from adibas.limbs.model import LimbModel
from adibas.limbs.segmentation import LimbParams, segment
from adibas.pipeline.likeness_training import people_shown
from adibas.pipeline.person_judge import Judge, person_judge
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.limb_frames import LimbFrames
from adibas.simulation.lone_things import KINDS, ThingFrames
from benchmarks.pose_real import ACTIONS, CAMERA, DEEP_BEND, PEOPLE, REAL_DATA, read_depths
from benchmarks.table import Row

SEED = 6310
REAL_STEP = 12
"""Every so many frames one is looked at: those between look alike."""


def rows(*, quick: bool) -> Iterator[Row]:
    """Measure; with `quick` one thing of each kind and ten people."""
    model = shipped_model()
    yield from _thing_rows(model, len(KINDS) * (1 if quick else 20))
    yield _people_row(model, 10 if quick else 200)
    if not quick:
        yield from _real_rows(model)


def _thing_rows(model: LimbModel, n_images: int) -> Iterator[Row]:
    frames = ThingFrames(SEED)
    camera = frames.camera
    judge = person_judge(model, camera)
    refused: dict[str, list[bool]] = {kind: [] for kind in KINDS}
    for index in range(n_images):
        frame = frames.frame(index)
        depth_m = _metres(frame.depth_mm)
        refused[frame.kind].append(
            is_refused(depth_m, frame.mask, camera.intrinsics.fx, model, judge)
        )
    every = [one for kind in refused.values() for one in kind]
    told = f"{n_images} simulated things alone, cut out"
    yield Row(f"{told}: refused", 100 * float(np.mean(every)), "%", 100, "goal")
    for kind, found in refused.items():
        yield Row(f"{told}: {kind} refused", 100 * float(np.mean(found)), "%")


def _people_row(model: LimbModel, n_images: int) -> Row:
    camera = LimbFrames(SEED).camera
    judge = person_judge(model, camera)
    refused = [
        is_refused(_metres(depth_mm), mask, camera.intrinsics.fx, model, judge)
        for depth_mm, mask in people_shown(SEED, n_images, 5)
    ]
    told = f"{n_images} simulated people, seen as badly as in training: refused"
    return Row(told, 100 * float(np.mean(refused)), "%")


def _real_rows(model: LimbModel) -> Iterator[Row]:
    folder = os.environ.get(REAL_DATA)
    if folder is None:
        return
    judge = person_judge(model, CAMERA)
    refused = []
    for action in (*ACTIONS, DEEP_BEND):
        for person in PEOPLE:
            name = f"a{action}_s{person}_t1_depth.mat"
            for depth_m in read_depths(Path(folder) / "utd_mhad" / "Depth" / name)[::REAL_STEP]:
                mask = np.asarray(np.isfinite(depth_m))
                refused.append(is_refused(depth_m, mask, CAMERA.intrinsics.fx, model, judge))
    told = f"real people, {len(refused)} frames of {len(PEOPLE)} people: refused"
    yield Row(told, 100 * float(np.mean(refused)), "%", 0.5, "goal <")


def is_refused(
    depth_m: Float32Array, mask: BoolArray, focal_px: float, model: LimbModel, judge: Judge
) -> bool:
    """Say whether no skeleton would be made of a mask, looked at for the first time."""
    if not judge_mask(depth_m, mask).is_person:
        return True
    parts = segment(depth_m, mask, focal_px, model, LimbParams(step=1))
    return not judge(depth_m, mask, parts, None).is_person


def _metres(depth_mm: AnyArray) -> Float32Array:
    depth_m: Float32Array = depth_mm.astype(np.float32) / np.float32(1000)
    depth_m[depth_mm == 0] = np.nan
    return depth_m
