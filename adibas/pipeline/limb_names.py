"""What limbs are called, and the colours in which they are painted by hand."""

import numpy as np

from adibas.arrays import UInt8Array
from adibas.limbs.joint_places import without_side
from adibas.texts import message
from adibas.texts import translate as _

NAMES = {
    "head": message("Head"),
    "neck": message("Neck"),
    "torso": message("Trunk"),
    "left_upper_arm": message("Left upper arm"),
    "left_lower_arm": message("Left lower arm"),
    "left_hand": message("Left hand"),
    "left_upper_leg": message("Left upper leg"),
    "left_lower_leg": message("Left lower leg"),
    "left_foot": message("Left foot"),
    "right_upper_arm": message("Right upper arm"),
    "right_lower_arm": message("Right lower arm"),
    "right_hand": message("Right hand"),
    "right_upper_leg": message("Right upper leg"),
    "right_lower_leg": message("Right lower leg"),
    "right_foot": message("Right foot"),
    "clutter": message("Furniture"),
}

PART_COLORS = {
    "head": (240, 228, 66),
    "neck": (213, 94, 0),
    "torso": (86, 180, 233),
    "upper_arm": (230, 159, 0),
    "lower_arm": (0, 158, 115),
    "hand": (204, 121, 167),
    "upper_leg": (213, 94, 0),
    "lower_leg": (240, 228, 66),
    "foot": (0, 114, 178),
    "clutter": (150, 150, 150),
}
"""Parts that touch differ for the colour-blind, too; the left side is light, the right side dark.

Source: Okabe & Ito, Color Universal Design (2008).
"""

LIGHT, DARK = 0.35, 0.55
"""How far the left side is drawn to white; what is left of the right side's light."""


def limb_text(name: str) -> str:
    """Return what a limb is called; its own name where it is none of ours."""
    return _(NAMES[name]) if name in NAMES else name


def painting_colors(names: tuple[str, ...]) -> UInt8Array:
    """Return (L + 1, 3) RGB colours of labels; the first is black."""
    others = list(PART_COLORS.values())
    colors = np.zeros((len(names) + 1, 3))
    for number, name in enumerate(names):
        color = np.array(PART_COLORS.get(without_side(name), others[number % len(others)]), float)
        if name.startswith("left_"):
            color += LIGHT * (255 - color)
        elif name.startswith("right_"):
            color *= DARK
        colors[number + 1] = color
    return np.asarray(colors, np.uint8)
