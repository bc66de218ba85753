"""The 15 joints in the order of the thesis and of NiTE; left and right are the patient's."""

from collections.abc import Sequence

SIDES = ("left_", "right_")
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

PARENT_OF = {
    "neck": "torso",
    "head": "neck",
    **{
        f"{side}{joint}": parent if parent in {"neck", "torso"} else f"{side}{parent}"
        for side in SIDES
        for joint, parent in (
            ("shoulder", "neck"),
            ("elbow", "shoulder"),
            ("hand", "elbow"),
            ("hip", "torso"),
            ("knee", "hip"),
            ("foot", "knee"),
        )
    },
}
"""The joint at the other end of the bone that ends at each joint; the torso has none."""

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
    """Return the joint, part or landmark of the other side; the name itself where it has none."""
    for side, other in zip(SIDES, SIDES[::-1], strict=True):
        if name.startswith(side):
            return other + name.removeprefix(side)
    return name


def mirror_order(names: Sequence[str]) -> list[int]:
    """Return for each name the index of its mirror image, of itself where there is none."""
    other = (other_side(name) for name in names)
    return [names.index(one) if one in names else i for i, one in enumerate(other)]
