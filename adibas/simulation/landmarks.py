"""Landmarks of the clinic on the skin of a simulated person.

Each is found by a rule: a ray from a place between the bones outwards, in the rest shape. The
rules follow anthropometric tables (ANSUR II ratios of stature for C7, sternal notch, acromion and
iliac crest; Bell et al. 1990 for the ASIS beside the hip's centre; mean vertebral heights for the
spine). **No anatomist checked them**: they serve as exact truth for measuring, not as anatomy.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray, Int32Array, IntArray
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.simulation.poses import DOWN, FORWARD, LEFT
from adibas.simulation.rotations import cross, unit
from adibas.simulation.skeleton import Skeleton
from adibas.simulation.surface import Ray, SurfaceAnchors, anchor_rays

UP = -DOWN
BACK = -FORWARD

SPINE_LEVELS = {
    "c7": 0.0,
    "t1": 0.05,
    "t3": 0.14,
    "t4": 0.19,
    "t5": 0.235,
    "t7": 0.34,
    "t9": 0.45,
    "t10": 0.505,
    "t11": 0.565,
    "t12": 0.63,
    "l1": 0.70,
    "l3": 0.845,
    "l4": 0.925,
    "l5": 1.0,
    "s1": 1.07,
}
"""Spinous processes as shares of the way from C7 to L5: sums of mean vertebral heights."""
_L4_ABOVE_HIPS = 0.24
"""Of the height from the hips to the neck's root: the iliac crests."""
_C7_ABOVE_NECK = -0.015
_CLEFT_LEVEL, _WAIST_LEVEL, _FOLD_LEVEL = 1.14, 0.845, 0.3
"""Of the natal cleft below the sacrum, of the waist (L3) and of the axillary fold (below T5)."""


@dataclass(frozen=True, slots=True, eq=False)
class RestBody:
    """What the rules look at: one body in its rest shape.

    Attributes
    ----------
    vertices_m : (V, 3) array
    triangles : (T, 3) array
    triangle_parts : (T,) array
        Index in `BODY_PART_NAMES` of the part that most of each triangle belongs to.
    skeleton : Skeleton
    """

    vertices_m: FloatArray
    triangles: Int32Array
    triangle_parts: IntArray
    skeleton: Skeleton

    def on(self, *parts: str) -> BoolArray:
        """Return which triangles belong to any of the named parts."""
        wanted = [BODY_PART_NAMES.index(part) for part in parts]
        return np.isin(self.triangle_parts, wanted)

    @property
    def span_m(self) -> float:
        """Return the height from the hips to the neck's root."""
        return float((self.skeleton.head("upperleg01.L") - self.skeleton.head("neck01")) @ DOWN)


def landmark_anchors(body: RestBody) -> SurfaceAnchors:
    """Return all landmarks; paired ones begin with ``left_`` or ``right_`` (the patient's)."""
    rays = _head_rays(body) | _spine_rays(body) | _middle_rays(body)
    for side, suffix, outward in (("left", ".L", LEFT), ("right", ".R", -LEFT)):
        paired = (
            _girdle_rays(body, side, suffix, outward)
            | _outline_rays(body, side, suffix, outward)
            | _pelvis_rays(body, suffix, outward)
            | _arm_rays(body, side, suffix)
            | _leg_rays(body, side, suffix, outward)
            | _foot_rays(body, side, suffix, outward)
        )
        rays |= {f"{side}_{name}": ray for name, ray in paired.items()}
    return anchor_rays(rays, body.vertices_m, body.triangles)


def joint_anchors(
    body: RestBody, joints_m: FloatArray, vertices_m: FloatArray, direction: FloatArray
) -> SurfaceAnchors:
    """Return the skin points that lie in `direction` of each of the 15 joints of a posed body."""
    rays = {
        name: Ray(joint_m, direction, body.on(*_parts_at(name)))
        for name, joint_m in zip(JOINT_NAMES, joints_m, strict=True)
    }
    return anchor_rays(rays, vertices_m, body.triangles)


def _parts_at(joint: str) -> tuple[str, ...]:
    side, _, name = joint.rpartition("_")
    parts = {
        "head": ("head",),
        "neck": ("neck", "torso", "head"),
        "torso": ("torso",),
        "shoulder": ("torso", f"{side}_upper_arm"),
        "elbow": (f"{side}_upper_arm", f"{side}_lower_arm"),
        "hand": (f"{side}_hand", f"{side}_lower_arm"),
        "hip": ("torso", f"{side}_upper_leg"),
        "knee": (f"{side}_upper_leg", f"{side}_lower_leg"),
        "foot": (f"{side}_lower_leg", f"{side}_foot"),
    }
    return parts[name]


def _at(x: float, y: float, z: float) -> FloatArray:
    return np.array([x, y, z])


def _head_rays(body: RestBody) -> dict[str, Ray]:
    head = body.on("head")
    points = body.vertices_m[np.unique(body.triangles[head])]
    eye = body.skeleton.head("eye.L")
    forehead_m = float(eye[1] - points[:, 1].min())
    ear_m = _ear(points)
    chin_m = points[np.argmax(points @ unit(DOWN + 0.8 * FORWARD))]
    return {
        "glabella": Ray(_at(0.0, eye[1] - 0.17 * forehead_m, eye[2] + 0.04), FORWARD, head),
        "menton": Ray(_at(0.0, chin_m[1] - 0.02, chin_m[2] + 0.02), unit(DOWN + FORWARD), head),
        "left_tragus": Ray(ear_m * _at(0.0, 1.0, 1.0), LEFT, head),
        "right_tragus": Ray(ear_m * _at(0.0, 1.0, 1.0), -LEFT, head),
        "sternal_notch": Ray(_notch_origin(body), FORWARD, body.on("torso", "neck")),
    }


def _middle_rays(body: RestBody) -> dict[str, Ray]:
    """Return the lower ends of the trunk's middle: the umbilicus lies level with L4."""
    trunk = body.on("torso", "left_upper_leg", "right_upper_leg")
    z = float(body.skeleton.head("upperleg01.L")[2])
    return {
        "umbilicus": Ray(_at(0.0, _level_y(body, SPINE_LEVELS["l4"]), z), FORWARD, trunk),
        "natal_cleft": Ray(_at(0.0, _level_y(body, _CLEFT_LEVEL), z), BACK, trunk),
    }


def _ear(head_points_m: FloatArray) -> FloatArray:
    """Return a point inside the left tragus: at the front of the ear, half way up."""
    ear = head_points_m[head_points_m[:, 0] > 0.9 * head_points_m[:, 0].max()]
    low, high = ear.min(0), ear.max(0)
    return _at(high[0], 0.5 * (low[1] + high[1]), low[2])


def _notch_origin(body: RestBody) -> FloatArray:
    clavicle = body.skeleton.head("clavicle.L")
    return _at(0.0, clavicle[1] - 0.02 * body.span_m, clavicle[2] + 0.02)


def _level_y(body: RestBody, level: float) -> float:
    """Return y of a spinous process by its share of the way from C7 to L5."""
    c7 = float(body.skeleton.head("neck01")[1]) - _C7_ABOVE_NECK * body.span_m
    l4 = float(body.skeleton.head("upperleg01.L")[1]) - _L4_ABOVE_HIPS * body.span_m
    return c7 + (l4 - c7) * level / SPINE_LEVELS["l4"]


def _spine_rays(body: RestBody) -> dict[str, Ray]:
    back = body.on("torso", "neck")
    return {
        name: Ray(_at(0.0, _level_y(body, level), 0.0), BACK, back)
        for name, level in SPINE_LEVELS.items()
    }


def _girdle_rays(body: RestBody, side: str, suffix: str, outward: FloatArray) -> dict[str, Ray]:
    shoulder = body.skeleton.head("upperarm01" + suffix)
    trunk = body.on("torso", f"{side}_upper_arm")
    x = float(shoulder[0])
    return {
        "acromion": Ray(shoulder, unit(UP + 0.3 * outward + 0.1 * BACK), trunk),
        "inferior_scapula": Ray(_at(0.45 * x, _level_y(body, SPINE_LEVELS["t7"]), 0), BACK, trunk),
        "scapular_spine": Ray(_at(0.36 * x, _level_y(body, SPINE_LEVELS["t3"]), 0), BACK, trunk),
    }


def _outline_rays(body: RestBody, side: str, suffix: str, outward: FloatArray) -> dict[str, Ray]:
    """Return what the symmetry of the trunk is told from, as it is seen from behind and before."""
    shoulder = body.skeleton.head("upperarm01" + suffix)
    trunk, girdle = body.on("torso"), body.on("torso", "neck", f"{side}_upper_arm")
    z = float(shoulder[2])
    fold = _at(0.75 * float(shoulder[0]), _level_y(body, _FOLD_LEVEL), z)
    waist = _at(0.0, _level_y(body, _WAIST_LEVEL), z)
    rays: dict[str, Ray] = {}
    for name, to_sensor in (("", BACK), ("anterior_", FORWARD)):
        rays |= {
            f"{name}shoulder_top": Ray(fold, unit(UP + 0.6 * to_sensor), girdle),
            f"{name}axilla": Ray(fold, to_sensor, girdle),
            f"{name}waist": Ray(waist, unit(outward + 0.3 * to_sensor), trunk),
        }
    return rays


def _pelvis_rays(body: RestBody, suffix: str, outward: FloatArray) -> dict[str, Ray]:
    hip = body.skeleton.head("upperleg01" + suffix)
    trunk = body.on("torso", "left_upper_leg", "right_upper_leg")
    above = _at(1.0, 0.0, 1.0) * hip
    asis_y, psis_y = (float(hip[1]) - share * body.span_m for share in (0.124, 0.15))
    return {
        "asis": Ray(above + asis_y * DOWN, FORWARD, trunk),
        "psis": Ray(above * _at(0.38, 0.0, 1.0) + psis_y * DOWN, BACK, trunk),
        "greater_trochanter": Ray(hip, outward, trunk),
    }


def _arm_rays(body: RestBody, side: str, suffix: str) -> dict[str, Ray]:
    bones = body.skeleton
    elbow, wrist = bones.head("lowerarm01" + suffix), bones.head("wrist" + suffix)
    upper = bones.direction("upperarm01" + suffix, "lowerarm01" + suffix)
    lower = bones.direction("lowerarm01" + suffix, "wrist" + suffix)
    hand = bones.direction("wrist" + suffix, "finger3-1" + suffix)
    # The elbow's axis points inward in a left arm and outward in a right one.
    medial = unit(cross(upper, lower)) * (1.0 if side == "left" else -1.0)
    thumb = bones.direction("finger5-1" + suffix, "finger2-1" + suffix)
    dorsal = unit(cross(thumb, hand)) * (1.0 if side == "left" else -1.0)
    arm = body.on(f"{side}_upper_arm", f"{side}_lower_arm")
    return {
        "lateral_epicondyle": Ray(elbow - 0.01 * upper, -medial, arm),
        "medial_epicondyle": Ray(elbow - 0.01 * upper, medial, arm),
        "wrist": Ray(wrist, dorsal, body.on(f"{side}_lower_arm", f"{side}_hand")),
    }


def _leg_rays(body: RestBody, side: str, suffix: str, outward: FloatArray) -> dict[str, Ray]:
    bones = body.skeleton
    knee, ankle = bones.head("lowerleg01" + suffix), bones.head("foot" + suffix)
    shank = unit(ankle - knee)
    length = float((ankle - knee) @ shank)
    ahead = unit(FORWARD - shank * (FORWARD @ shank))
    aside = unit(outward - shank * (outward @ shank))
    leg = body.on(f"{side}_upper_leg", f"{side}_lower_leg")
    return {
        "knee_joint_line": Ray(knee + 0.04 * length * shank, aside, leg),
        "patella": Ray(knee - 0.03 * length * shank, ahead, leg),
        "tibial_tuberosity": Ray(knee + 0.15 * length * shank, ahead, leg),
        "midleg": Ray(knee + 0.45 * length * shank, -ahead, leg),
    }


def _foot_rays(body: RestBody, side: str, suffix: str, outward: FloatArray) -> dict[str, Ray]:
    bones = body.skeleton
    ankle = bones.head("foot" + suffix)
    toe2, toe3 = (bones.head(f"toe{n}-1{suffix}") for n in (2, 3))
    ahead = unit((0.5 * (toe2 + toe3) - ankle) * _at(1.0, 0.0, 1.0))
    aside = unit(outward - ahead * (outward @ ahead))
    height = float(body.vertices_m[:, 1].max() - ankle[1])
    foot = body.on(f"{side}_foot", f"{side}_lower_leg")
    return {
        "lateral_malleolus": Ray(ankle + 0.12 * height * DOWN, unit(aside - 0.25 * ahead), foot),
        "medial_malleolus": Ray(ankle, -aside, foot),
        "achilles": Ray(ankle, -ahead, foot),
        "calcaneus": Ray(ankle + 0.6 * height * DOWN, -ahead, foot),
        "metatarsals": Ray(0.5 * (toe2 + toe3), UP, foot),
    }
