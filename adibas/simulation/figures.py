"""A posture in the angles of the clinic: what gestures interpolate, and what `Pose` is made of."""

from dataclasses import astuple, dataclass, field, fields

import numpy as np

from adibas.arrays import FloatArray
from adibas.simulation.poses import (
    DOWN,
    FORWARD,
    LEFT,
    ArmAngles,
    LegAngles,
    Pose,
    arm_pose,
    leg_pose,
)
from adibas.simulation.rotations import about


@dataclass(frozen=True, slots=True)
class TrunkAngles:
    """Trunk and head with respect to upright, radians.

    Attributes
    ----------
    pelvis, chest, head : float
        Forward bend of each against the vertical.
    side_bend : float
        Of the chest, to the patient's left positive.
    twist, look : float
        Turn of the chest and of the head to the patient's left.
    tilt : float
        Of the head, to the patient's left.
    """

    pelvis: float = 0.0
    chest: float = 0.0
    head: float = 0.0
    side_bend: float = 0.0
    twist: float = 0.0
    look: float = 0.0
    tilt: float = 0.0


@dataclass(frozen=True, slots=True)
class Figure:
    """A whole body in angles; the default is `adibas.simulation.poses.standing`."""

    left_arm: ArmAngles = field(default_factory=ArmAngles)
    right_arm: ArmAngles = field(default_factory=ArmAngles)
    left_leg: LegAngles = field(default_factory=LegAngles)
    right_leg: LegAngles = field(default_factory=LegAngles)
    trunk: TrunkAngles = field(default_factory=TrunkAngles)

    def pose(self, lift_m: float = 0.0) -> Pose:
        """Return the pose, its lowest point `lift_m` over the floor."""
        trunk = self.trunk
        return Pose(
            left_arm=arm_pose("left", self.left_arm),
            right_arm=arm_pose("right", self.right_arm),
            left_leg=leg_pose("left", self.left_leg),
            right_leg=leg_pose("right", self.right_leg),
            pelvis=about(LEFT, trunk.pelvis),
            chest=_bent(trunk.chest, trunk.side_bend, trunk.twist),
            head=_bent(trunk.head, trunk.tilt, trunk.look),
            lift_m=lift_m,
        )

    def vector(self) -> FloatArray:
        """Return all angles as one vector, radians."""
        return np.array([angle for part in astuple(self) for angle in part])

    @staticmethod
    def from_vector(angles: FloatArray) -> "Figure":
        """Return the figure of a `vector`."""
        values = [float(angle) for angle in angles]
        n_arm, n_leg = len(fields(ArmAngles)), len(fields(LegAngles))
        ends = np.cumsum([n_arm, n_arm, n_leg, n_leg])
        return Figure(
            ArmAngles(*values[: ends[0]]),
            ArmAngles(*values[ends[0] : ends[1]]),
            LegAngles(*values[ends[1] : ends[2]]),
            LegAngles(*values[ends[2] : ends[3]]),
            TrunkAngles(*values[ends[3] :]),
        )


def _bent(forward_rad: float, left_rad: float, turn_rad: float) -> FloatArray:
    # A turn about the axis that points down takes the face from forward to the patient's right.
    turned: FloatArray = (
        about(LEFT, forward_rad) @ about(FORWARD, -left_rad) @ about(DOWN, -turn_rad)
    )
    return turned
