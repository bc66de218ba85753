"""Angles of the joints that a clinic names, from the fifteen joints of one moment or many.

Each is 0 in the upright stance with hanging arms. Flexion forward, side bending and turning to
the patient's right, and abduction away from the body are positive. The trunk has its own axes:
up from the middle of the hips to the neck, to the right from the left hip to the right one, made
square to it. Angles in a plane are those of the limb's shadow on it, and are not given where the
shadow is short.

Source: the definitions follow the neutral zero method (Ryf & Weymann, 1999), as far as joints
without the turn of a limb about its own axis allow.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.data.joints import JOINT_NAMES
from adibas.geometry.angles import angle

SHORTEST_SHADOW = 0.35
"""Of a limb's length: nearer to the plane's normal than 20 degrees its angle means nothing."""

INDEX = {name: number for number, name in enumerate(JOINT_NAMES)}


@dataclass(frozen=True, slots=True)
class Body:
    """Joints (..., 15, 3) with the trunk's axes (..., 3 each), and up against gravity (3,)."""

    joints_m: FloatArray
    trunk_up: FloatArray
    trunk_right: FloatArray
    trunk_ahead: FloatArray
    up: FloatArray

    def joint(self, name: str) -> FloatArray:
        """Return (..., 3) positions of one joint."""
        return np.asarray(self.joints_m[..., INDEX[name], :])


AngleOf = Callable[[Body], FloatArray]


def body_of(joints_m: FloatArray, up: FloatArray) -> Body:
    """Return joints (..., 15, 3) with the axes of the trunk; NaN where hips or neck are."""
    check_shape("up", up, (3,))
    neck = joints_m[..., INDEX["neck"], :]
    left, right = joints_m[..., INDEX["left_hip"], :], joints_m[..., INDEX["right_hip"], :]
    trunk_up = _unit(neck - (left + right) / 2)
    across = right - left
    trunk_right = _unit(across - _dot(across, trunk_up)[..., None] * trunk_up)
    return Body(joints_m, trunk_up, trunk_right, np.cross(trunk_up, trunk_right), up)


def joint_angles(joints_m: FloatArray, up: FloatArray) -> dict[str, FloatArray]:
    """Return every angle of `ANGLES` by its name.

    Parameters
    ----------
    joints_m : (..., 15, 3) array
        In the order of `JOINT_NAMES`; NaN where not seen.
    up : (3,) array
        Against gravity, in the same axes, length 1; NaN where it is not known.

    Returns
    -------
    angles_rad : dict of (...) arrays
        NaN where a joint that it needs was not seen, or the vertical is not known.
    """
    body = body_of(joints_m, up)
    return {name: angle_of(body) for name, angle_of in ANGLES.items()}


def _bend(a: str, vertex: str, c: str) -> AngleOf:
    """Return by how much a hinge is bent: 0 where it is straight."""

    def angle_of(body: Body) -> FloatArray:
        return np.pi - angle(body.joint(a), body.joint(vertex), body.joint(c))

    return angle_of


def _elevation(side: str) -> AngleOf:
    """Return the angle of the upper arm with the trunk's way down, in any plane."""

    def angle_of(body: Body) -> FloatArray:
        arm = body.joint(f"{side}_elbow") - body.joint(f"{side}_shoulder")
        origin = np.zeros(3)
        return angle(arm, origin, -body.trunk_up)

    return angle_of


def _hip_flexion(side: str) -> AngleOf:
    def angle_of(body: Body) -> FloatArray:
        thigh = body.joint(f"{side}_knee") - body.joint(f"{side}_hip")
        return _in_plane(thigh, body.trunk_ahead, -body.trunk_up)

    return angle_of


def _hip_abduction(side: str) -> AngleOf:
    outwards = 1.0 if side == "right" else -1.0

    def angle_of(body: Body) -> FloatArray:
        thigh = body.joint(f"{side}_knee") - body.joint(f"{side}_hip")
        return _in_plane(thigh, outwards * body.trunk_right, -body.trunk_up)

    return angle_of


def _neck_flexion(body: Body) -> FloatArray:
    return _in_plane(body.joint("head") - body.joint("neck"), body.trunk_ahead, body.trunk_up)


def _neck_bending(body: Body) -> FloatArray:
    return _in_plane(body.joint("head") - body.joint("neck"), body.trunk_right, body.trunk_up)


def _trunk_flexion(body: Body) -> FloatArray:
    ahead, _right = _level_axes(body)
    return _in_plane(body.trunk_up, ahead, np.broadcast_to(body.up, ahead.shape))


def _trunk_bending(body: Body) -> FloatArray:
    _ahead, right = _level_axes(body)
    return _in_plane(body.trunk_up, right, np.broadcast_to(body.up, right.shape))


def _trunk_turn(body: Body) -> FloatArray:
    """Return by how much the shoulders are turned to the right against the hips."""
    shoulders = body.joint("right_shoulder") - body.joint("left_shoulder")
    # Turning to the right takes the right shoulder back.
    return _in_plane(shoulders, -body.trunk_ahead, body.trunk_right)


def _level_axes(body: Body) -> tuple[FloatArray, FloatArray]:
    """Return the level directions ahead and to the right by the hips."""
    across = body.joint("right_hip") - body.joint("left_hip")
    right = _unit(across - _dot(across, body.up)[..., None] * body.up)
    return np.cross(body.up, right), right


def _in_plane(limb: FloatArray, towards: FloatArray, zero: FloatArray) -> FloatArray:
    """Return the signed angle from `zero` of the limb's shadow on the plane of both directions."""
    across, along = _dot(limb, towards), _dot(limb, zero)
    is_short = np.hypot(across, along) < SHORTEST_SHADOW * np.linalg.norm(limb, axis=-1)
    return np.where(is_short, np.nan, np.arctan2(across, along))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray((a * b).sum(axis=-1))


def _unit(vectors: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0, lengths, np.nan))


ANGLES: dict[str, AngleOf] = {
    "neck_flexion": _neck_flexion,
    "neck_side_bending": _neck_bending,
    "trunk_flexion": _trunk_flexion,
    "trunk_side_bending": _trunk_bending,
    "trunk_rotation": _trunk_turn,
    **{f"{side}_shoulder_elevation": _elevation(side) for side in ("left", "right")},
    **{
        f"{side}_elbow_flexion": _bend(f"{side}_shoulder", f"{side}_elbow", f"{side}_hand")
        for side in ("left", "right")
    },
    **{f"{side}_hip_flexion": _hip_flexion(side) for side in ("left", "right")},
    **{f"{side}_hip_abduction": _hip_abduction(side) for side in ("left", "right")},
    **{
        f"{side}_knee_flexion": _bend(f"{side}_hip", f"{side}_knee", f"{side}_foot")
        for side in ("left", "right")
    },
}
"""By name; the order is that of the report."""
