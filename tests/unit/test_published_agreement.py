"""Agreement of observers against worked examples that others published."""

import numpy as np
import pytest

from adibas.behaviour import interval_agreement as ioa
from adibas.behaviour.agreement import AgreementParams, agreement
from adibas.behaviour.chance import cohen_kappa, event_kappa, fleiss_kappa, gwet_ac1, pabak
from adibas.behaviour.matching import matched
from adibas.data.coding import Coding, Occurrence
from adibas.data.ethogram import Behaviour, Ethogram
from tests.unit.coding_samples import coding

COHEN_1960 = np.array([[0.25, 0.13, 0.12], [0.12, 0.02, 0.16], [0.03, 0.15, 0.02]]) * 100
"""The example of Cohen (1960): kappa -.09."""
FEINSTEIN_CICCHETTI = (([[40, 9], [6, 45]], 0.70), ([[80, 10], [5, 5]], 0.32))
"""High agreement but low kappa I (1990), for kappa; both tables agree in 85 %."""
GWET_2002 = np.array([[118.0, 5.0], [2.0, 0.0]])
"""Kappa statistic is not satisfactory for assessing the extent of agreement (2002)."""
FLEISS = np.array(
    [
        *([0, 0, 0, 0, 14], [0, 2, 6, 4, 2], [0, 0, 3, 5, 6], [0, 3, 9, 2, 0], [2, 2, 8, 1, 1]),
        *([7, 7, 0, 0, 0], [3, 2, 6, 3, 0], [2, 5, 3, 2, 2], [6, 5, 2, 1, 0], [0, 2, 2, 3, 7]),
    ],
    float,
)
"""The example of ten subjects and fourteen raters that is taught with Fleiss' kappa: .210."""


def test_kappa_of_cohens_own_example():
    found = cohen_kappa(COHEN_1960)
    assert (found.observed, found.expected) == pytest.approx((0.29, 0.35))
    assert found.value == pytest.approx(-0.09, abs=0.005)


@pytest.mark.parametrize(("table", "kappa"), FEINSTEIN_CICCHETTI)
def test_kappa_falls_with_prevalence_and_pabak_does_not(table, kappa):
    table = np.array(table, float)
    assert cohen_kappa(table).value == pytest.approx(kappa, abs=0.005)
    assert pabak(table).value == pytest.approx(0.70)


def test_gwets_own_example():
    assert gwet_ac1(GWET_2002).value == pytest.approx(0.941, abs=0.0005)
    assert cohen_kappa(GWET_2002).value == pytest.approx(-0.023, abs=0.0005)


def test_kappa_of_the_example_in_easydiag():
    """The example that Holle & Rein give in their program (EasyDIAg, Cohenskappa.m): 0.429."""
    table = np.array([[53.0, 5, 2], [11, 14, 5], [1, 6, 3]])
    assert cohen_kappa(table).value == pytest.approx(0.429, abs=0.0005)
    # Where nobody missed an event, that of events is the same; each pair is two judgements.
    of_events = event_kappa(np.pad(table, ((0, 1), (0, 1))))
    assert of_events.value == pytest.approx(0.429, abs=0.0005)
    assert of_events.n == 2 * table.sum()


def test_fleiss_example():
    assert fleiss_kappa(FLEISS).value == pytest.approx(0.210, abs=0.0005)


def of_behaviour(result, behaviour):
    """Return the coefficients of one behaviour by method."""
    found = [one.coefficient for one in result.figures if one.behaviour == behaviour]
    return {one.method: one for one in found}


def minutes(*counts):
    """Code as many nods in each minute as `counts` says."""
    events = [
        ("nods", 60 * minute + 10 * number, 60 * minute + 10 * number)
        for minute, count in enumerate(counts)
        for number in range(count)
    ]
    return coding(*events, end_ms=60_000 * len(counts))


def test_counts_of_the_example_by_reed_and_azulay():
    """Behavior Analysis in Practice 4 (2011), figure 1: fifteen intervals of a minute.

    Observer 1 counts one in each of minutes 1 to 3 and two in minute 4, observer 2 one in minute
    4 and four in minute 15: in all 100 %, in intervals 10.5 / 15 = 70 %, exactly 10 of 15.
    """
    codings_of_it = [minutes(1, 1, 1, 2, *[0] * 11), minutes(0, 0, 0, 1, *[0] * 10, 4)]
    result = agreement(codings_of_it, AgreementParams(interval_ms=60_000))
    values = of_behaviour(result, "nods")
    assert values["total-count"].value == 1.0
    assert values["mean-count-per-interval"].value == pytest.approx(0.70)
    assert values["exact-count-per-interval"].value == pytest.approx(10 / 15)
    assert values["exact-count-per-interval"].n == 15


def test_intervals_of_the_example_by_reed_and_azulay():
    """The same, figure 2: of seven intervals they differ in the first and the last.

    In intervals 2 to 4 neither saw anything, in 5 and 6 both did: interval by interval 5 of 7
    (71.4 %), scored 2 of 4 (50 %), unscored 3 of 5 (60 %).
    """
    codings_of_it = [minutes(1, 0, 0, 0, 1, 1, 0), minutes(0, 0, 0, 0, 1, 1, 1)]
    result = agreement(codings_of_it, AgreementParams(interval_ms=60_000))
    values = of_behaviour(result, "nods")
    assert values["interval-by-interval"].value == pytest.approx(0.714, abs=0.0005)
    assert values["scored-intervals"].value == pytest.approx(0.50)
    assert values["scored-intervals"].n == 4
    assert values["unscored-intervals"].value == pytest.approx(0.60)
    assert values["unscored-intervals"].n == 5


@pytest.mark.parametrize(
    ("shares", "mean"), [((0.997, 0.023, 0.692, 0.927), 0.66), ((0.75, 1.0, 0.8), 0.85)]
)
def test_mean_of_durations_of_published_examples(shares, mean):
    """Agreement of each occurrence, and the mean of them.

    Reed & Azulay (2011), figure 3: 99.7, 2.3, 69.2 and 92.7 % give 66 %; Triad Behavioral
    Analysis, Interobserver agreement part 5: 0.75, 1.0 and 0.8 give 85 %.
    """
    durations_ms = [round(1000 * share) for share in shares]
    found = ioa.mean_duration(durations_ms, [1000] * len(shares))
    assert found.value == pytest.approx(mean, abs=0.005)


def test_equal_totals_agree_although_nobody_saw_the_same():
    """The classic warning, as BxM Education puts it: seconds 1-30 against 31-60, 100 %."""
    result = agreement([coding(("seated", 0, 30)), coding(("seated", 30, 60))])
    values = of_behaviour(result, "seated")
    assert values["total-duration"].value == 1.0
    assert values["interval-by-interval"].value == 0.0
    assert values["time-unit-kappa"].value == pytest.approx(-1.0)


@pytest.mark.parametrize(("tolerance_ms", "cases"), [(1000, 4), (2000, 3)])
def test_the_tolerance_says_how_many_cases_there_are(tolerance_ms, cases):
    """Jansen, Elbers, Meyer & Wiertz, Measuring Behavior 2002, figure 2.

    Walk 0 s, jog 5 s, hold 12 s against walk 0 s, run 7 s, hold 11 s: four cases where jog and run
    are different events, three where they are the same one, named differently.
    """
    scheme = Ethogram("e", tuple(Behaviour(n, "point") for n in ("walk", "jog", "run", "hold")))
    first, second = (
        Coding("x", scheme, 0, 20_000, tuple(Occurrence(name, at, at) for name, at in events))
        for events in (
            (("walk", 0), ("jog", 5000), ("hold", 12_000)),
            (("walk", 0), ("run", 7000), ("hold", 11_000)),
        )
    )
    pairs = matched(first, second, tolerance_ms)
    assert len(pairs) == cases
    assert sum(pair.is_agreed for pair in pairs) == 2
    confused = [pair for pair in pairs if pair.first and pair.second and not pair.is_agreed]
    assert [(pair.first.behaviour, pair.second.behaviour) for pair in confused] == (
        [("jog", "run")] if cases == 3 else []
    )
