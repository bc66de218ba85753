"""What markers are called for a reader: names that the program knows follow the language."""

from dataclasses import dataclass

from adibas.data.joints import SIDES
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
MIDDLE: dict[str, Message] = {
    "glabella": message("Glabella"),
    "menton": message("Menton"),
    "sternal_notch": message("Sternal notch"),
    "thoracic_apex": message("Thoracic apex"),
    "umbilicus": message("Umbilicus"),
    "natal_cleft": message("Natal cleft"),
}
PAIRED: dict[str, Message] = {
    "canthus": message("Outer canthus"),
    "tragus": message("Tragus"),
    "acromion": message("Acromion"),
    "shoulder_top": message("Shoulder line"),
    "anterior_shoulder_top": message("Shoulder line from the front"),
    "scapular_spine": message("Spine of scapula"),
    "axilla": message("Axillary fold"),
    "anterior_axilla": message("Anterior axillary fold"),
    "inferior_scapula": message("Inferior angle of scapula"),
    "lateral_epicondyle": message("Lateral epicondyle"),
    "waist": message("Waist"),
    "anterior_waist": message("Waist from the front"),
    "wrist": message("Wrist"),
    "asis": message("ASIS"),
    "psis": message("PSIS"),
    "greater_trochanter": message("Greater trochanter"),
    "knee_joint_line": message("Knee joint line"),
    "patella": message("Patella"),
    "tibial_tuberosity": message("Tibial tuberosity"),
    "midleg": message("Midline of leg"),
    "achilles": message("Achilles tendon"),
    "calcaneus": message("Calcaneus"),
    "lateral_malleolus": message("Lateral malleolus"),
    "medial_malleolus": message("Medial malleolus"),
    "metatarsals": message("Metatarsals 2 and 3"),
}
VERTEBRAE = ("c7", "t1", "t3", "t5", "t7", "t9", "t11", "t12", "l1", "l3", "l4", "l5", "s1")
"""Of the shipped protocols."""
SPINE = tuple(
    f"{part}{number}"
    for part, n in (("c", 7), ("t", 12), ("l", 5), ("s", 5))
    for number in range(1, n + 1)
)
"""Every vertebra from head to foot: called the same in every language, in capitals."""
LEFT, RIGHT = message("{landmark}, left"), message("{landmark}, right")
LANDMARKS = (
    *MIDDLE,
    *VERTEBRAE,
    *(f"{side}{landmark}" for landmark in PAIRED for side in reversed(SIDES)),
)
"""The landmarks of the shipped protocols, but joints, from head to foot."""
KNOWN = (*LANDMARKS, *JOINTS)


def landmark_text(label: str) -> str:
    """Return the label of a marker for a reader.

    Joints and landmarks that the program knows have a name in the language in use; what a user
    typed is its own name. Files for programs keep the label, the same in every language.
    """
    if label in SPINE:
        return label.upper()
    named = JOINTS.get(label) or MIDDLE.get(label)
    if named is not None:
        return _(named)
    for side, words in zip(SIDES, (LEFT, RIGHT), strict=True):
        paired = PAIRED.get(label.removeprefix(side)) if label.startswith(side) else None
        if paired is not None:
            return _(words).format(landmark=_(paired))
    return label


@dataclass(frozen=True, slots=True)
class LandmarkNames:
    """Markers that a sentence tells of: by their names in the language in use when it is read."""

    labels: tuple[str, ...]

    def __str__(self) -> str:
        return "; ".join(map(landmark_text, self.labels))  # names of a side have a comma inside


def landmark_label(text: str) -> str:
    """Return the label whose text this is in the language in use; other texts are labels."""
    return next((label for label in (*KNOWN, *SPINE) if landmark_text(label) == text), text)
