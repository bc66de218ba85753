"""Labelled shapes of simulated people: what the shipped skeleton model is trained on.

People mark a joint at different places: its centre (a mocap skeleton), the skin before or behind
it, or a landmark beside it. Each shape chooses among them, the same on both sides, so that the
model learns where a marker of that name may be.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.skeleton_marks import JointMarks, MarkedBody
from adibas.pipeline.skeleton_poses import draw_pose
from adibas.progress import Progress
from adibas.simulation.body import ShapedBody, load_body_model
from adibas.simulation.body_shape import BodyShape

KIND_SHARES: Mapping[str, float] = {
    "standing": 0.3,
    "moving": 0.35,
    "seated": 0.2,
    "gesture": 0.15,
}
"""What names are tested on."""
TRAINING_SHARES: Mapping[str, float] = {
    "standing": 0.22,
    "moving": 0.22,
    "seated": 0.16,
    "gesture": 0.10,
    "table": 0.08,
    "active": 0.22,
}
"""What they are learned from: broader."""
CHILDREN_SHARE = 0.25
GROWN_YEARS = 18.0
MARKER_SD_M = 0.012
"""Of a marker about its place: palpation differs by about a centimetre between hands."""
WHOLE_SET_SHARE = 0.4
"""Of shapes that are all centres, all fronts or all backs."""

SKIN_PLACES: Mapping[str, tuple[str, ...]] = {
    "head": ("glabella",),
    "neck": ("c7", "sternal_notch"),
    "shoulder": ("acromion",),
    "elbow": ("lateral_epicondyle", "medial_epicondyle"),
    "hand": ("wrist",),
    "torso": ("t10", "t9", "sternum"),
    "hip": ("asis", "psis", "greater_trochanter"),
    "knee": ("patella", "knee_joint_line"),
    "foot": ("lateral_malleolus", "medial_malleolus", "metatarsals", "achilles", "calcaneus"),
}
"""Landmarks that are taken for a joint, beside its centre and the skin before and behind it."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledShapes:
    """Shapes of simulated people, each facing a camera that looks along z.

    Attributes
    ----------
    shapes_m : (S, 15, 3) array
        In the order of `JOINT_NAMES`.
    kinds : tuple of str
        Of each: see `draw_pose`.
    """

    shapes_m: FloatArray
    kinds: tuple[str, ...]


def simulate_shapes(
    n_bodies: int,
    n_poses: int,
    seed: int,
    progress: Progress,
    shares: Mapping[str, float] = KIND_SHARES,
) -> LabelledShapes:
    """Return `n_bodies` times `n_poses` shapes; the same seed gives the same ones.

    `shares` of the kinds of poses sum to 1.
    """
    rng = np.random.default_rng(seed)
    shapes: list[FloatArray] = []
    kinds: list[str] = []
    for done in range(n_bodies):
        body = MarkedBody(_random_body(rng))
        for _ in range(n_poses):
            kind = str(rng.choice(list(shares), p=list(shares.values())))
            shapes.append(marked_joints(body.posed(draw_pose(rng, kind)), rng))
            kinds.append(kind)
        progress(done + 1, n_bodies)
    return LabelledShapes(np.stack(shapes), tuple(kinds))


def marked_joints(marks: JointMarks, rng: np.random.Generator) -> FloatArray:
    """Return (15, 3) places at which somebody would mark the joints of a body, metres."""
    sets: dict[str, FloatArray] = {
        "centre": marks.centres,
        "front": marks.fronts,
        "back": marks.backs,
    }
    whole = str(rng.choice(list(sets))) if rng.random() < WHOLE_SET_SHARE else None
    chosen = {
        joint: whole or str(rng.choice([*sets, *SKIN_PLACES[joint]])) for joint in SKIN_PLACES
    }
    places = np.empty((len(JOINT_NAMES), 3))
    for i, name in enumerate(JOINT_NAMES):
        place = chosen[_unsided(name)]
        places[i] = sets[place][i] if place in sets else _landmark(marks, name, place)
    return np.asarray(places + rng.normal(scale=MARKER_SD_M, size=places.shape))


def _landmark(marks: JointMarks, joint: str, place: str) -> FloatArray:
    landmarks = marks.landmarks
    if place == "sternum":
        torso = marks.fronts[JOINT_NAMES.index("torso")]
        return np.asarray(0.5 * (landmarks["sternal_notch"] + torso))
    side = joint.partition("_")[0]
    return landmarks[f"{side}_{place}" if side in ("left", "right") else place]


def _unsided(joint: str) -> str:
    return joint.removeprefix("left_").removeprefix("right_")


def _random_body(rng: np.random.Generator) -> ShapedBody:
    sex = "female" if rng.random() < 0.5 else "male"  # noqa: PLR2004  (half and half)
    is_child = rng.random() < CHILDREN_SHARE
    age = rng.uniform(7.0, GROWN_YEARS) if is_child else rng.uniform(GROWN_YEARS, 85.0)
    grown_m = 1.63 if sex == "female" else 1.76
    stature_m = np.interp(age, [6.0, GROWN_YEARS], [1.16, grown_m]) + rng.normal(scale=0.06)
    mass_index = np.interp(age, [6.0, GROWN_YEARS], [16.0, 24.0]) * np.exp(rng.normal(scale=0.12))
    shape = BodyShape(
        "female" if sex == "female" else "male",
        float(age),
        float(stature_m),
        float(mass_index * stature_m**2),
    )
    return load_body_model().shaped(shape)
