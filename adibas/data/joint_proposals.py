"""Where each joint of a person may be in one frame, before one place is chosen."""

from dataclasses import dataclass

from adibas.arrays import FloatArray, check_shape, read_only
from adibas.data.joints import JOINT_NAMES, mirror_order


@dataclass(frozen=True, slots=True, eq=False)
class JointProposals:
    """Some places for each joint, the best supported one first.

    Attributes
    ----------
    positions_m : (15, K, 3) array
        In the order of `JOINT_NAMES`, axes of the depth camera, metres; NaN where there are fewer.
    weights_m2 : (15, K) array
        How much surface speaks for each: square metres times the probability of the part; 0 where
        there are fewer.
    """

    positions_m: FloatArray
    weights_m2: FloatArray

    def __post_init__(self) -> None:
        check_shape("positions_m", self.positions_m, (len(JOINT_NAMES), None, 3))
        check_shape("weights_m2", self.weights_m2, self.positions_m.shape[:2])
        read_only(self.positions_m)
        read_only(self.weights_m2)

    def with_sides_swapped(self) -> "JointProposals":
        """Return the proposals of which every left joint is a right one, and the other way."""
        swapped = mirror_order(JOINT_NAMES)
        return JointProposals(self.positions_m[swapped].copy(), self.weights_m2[swapped].copy())
