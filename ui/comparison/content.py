"""What the comparison screen shows; without Qt."""

from dataclasses import dataclass

from adibas.arrays import UInt8Array
from adibas.data.markers import Marker
from adibas.data.protocols import MeasureDefinition, Protocol
from adibas.data.reliability import Comparison, Reliability
from adibas.data.sessions import Session
from adibas.data.trends import Trend
from adibas.pipeline.picture_overlay import PictureOverlay
from adibas.pipeline.session_comparison import is_earlier
from ui.widgets.rows import Key


@dataclass(frozen=True, slots=True)
class Choices:
    """What can be compared, and what is.

    Attributes
    ----------
    sessions : tuple of Session
        Those with pictures, newest first.
    earlier, later : Session or None
        Those that are compared.
    protocols : tuple of (str, str)
        Name and title of each.
    protocol : str
        Name of the one that is measured by.
    operators : tuple of str
        Whose repeats can be looked at; an empty name is nobody's.
    operator : str
        Whose repeats are.
    """

    sessions: tuple[Session, ...] = ()
    earlier: Session | None = None
    later: Session | None = None
    protocols: tuple[tuple[str, str], ...] = ()
    protocol: str = ""
    operators: tuple[str, ...] = ()
    operator: str = ""

    @property
    def befores(self) -> tuple[Session, ...]:
        """Return what the later session can be compared with: what was before it."""
        later = self.later
        return () if later is None else tuple(x for x in self.sessions if is_earlier(x, later))

    @property
    def nows(self) -> tuple[Session, ...]:
        """Return what can be the later session: the first one has nothing before it."""
        return self.sessions[:-1] or self.sessions


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """One picture with the markers as corrected."""

    picture_rgb: UInt8Array
    markers: tuple[Marker, ...]
    rotation_deg: int


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """One view in both sessions; None where a session has it not.

    Attributes
    ----------
    view : str
        Which.
    earlier, later : Seen or None
        The pictures.
    overlay : PictureOverlay or None
        How the earlier picture is laid over the later one; None unless there are both.
    laid_rgb : (H, W, 3) uint8 array or None
        The earlier picture in the later one's pixels.
    """

    view: str
    earlier: Seen | None = None
    later: Seen | None = None
    overlay: PictureOverlay | None = None
    laid_rgb: UInt8Array | None = None


@dataclass(frozen=True, slots=True)
class Differences:
    """The change of every measure, or a sentence that says why there is none."""

    protocol: Protocol | None = None
    comparison: Comparison | None = None
    refusal: str = ""
    is_looking: bool = False
    """Whether the clinic's repeats are still being looked through."""


@dataclass(frozen=True, slots=True)
class Trends:
    """Every measure over the patient's sessions, and what must be known of them."""

    trends: tuple[Trend, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Repeats:
    """How well each measure repeats in the hands of one operator."""

    protocol: Protocol | None = None
    by_measure: tuple[tuple[Key, Reliability], ...] = ()
    sentence: str = ""
    """What to say where there is nothing."""


def definitions_of(protocol: Protocol) -> dict[str, MeasureDefinition]:
    """Return the measures by their ids."""
    return {one.measure_id: one for one in protocol.measures}


def clinical_ids(protocol: Protocol) -> frozenset[str]:
    """Return the measures that somebody chose; all where they are every pair and triplet."""
    chosen = {one.measure_id for one in protocol.measures if not one.is_one_of_all}
    return frozenset(chosen or {one.measure_id for one in protocol.measures})
