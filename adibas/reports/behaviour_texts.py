"""The words of a report of behaviour."""

from adibas.pipeline.behaviour import OUT_OF_VIEW, POSTURE_CHANGE
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
OWN: dict[str, Message] = {
    POSTURE_CHANGE: message("posture change"),
    OUT_OF_VIEW: message("out of view"),
}
UNTAGGED = message("rest of the session")
NOBODY = message("nobody in particular")
PERSON = message("Person {n}")


def joint_text(joint: str) -> str:
    """Return a joint's name for a reader."""
    return _(JOINTS[joint])


def behaviour_text(name: str) -> str:
    """Return what the program calls its own behaviours in the language in use; others stay."""
    return _(OWN[name]) if name in OWN else name


def subject_text(subject: str) -> str:
    """Return who acts, for a reader."""
    kind, _space, number = subject.partition(" ")
    if kind == "person" and number.isdecimal():
        return _(PERSON).format(n=number)
    return subject or _(NOBODY)


def condition_text(name: str) -> str:
    """Return a condition's name for a reader."""
    return name or _(UNTAGGED)
