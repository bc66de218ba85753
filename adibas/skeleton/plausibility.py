"""What joints that were found at first sight say of whether they are a person's.

Part of what tells people from things; see `adibas.limbs.likeness`. The figures are ours.
"""

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.joints import JOINT_NAMES
from adibas.skeleton.following import ChosenJoints
from adibas.skeleton.proportions import Proportions, bone_lengths_m

PLAUSIBILITIES = ("confidence", "shoulders", "hips", "stature")
"""What `describe_joints` gives, in this order."""
ABSENT_M = -0.1
"""Way between two joints of which one is not seen."""
UNKNOWN_STATURE_M = 1.0


def describe_joints(joints: ChosenJoints, proportions: Proportions) -> FloatArray:
    """Return the (4,) `PLAUSIBILITIES` of joints.

    Mean confidence of all fifteen (0 where not seen), the ways between both shoulders and between
    both hips, and the stature that most bones speak for; metres.
    """
    lengths_m = bone_lengths_m(joints.joints_m)
    known = np.isfinite(lengths_m) & (proportions.lengths > 0)
    stature_m = UNKNOWN_STATURE_M
    if known.any():
        stature_m = float(np.median(lengths_m[known] / proportions.lengths[known]))
    shoulders_m, hips_m = (_apart_m(joints.joints_m, name) for name in ("shoulder", "hip"))
    return np.array(
        [float(np.nan_to_num(joints.confidence).mean()), shoulders_m, hips_m, stature_m]
    )


def _apart_m(joints_m: FloatArray, name: str) -> float:
    left_m, right_m = (joints_m[JOINT_NAMES.index(f"{side}_{name}")] for side in ("left", "right"))
    way_m = float(np.linalg.norm(left_m - right_m))
    return way_m if np.isfinite(way_m) else ABSENT_M
