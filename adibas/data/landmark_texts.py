"""What markers are called for a reader: names that the program gives follow the language."""

from adibas.texts import Message, message
from adibas.texts import translate as _

JOINTS: dict[str, Message] = {
    "head": message("Head"),
    "neck": message("Neck"),
    "left_shoulder": message("Left shoulder"),
    "right_shoulder": message("Right shoulder"),
    "left_elbow": message("Left elbow"),
    "right_elbow": message("Right elbow"),
    "left_hand": message("Left hand"),
    "right_hand": message("Right hand"),
    "torso": message("Torso"),
    "left_hip": message("Left hip"),
    "right_hip": message("Right hip"),
    "left_knee": message("Left knee"),
    "right_knee": message("Right knee"),
    "left_foot": message("Left foot"),
    "right_foot": message("Right foot"),
}


def landmark_text(label: str) -> str:
    """Return the label of a marker for a reader: a joint's name in the language in use, or itself.

    Files for programs keep the label, which is the same in every language.
    """
    return _(JOINTS[label]) if label in JOINTS else label


def landmark_label(text: str) -> str:
    """Return the label whose text this is in the language in use; other texts are labels."""
    return next((label for label, name in JOINTS.items() if _(name) == text), text)
