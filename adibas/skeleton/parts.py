"""The shape of a body in space as a core and limbs: the model, as data."""

from dataclasses import dataclass

from adibas.shapes.parts_types import Anchors, Core, Limbs
from adibas.skeleton.stance import Stance

CORE_NAMES = (
    "head",
    "neck",
    "left_shoulder",
    "right_shoulder",
    "torso",
    "left_hip",
    "right_hip",
)
LIMB_NAMES = (
    ("left_shoulder", "left_elbow", "left_hand"),
    ("right_shoulder", "right_elbow", "right_hand"),
    ("left_hip", "left_knee", "left_foot"),
    ("right_hip", "right_knee", "right_foot"),
)
"""Root, inner and outer point; a left limb, then its mirror image."""
ARMS, LEGS = slice(0, 2), slice(2, 4)
"""Of the limbs."""
ANCHOR_NAMES = ("neck", "left_hip", "right_hip")
"""At least one of them is there where two points are hidden."""


@dataclass(frozen=True, slots=True, eq=False)
class PartsModel:
    """What is known of the 15 joints by parts; `names` are of the N points.

    Attributes
    ----------
    kinds : tuple of str
        Of posture, such as ``standing``.
    stance : Stance or None
        How all joints of people who stand still lie together; None: nothing was learned of it.
    """

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    core: Core
    limbs: Limbs
    anchors: Anchors
    stance: Stance | None = None


def has_parts(names: tuple[str, ...]) -> bool:
    """Say whether all points of the core and the limbs are among the names, and no others."""
    beyond = {name for limb in LIMB_NAMES for name in limb}
    return set(names) == beyond | set(CORE_NAMES)
