"""The measures of one patient over several sessions, one line of values for each measure."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TypeAlias

from adibas.data.protocol_measures import Estimate, ProtocolMeasures
from adibas.data.protocols import KINDS, MeasureDefinition
from adibas.data.trends import Trend, TrendPoint

Key: TypeAlias = tuple[str, str]
"""View and measure."""


@dataclass(frozen=True, slots=True)
class Visit:
    """One session of a patient, measured.

    Attributes
    ----------
    session_id : str
        Which.
    taken_utc : datetime
        When it began.
    captures : tuple of ProtocolMeasures
        All by one protocol in one plane; of several captures of one view the last counts.
    """

    session_id: str
    taken_utc: datetime
    captures: tuple[ProtocolMeasures, ...]


def trends_of(
    visits: Sequence[Visit], mdc95: Mapping[Key, float] | None = None
) -> tuple[Trend, ...]:
    """Return each measure that has a value in any session, in the protocol's order by view.

    Parameters
    ----------
    visits : sequence of Visit
        In any order.
    mdc95 : Mapping, optional
        Smallest detectable change of each (view, measure), in its unit.
    """
    known = mdc95 or {}
    points: dict[Key, list[TrendPoint]] = {}
    definitions: dict[Key, MeasureDefinition] = {}
    for visit in sorted(visits, key=lambda one: one.taken_utc):
        for key, (definition, found) in _values(visit).items():
            definitions[key] = definition
            line = points.setdefault(key, [])
            line.append(_point(visit, definition, found, line))
    return tuple(
        Trend(definitions[key], key[0], tuple(line), known.get(key)) for key, line in points.items()
    )


def _values(visit: Visit) -> dict[Key, tuple[MeasureDefinition, Estimate]]:
    last = {
        (capture.view, result.definition.measure_id): result
        for capture in visit.captures
        for result in capture.results
    }
    return {
        key: (result.definition, result.main)
        for key, result in last.items()
        if result.main is not None
    }


def _point(
    visit: Visit, definition: MeasureDefinition, found: Estimate, before: Sequence[TrendPoint]
) -> TrendPoint:
    """Return a value in its unit; an angle goes the shorter way round from the first one."""
    per_unit = definition.per_unit
    shift = 0.0
    if before and KINDS[definition.kind].quantity == "angle":
        change = found.value - before[0].value * per_unit
        shift = math.remainder(change, math.tau) - change
    low, high = found.interval
    return TrendPoint(
        visit.session_id,
        visit.taken_utc,
        (found.value + shift) / per_unit,
        ((low + shift) / per_unit, (high + shift) / per_unit),
    )
