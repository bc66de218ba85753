"""From a pose (directions) to one rotation per bone of one body."""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.simulation.poses import DOWN, FORWARD, LEFT, ArmPose, LegPose, Pose
from adibas.simulation.rotations import (
    about,
    cross,
    frame,
    onto,
    part_way,
    turn_about,
    unit,
)

CLAVICLE_SHARE = 0.3
"""Of the arm's elevation, taken by the shoulder girdle (a third in textbooks)."""
CLAVICLE_REST_RAD = math.radians(30)
"""Elevation of the arms in the rest shape, where the girdle is as modelled; below it drops."""


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """The bones of one body at rest.

    Attributes
    ----------
    names : tuple of str
        anny's, parents before children.
    parents : (B,) array
        Index of each bone's parent, -1 for the root.
    heads_m : (B, 3) array
        Where each bone begins, metres, body axes.
    """

    names: tuple[str, ...]
    parents: IntArray
    heads_m: FloatArray

    def head(self, name: str) -> FloatArray:
        """Return the (3,) rest position of the bone's beginning, metres."""
        position_m: FloatArray = self.heads_m[self.names.index(name)]
        return position_m

    def direction(self, start: str, end: str) -> FloatArray:
        """Return the unit vector from one bone's beginning to another's."""
        return unit(self.head(end) - self.head(start))


def bone_turns(skeleton: Skeleton, pose: Pose) -> FloatArray:
    """Return (B, 3, 4) maps from rest points to posed ones, metres; the root does not move."""
    rotations = _bone_rotations(skeleton, pose)
    heads = np.empty_like(skeleton.heads_m)
    turns = np.empty((len(heads), 3, 4))
    for bone, parent in enumerate(skeleton.parents):
        rest = skeleton.heads_m[bone]
        heads[bone] = rest if parent < 0 else turns[parent, :, :3] @ rest + turns[parent, :, 3]
        turns[bone, :, :3] = rotations[bone]
        turns[bone, :, 3] = heads[bone] - rotations[bone] @ rest
    return turns


def _bone_rotations(skeleton: Skeleton, pose: Pose) -> FloatArray:
    """Return (B, 3, 3) rotations in body axes; a bone without its own follows its parent."""
    own = _trunk_rotations(pose)
    for suffix, arm, leg in (
        (".L", pose.left_arm, pose.left_leg),
        (".R", pose.right_arm, pose.right_leg),
    ):
        own |= _arm_rotations(skeleton, suffix, arm, pose.chest)
        own |= _leg_rotations(skeleton, suffix, leg, pose.pelvis)
    rotations = np.empty((len(skeleton.names), 3, 3))
    for bone, (name, parent) in enumerate(zip(skeleton.names, skeleton.parents, strict=True)):
        rotations[bone] = own[name] if name in own else rotations[parent]
    return rotations


def _trunk_rotations(pose: Pose) -> dict[str, FloatArray]:
    own = {"root": pose.pelvis, "head": pose.head}
    spine = _spine_rotations(pose)
    own |= dict(zip(("spine05", "spine04", "spine03", "spine02"), spine, strict=True))
    for share, bone in enumerate(("neck01", "neck02", "neck03"), start=1):
        own[bone] = part_way(pose.chest, pose.head, share / 4)
    return own


def _spine_rotations(pose: Pose) -> list[FloatArray]:
    """Return the rotations of the spine's parts from the pelvis up; the last is the chest's."""
    if pose.spine is not None:
        return [*pose.spine, pose.chest]
    return [part_way(pose.pelvis, pose.chest, share / 4) for share in range(1, 5)]


def _arm_rotations(
    skeleton: Skeleton, suffix: str, arm: ArmPose, chest: FloatArray
) -> dict[str, FloatArray]:
    names = [bone + suffix for bone in ("upperarm01", "lowerarm01", "wrist", "finger3-1")]
    upper, lower, hand = (skeleton.direction(*names[i : i + 2]) for i in range(3))
    hinge = cross(upper, lower)
    thumb = skeleton.head("finger2-1" + suffix) - skeleton.head("finger5-1" + suffix)
    whole_upper = frame(arm.upper, arm.hinge) @ frame(upper, hinge).T
    whole_lower = frame(arm.lower, arm.hinge) @ frame(lower, hinge).T
    palm = frame(arm.hand, arm.thumb) @ frame(hand, thumb).T
    girdle = _girdle(suffix, arm, chest)
    swing_upper = onto(girdle @ upper, arm.upper) @ girdle
    carried = onto(whole_lower @ hand, arm.hand) @ whole_lower
    twist_rad = turn_about(arm.hand, palm @ carried.T)
    own = {
        "clavicle": part_way(chest, girdle, 0.7),
        "shoulder01": girdle,
        "upperarm01": part_way(swing_upper, whole_upper, 0.5),
        "upperarm02": whole_upper,
        "lowerarm01": about(arm.lower, 0.3 * twist_rad) @ whole_lower,
        "lowerarm02": about(arm.lower, 0.7 * twist_rad) @ whole_lower,
        "wrist": palm,
    }
    own |= _finger_rotations(suffix, arm, palm)
    return {bone + suffix: rotation for bone, rotation in own.items()}


def _girdle(suffix: str, arm: ArmPose, chest: FloatArray) -> FloatArray:
    """Return the shoulder girdle's rotation: it follows the arm."""
    elevation = math.acos(max(-1.0, min(1.0, float(arm.upper @ chest @ DOWN))))
    share = CLAVICLE_SHARE * (elevation - CLAVICLE_REST_RAD)
    outward = LEFT if suffix == ".L" else -LEFT
    local = chest.T @ arm.upper
    forward = max(0.0, float(local @ FORWARD))
    axis = cross(DOWN, outward)
    protract = cross(outward, FORWARD)
    return chest @ about(protract, 0.25 * forward) @ about(axis, share)


def _finger_rotations(suffix: str, arm: ArmPose, palm: FloatArray) -> dict[str, FloatArray]:
    """Return the fingers' rotations: each joint bends by the same angle to the palm's side."""
    across = -arm.thumb if suffix == ".L" else arm.thumb
    return {
        f"finger{finger}-{joint}": about(across, joint * arm.curl_rad) @ palm
        for finger in (2, 3, 4, 5)
        for joint in (1, 2, 3)
    }


def _leg_rotations(
    skeleton: Skeleton, suffix: str, leg: LegPose, pelvis: FloatArray
) -> dict[str, FloatArray]:
    names = [bone + suffix for bone in ("upperleg01", "lowerleg01", "foot")]
    upper, lower = (skeleton.direction(*names[i : i + 2]) for i in range(2))
    toes = skeleton.head("toe3-1" + suffix) - skeleton.head(names[2])
    ahead = unit(toes * np.array([1.0, 0.0, 1.0]))
    hinge = cross(ahead, DOWN)
    whole_upper = frame(leg.upper, leg.hinge) @ frame(upper, hinge).T
    whole_lower = frame(leg.lower, leg.hinge) @ frame(lower, hinge).T
    swing = onto(pelvis @ upper, leg.upper) @ pelvis
    flat = onto(ahead, FORWARD)
    return {
        "upperleg01" + suffix: part_way(swing, whole_upper, 0.5),
        "upperleg02" + suffix: whole_upper,
        "lowerleg01" + suffix: whole_lower,
        "foot" + suffix: leg.foot @ flat,
    }
