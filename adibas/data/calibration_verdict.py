"""What a calibration is worth, in words."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from adibas.data.sentence import Sentence
from adibas.texts import Message, message, spoken, translate


class Grade(Enum):
    """From the best to the worst."""

    GOOD = "good"
    USABLE = "usable"
    REPEAT = "repeat"


class Reason(Enum):
    """What keeps a calibration from being good: causes before their consequences."""

    MIRRORED = "mirrored"
    TWO_BOARDS = "two boards"
    OTHER_SIZE = "another size of board"
    SCALE = "wrong square size"
    CUT_OFF = "cut off"
    BLURRED = "blurred"
    NO_BOARD = "no board"
    TOO_FEW = "too few images"
    FRONTAL = "all frontal"
    UNCOVERED = "uncovered"
    ONE_LEAN = "one lean"
    FEW = "few images"
    OUTLIERS = "outlier images"
    LARGE_ERROR = "large error"
    NOT_FLAT = "views contradict one another"
    UNSETTLED = "no solution"
    UNCERTAIN = "uncertain"
    DEPTH = "depth camera"


SENTENCES: dict[Reason, Message] = {
    Reason.NO_BOARD: message(
        "No chessboard was found in {n} of {total} images. Hold it whole in view, in even light, "
        "and check that its pattern has no glare."
    ),
    Reason.OTHER_SIZE: message(
        "A board of {columns} x {rows} inner corners is in {n} of {total} images, but {board} was "
        "said. Give the size of the board that was held, or hold the right one."
    ),
    Reason.TWO_BOARDS: message(
        "Two boards are in view in {n} of {total} images. Take one away and take these images anew."
    ),
    Reason.MIRRORED: message(
        "The images are mirrored: the dots of the board are exchanged left and right. Switch the "
        "mirroring of the camera off and take the images anew."
    ),
    Reason.TOO_FEW: message(
        "Too few images show the board: {n}, and {least} are needed. Take more, each from another "
        "place and with another tilt."
    ),
    Reason.FEW: message(
        "Few images show the board: {n}, and {wanted} make a good calibration. Take more, with "
        "other places and tilts."
    ),
    Reason.FRONTAL: message(
        "The board always faces the camera, so that distance and focal length cannot be told "
        "apart. Tilt it by 20 to 45 degrees in every direction and take the images anew."
    ),
    Reason.ONE_LEAN: message(
        "The board always leans the same way. Tilt it to the left and right as well as up and down."
    ),
    Reason.CUT_OFF: message(
        "In {n} of {total} images a part of the board is outside the image or hidden. Hold it so "
        "that all of it is seen."
    ),
    Reason.BLURRED: message(
        "The board is blurred in {n} of {total} images. Hold it still while an image is taken, "
        "clean the lens, and give more light."
    ),
    Reason.UNCOVERED: message(
        "The board was seen in {percent} % of the image only, and lens distortion is unknown in "
        "the rest. Hold it to all borders and corners of the image."
    ),
    Reason.OUTLIERS: message(
        "Of {total} images {n} contradict the others and took no part: {images}. Leave them out or "
        "take them anew."
    ),
    Reason.LARGE_ERROR: message(
        "The corners are {rms:.2f} pixels off on average; {limit:.2f} is usual. Check that the "
        "board is flat and stiff, held still and sharply seen."
    ),
    Reason.NOT_FLAT: message(
        "The images contradict one another {ratio:.1f} times more than the corners' noise "
        "explains, and the intervals are widened for it. Glue the board onto something flat "
        "and stiff."
    ),
    Reason.SCALE: message(
        "The board is {factor:.3f} times as far away by depth as by its image: its squares would "
        "measure {square_mm:.2f} mm, not {said_mm:.2f} mm. Measure a square with a ruler and give "
        "its true size."
    ),
    Reason.UNSETTLED: message(
        "These images do not determine the camera. Take new ones, with the board near and far, "
        "tilted, and in all parts of the image."
    ),
    Reason.DEPTH: message("The depth camera is not well calibrated."),
    Reason.UNCERTAIN: message(
        "A length of {length_mm:.0f} mm at {distance_m:.1f} m would be uncertain by {error_mm:.1f} "
        "mm; {limit_mm:.1f} mm is good. Take more images, with the board nearer, tilted more, and "
        "up to the borders."
    ),
}

GRADES: dict[Grade, Message] = {
    Grade.GOOD: message("Good: the calibration can be used for measuring."),
    Grade.USABLE: message("Usable, but it could be better:"),
    Grade.REPEAT: message("Repeat the calibration, because:"),
}


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong, and how bad that makes the calibration.

    Attributes
    ----------
    reason : Reason
        What.
    grade : Grade
        USABLE or REPEAT.
    fields : mapping
        What stands at the places of its sentence.
    sentence : Sentence or None
        In place of the reason's own: the checks of the depth camera each bring theirs.
    """

    reason: Reason
    grade: Grade
    fields: Mapping[str, object] = field(default_factory=dict)
    sentence: Sentence | None = None

    @property
    def text(self) -> str:
        """The sentence in the language in use: what is wrong, and what to do."""
        if self.sentence is not None:
            return self.sentence.text
        fields = {name: spoken(value) for name, value in self.fields.items()}
        return translate(SENTENCES[self.reason]).format(**fields)


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a calibration is worth.

    Attributes
    ----------
    findings : tuple of Finding
        The worst first; empty for a good calibration.
    """

    findings: tuple[Finding, ...] = ()

    @property
    def grade(self) -> Grade:
        """The worst of its findings'."""
        grades = list(Grade)
        worst = max((grades.index(finding.grade) for finding in self.findings), default=0)
        return grades[worst]

    def sentences(self) -> tuple[str, ...]:
        """Return the grade and the findings in the language in use."""
        return translate(GRADES[self.grade]), *(finding.text for finding in self.findings)
