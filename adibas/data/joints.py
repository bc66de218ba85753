"""The 15 joints in the order of the thesis and of NiTE; left and right are the patient's."""

JOINT_NAMES = (
    "head",
    "neck",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_hand",
    "right_hand",
    "torso",
    "left_hip",
    "right_hip",
    "left_knee",
    "right_knee",
    "left_foot",
    "right_foot",
)

BODY_PART_NAMES = (
    "head",
    "neck",
    "torso",
    *(
        f"{side}_{part}"
        for side in ("left", "right")
        for part in ("upper_arm", "lower_arm", "hand", "upper_leg", "lower_leg", "foot")
    ),
)
"""The 15 limb labels of the full body; label k of the tuple is pixel value k + 1, 0 = none."""


def other_side(name: str) -> str:
    """Return the joint or part of the other side; the same one in the middle of the body."""
    for side, other in (("left_", "right_"), ("right_", "left_")):
        if name.startswith(side):
            return other + name.removeprefix(side)
    return name
