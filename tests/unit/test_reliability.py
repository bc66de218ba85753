"""Repeats, correlations and changes against published examples, closed forms and simulation."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.data.protocol_measures import (
    Estimate,
    MeasureResult,
    PlaneChoice,
    ProtocolMeasures,
    VerticalOrigin,
)
from adibas.data.reliability import Repeat, Verdict
from adibas.errors import ProtocolError
from adibas.measures.comparison import compare_sessions
from adibas.measures.protocol_store import find_protocol
from adibas.measures.reliability import (
    agreement_of,
    detectable_change,
    icc_2_1,
    icc_3_1,
    mean_squares,
    reliability_of,
    unwrap_repeats,
    within_subject_sd,
)

SHROUT_FLEISS = np.array(
    [[9, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9], [6, 2, 4, 7]], float
)
"""Six targets and four judges: Shrout & Fleiss 1979, table 2."""

LARGE = (494, 395, 516, 434, 476, 557, 413, 442, 650, 433, 417, 656, 267, 478, 178, 423, 427)
LARGE_AGAIN = (490, 397, 512, 401, 470, 611, 415, 431, 638, 429, 420, 633, 275, 492, 165, 372, 421)
MINI = (512, 430, 520, 428, 500, 600, 364, 380, 658, 445, 432, 626, 260, 477, 259, 350, 451)
"""Peak flow by two meters in l/min: Bland & Altman 1986, table 1."""


def test_mean_squares_are_those_of_shrout_and_fleiss():
    assert mean_squares(SHROUT_FLEISS) == pytest.approx((11.24, 32.49, 1.02), abs=0.005)


def test_correlations_are_those_of_shrout_and_fleiss():
    assert icc_2_1(SHROUT_FLEISS).value == pytest.approx(0.29, abs=0.005)
    assert icc_3_1(SHROUT_FLEISS).value == pytest.approx(0.71, abs=0.005)
    assert icc_2_1(SHROUT_FLEISS).interval == pytest.approx((0.02, 0.76), abs=0.005)
    assert icc_3_1(SHROUT_FLEISS).interval == pytest.approx((0.34, 0.95), abs=0.005)


def test_limits_of_agreement_are_those_of_bland_and_altman():
    found = agreement_of(list(zip(LARGE, MINI, strict=True)))
    assert found.bias == pytest.approx(-2.1, abs=0.05)
    assert found.sd == pytest.approx(38.8, abs=0.05)
    # Printed with the factor 2 (-79.7 to 75.5); here it is 1.96.
    assert found.limits == pytest.approx((-2.12 - 1.96 * 38.77, -2.12 + 1.96 * 38.77), abs=0.05)
    assert found.bias_interval == pytest.approx((-22.0, 17.8), abs=0.1)
    low, high = found.limits_intervals
    assert (low[1] - low[0]) / 2 == pytest.approx(34.5, abs=0.2)
    assert (high[1] - high[0]) / 2 == pytest.approx((low[1] - low[0]) / 2)
    assert found.means[0] == 503.0
    with pytest.raises(ValueError, match="two pairs"):
        agreement_of([(1.0, 2.0)])


def test_the_error_of_repeats_of_the_large_meter_is_that_of_bland_and_altman():
    sem, _interval = within_subject_sd(list(zip(LARGE, LARGE_AGAIN, strict=True)))
    assert sem == pytest.approx(15.3, abs=0.05)


def test_a_published_sem_gives_its_published_detectable_change():
    """Ruivo et al. 2014: 2.72 and 7.54, 2.35 and 6.51 degrees."""
    assert detectable_change(2.72, math.inf) == pytest.approx(7.54, abs=0.005)
    assert detectable_change(2.35, math.inf) == pytest.approx(6.51, abs=0.005)


@pytest.mark.parametrize("n_patients", [1, 3, 10])
def test_five_of_a_hundred_unchanged_patients_are_beyond_it_however_few_the_repeats(n_patients):
    rng = np.random.default_rng(n_patients)
    n_beyond = n_judged = 0
    for _clinic in range(3000):
        pairs = rng.normal(0, 2, (n_patients, 2)).tolist()
        found = reliability_of(
            [
                Repeat(f"P{n}", value, k > 0)
                for n, pair in enumerate(pairs)
                for k, value in enumerate(pair)
            ]
        )
        changes = np.diff(rng.normal(0, 2, (10, 2)))
        n_beyond += int((np.abs(changes) > found.mdc95).sum())
        n_judged += len(changes)
    assert n_beyond / n_judged == pytest.approx(0.05, abs=0.012)


def test_the_figures_tell_how_many_patients_they_rest_on():
    """One with the markers placed anew, twenty with the same markers."""
    many = [replace(one, patient=f"S{one.patient}") for one in repeats(20, 2, is_placed_anew=False)]
    found = reliability_of([*many, *repeats(1, 3)])
    assert (found.n_patients, found.n_values) == (1, 3)
    assert found.sem == reliability_of(repeats(1, 3)).sem


def test_correlations_are_one_without_error_and_differ_where_a_judge_is_stricter():
    same = np.repeat(np.arange(12.0)[:, None], 3, axis=1)
    assert icc_2_1(same).value == icc_3_1(same).value == 1.0
    assert icc_2_1(same).interval == icc_3_1(same).interval == (1.0, 1.0)
    stricter = same + np.array([0.0, 5.0, 0.0])
    assert icc_3_1(stricter).value == 1.0
    assert icc_2_1(stricter).value < 0.7


@given(st.integers(0, 2**32 - 1), st.floats(0.5, 20), st.floats(-100, 100))
def test_correlations_do_not_depend_on_the_unit(seed, scale, shift):
    table = np.random.default_rng(seed).normal(0, 1, (11, 2)) + np.arange(11)[:, None]
    for icc in (icc_2_1, icc_3_1):
        found, moved = icc(table), icc(scale * table + shift)
        assert moved.value == pytest.approx(found.value, abs=1e-6)
        assert found.interval[0] <= found.value <= found.interval[1]


def test_intervals_hold_the_truth():
    """Patients with variance 4, occasions 0.5, error 1, twelve patients and three occasions."""
    rng = np.random.default_rng(3)
    held = {"2,1": 0, "3,1": 0, "sem": 0}
    n_cases = 2000
    for _case in range(n_cases):
        patients, errors = rng.normal(0, 2, (12, 1)), rng.normal(0, 1, (12, 3))
        low, high = icc_2_1(patients + errors + rng.normal(0, math.sqrt(0.5), 3)).interval
        held["2,1"] += low <= 4 / 5.5 <= high
        low, high = icc_3_1(patients + errors).interval
        held["3,1"] += low <= 4 / 5 <= high
        low, high = within_subject_sd((patients + errors).tolist())[1]
        held["sem"] += low <= 1 <= high
    shares = {name: count / n_cases for name, count in held.items()}
    assert shares["3,1"] == pytest.approx(0.95, abs=0.015)
    assert shares["sem"] == pytest.approx(0.95, abs=0.015)
    assert shares["2,1"] == pytest.approx(0.95, abs=0.03)  # an approximation by its authors


def test_a_table_needs_two_of_each():
    with pytest.raises(ValueError, match="two patients"):
        mean_squares(np.ones((1, 3)))
    with pytest.raises(ValueError, match="two values"):
        within_subject_sd([[1.0]])
    with pytest.raises(ValueError, match="two values"):
        within_subject_sd([])


def repeats(n_patients, n_repeats, *, is_placed_anew=True, sd=1.0):
    rng = np.random.default_rng(1)
    return [
        Repeat(f"P{patient}", 3.0 * patient + rng.normal(0, sd), is_placed_anew and number > 0)
        for patient in range(n_patients)
        for number in range(n_repeats)
    ]


def test_ten_patients_with_two_repeats_suffice_and_nine_do_not():
    enough, few = reliability_of(repeats(10, 2)), reliability_of(repeats(9, 2))
    assert enough.reasons == ()
    assert enough.icc_2_1.value > 0.9
    assert len(enough.agreement.differences) == 10
    assert enough.mdc95 == pytest.approx(2.228 * math.sqrt(2) * enough.sem, rel=1e-3)  # t of 10
    assert enough.sem_interval[0] < enough.sem < enough.sem_interval[1]
    assert (few.icc_2_1, few.icc_3_1) == (None, None)
    assert few.sem is not None
    assert few.reasons[0].text == (
        "An intraclass correlation takes 10 patients with two repeats each, and there are 9."
    )


def test_repeats_with_the_same_markers_give_no_detectable_change():
    same = reliability_of(repeats(10, 3, is_placed_anew=False))
    assert same.sem is not None
    assert same.mdc95 is None
    assert "placed anew" in same.reasons[0].text


def test_only_placings_count_where_markers_were_placed_anew():
    """Captures that follow at once would make the error look smaller than it is."""
    found = [
        Repeat(f"P{patient}", patient + 2.0 * (number // 2), number == 2)
        for patient in range(10)
        for number in range(4)
    ]
    assert reliability_of(found).sem == pytest.approx(math.sqrt(2.0))


def test_an_angle_about_180_degrees_repeats_as_well_as_any_other():
    turned = [
        replace(one, value=(one.value + 170.0 + 180.0) % 360.0 - 180.0) for one in repeats(10, 3)
    ]
    assert min(one.value for one in turned) < -150.0
    found, expected = reliability_of(unwrap_repeats(turned)), reliability_of(repeats(10, 3))
    assert found.sem == pytest.approx(expected.sem)
    assert found.icc_2_1.value == pytest.approx(expected.icc_2_1.value)
    assert found.agreement.differences == pytest.approx(expected.agreement.differences)
    assert unwrap_repeats([]) == []


def test_single_values_and_values_without_spread_are_told():
    assert "No patient was measured twice" in reliability_of(repeats(20, 1)).reasons[0].text
    constant = [Repeat(f"P{n // 2}", 5.0, n % 2 == 1) for n in range(20)]
    found = reliability_of(constant)
    assert found.sem == found.mdc95 == 0.0
    assert "do not differ" in found.reasons[0].text


SAPO = find_protocol("sapo-1")


def capture(degrees, *, view="anterior", protocol=SAPO, half=0.5, **options):
    """One capture whose angles are all alike; None where nothing was measured."""
    unit = math.radians(1)
    results = []
    for definition in protocol.measures_of(view):
        one = None
        if degrees is not None and definition.unit == "deg":
            one = Estimate(degrees * unit, ((degrees - half) * unit, (degrees + half) * unit))
        results.append(MeasureResult(definition, one, one))
    settings = {"plane": PlaneChoice.SENSOR, "vertical": VerticalOrigin.GRAVITY} | options
    return ProtocolMeasures(protocol, view, settings["plane"], settings["vertical"], tuple(results))


def test_changes_are_marked_against_the_detectable_one():
    mdc95 = {("anterior", "ANT.ACR.H"): 2.5, ("anterior", "ANT.HEAD.H"): 3.5}
    found = compare_sessions([capture(1.0)], [capture(4.0)], mdc95)
    one = {change.measure_id: change for change in found.changes}
    assert one["ANT.ACR.H"].verdict is Verdict.BEYOND
    assert one["ANT.HEAD.H"].verdict is Verdict.INSIDE
    assert one["ANT.ASIS.H"].verdict is Verdict.UNKNOWN
    assert one["ANT.ACR.H"].difference == pytest.approx(3.0)
    reach = math.hypot(0.5, 0.5)
    assert one["ANT.ACR.H"].interval == pytest.approx((3.0 - reach, 3.0 + reach))
    assert one["ANT.LLD"].difference is None
    assert (found.n_judged, found.n_beyond) == (2, 1)
    assert found.expected_by_chance == pytest.approx(0.1)


def test_a_change_over_180_degrees_goes_the_shorter_way():
    (one, *_rest) = compare_sessions([capture(179.0)], [capture(-179.0)]).changes
    assert one.difference == pytest.approx(2.0)


def test_a_view_of_one_session_alone_has_no_change():
    found = compare_sessions([capture(1.0)], [capture(1.0, view="posterior")])
    assert {change.difference for change in found.changes} == {None}
    assert len(found.changes) == 14
    assert compare_sessions([capture(None)], [capture(1.0)]).changes[0].before is None


@pytest.mark.parametrize(
    ("other", "told"),
    [
        ([], "without measures"),
        ([capture(1.0, protocol=find_protocol("upper-quadrant"))], "different protocols"),
        ([capture(1.0, plane=PlaneChoice.ASIS)], "different planes"),
        ([capture(1.0, vertical=VerticalOrigin.UNKNOWN)], "vertical was not measured"),
    ],
)
def test_what_cannot_be_compared_is_refused_in_words(other, told):
    with pytest.raises(ProtocolError, match=told):
        compare_sessions([capture(1.0)], other)
