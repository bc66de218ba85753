"""The names of joint angles for a reader."""

from collections.abc import Sequence

from adibas.data.movement import AngleCurve, Movement
from adibas.texts import Message, message
from adibas.texts import translate as _

JOINT_MOTIONS: dict[str, Message] = {
    "neck_flexion": message("Neck: flexion"),
    "neck_side_bending": message("Neck: bending to the right"),
    "trunk_flexion": message("Trunk: flexion against the vertical"),
    "trunk_side_bending": message("Trunk: bending to the right"),
    "trunk_rotation": message("Trunk: turn of the shoulders to the right"),
    "shoulder_elevation": message("Shoulder: elevation of the arm"),
    "elbow_flexion": message("Elbow: flexion"),
    "hip_flexion": message("Hip: flexion"),
    "hip_abduction": message("Hip: abduction"),
    "knee_flexion": message("Knee: flexion"),
}
SIDES: dict[str, Message] = {"left": message("left side"), "right": message("right side")}


def split_side(name: str) -> tuple[str, str]:
    """Return the side (or nothing) and the rest of an angle's name."""
    side, _underscore, rest = name.partition("_")
    return (side, rest) if side in SIDES else ("", name)


def angle_text(name: str) -> str:
    """Return an angle's name for a reader."""
    side, motion = split_side(name)
    text = _(JOINT_MOTIONS[motion])
    return f"{text}, {_(SIDES[side])}" if side else text


def by_motion(movement: Movement) -> dict[str, Sequence[AngleCurve]]:
    """Return the curves of each motion, the left side first."""
    found: dict[str, list[AngleCurve]] = {}
    for curve in movement.curves:
        found.setdefault(split_side(curve.name)[1], []).append(curve)
    return {motion: tuple(curves) for motion, curves in found.items()}
