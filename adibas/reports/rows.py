"""The numbers of a report in clinical units: one place, so that every format shows the same."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from adibas.data.landmark_texts import LandmarkNames, landmark_text
from adibas.data.markers import Marker, is_numbered
from adibas.data.measures import AngleMeasure, DistanceMeasure
from adibas.data.posture import PostureAnalysis
from adibas.data.protocol_measures import Estimate, MeasureResult
from adibas.data.protocols import CONVENTION, MeasureDefinition, ReferenceValue
from adibas.data.report import CaptureReport
from adibas.texts import decimal_text, translate_plural
from adibas.texts import translate as _

MM_PER_M = 1000.0
USER = "user"
"""Who named a marker by hand, or by a file of labels; files for programs have this word."""


@dataclass(frozen=True, slots=True)
class MarkerRow:
    """A marker in pixels and millimetres; None where there is no position.

    Attributes
    ----------
    named_by : str
        `USER`, or the model that gave the name; empty where it has none but a number.
    name_confidence : float or None
        0 to 1; None where no model gave the name.
    """

    label: str
    u_px: float
    v_px: float
    position_mm: tuple[float, float, float] | None
    deviation_mm: tuple[float, float, float] | None
    named_by: str
    name_confidence: float | None


@dataclass(frozen=True, slots=True)
class DistanceRow:
    """A distance and its 95 % interval, millimetres."""

    a: str
    b: str
    mm: float
    low_mm: float
    high_mm: float


@dataclass(frozen=True, slots=True)
class AngleRow:
    """An angle, its 95 % interval and its bias, degrees."""

    a: str
    vertex: str
    c: str
    deg: float
    low_deg: float
    high_deg: float
    bias_deg: float


@dataclass(frozen=True, slots=True)
class FreeRow:
    """A distance (no vertex) or an angle that was asked for; None where it was not measured."""

    a: str
    vertex: str
    c: str
    unit: str
    value: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True, slots=True)
class NumberRow:
    """A value and its 95 % interval, in the unit of its measure."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class MeasureRow:
    """A measure of a protocol; None where there is no such value.

    Attributes
    ----------
    measure_id, name, unit : str
        What was measured.
    main : NumberRow or None
        The value that stands for it: the signed one in the plane, where it has a sign.
    projected, spatial : NumberRow or None
        In the plane, and in space.
    positive, reference, remark : str
        What a positive value means; what others found, with the source; what to know of it.
    """

    measure_id: str
    name: str
    unit: str
    main: NumberRow | None
    projected: NumberRow | None
    spatial: NumberRow | None
    positive: str
    reference: str
    remark: str


def measure_rows(analysis: PostureAnalysis) -> Iterator[MeasureRow]:
    """Yield the measures of the protocol in its order, in the language in use."""
    if analysis.measures is not None:
        yield from map(measure_row, analysis.measures.results)


def measure_row(result: MeasureResult) -> MeasureRow:
    """Return a measure of a protocol, in the language in use."""
    definition = result.definition
    projected, spatial, main = (
        _in_unit(one, definition) for one in (result.projected, result.spatial, result.main)
    )
    remarks = [result.reason.text] if result.reason is not None else []
    if result.by_hand:
        remarks.append(_("placed by hand: {names}").format(names=LandmarkNames(result.by_hand)))
    return MeasureRow(
        definition.measure_id,
        definition.name.text,
        definition.unit,
        main,
        projected,
        spatial,
        "" if definition.positive is None else definition.positive.text,
        "; ".join(reference_text(one) for one in definition.references),
        "; ".join(remarks),
    )


def reference_text(reference: ReferenceValue) -> str:
    """Return what others found or fixed, whom, and where it can be read."""
    number = decimal_text(reference.mean, 1)
    if reference.sd is not None:
        number = f"{number} \N{PLUS-MINUS SIGN} {decimal_text(reference.sd, 1)}"
    text = f"{number} ({reference.who}; {reference.source})"
    if reference.kind == CONVENTION:
        text = _("default of a program, no normal value: {value}").format(value=text)
    return f"{text}. {reference.note}" if reference.note else text


def _in_unit(estimate: Estimate | None, definition: MeasureDefinition) -> NumberRow | None:
    if estimate is None:
        return None
    per_unit = definition.per_unit
    low, high = estimate.interval
    return NumberRow(estimate.value / per_unit, low / per_unit, high / per_unit)


def marker_rows(analysis: PostureAnalysis) -> Iterator[MarkerRow]:
    """Yield the markers in their order."""
    for marker in analysis.markers:
        named = name_origin(marker)
        yield MarkerRow(marker.label, marker.u, marker.v, *_millimetres(marker), *named)


def name_origin(marker: Marker) -> tuple[str, float | None]:
    """Return who named a marker and how sure that is, as `MarkerRow` has it."""
    if marker.named_by is not None:
        return marker.named_by.model, marker.named_by.confidence
    return "" if is_numbered(marker.label) else USER, None


def names_line(analysis: PostureAnalysis) -> str:
    """Return who named the markers and which name is least sure; empty where none has a name."""
    by_model = [
        (one.named_by.confidence, one.label) for one in analysis.markers if one.named_by is not None
    ]
    n_by_hand = sum(name_origin(one)[0] == USER for one in analysis.markers)
    parts = []
    if by_model:
        confidence, label = min(by_model)
        text = translate_plural(
            "{n} automatic (least sure: {marker}, {percent} %)",
            "{n} automatic (least sure: {marker}, {percent} %)",
            len(by_model),
        )
        percent = math.floor(100.0 * confidence)
        parts.append(text.format(n=len(by_model), marker=landmark_text(label), percent=percent))
    if n_by_hand:
        parts.append(
            translate_plural("{n} by a person", "{n} by a person", n_by_hand).format(n=n_by_hand)
        )
    return _("Names of markers: {parts}").format(parts=", ".join(parts)) if parts else ""


def distance_rows(distances: Iterable[DistanceMeasure]) -> Iterator[DistanceRow]:
    """Yield the distances in their order."""
    for distance in distances:
        low_m, high_m = distance.interval_m
        yield DistanceRow(
            distance.a,
            distance.b,
            distance.value_m * MM_PER_M,
            low_m * MM_PER_M,
            high_m * MM_PER_M,
        )


def angle_rows(angles: Iterable[AngleMeasure]) -> Iterator[AngleRow]:
    """Yield the angles in their order."""
    for angle in angles:
        low_rad, high_rad = angle.interval_rad
        yield AngleRow(
            angle.a,
            angle.vertex,
            angle.c,
            math.degrees(angle.value_rad),
            math.degrees(low_rad),
            math.degrees(high_rad),
            math.degrees(angle.bias_rad),
        )


def free_rows(capture: CaptureReport) -> Iterator[FreeRow]:
    """Yield the free measures in their order, with the numbers of the tables."""
    distances = {
        frozenset((row.a, row.b)): row for row in distance_rows(capture.analysis.distances)
    }
    angles = {
        (row.vertex, frozenset((row.a, row.c))): row for row in angle_rows(capture.analysis.angles)
    }
    for measure in capture.measures:
        a, c = measure.labels[0], measure.labels[-1]
        numbers: tuple[float, float, float] | tuple[None, None, None] = (None, None, None)
        if len(measure.labels) == 2:  # noqa: PLR2004  (a distance)
            distance = distances.get(frozenset((a, c)))
            if distance is not None:
                numbers = (distance.mm, distance.low_mm, distance.high_mm)
            yield FreeRow(a, "", c, "mm", *numbers)
        else:
            vertex = measure.labels[1]
            angle = angles.get((vertex, frozenset((a, c))))
            if angle is not None:
                numbers = (angle.deg, angle.low_deg, angle.high_deg)
            yield FreeRow(a, vertex, c, "deg", *numbers)


def remark(capture: CaptureReport, row: MarkerRow) -> str | None:
    """Return what the reader must know about a marker."""
    is_placed = row.label in capture.placed_by_hand
    if row.position_mm:
        return _("corrected by hand") if is_placed else None
    if is_placed:
        return _("corrected by hand; the depth gives no position here")
    return _("the depth gives no position here")


def free_remark(row: FreeRow) -> str | None:
    """Return why a measure that was asked for has no value."""
    return None if row.value is not None else _("not measured: a marker has no position")


def _millimetres(
    marker: Marker,
) -> tuple[tuple[float, float, float] | None, tuple[float, float, float] | None]:
    """Return position and standard deviation of each axis, or None twice."""
    if marker.position_m is None or marker.covariance_m2 is None:
        return None, None
    x, y, z = (marker.position_m * MM_PER_M).tolist()
    sx, sy, sz = (np.sqrt(np.diag(marker.covariance_m2)) * MM_PER_M).tolist()
    return (x, y, z), (sx, sy, sz)
