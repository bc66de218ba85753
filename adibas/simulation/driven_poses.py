"""Poses of a body that somebody else's joints drive: motion capture, or another sensor's skeleton.

Joints say where segments point; how limbs turn about themselves is taken from the bend of elbow
and knee, and from rest where these are straight.
"""

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.data.joints import JOINT_NAMES
from adibas.simulation.poses import DOWN, FORWARD, LEFT, ArmPose, LegPose, Pose
from adibas.simulation.rotations import about, cross, onto, part_way, unit

_STRAIGHT = 0.12
"""Sine of the bend below which a limb does not tell how it is turned."""
_CURL_RAD = 0.4


def driven_pose(joints_m: FloatArray) -> Pose:
    """Return the pose of a body whose segments point as those between joints do.

    Parameters
    ----------
    joints_m : (15, 3) array
        In the order of `JOINT_NAMES`, all known; x to the person's left, y down, z to the back, as
        of somebody who faces the camera (any lengths of the segments).
    """
    check_shape("joints_m", joints_m, (len(JOINT_NAMES), 3))
    at = dict(zip(JOINT_NAMES, joints_m, strict=True))
    hips = 0.5 * (at["left_hip"] + at["right_hip"])
    pelvis = _axes(at["left_hip"] - at["right_hip"], hips - at["torso"])
    chest = _axes(at["left_shoulder"] - at["right_shoulder"], at["torso"] - at["neck"])
    head = _axes(chest[:, 0], at["neck"] - at["head"])
    return Pose(
        left_arm=_arm(at, "left"),
        right_arm=_arm(at, "right"),
        left_leg=_leg(at, "left", pelvis),
        right_leg=_leg(at, "right", pelvis),
        pelvis=pelvis,
        chest=chest,
        head=head,
    )


def _axes(left: FloatArray, down: FloatArray) -> FloatArray:
    """Return the rotation from upright whose y axis is `down`, and x as near `left` as may be."""
    y = unit(down)
    x = unit(left - y * (left @ y))
    return np.stack([x, y, cross(x, y)], axis=1)


def _hinge(upper: FloatArray, lower: FloatArray, at_rest: FloatArray) -> FloatArray:
    """Return the axis of elbow or knee: that of the bend, or the one at rest, across `upper`."""
    axis = cross(upper, lower)
    if np.linalg.norm(axis) < _STRAIGHT:
        axis = at_rest
    return unit(axis - upper * (axis @ upper))


def _arm(at: dict[str, FloatArray], side: str) -> ArmPose:
    upper = unit(at[f"{side}_elbow"] - at[f"{side}_shoulder"])
    lower = unit(at[f"{side}_hand"] - at[f"{side}_elbow"])
    hinge = _hinge(upper, lower, onto(DOWN, upper) @ cross(DOWN, FORWARD))
    across = cross(hinge, lower)
    return ArmPose(upper, lower, hinge, lower, unit(across), _CURL_RAD)


def _leg(at: dict[str, FloatArray], side: str, pelvis: FloatArray) -> LegPose:
    upper = unit(at[f"{side}_knee"] - at[f"{side}_hip"])
    lower = unit(at[f"{side}_foot"] - at[f"{side}_knee"])
    hinge = _hinge(upper, lower, pelvis @ LEFT)
    level = hinge - DOWN * (hinge @ DOWN)
    turn = onto(LEFT, level) if np.linalg.norm(level) > _STRAIGHT else np.eye(3)
    lifted = part_way(np.eye(3), onto(DOWN, lower), 0.4)
    return LegPose(upper, lower, hinge, lifted @ turn)


def turned_to_camera(joints_m: FloatArray) -> FloatArray:
    """Turn (15, 3) joints about the vertical until hips and shoulders face the camera."""
    at = dict(zip(JOINT_NAMES, joints_m, strict=True))
    across = (
        at["left_hip"] - at["right_hip"] + at["left_shoulder"] - at["right_shoulder"]
    ) * np.array([1.0, 0.0, 1.0])
    heading = np.arctan2(across[2], across[0])
    return np.asarray(joints_m @ about(DOWN, float(heading)).T)
