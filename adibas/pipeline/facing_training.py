"""Learns from simulated people, seen from the front and from behind, what tells these apart.

Run as a module it makes ``resources/models/facing.json`` again, for the shipped model of limbs.
"""

import math
from collections.abc import Mapping

import numpy as np
from scipy.optimize import minimize

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.body.rays import viewing_rays
from adibas.data.frames import depth_in_metres
from adibas.limbs.facing import FARTHEST, Facing
from adibas.limbs.facing_quantities import QUANTITIES, describe_shape
from adibas.limbs.model import LimbModel
from adibas.limbs.proposals import part_points
from adibas.limbs.segmentation import LimbParams, segment
from adibas.pipeline.facing_file import write_facing
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.simulation.device import DEPTH_UNIT_M
from adibas.simulation.limb_frames import FRAMES_A_PERSON, FrameSettings, LimbFrames

SEED = 6500
N_IMAGES, STEP = 500, 5
"""Of each of four kinds: fronts and backs, as bad as in training and clean; every fifth image."""
FARTHEST_TURN_RAD = math.radians(75.0)
LEAST_PIXELS = 500
PENALTY = 10.0
"""On the squares of the weights, of standardised quantities."""
N_FOLDS = 5


def kinds() -> tuple[tuple[FrameSettings, bool], ...]:
    """Return how people are shown, and whether that is their front."""
    return tuple(
        (FrameSettings(is_bad, is_bad, FARTHEST_TURN_RAD, turned_rad=turned), turned == 0.0)
        for is_bad in (True, False)
        for turned in (0.0, math.pi)
    )


def described(seed: int, n_images: int, model: LimbModel) -> tuple[FloatArray, BoolArray, IntArray]:
    """Return (N, Q) quantities, whether each is of a front, and the number of the person.

    All four kinds show the same people.
    """
    found, fronts, people = [], [], []
    for settings, is_front in kinds():
        frames = LimbFrames(seed, settings)
        camera = frames.camera
        rays = viewing_rays(camera)
        for number in range(n_images):
            frame = frames.frame(STEP * number)
            mask: BoolArray = np.asarray(frame.labels > 0)
            if np.count_nonzero(mask) < LEAST_PIXELS:
                continue
            depth_m = depth_in_metres(frame.depth_mm, DEPTH_UNIT_M)
            parts = segment(depth_m, mask, camera.intrinsics.fx, model, LimbParams())
            found.append(describe_shape(part_points(depth_m, parts, rays)))
            fronts.append(is_front)
            people.append(STEP * number // FRAMES_A_PERSON)
    return np.array(found), np.array(fronts), np.array(people)


def learn_facing(
    quantities: FloatArray, is_front: BoolArray, provenance: Mapping[str, object]
) -> Facing:
    """Return the weights that (N, Q) quantities of fronts and backs teach; NaN: not seen."""
    middles, spreads = np.nanmean(quantities, axis=0), np.nanstd(quantities, axis=0)
    scaled = np.clip((quantities - middles) / spreads, -FARTHEST, FARTHEST)
    design = np.column_stack([np.ones(len(scaled)), np.nan_to_num(scaled)])
    signs = np.where(is_front, 1.0, -1.0)
    penalties = np.r_[0.0, np.full(len(QUANTITIES), PENALTY)]

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        margins = signs * (design @ weights)
        slopes = design.T @ (signs / (1.0 + np.exp(margins)))
        total = np.logaddexp(0.0, -margins).sum() + 0.5 * (penalties * weights**2).sum()
        return float(total), np.asarray(penalties * weights - slopes)

    found = np.asarray(minimize(loss, np.zeros(design.shape[1]), jac=True).x)
    return Facing(middles, spreads, found[1:], float(found[0]), provenance)


def held_out_share(quantities: FloatArray, is_front: BoolArray, people: IntArray) -> float:
    """Return how many are told right, in percent, by what others taught: people in five folds."""
    right = 0
    for fold in range(N_FOLDS):
        out = people % N_FOLDS == fold
        taught = learn_facing(quantities[~out], is_front[~out], {})
        right += int(np.count_nonzero((taught.log_odds(quantities[out]) > 0) == is_front[out]))
    return 100.0 * right / len(people)


def learn() -> Facing:
    """Return what the simulator teaches; the same every time."""
    model = shipped_model()
    quantities, is_front, people = described(SEED, N_IMAGES, model)
    provenance = {
        "seed": SEED,
        "n_images": len(people),
        "n_people": len(np.unique(people)),
        "held_out_percent": round(held_out_share(quantities, is_front, people), 1),
        "limbs_created_utc": model.created_utc,
    }
    return learn_facing(quantities, is_front, provenance)


if __name__ == "__main__":
    write_facing(learn())
