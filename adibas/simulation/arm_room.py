"""Arms hang as far out as hips and thighs ask for: farther in heavy people."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.data.joints import BODY_PART_NAMES
from adibas.simulation.poses import DOWN, FORWARD, ArmPose, Pose, standing
from adibas.simulation.rotations import about

MOST_ROOM_RAD = math.radians(30)
_FULL_BELOW_RAD = math.radians(15)
_NONE_ABOVE_RAD = math.radians(50)
_CELL_M = 0.025
_GAP_M = 0.003
_STEPS = 6


def find_arm_room_rad(posed_m: Callable[[Pose], FloatArray], part: IntArray) -> float:
    """Return by how much the arms of a standing body must be spread to clear its trunk.

    Parameters
    ----------
    posed_m : callable
        Gives the (V, 3) vertices of the body in a pose, metres.
    part : (V,) array
        Index in `BODY_PART_NAMES` of each vertex.
    """

    def collides(room_rad: float) -> bool:
        return _arm_in_trunk(posed_m(with_arm_room(standing(), room_rad)), part)

    low, high = 0.0, MOST_ROOM_RAD
    if not collides(low):
        return low
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if collides(middle) else (low, middle)
    return high


def with_arm_room(pose: Pose, room_rad: float) -> Pose:
    """Return `pose` with hanging arms spread by `room_rad`, raised or bent ones as they are."""
    if room_rad == 0.0:
        return pose
    return replace(
        pose,
        left_arm=_spread(pose.left_arm, -room_rad),
        right_arm=_spread(pose.right_arm, room_rad),
    )


def _spread(arm: ArmPose, room_rad: float) -> ArmPose:
    hanging = min(float(arm.upper @ DOWN), float(arm.lower @ DOWN))
    elevation_rad = math.acos(max(-1.0, min(1.0, hanging)))
    share = (_NONE_ABOVE_RAD - elevation_rad) / (_NONE_ABOVE_RAD - _FULL_BELOW_RAD)
    return arm.turned(about(-FORWARD, max(0.0, min(1.0, share)) * room_rad))


def _arm_in_trunk(vertices_m: FloatArray, part: IntArray) -> bool:
    """Return whether left forearm or hand reach into the left side of trunk or thigh.

    Both are seen from the side in cells; the body is its own mirror image.
    """
    trunk = vertices_m[_of(part, "torso", "left_upper_leg")]
    arm = vertices_m[_of(part, "left_lower_arm", "left_hand")]
    cells = np.floor(vertices_m[:, 1:] / _CELL_M).astype(int)
    origin, size = cells.min(0), np.ptp(cells, axis=0) + 1
    outermost_m = np.full(size, -np.inf)
    at_trunk = np.floor(trunk[:, 1:] / _CELL_M).astype(int) - origin
    np.maximum.at(outermost_m, tuple(at_trunk.T), trunk[:, 0])
    # Cells are finer than the mesh in places; the neighbours close the gaps.
    outermost_m = maximum_filter(outermost_m, size=3, mode="nearest")
    at_arm = np.floor(arm[:, 1:] / _CELL_M).astype(int) - origin
    return bool((arm[:, 0] < outermost_m[tuple(at_arm.T)] + _GAP_M).any())


def _of(part: IntArray, *names: str) -> BoolArray:
    return np.isin(part, [BODY_PART_NAMES.index(name) for name in names])
