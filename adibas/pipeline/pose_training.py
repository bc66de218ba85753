"""Learns from the simulator how far joints lie behind the surface, and how long bones are.

Run as a module it makes ``resources/models/joints.json`` again.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from adibas.arrays import FloatArray
from adibas.body.rays import viewing_rays
from adibas.data.calibration import CameraCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.data.limbs import FULL_BODY, NO_LABEL, LimbParts
from adibas.geometry.pinhole import Intrinsics
from adibas.limbs.joint_offsets import JointOffsets, OffsetExample, learn_offset
from adibas.limbs.joint_places import PLACES
from adibas.limbs.proposals import PartPoints, modes_of_places, part_points
from adibas.pipeline.pose_model import JointModel, write_joint_model
from adibas.progress import Progress
from adibas.resources import resource_path
from adibas.simulation.body import ShapedBody, load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.random_poses import KINDS, random_figure
from adibas.simulation.raster import rasterise
from adibas.skeleton.proportions import learn_proportions

CAMERA = CameraCalibration(640, 480, Intrinsics(570.0, 570.0, 319.5, 239.5))
SHAPES = (
    BodyShape("female", 35, 1.66, 60),
    BodyShape("male", 50, 1.78, 85),
    BodyShape("female", 9, 1.33, 30),
    BodyShape("male", 25, 1.85, 78),
    BodyShape("female", 60, 1.58, 75),
    BodyShape("male", 7, 1.22, 23),
    BodyShape("male", 40, 1.74, 100),
    BodyShape("female", 12, 1.50, 40),
    BodyShape("female", 24, 1.72, 58),
    BodyShape("male", 16, 1.70, 60),
)
NOISE_M = 0.003
LEAST_DENSITY_M2 = 0.0006
FARTHEST_M = 0.4
"""A mode so far from its joint belongs to something else."""
POSES_WEIGHTS = (0.4, 0.4, 0.2)


@dataclass(frozen=True, slots=True, eq=False)
class _Example:
    points: PartPoints
    joints_m: FloatArray
    stature_m: float


def learn_joints(n_examples: int, seed: int, progress: Progress) -> JointModel:
    """Return what `n_examples` simulated people teach; the same for the same seed."""
    by_kind: dict[str, list[OffsetExample]] = {place.kind: [] for place in PLACES}
    joints_m, statures_m, weights_m2 = [], [], []
    for number, example in enumerate(_examples(n_examples, seed), 1):
        middles_m = example.points.middles_m()
        weights = np.zeros(len(JOINT_NAMES))
        for place, modes in zip(PLACES, modes_of_places(example.points), strict=True):
            at = JOINT_NAMES.index(place.joint)
            x, y, z, weights[at] = modes[0]
            mode_m, joint_m = np.array([x, y, z]), example.joints_m[at]
            is_near = np.linalg.norm(mode_m - joint_m) < FARTHEST_M
            if weights[at] >= LEAST_DENSITY_M2 and is_near:
                by_kind[place.kind].append(OffsetExample(place, mode_m, joint_m, middles_m))
        joints_m.append(example.joints_m)
        statures_m.append(example.stature_m)
        weights_m2.append(weights)
        progress(number, n_examples)
    offsets = JointOffsets({kind: learn_offset(found) for kind, found in by_kind.items()})
    proportions = learn_proportions(np.stack(joints_m), np.array(statures_m), np.stack(weights_m2))
    return JointModel(offsets, proportions)


def _examples(n_examples: int, seed: int) -> Iterator[_Example]:
    model = load_body_model()
    bodies = [model.shaped(shape) for shape in SHAPES]
    for number in range(n_examples):
        rng = np.random.default_rng([seed, number])
        yield _example(bodies[number % len(bodies)], rng)


def _example(body: ShapedBody, rng: np.random.Generator) -> _Example:
    kind = KINDS[int(rng.choice(len(KINDS), p=POSES_WEIGHTS))]
    turned_rad = float(rng.normal(0.0, 0.35)) + (math.pi if rng.random() < 0.2 else 0.0)  # noqa: PLR2004
    posed = body.posed(replace(random_figure(rng, kind).pose(), heading_rad=turned_rad))
    middle_m = 0.5 * (posed.vertices_m.min(axis=0) + posed.vertices_m.max(axis=0))
    shift_m = np.array([0.0, 0.0, float(rng.uniform(1.8, 3.2))]) - middle_m
    size = (CAMERA.height, CAMERA.width)
    seen = rasterise(
        posed.vertices_m + shift_m,
        body.model.triangles,
        CAMERA.intrinsics,
        size,
        hides_back_faces=True,
    )
    pixels = seen.triangle >= 0
    chosen = np.full(size, NO_LABEL, np.int16)
    chosen[pixels] = body.model.triangle_parts[seen.triangle[pixels]]
    probabilities = np.zeros((int(pixels.sum()), len(FULL_BODY)), np.float32)
    probabilities[np.arange(len(probabilities)), chosen[pixels]] = 1.0
    depth_m = (seen.depth_m + rng.normal(0.0, NOISE_M, size)).astype(np.float32)
    parts = LimbParts(FULL_BODY, pixels, probabilities, chosen)
    points = part_points(depth_m, parts, viewing_rays(CAMERA))
    return _Example(points, posed.joints_m + shift_m, body.stature_m)


def train(path: Path, n_examples: int = 2000, seed: int = 1) -> None:
    """Write the model of joints."""
    model = learn_joints(n_examples, seed, lambda _done, _total: None)
    provenance = {
        "source": "simulated bodies with their true parts",
        "examples": n_examples,
        "seed": seed,
        "people": len(SHAPES),
    }
    write_joint_model(path, model, provenance)


if __name__ == "__main__":
    train(resource_path("models", "joints.json"))
