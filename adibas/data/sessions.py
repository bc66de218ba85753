"""A patient's sessions and their captures, as the store keeps them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime

from adibas.data.calibration import RgbdCalibration
from adibas.data.corrections import CorrectionHistory
from adibas.data.markers import Marker, RejectedBlob
from adibas.data.posture import VIEWS, Provenance

ROTATIONS_DEG = (0, 90, 180, 270)


@dataclass(frozen=True, slots=True)
class SessionSetup:
    """How a session was taken; the next one can start from it.

    Attributes
    ----------
    source : str
        As `adibas.sensors.open_source` takes it.
    color_size : (int, int)
        (width, height) of the colour image, pixels.
    markers : Mapping or None
        The content of a colours file, ``{"format": "adibas-leds", ...}``, or None before learning.
    rotation_deg : int
        How far the picture is turned clockwise for showing; the sensor is mounted the other way.
    protocol : str
        Name of the protocol; empty for free measures.
    wand : Mapping or None
        The content of the last check with a wand, ``{"format": "adibas-wand", ...}``.
    turn : str
        Of the store: the recording of a slow turn that begins with the back to the sensor; empty
        where none was taken.
    is_repeat : bool
        Whether the markers were placed anew since the session before on that day, and nothing else
        was done to the patient: then the two tell how well measures repeat.
    """

    source: str = "simulator"
    color_size: tuple[int, int] = (1280, 1024)
    markers: Mapping[str, object] | None = None
    rotation_deg: int = 0
    protocol: str = ""
    wand: Mapping[str, object] | None = None
    turn: str = ""
    is_repeat: bool = False

    def __post_init__(self) -> None:
        if self.rotation_deg not in ROTATIONS_DEG:
            raise ValueError(f"rotation_deg must be one of {ROTATIONS_DEG}")


@dataclass(frozen=True, slots=True, eq=False)
class Capture:
    """One burst of one view: what was recorded, found, and corrected.

    Attributes
    ----------
    capture_id, session_id : str
        Random, without meaning.
    view : str
        One of `VIEWS`, or empty.
    captured_utc : datetime
        When.
    recording_id : str
        Of the sealed recording.
    first_frame, n_frames : int
        The burst in it.
    calibration : RgbdCalibration
        That the positions rest on.
    detected : tuple of Marker
        As the program found them.
    rejected : tuple of RejectedBlob
        What it refused in the last frame.
    history : CorrectionHistory
        What the clinician changed since.
    provenance : Provenance
        What `detected` was computed from.
    notices : tuple of str
        What the reader must know about the input.
    is_deleted : bool
        Hidden, until it is undone or purged.
    """

    capture_id: str
    session_id: str
    view: str
    captured_utc: datetime
    recording_id: str
    first_frame: int
    n_frames: int
    calibration: RgbdCalibration
    detected: tuple[Marker, ...]
    rejected: tuple[RejectedBlob, ...]
    provenance: Provenance
    history: CorrectionHistory = field(default_factory=CorrectionHistory)
    notices: tuple[str, ...] = ()
    is_deleted: bool = False

    def __post_init__(self) -> None:
        if self.view not in ("", *VIEWS):
            raise ValueError(f"view must be one of {VIEWS}, got {self.view!r}")

    def markers(self) -> tuple[Marker, ...]:
        """Return the markers as corrected."""
        return self.history.markers(self.detected)


@dataclass(frozen=True, slots=True)
class Session:
    """One visit of a patient.

    Attributes
    ----------
    session_id : str
        Random, without meaning.
    patient : str
        A pseudonym.
    started_utc : datetime
        When.
    operator : str
        Who took it.
    setup : SessionSetup
        How it was taken.
    notes : str
        Free text of the clinician.
    capture_ids : tuple of str
        In the order in which they were taken, without deleted ones.
    is_deleted : bool
        Hidden, until it is undone or purged.
    """

    session_id: str
    patient: str
    started_utc: datetime
    operator: str
    setup: SessionSetup
    notes: str = field(default="", repr=False)
    capture_ids: tuple[str, ...] = ()
    is_deleted: bool = False
