"""The measures of a protocol on the markers of one capture."""

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import groupby

from adibas.data.landmark_texts import LandmarkNames
from adibas.data.markers import Marker, is_numbered
from adibas.data.protocol_measures import (
    Estimate,
    MeasureResult,
    PlaneChoice,
    ProtocolMeasures,
    VerticalOrigin,
)
from adibas.data.protocols import MeasureDefinition, Protocol, same_label
from adibas.data.sentence import Sentence
from adibas.measures.marker_errors import placed_markers
from adibas.measures.protocol_sides import SidesSeen, patient_axis, see_sides
from adibas.measures.protocol_values import Measurer, PlacedLandmarks, Sightline
from adibas.measures.sight_plane import Vertical
from adibas.texts import Message, message

_PLANE_MARKS: dict[PlaneChoice, tuple[tuple[str, str, bool], ...]] = {
    PlaneChoice.SENSOR: (),
    PlaneChoice.TEMPLATE: (
        ("template_right", "template_left", True),
        ("template_back", "template_front", False),
    ),
    PlaneChoice.ACROMIA: (("right_acromion", "left_acromion", True),),
    PlaneChoice.ASIS: (("right_asis", "left_asis", True),),
}
"""From, to, and whether that is from right to left; else it is from back to front."""

NOT_MARKED = message("not marked: {names}")
NO_DEPTH = message("the depth gives no position of: {names}")
COINCIDE = message("two of its points coincide")
NO_VERTICAL = message("the vertical is not measured: calibrate it with the floor")
NO_PLANE = message("the plane that was asked for is not seen: {names}")
SWAPPED = message(
    "In this picture left and right are exchanged: the names of the markers, or the view, are "
    "wrong. Nothing was measured; correct them."
)
EXCHANGED = message("left and right are exchanged: {names}")
LEFT_OUT_EXCHANGED = message(
    "Left and right of these are exchanged, and nothing was measured with them. Correct their "
    "names: {names}."
)
CROSSED = message(
    "The left lies on the right here: crossed limbs, or exchanged names. Look before you trust "
    "what was measured with them: {names}."
)
TWICE = message("{names} is named twice and was left out. Rename one of the two markers.")
UNKNOWN_LABEL = message(
    "No landmark of this protocol in this view, and so left out of its measures: {names}."
)
UNKNOWN_SD = message(
    "How sure the vertical is, is not known: its part of the intervals is missing."
)


@dataclass(frozen=True, slots=True, eq=False)
class Capturing:
    """How the markers were taken.

    Attributes
    ----------
    view : str
        Of `VIEWS`.
    vertical : Vertical
        In the colour camera's axes.
    plane : PlaneChoice
        In which projected values are measured.
    by_hand : collection of str
        Labels of markers that were placed by hand.
    """

    view: str
    vertical: Vertical
    plane: PlaneChoice = PlaneChoice.SENSOR
    by_hand: Collection[str] = ()


def measure_protocol(
    protocol: Protocol, markers: Sequence[Marker], capturing: Capturing
) -> ProtocolMeasures:
    """Measure what a protocol asks for in one view.

    Parameters
    ----------
    protocol : Protocol
        What to measure.
    markers : sequence of Marker
        Their labels say which landmarks they are.
    capturing : Capturing
        View, vertical and plane.

    Returns
    -------
    measures : ProtocolMeasures
        Every measure of the view; one that cannot be measured says why, and has no number.
    """
    labelled = _Labelled(protocol, markers, capturing)
    definitions = protocol.measures_of(capturing.view)
    results = _Results(protocol, labelled, capturing).of(definitions)
    notices = list(labelled.notices)
    if capturing.vertical.origin is not VerticalOrigin.UNKNOWN and not (
        capturing.vertical.is_sd_known
    ):
        notices.append(Sentence(UNKNOWN_SD))
    return ProtocolMeasures(
        protocol,
        capturing.view,
        capturing.plane,
        capturing.vertical.origin,
        results,
        tuple(notices),
    )


class _Labelled:
    """Which marker is which landmark."""

    def __init__(self, protocol: Protocol, markers: Sequence[Marker], capturing: Capturing) -> None:
        by_label = {
            label: landmark.landmark_id
            for landmark in protocol.landmarks
            if capturing.view in landmark.views
            for label in landmark.labels
        }
        for marks in _PLANE_MARKS.values():
            for first, last, _sideways in marks:
                by_label |= {same_label(name): name for name in (first, last)}
        known = [(by_label.get(same_label(marker.label)), marker) for marker in markers]
        counts = Counter(name for name, _marker in known if name is not None)
        self.markers = {
            name: marker for name, marker in known if name is not None and counts[name] == 1
        }
        self.by_hand = {
            name for name, one in self.markers.items() if one.label in capturing.by_hand
        }
        twice = [name for name, count in counts.items() if count > 1]
        others = [one.label for name, one in known if name is None and not is_numbered(one.label)]
        self.notices = [
            *(_of_landmarks(TWICE, [name]) for name in twice),
            *([_of_landmarks(UNKNOWN_LABEL, others)] if others else []),
        ]
        self.sides = see_sides(
            {
                name: marker.position_m
                for name, marker in self.markers.items()
                if marker.position_m is not None
            },
            capturing.view,
            capturing.vertical.up,
        )
        self.notices += _said_of_sides(self.sides)

    def placed(self) -> PlacedLandmarks:
        """Return those that have a position."""
        names = tuple(
            name for name, marker in self.markers.items() if marker.position_m is not None
        )
        _markers, positions_m, errors = placed_markers([self.markers[name] for name in names])
        return PlacedLandmarks(names, positions_m, errors.of_all())


def _said_of_sides(sides: SidesSeen) -> list[Sentence]:
    if sides.are_exchanged:
        return [Sentence(SWAPPED)]
    told = ((LEFT_OUT_EXCHANGED, sides.exchanged), (CROSSED, sides.crossed))
    return [_of_landmarks(text, sorted(names)) for text, names in told if names]


def _of_landmarks(text: Message, names: Sequence[str]) -> Sentence:
    return Sentence(text, {"names": LandmarkNames(tuple(names))})


class _Results:
    """Measures what can be, and says of the rest why not."""

    def __init__(self, protocol: Protocol, labelled: _Labelled, capturing: Capturing) -> None:
        self._protocol = protocol
        self._labelled = labelled
        self._vertical = capturing.vertical
        self._placed = labelled.placed()
        marks = _PLANE_MARKS[capturing.plane]
        seen = [mark for mark in marks if set(mark[:2]) <= set(self._placed.names)]
        self._plane_names = (seen or marks)[0][:2] if marks else ()
        self._is_plane_seen = not marks or bool(seen)
        self._is_plane_turned = bool(seen) and not self._points_as_seen(seen[0], capturing)
        across, is_sideways = (seen[0][:2], seen[0][2]) if seen else ((), True)
        sight = Sightline(capturing.view, capturing.vertical, across, is_sideways)
        self._measurer = Measurer(protocol, self._placed, sight)

    def of(self, definitions: Sequence[MeasureDefinition]) -> tuple[MeasureResult, ...]:
        reasons = {one.measure_id: self._missing(one) for one in definitions}
        ready = [one for one in definitions if reasons[one.measure_id] is None]
        alike = sorted(ready, key=lambda one: (one.kind, one.axis))
        projected: dict[str, Estimate | None] = {}
        spatial: dict[str, Estimate | None] = {}
        for _kind, group in groupby(alike, key=lambda one: (one.kind, one.axis)):
            same = list(group)
            ids = [one.measure_id for one in same]
            if self._flat_reason() is None:
                projected |= zip(ids, self._measurer.projected(same), strict=True)
            if not self._needs_vertical(same[0]):
                spatial |= zip(ids, self._measurer.spatial(same), strict=True)
        return tuple(
            self._result(
                one,
                projected.get(one.measure_id),
                spatial.get(one.measure_id),
                reasons[one.measure_id],
            )
            for one in definitions
        )

    def _result(
        self,
        definition: MeasureDefinition,
        projected: Estimate | None,
        spatial: Estimate | None,
        reason: Sentence | None,
    ) -> MeasureResult:
        main = spatial if definition.is_spatial else projected
        if main is None and reason is None:
            flat = None if definition.is_spatial else self._flat_reason()
            reason = flat or Sentence(COINCIDE)
        marked = self._protocol.marked_for(definition.points)
        by_hand = tuple(name for name in marked if name in self._labelled.by_hand)
        return MeasureResult(definition, projected, spatial, reason, by_hand)

    def _missing(self, definition: MeasureDefinition) -> Sentence | None:
        """Return which landmarks a measure lacks."""
        if self._labelled.sides.are_exchanged:
            return Sentence(SWAPPED)
        needed = self._protocol.marked_for(definition.points)
        exchanged = [name for name in needed if name in self._labelled.sides.exchanged]
        if exchanged:
            return _of_landmarks(EXCHANGED, exchanged)
        unmarked = [name for name in needed if name not in self._labelled.markers]
        if unmarked:
            return _of_landmarks(NOT_MARKED, unmarked)
        nowhere = [name for name in needed if name not in self._placed.names]
        return _of_landmarks(NO_DEPTH, nowhere) if nowhere else None

    def _flat_reason(self) -> Sentence | None:
        """Return why nothing can be projected."""
        if self._vertical.origin is VerticalOrigin.UNKNOWN:
            return Sentence(NO_VERTICAL)
        if not self._is_plane_seen:
            return _of_landmarks(NO_PLANE, self._plane_names)
        if self._is_plane_turned:
            return _of_landmarks(EXCHANGED, self._plane_names)
        return None

    def _points_as_seen(self, mark: tuple[str, str, bool], capturing: Capturing) -> bool:
        """Say whether the two points of a plane lie as the view shows them."""
        first, last, is_sideways = mark
        axis = "left" if is_sideways else "anterior"
        direction = patient_axis(axis, capturing.view, capturing.vertical.up)
        places_m = [self._placed.positions_m[self._placed.names.index(n)] for n in (first, last)]
        return bool((places_m[1] - places_m[0]) @ direction > 0)

    def _needs_vertical(self, definition: MeasureDefinition) -> bool:
        """Say whether a value in space is lacking the vertical that it rests on."""
        rests_on_it = definition.kind in (
            *("line_to_horizontal", "line_to_vertical", "asymmetry_index"),
        )
        return rests_on_it and self._flat_reason() is not None
