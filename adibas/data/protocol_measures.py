"""What a protocol's measures came out as in one capture, and on what they rest."""

from dataclasses import dataclass
from enum import Enum

from adibas.data.protocols import MeasureDefinition, Protocol
from adibas.data.sentence import Sentence
from adibas.texts import Message, message


class PlaneChoice(Enum):
    """Whose plane projected measures are measured in; it is vertical in any case."""

    SENSOR = "sensor"
    """Across the sensor's look."""
    TEMPLATE = "template"
    """Along two marks on the foot template: ``template_right`` and ``template_left``, or
    ``template_back`` and ``template_front``."""
    ACROMIA = "acromia"
    """The patient's own, through both acromia."""
    ASIS = "asis"
    """The patient's own, through both ASIS."""


class VerticalOrigin(Enum):
    """Where the vertical comes from."""

    GRAVITY = "gravity"
    FLOOR = "floor"
    UNKNOWN = "unknown"


PLANE_TEXTS: dict[PlaneChoice, Message] = {
    PlaneChoice.SENSOR: message("vertical plane across the sensor's look"),
    PlaneChoice.TEMPLATE: message("vertical plane of the foot template"),
    PlaneChoice.ACROMIA: message("patient's own vertical plane through both acromia"),
    PlaneChoice.ASIS: message("patient's own vertical plane through both ASIS"),
}

VERTICAL_TEXTS: dict[VerticalOrigin, Message] = {
    VerticalOrigin.GRAVITY: message("measured, kept in the calibration"),
    VerticalOrigin.FLOOR: message("across the floor of the calibration"),
    VerticalOrigin.UNKNOWN: message("not measured"),
}

INSTRUMENT_ONLY = message(
    "95 %, instrument only: marker placement and stance add about 2-3 deg and 3-6 mm."
)


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value with its interval, in radians, metres or as a share.

    Attributes
    ----------
    value : float
        As measured.
    interval : (float, float)
        Holds the truth in 95 % of cases as far as the instrument goes.
    """

    value: float
    interval: tuple[float, float]


@dataclass(frozen=True, slots=True)
class MeasureResult:
    """One measure of one capture.

    Attributes
    ----------
    definition : MeasureDefinition
        What was measured.
    projected : Estimate or None
        In the plane, with the sign that the protocol gives it.
    spatial : Estimate or None
        In space; deviations and angles between lines have no sign there.
    reason : Sentence or None
        Why the main value is missing.
    by_hand : tuple of str
        Those of its landmarks that were placed by hand.
    """

    definition: MeasureDefinition
    projected: Estimate | None
    spatial: Estimate | None
    reason: Sentence | None = None
    by_hand: tuple[str, ...] = ()

    @property
    def main(self) -> Estimate | None:
        """Return the value that stands for the measure: the signed one, where there is a sign."""
        return self.spatial if self.definition.is_spatial else self.projected


@dataclass(frozen=True, slots=True)
class ProtocolMeasures:
    """The measures of one capture.

    Attributes
    ----------
    protocol : Protocol
        That was followed.
    view : str
        Of the capture.
    plane : PlaneChoice
        Of the projected values.
    vertical : VerticalOrigin
        What the projected values rest on.
    results : tuple of MeasureResult
        In the protocol's order, those of this view; measured on markers, never without.
    notices : tuple of Sentence
        What the reader must know.
    """

    protocol: Protocol
    view: str
    plane: PlaneChoice
    vertical: VerticalOrigin
    results: tuple[MeasureResult, ...]
    notices: tuple[Sentence, ...] = ()
