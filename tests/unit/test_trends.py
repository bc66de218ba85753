"""A measure from session to session: values, intervals, what is detectable."""

import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest

from adibas.data.protocol_measures import (
    Estimate,
    MeasureResult,
    PlaneChoice,
    ProtocolMeasures,
    VerticalOrigin,
)
from adibas.data.reliability import Verdict
from adibas.data.trends import Trend, TrendPoint
from adibas.measures.protocol_store import find_protocol
from adibas.measures.trends import Visit, trends_of

SAPO = find_protocol("sapo-1")
JOINTS = find_protocol("joints-15")
ACROMIA = next(one for one in SAPO.measures if one.measure_id == "ANT.ACR.H")
START = datetime(2026, 1, 5, 9, 0, tzinfo=UTC)


def measured(deg, definition=ACROMIA):
    """One capture from the front with one angle, half a degree sure."""
    estimate = None
    if deg is not None:
        value, half = math.radians(deg), math.radians(0.5)
        estimate = Estimate(value, (value - half, value + half))
    result = MeasureResult(definition, estimate, estimate)
    return ProtocolMeasures(SAPO, "anterior", PlaneChoice.SENSOR, VerticalOrigin.GRAVITY, (result,))


def visit(number, *degrees):
    taken = START + timedelta(days=7 * number)
    return Visit(f"s{number}", taken, tuple(measured(deg) for deg in degrees))


def trend(*values, mdc95=None):
    points = tuple(
        TrendPoint(f"s{n}", START + timedelta(days=n), value, (value - 0.5, value + 0.5))
        for n, value in enumerate(values)
    )
    return Trend(ACROMIA, "anterior", points, mdc95)


def test_values_stand_in_the_order_of_time_in_the_measures_unit():
    (found,) = trends_of([visit(2, 3.0), visit(0, 1.0), visit(1, 2.0)])
    assert [point.session_id for point in found.points] == ["s0", "s1", "s2"]
    assert [point.value for point in found.points] == pytest.approx([1.0, 2.0, 3.0])
    assert found.points[1].interval == pytest.approx((1.5, 2.5))
    assert found.key == ("anterior", "ANT.ACR.H")
    assert found.mdc95 is None


def test_of_several_captures_of_one_view_the_last_counts():
    (found,) = trends_of([visit(0, 1.0, 5.0)])
    assert [point.value for point in found.points] == pytest.approx([5.0])


def test_a_capture_that_was_taken_again_counts_no_more_even_where_the_last_has_no_value():
    assert trends_of([visit(0, 1.0, None)]) == ()


def test_a_session_without_a_value_is_no_point():
    (found,) = trends_of([visit(0, 1.0), visit(1, None), visit(2)])
    assert [point.session_id for point in found.points] == ["s0"]
    assert trends_of([visit(0, None)]) == ()


def test_an_angle_goes_the_shorter_way_round():
    (found,) = trends_of([visit(0, 179.0), visit(1, -178.0), visit(2, -179.0)])
    assert [point.value for point in found.points] == pytest.approx([179.0, 182.0, 181.0])
    assert found.points[1].interval == pytest.approx((181.5, 182.5))


def test_a_length_is_never_turned_round():
    distance = next(one for one in JOINTS.measures if one.kind == "distance")
    metres = [
        Visit(f"s{n}", START + timedelta(n), (_of_length(distance, length),))
        for n, length in enumerate((1.0, 5.0))
    ]
    (found,) = trends_of(metres)
    assert [point.value for point in found.points] == pytest.approx([1000.0, 5000.0])


def _of_length(definition, metres):
    capture = measured(0.0, definition)
    estimate = Estimate(metres, (metres, metres))
    return replace(capture, results=(replace(capture.results[0], spatial=estimate),))


def test_the_band_and_the_verdicts_are_against_the_first_session():
    (found,) = trends_of([visit(0, 1.0), visit(1, 2.0), visit(2, 4.0)], {_key(): 1.5})
    assert found.band == pytest.approx((-0.5, 2.5))
    verdicts = [found.verdict_of(index) for index in range(3)]
    assert verdicts == [Verdict.UNKNOWN, Verdict.INSIDE, Verdict.BEYOND]
    assert found.change_of(2) == pytest.approx(3.0)


def _key():
    return "anterior", "ANT.ACR.H"


def test_without_repeats_nothing_is_judged():
    found = trend(1.0, 100.0)
    assert found.band is None
    assert found.verdict_of(1) is Verdict.UNKNOWN


def test_a_trend_needs_points_in_the_order_of_time():
    with pytest.raises(ValueError, match="needs a point"):
        trend()
    with pytest.raises(ValueError, match="order of time"):
        replace(trend(1.0, 2.0), points=tuple(reversed(trend(1.0, 2.0).points)))


def test_only_measures_that_nobody_named_are_of_every_pair_and_triplet():
    assert all(one.is_one_of_all for one in JOINTS.measures)
    assert not any(one.is_one_of_all for one in SAPO.measures)
