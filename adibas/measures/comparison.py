"""Two sessions of one patient against each other, measure by measure."""

import math
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from adibas.data.protocol_measures import MeasureResult, ProtocolMeasures
from adibas.data.protocols import KINDS
from adibas.data.reliability import Change, Comparison, Verdict
from adibas.errors import ProtocolError

Key: TypeAlias = tuple[str, str]
"""View and measure."""


def compare_sessions(
    before: Sequence[ProtocolMeasures],
    after: Sequence[ProtocolMeasures],
    mdc95: Mapping[Key, float] | None = None,
) -> Comparison:
    """Return the change of every measure.

    Parameters
    ----------
    before, after : sequence of ProtocolMeasures
        The captures of each session; of several captures of one view the last counts.
    mdc95 : Mapping, optional
        Smallest detectable change of each (view, measure), in its unit, of this clinic, operator
        and protocol; a measure without one is marked "not known".

    Raises
    ------
    ProtocolError
        The sessions do not follow one protocol, or not in one plane.
    """
    _check_alike(before, after)
    first, second = _by_measure(before), _by_measure(after)
    known = mdc95 or {}
    keys = (*first, *(key for key in second if key not in first))
    changes = [_change(key, first.get(key), second.get(key), known.get(key)) for key in keys]
    return Comparison(before[0].protocol.protocol_id, tuple(changes))


def _check_alike(before: Sequence[ProtocolMeasures], after: Sequence[ProtocolMeasures]) -> None:
    if not before or not after:
        raise ProtocolError(
            "A session without measures of a protocol cannot be compared. Choose a protocol for it "
            "and name its markers."
        )
    used = {(one.protocol.protocol_id, one.protocol.revision) for one in (*before, *after)}
    if len(used) > 1:
        raise ProtocolError(
            "Sessions of different protocols cannot be compared: {names}. Measure both with one.",
            names=", ".join(sorted(f"{name} ({revision})" for name, revision in used)),
        )
    planes = {one.plane.value for one in (*before, *after)}
    if len(planes) > 1:
        raise ProtocolError(
            "Measures in different planes cannot be compared: {names}. Measure both in one.",
            names=", ".join(sorted(planes)),
        )
    for view in {one.view for one in before} & {one.view for one in after}:
        verticals = {one.vertical.value for one in (*before, *after) if one.view == view}
        if "unknown" in verticals and len(verticals) > 1:
            raise ProtocolError(
                "In one of the sessions the vertical was not measured, so that they cannot be "
                "compared. Calibrate it with the floor."
            )


def _by_measure(captures: Sequence[ProtocolMeasures]) -> dict[Key, MeasureResult]:
    return {
        (capture.view, result.definition.measure_id): result
        for capture in captures
        for result in capture.results
    }


def _change(
    key: Key, before: MeasureResult | None, after: MeasureResult | None, mdc95: float | None
) -> Change:
    definition = next(one.definition for one in (before, after) if one is not None)
    ends = [None if one is None else one.main for one in (before, after)]
    values = [None if one is None else one.value / definition.per_unit for one in ends]
    difference = interval = None
    verdict = Verdict.UNKNOWN
    if ends[0] is not None and ends[1] is not None:
        raw = ends[1].value - ends[0].value
        if KINDS[definition.kind].quantity == "angle":
            raw = math.remainder(raw, math.tau)
        (low_0, high_0), (low_1, high_1) = ends[0].interval, ends[1].interval
        down = math.hypot(ends[1].value - low_1, high_0 - ends[0].value)
        up = math.hypot(high_1 - ends[1].value, ends[0].value - low_0)
        per_unit = definition.per_unit
        difference = raw / per_unit
        interval = ((raw - down) / per_unit, (raw + up) / per_unit)
        if mdc95 is not None:
            verdict = Verdict.BEYOND if abs(difference) > mdc95 else Verdict.INSIDE
    return Change(
        measure_id=key[1],
        name=definition.name.text,
        unit=definition.unit,
        view=key[0],
        before=values[0],
        after=values[1],
        difference=difference,
        interval=interval,
        mdc95=mdc95,
        verdict=verdict,
    )
