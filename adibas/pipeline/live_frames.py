"""What the live view tells: frames with all that is drawn over them, and how the sensor fares."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias

from adibas.arrays import BoolArray, Float32Array, UInt8Array
from adibas.errors import AdibasError
from adibas.texts import Message

if TYPE_CHECKING:  # the window knows these types before anything is compiled
    from adibas.calibration.finder import BoardSearch
    from adibas.data.frames import SourceInfo
    from adibas.markers.detection import Detections
    from adibas.pipeline.plumb import PlumbLine

SensorKind: TypeAlias = Literal["closed", "opening", "live", "lost", "ended"]


@dataclass(frozen=True, slots=True)
class Naming:
    """After what markers are named: the landmarks of a protocol (its name), in one of its views."""

    protocol: str
    view: str


@dataclass(frozen=True, slots=True, eq=False)
class LiveFrame:
    """One moment of a sensor and what is seen in it, safe to share between threads.

    Attributes
    ----------
    sequence, timestamp_ns : int
        As in `SensorFrame`; where a recording begins anew they go on.
    color_rgb : (H', W', 3) uint8 array or None
        None where the frame has no colour, or a damaged one.
    depth_m : (H, W) float32 array or None
        Along the depth camera's z, bias corrected (but for a board), metres; NaN where not
        measured.
    depth_in_color_m : (H', W') float32 array or None
        The same registered to the colour image; None without a calibration.
    outline : (H', W') bool array or None
        The person in the colour image; None where nobody is seen.
    detections : Detections or None
        Markers in this frame; None where nobody is seen or no marker is looked for.
    joints : dict
        Pixel (u, v) of each joint that a marker surely marks, by its name.
    board : BoardSearch or None
        What the search for a board came to; None where none is looked for, or without colour.
    plumb : PlumbLine or None
        Vertical and horizon in the colour image; None where neither floor nor gravity is known.
    hints : tuple of Message
        What the clinician should know or do, to be translated.
    frame_rate_hz : float
        Frames a second that came from the sensor lately; 0 before it is known.
    n_dropped : int
        Frames since `LiveView.open` that the sensor counted and that never came. Frames that
        came and were skipped because a newer one was there are none of them.
    rotation_deg : int
        How far the picture is turned clockwise for showing.
    """

    sequence: int
    timestamp_ns: int
    color_rgb: UInt8Array | None
    depth_m: Float32Array | None
    depth_in_color_m: Float32Array | None = None
    outline: BoolArray | None = None
    detections: "Detections | None" = None
    joints: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    board: "BoardSearch | None" = None
    plumb: "PlumbLine | None" = None
    hints: tuple[Message, ...] = ()
    frame_rate_hz: float = 0.0
    n_dropped: int = 0
    rotation_deg: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class SensorState:
    """How the source of frames fares.

    Attributes
    ----------
    kind : str
        ``closed``; ``opening`` until the first frame; ``live``; ``lost``: it is tried again every
        second; ``ended``: nothing more will come.
    error : AdibasError or None
        Why it is lost or has ended; None where a recording is simply over.
    info : SourceInfo or None
        Of the source while it is live.
    """

    kind: SensorKind
    error: AdibasError | None = None
    info: "SourceInfo | None" = None


class LiveListener(Protocol):
    """Who is told. Called by worker threads; must neither wait nor open or close the view.

    An exception here is a bug: it ends the view's threads and goes to `threading.excepthook`.
    """

    def frame_arrived(self, frame: LiveFrame) -> None:
        """Take the newest frame."""

    def state_changed(self, state: SensorState) -> None:
        """Take how the sensor fares now."""
