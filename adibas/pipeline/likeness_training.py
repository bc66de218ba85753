"""Learns from the simulator how limbs that are found in things differ from those of people.

Run as a module it makes ``resources/models/likeness.json`` again, for the shipped model of limbs.
"""

import itertools
from collections.abc import Iterable, Iterator

import numpy as np

from adibas.arrays import AnyArray, BoolArray, Float32Array, FloatArray
from adibas.body.people import find_people
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.limbs.judging import judge_mask, judge_parts
from adibas.limbs.likeness import Likeness, learn_likeness
from adibas.limbs.model import LimbModel
from adibas.limbs.segmentation import LimbParams, segment
from adibas.pipeline.likeness_file import write_likeness
from adibas.pipeline.person_quantities import QUANTITIES, describer
from adibas.pipeline.pose_following import forest_segmenter
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.crowds import CrowdFrame, CrowdScene, open_crowd
from adibas.simulation.limb_frames import LimbFrames
from adibas.simulation.lone_things import ThingFrames
from adibas.simulation.odd_plans import ODD_PLANS

SEED, WHOLE_SEED, SPARED_SEEDS = 6300, 6303, (6301, 6302)
N_PEOPLE, N_THINGS, N_SPARED = 300, 440, 120
CROWDS, CROWD_FRAMES = ("seated_child", "passer_by"), (0, 45)
N_CROWDS, N_SPARED_CROWDS = 24, 12
ANIMALS, ANIMAL_SEEDS, ANIMAL_FRAMES = ("quadruped", "sitting_dog"), range(6700, 6900), (0, 10, 20)
LEAST_PIXELS = 50
Shown = Iterator[tuple[AnyArray, BoolArray]]
"""Depth in millimetres, 0 where not measured, and a mask."""
_NOTHING = np.empty((0, len(QUANTITIES)))


def people_shown(seed: int, n_images: int, step: int) -> Shown:
    """Yield simulated people as bad as in training, every `step`-th image."""
    frames = LimbFrames(seed)
    for number in range(n_images):
        frame = frames.frame(step * number)
        yield frame.depth_mm, np.asarray(frame.labels > 0)


def things_shown(seed: int, n_images: int, step: int, *, has_damage: bool = True) -> Shown:
    """Yield things without people, of each kind in turn."""
    frames = ThingFrames(seed, has_damage=has_damage)
    for number in range(n_images):
        frame = frames.frame(step * number)
        yield frame.depth_mm, frame.mask


def described(shown: Shown, camera: CameraCalibration, model: LimbModel) -> FloatArray:
    """Return the (N, Q) quantities of all that other words do not refuse already."""
    describe = describer(camera)
    focal_px = camera.intrinsics.fx
    found = [_NOTHING]
    for depth_mm, mask in shown:
        depth_m = np.where(depth_mm > 0, depth_mm, np.nan).astype(np.float32) / np.float32(1000)
        if np.count_nonzero(mask) < LEAST_PIXELS or not judge_mask(depth_m, mask).is_person:
            continue
        parts = segment(depth_m, mask, focal_px, model, LimbParams(step=1))
        if judge_parts(parts, mask).is_person:
            found.append(describe(depth_m, mask, parts, None)[None])
    return np.concatenate(found)


def crowd_described(seeds: range, model: LimbModel) -> FloatArray:
    """Return the (N, Q) quantities of people at tables and half hidden, as they are found."""
    scenes = (open_crowd(name, seed) for name, seed in itertools.product(CROWDS, seeds))
    return np.concatenate(
        [_NOTHING, *(scene_described(one, CROWD_FRAMES, model, of_people=True) for one in scenes)]
    )


def animals_described(model: LimbModel) -> FloatArray:
    """Return the (N, Q) quantities of animals alone in a room, as they are found.

    Of single images most animals are refused by other words, and few are left to learn from.
    """
    pairs = itertools.product(ANIMALS, ANIMAL_SEEDS)
    scenes = (CrowdScene(ODD_PLANS[name], seed) for name, seed in pairs)
    return np.concatenate(
        [_NOTHING, *(scene_described(one, ANIMAL_FRAMES, model, of_people=False) for one in scenes)]
    )


def scene_described(
    scene: CrowdScene, frames: Iterable[int], model: LimbModel, *, of_people: bool
) -> FloatArray:
    """Return the (N, Q) quantities of people in a scene, or of all else that stands there."""
    calibration = scene.info.calibration
    if calibration is None or calibration.depth is None:
        raise ValueError("a simulated scene has a calibrated depth camera")
    camera = calibration.depth
    describe, segmented = describer(camera), forest_segmenter(model, camera)
    found = [_NOTHING]
    for index in frames:
        frame = scene.frame(index)
        depth_m = _metres(frame, calibration, scene.info.depth_unit_m)
        for mask in find_people(depth_m, camera, calibration.floor):
            pixels = mask.pixels
            is_person = bool(np.bincount(frame.owners[pixels], minlength=1).argmax())
            if is_person is not of_people or not judge_mask(depth_m, pixels).is_person:
                continue
            parts = segmented(depth_m, pixels)
            if judge_parts(parts, pixels).is_person:
                found.append(describe(depth_m, pixels, parts, None)[None])
    return np.concatenate(found)


def _metres(frame: CrowdFrame, calibration: RgbdCalibration, unit_m: float) -> Float32Array:
    raw = frame.sensor_frame.depth_raw
    if raw is None:
        raise ValueError("a simulated frame has depth")
    depth_m = calibration.corrected_depth(depth_in_metres(raw, unit_m))
    return np.ascontiguousarray(depth_m, np.float32)


def learn() -> Likeness:
    """Return what simulated people and things teach; the same every time."""
    model = shipped_model()
    people = described(people_shown(SEED, N_PEOPLE, 5), LimbFrames(SEED).camera, model)
    things = [
        described(things_shown(seed, N_THINGS, 1, has_damage=torn), ThingFrames(seed).camera, model)
        for seed, torn in ((SEED, True), (WHOLE_SEED, False))
    ]
    spared = [
        described(people_shown(seed, N_SPARED, 5), LimbFrames(seed).camera, model)
        for seed in SPARED_SEEDS
    ]
    first = range(SEED, SEED + N_CROWDS)
    second = range(SPARED_SEEDS[0] + N_CROWDS, SPARED_SEEDS[0] + N_CROWDS + N_SPARED_CROWDS)
    people = np.concatenate([people, crowd_described(first, model)])
    spared.append(crowd_described(second, model))
    shown = people, np.concatenate([*things, animals_described(model)])
    return learn_likeness(QUANTITIES, shown, np.concatenate(spared), provenance_of(model))


def provenance_of(model: LimbModel) -> dict[str, object]:
    """Return from what it is learned."""
    return {
        "seed": SEED,
        "whole_things_seed": WHOLE_SEED,
        "spared_seeds": list(SPARED_SEEDS),
        "n_people": N_PEOPLE,
        "n_things": 2 * N_THINGS,
        "animal_seeds": [ANIMAL_SEEDS.start, ANIMAL_SEEDS.stop],
        "n_animal_scenes": len(ANIMALS) * len(ANIMAL_SEEDS),
        "n_crowds": len(CROWDS) * N_CROWDS,
        "n_spared_crowds": len(CROWDS) * N_SPARED_CROWDS,
        "n_spared": N_SPARED * len(SPARED_SEEDS),
        "limbs_created_utc": model.created_utc,
    }


if __name__ == "__main__":
    write_likeness(learn())
