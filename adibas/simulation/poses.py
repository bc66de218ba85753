"""Postures that hold for any body: where its segments point.

Axes are the body's own: x to the patient's left, y down, z to the patient's back, so that an
unturned body faces a camera that looks along z. Limbs are given by the direction of each segment
and by the axis of its hinge, trunk and head by rotations from upright.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.simulation.rotations import about, cross, onto, unit

Side: TypeAlias = Literal["left", "right"]
View: TypeAlias = Literal["anterior", "posterior", "left_lateral", "right_lateral"]

LEFT = np.array([1.0, 0.0, 0.0])
DOWN = np.array([0.0, 1.0, 0.0])
FORWARD = np.array([0.0, 0.0, -1.0])
N_SPINE_PARTS = 3

HEADINGS_RAD: dict[View, float] = {
    "anterior": 0.0,
    "left_lateral": math.pi / 2,
    "posterior": math.pi,
    "right_lateral": -math.pi / 2,
}
"""Turn about y (down) that shows the named side to a camera that looks along z."""


@dataclass(frozen=True, slots=True, eq=False)
class ArmPose:
    """Directions (unit vectors) of one arm.

    Attributes
    ----------
    upper, lower, hand : (3,) arrays
        Shoulder to elbow, elbow to wrist, wrist to knuckles.
    hinge : (3,) array
        Elbow axis: a right-handed turn about it bends the elbow.
    thumb : (3,) array
        Across the palm to the thumb's side.
    curl_rad : float
        Bend of each finger joint.
    """

    upper: FloatArray
    lower: FloatArray
    hinge: FloatArray
    hand: FloatArray
    thumb: FloatArray
    curl_rad: float = 0.2

    def turned(self, turn: FloatArray) -> "ArmPose":
        """Return the arm turned as a whole."""
        return ArmPose(
            turn @ self.upper,
            turn @ self.lower,
            turn @ self.hinge,
            turn @ self.hand,
            turn @ self.thumb,
            self.curl_rad,
        )


@dataclass(frozen=True, slots=True, eq=False)
class LegPose:
    """Directions (unit vectors) of one leg.

    Attributes
    ----------
    upper, lower : (3,) arrays
        Hip to knee, knee to ankle.
    hinge : (3,) array
        Knee axis: a right-handed turn about it bends the knee.
    foot : (3, 3) array
        Rotation of the foot from standing flat, toes ahead.
    """

    upper: FloatArray
    lower: FloatArray
    hinge: FloatArray
    foot: FloatArray

    def turned(self, turn: FloatArray) -> "LegPose":
        """Return the leg turned about the ankle: the foot stays."""
        return replace(
            self, upper=turn @ self.upper, lower=turn @ self.lower, hinge=turn @ self.hinge
        )


def _upright() -> FloatArray:
    return np.eye(3)


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """How a body stands, whatever its shape.

    Attributes
    ----------
    left_arm, right_arm : ArmPose
    left_leg, right_leg : LegPose
    pelvis, chest, head : (3, 3) arrays
        Rotations from upright.
    spine : (3, 3, 3) array or None
        Rotations from upright of the three parts of the spine between pelvis and chest, the
        lowest first; None: even steps from one to the other.
    lift_m : float
        Height of the lowest point over the floor.
    offset_m : (2,) array
        Where (x, z) the middle between the ankles is, before the turn by `heading_rad`.
    heading_rad : float
        Turn of the whole body about y through the origin.
    """

    left_arm: ArmPose
    right_arm: ArmPose
    left_leg: LegPose
    right_leg: LegPose
    pelvis: FloatArray = field(default_factory=_upright)
    chest: FloatArray = field(default_factory=_upright)
    head: FloatArray = field(default_factory=_upright)
    lift_m: float = 0.0
    offset_m: FloatArray = field(default_factory=lambda: np.zeros(2))
    heading_rad: float = 0.0
    spine: FloatArray | None = None

    def __post_init__(self) -> None:
        for name in ("pelvis", "chest", "head"):
            check_shape(name, getattr(self, name), (3, 3))
        if self.spine is not None:
            check_shape("spine", self.spine, (N_SPINE_PARTS, 3, 3))
        check_shape("offset_m", self.offset_m, (2,))
        read_only(self.offset_m)

    def facing(self, view: View) -> "Pose":
        """Return the pose turned so that a camera that looks along z sees that side."""
        return replace(self, heading_rad=HEADINGS_RAD[view])

    def leaned(self, turn: FloatArray) -> "Pose":
        """Return the pose leaned about the ankles as one piece; the feet stay flat."""
        return replace(
            self,
            left_arm=self.left_arm.turned(turn),
            right_arm=self.right_arm.turned(turn),
            left_leg=self.left_leg.turned(turn),
            right_leg=self.right_leg.turned(turn),
            pelvis=turn @ self.pelvis,
            chest=turn @ self.chest,
            head=turn @ self.head,
            spine=None if self.spine is None else turn @ self.spine,
        )


@dataclass(frozen=True, slots=True)
class ArmAngles:
    """An arm by the angles of the clinic, radians.

    Attributes
    ----------
    elevation : float
        0 hanging, pi / 2 horizontal, pi overhead.
    plane : float
        Of elevation: 0 sideways (abduction), pi / 2 forward (flexion).
    rotation : float
        Of the upper arm about its axis, inward positive.
    elbow : float
        Flexion, 0 straight.
    pronation : float
        Of the forearm from thumb forward, inward positive.
    wrist : float
        Flexion of the hand to the palm's side.
    curl : float
        Bend of each finger joint.
    """

    elevation: float = math.radians(8)
    plane: float = math.radians(15)
    rotation: float = math.radians(20)
    elbow: float = math.radians(12)
    pronation: float = math.radians(15)
    wrist: float = 0.0
    curl: float = 0.2


@dataclass(frozen=True, slots=True)
class LegAngles:
    """A leg by the angles of the clinic, radians, with respect to the vertical.

    Attributes
    ----------
    flexion : float
        Of the thigh, forward positive.
    spread : float
        Of the whole leg, outward positive.
    knee : float
        Flexion, 0 straight.
    toe_out : float
        Turn of knee and foot, outward positive.
    sole : float
        Plantar flexion of the foot against the floor: 0 flat, positive on tiptoe.
    """

    flexion: float = math.radians(1.0)
    spread: float = math.radians(2.0)
    knee: float = math.radians(2.0)
    toe_out: float = math.radians(8)
    sole: float = 0.0


def _outward(side: Side) -> FloatArray:
    return LEFT if side == "left" else -LEFT


def arm_pose(side: Side, angles: ArmAngles) -> ArmPose:
    """Return the arm of an upright trunk at `angles`."""
    inward_sign = 1.0 if side == "left" else -1.0
    level = math.cos(angles.plane) * _outward(side) + math.sin(angles.plane) * FORWARD
    upper = math.cos(angles.elevation) * DOWN + math.sin(angles.elevation) * level
    raised = onto(DOWN, upper)
    # Seen along the hanging arm (down) a left arm turns inward clockwise, by the right hand.
    hinge = about(upper, inward_sign * angles.rotation) @ raised @ cross(DOWN, FORWARD)
    lower = about(hinge, angles.elbow) @ upper
    thumb = about(lower, inward_sign * angles.pronation) @ cross(hinge, lower)
    hand = about(thumb, -inward_sign * angles.wrist) @ lower
    return ArmPose(upper, lower, unit(hinge), hand, thumb, angles.curl)


def leg_pose(side: Side, angles: LegAngles) -> LegPose:
    """Return the leg at `angles`."""
    outward_sign = -1.0 if side == "left" else 1.0
    turn = about(DOWN, outward_sign * angles.toe_out)
    spread = about(FORWARD, -outward_sign * angles.spread)
    hinge = spread @ turn @ LEFT
    upper = about(LEFT, -angles.flexion) @ spread @ DOWN
    hinge = unit(hinge - upper * (hinge @ upper))
    lower = about(hinge, angles.knee) @ upper
    foot = turn @ about(LEFT, angles.sole)
    return LegPose(upper, lower, hinge, foot)


def standing(
    left_arm: ArmAngles | None = None,
    right_arm: ArmAngles | None = None,
    left_leg: LegAngles | None = None,
    right_leg: LegAngles | None = None,
) -> Pose:
    """Return the natural standing posture, facing a camera that looks along z; arms may differ."""
    return Pose(
        left_arm=arm_pose("left", left_arm or ArmAngles()),
        right_arm=arm_pose("right", right_arm or ArmAngles()),
        left_leg=leg_pose("left", left_leg or LegAngles()),
        right_leg=leg_pose("right", right_leg or LegAngles()),
    )
