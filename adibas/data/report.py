"""What one report shows: the captures of a session, and how the reader wants them."""

from dataclasses import dataclass, field
from datetime import datetime
from enum import Enum

from adibas.data.corrections import FreeMeasure
from adibas.data.posture import PostureAnalysis
from adibas.data.reliability import Comparison
from adibas.data.sessions import ROTATIONS_DEG
from adibas.data.trends import Trend


class PictureChoice(Enum):
    """How much of the patient the pictures show."""

    AS_IS = "as-is"
    BLURRED = "blurred"
    """Head and surroundings cannot be recognised."""
    DEPTH = "depth"
    """Colour-mapped depth, and nothing of the colour camera."""


@dataclass(frozen=True, slots=True, eq=False)
class CaptureReport:
    """One capture with its corrections.

    Attributes
    ----------
    analysis : PostureAnalysis
        Of the markers as corrected.
    placed_by_hand : frozenset of str
        Labels of its markers that the clinician added or moved.
    measures : tuple of FreeMeasure
        Distances and angles that the clinician asked for.
    """

    analysis: PostureAnalysis
    placed_by_hand: frozenset[str] = frozenset()
    measures: tuple[FreeMeasure, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class SessionComparison:
    """What changed since an earlier session.

    Attributes
    ----------
    since_utc : datetime
        When that began.
    comparison : Comparison
        Measure by measure.
    trends : tuple of Trend
        Every measure over the patient's sessions until the reported one.
    earlier : tuple of CaptureReport
        The captures of the earlier session.
    earlier_rotation_deg : int
        How far its pictures are turned clockwise to be upright.
    """

    since_utc: datetime
    comparison: Comparison
    trends: tuple[Trend, ...] = ()
    earlier: tuple[CaptureReport, ...] = ()
    earlier_rotation_deg: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class SessionReport:
    """The captures of one session, or a single capture that belongs to none.

    Attributes
    ----------
    patient : str
        A pseudonym, never a name; empty where it was not told.
    captures : tuple of CaptureReport
        In the order in which they are shown; one at least.
    language : str
        Two letters.
    pictures : PictureChoice
        How much the pictures show.
    version : str
        Of the program that writes the report.
    started_utc : datetime or None
        When the session began; None where the capture belongs to none.
    operator, protocol, notes : str
        Of the session; empty where there is nothing to tell.
    rotation_deg : int
        How far pictures are turned clockwise to be upright.
    comparison : SessionComparison or None
        With an earlier session.
    """

    patient: str
    captures: tuple[CaptureReport, ...]
    language: str = "en"
    pictures: PictureChoice = PictureChoice.AS_IS
    version: str = ""
    started_utc: datetime | None = None
    operator: str = ""
    protocol: str = ""
    notes: str = field(default="", repr=False)
    rotation_deg: int = 0
    comparison: SessionComparison | None = None

    def __post_init__(self) -> None:
        if not self.captures:
            raise ValueError("a report needs a capture")
        if self.rotation_deg not in ROTATIONS_DEG:
            raise ValueError(f"rotation_deg must be one of {ROTATIONS_DEG}")
