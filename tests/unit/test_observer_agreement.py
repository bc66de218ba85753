"""Agreement of observers: what must hold for any codings, and tables done by hand."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from adibas.behaviour import interval_agreement as ioa
from adibas.behaviour.agreement import AgreementParams, agreement, interval_values
from adibas.behaviour.budget import shared_ms
from adibas.behaviour.chance import (
    cohen_kappa,
    event_kappa,
    fleiss_kappa,
    gwet_ac1,
    pabak,
    without_corner,
)
from adibas.behaviour.matching import matched
from adibas.behaviour.units import lasting_at, unit_middles
from adibas.data.coding import Coding
from adibas.data.ethogram import Behaviour, Ethogram
from adibas.errors import BehaviourError
from tests.unit.coding_samples import ETHOGRAM, coding, codings

counts = arrays(np.int64, (3, 3), elements=st.integers(0, 30)).map(lambda a: a.astype(float))


@given(counts)
def test_who_is_first_does_not_matter(table):
    for coefficient in (cohen_kappa, pabak, gwet_ac1):
        one, other = coefficient(table), coefficient(table.T)
        if one.value is None:
            assert other.value is None
            assert one.reason is not None
        else:
            assert one.value == pytest.approx(other.value)


@given(counts)
def test_kappa_is_that_of_all_pairs_of_ratings(table):
    """Brute force over ratings: 1 - observed over expected disagreement."""
    rows = [i for i, row in enumerate(table) for n in row for _ in range(int(n))]
    columns = [j for row in table for j, n in enumerate(row) for _ in range(int(n))]
    found = cohen_kappa(table)
    if not rows:
        assert found.value is None
        return
    apart = np.mean(np.array(rows) != np.array(columns))
    chance = np.mean(np.array(rows)[:, None] != np.array(columns)[None])
    if chance == 0:
        assert found.value is None
        assert "one category alone" in found.reason.text
    else:
        assert found.value == pytest.approx(1 - apart / chance)


@given(arrays(np.int64, (3, 3), elements=st.integers(1, 30)))
def test_chance_without_a_corner_keeps_margins_and_independence(table):
    shares = table / table.sum()
    shares[-1, -1] = 0.0
    fitted = without_corner(shares)
    np.testing.assert_allclose(fitted.sum(axis=0), shares.sum(axis=0), atol=1e-9)
    np.testing.assert_allclose(fitted.sum(axis=1), shares.sum(axis=1), atol=1e-9)
    # All odds of cells that may be filled are 1.
    assert fitted[0, 0] * fitted[1, 1] == pytest.approx(fitted[0, 1] * fitted[1, 0])
    assert fitted[0, 0] * fitted[1, 2] == pytest.approx(fitted[0, 2] * fitted[1, 0])


def test_observers_who_saw_no_event_alike_agree_as_by_chance_whoever_is_first():
    table = np.array([[0.0, 1.0], [2.0, 0.0]])
    for either in (table, table.T):
        assert event_kappa(either).value == pytest.approx(0.0, abs=1e-12)


def kappa_of_judgements(table):
    """Kappa as EasyDIAg and ELAN find it: from a list of judgements, chance fitted in 20 rounds.

    Source: Holle & Rein (2015); the counting as in their program, which says that it follows GSEQ
    5.1 where matched events are scored double, and as in ELAN.
    """
    last = len(table) - 1
    judgements = []
    for (row, column), n in np.ndenumerate(table):
        observers = 1 if last in (row, column) else 2  # whose events these are
        judgements += [(row, column)] * (int(n) * observers)
    rows, columns = (
        np.bincount(some, minlength=last + 1) for some in zip(*judgements, strict=True)
    )
    fitted = np.ones(table.shape)
    fitted[-1, -1] = 0.0
    for _ in range(20):
        fitted *= (rows / fitted.sum(axis=1))[:, None]
        fitted *= columns / fitted.sum(axis=0)
    agreed = np.mean([row == column for row, column in judgements])
    chance = np.trace(fitted) / len(judgements)
    return len(judgements), (agreed - chance) / (1 - chance)


@given(arrays(np.int64, (4, 4), elements=st.integers(1, 12)))
def test_every_event_of_either_observer_is_one_judgement(table):
    table = table.astype(float)
    table[-1, -1] = 0.0
    found = event_kappa(table)
    n, kappa = kappa_of_judgements(table)
    assert found.n == n
    assert found.value == pytest.approx(kappa, abs=1e-6)


def test_events_of_one_kind_cannot_have_a_kappa():
    assert event_kappa(np.array([[5.0, 0.0], [0.0, 0.0]])).value is None


@pytest.mark.parametrize(
    ("coefficient", "nothing"),
    [
        (cohen_kappa, np.zeros((2, 2))),
        (pabak, np.zeros((2, 2))),
        (gwet_ac1, np.zeros((2, 2))),
        (event_kappa, np.zeros((2, 2))),
        (fleiss_kappa, np.zeros((0, 2))),
    ],
)
def test_nothing_counted_has_a_reason_and_no_number(coefficient, nothing):
    found = coefficient(nothing)
    assert found.value is None
    assert "Nothing was counted" in found.reason.text


def test_one_rater_and_one_category_have_a_reason():
    assert "two observers" in fleiss_kappa(np.array([[1.0, 0.0]])).reason.text
    assert "one category alone" in gwet_ac1(np.array([[4.0]])).reason.text
    with pytest.raises(ValueError, match="same number"):
        fleiss_kappa(np.array([[1.0, 1.0], [1.0, 0.0]]))


def test_interval_agreements_of_a_session_done_by_hand():
    """Five intervals with counts 2 0 3 1 0 against 2 1 1 1 0."""
    first, second = [2, 0, 3, 1, 0], [2, 1, 1, 1, 0]
    assert ioa.total_count(first, second).value == pytest.approx(5 / 6)
    assert ioa.exact_count(first, second).value == pytest.approx(3 / 5)
    assert ioa.mean_count(first, second).value == pytest.approx((1 + 0 + 1 / 3 + 1 + 1) / 5)
    scores = [[count > 0 for count in some] for some in (first, second)]
    assert ioa.interval_by_interval(*scores).value == pytest.approx(4 / 5)
    assert ioa.scored_intervals(*scores).value == pytest.approx(3 / 4)
    assert ioa.unscored_intervals(*scores).value == pytest.approx(1 / 2)
    assert ioa.total_duration([30_000], [20_000, 5_000]).value == pytest.approx(25 / 30)
    assert ioa.mean_duration([30_000, 10_000], [15_000]).value == pytest.approx(0.25)


def test_what_nobody_saw_has_a_reason():
    assert "Neither" in ioa.total_count([0, 0], [0, 0]).reason.text
    assert "Neither" in ioa.total_duration([], []).reason.text
    assert "Neither" in ioa.mean_duration([], []).reason.text
    assert "unscored" in ioa.scored_intervals([False], [False]).reason.text
    assert "every interval" in ioa.unscored_intervals([True], [True]).reason.text


def figure(result, method, behaviour="", subject=""):
    return next(
        one.coefficient
        for one in result.figures
        if (one.coefficient.method, one.behaviour, one.subject) == (method, behaviour, subject)
    )


@settings(max_examples=25)
@given(codings(), codings())
def test_agreement_does_not_depend_on_who_is_first(one, other):
    here, there = agreement([one, other]), agreement([other, one])
    for mine, theirs in zip(here.figures, there.figures, strict=True):
        assert (mine.behaviour, mine.subject) == (theirs.behaviour, theirs.subject)
        if mine.coefficient.value is None:
            assert theirs.coefficient.value is None
            assert mine.coefficient.reason is not None
        else:
            assert mine.coefficient.value == pytest.approx(theirs.coefficient.value, abs=1e-9)


@settings(max_examples=25)
@given(codings())
def test_an_observer_agrees_with_himself(one):
    result = agreement([one, one])
    values = [found.coefficient.value for found in result.figures]
    assert all(value is None or value == pytest.approx(1.0) for value in values)
    assert result.differences == ()
    assert all(match.is_agreed for match in result.matches)


@settings(max_examples=25)
@given(codings(), codings(), st.integers(0, 4000))
def test_every_event_is_matched_once_and_within_the_tolerance(one, other, tolerance_ms):
    pairs = matched(one, other, tolerance_ms)
    assert sorted(p.first.begin_ms for p in pairs if p.first) == sorted(
        o.begin_ms for o in one.occurrences
    )
    assert len([p for p in pairs if p.second]) == len(other.occurrences)
    for pair in pairs:
        if pair.first and pair.second:
            assert abs(pair.first.begin_ms - pair.second.begin_ms) <= tolerance_ms
            assert pair.first.subject == pair.second.subject


def most_pairs(mine, theirs, tolerance):
    """Try every way to pair the shorter list with the longer one."""
    short, long = sorted((mine, theirs), key=len)
    return max(
        sum(abs(a - b) <= tolerance for a, b in zip(short, order, strict=True))
        for order in itertools.permutations(long, len(short))
    )


@given(
    st.lists(st.integers(0, 20), max_size=4, unique=True),
    st.lists(st.integers(0, 20), max_size=4, unique=True),
    st.integers(0, 5),
)
def test_as_many_events_are_matched_as_can_be(mine, theirs, tolerance):
    first, second = (coding(*[("nods", at, at) for at in some]) for some in (mine, theirs))
    pairs = matched(first, second, 1000 * tolerance)
    assert sum(pair.is_agreed for pair in pairs) == most_pairs(mine, theirs, tolerance)


def test_time_unit_kappa_is_that_of_a_table_done_by_hand():
    """Seconds 0-30 against 10-40 of 60: 20 both, 10 + 10 one of them, 20 neither."""
    one, other = coding(("seated", 0, 30)), coding(("seated", 10, 40))
    result = agreement([one, other], AgreementParams(unit_ms=1000))
    found = figure(result, "time-unit-kappa", "seated")
    assert found.n == 60
    assert found.observed == pytest.approx(40 / 60)
    assert found.value == pytest.approx(cohen_kappa(np.array([[20.0, 10], [10, 20]])).value)
    table = result.tables[0]
    assert sorted(table.names) == ["", "seated"]
    assert table.counts.sum() == 60  # of the one subject that anybody saw
    assert [(d.begin_ms, d.end_ms, d.is_first) for d in result.differences] == [
        (0, 10_000, True),
        (30_000, 40_000, False),
    ]


@settings(max_examples=25)
@given(codings(), codings())
def test_differences_and_common_time_are_all_that_was_seen(one, other):
    result = agreement([one, other])
    for name, subject in (("seated", "child"), ("up", "")):
        spans = [[(o.begin_ms, o.end_ms) for o in some.of(name, subject)] for some in (one, other)]
        alone = sum(
            d.end_ms - d.begin_ms
            for d in result.differences
            if (d.behaviour, d.subject) == (name, subject)
        )
        total = sum(end - begin for some in spans for begin, end in some)
        assert alone + 2 * shared_ms(*spans) == total


def test_a_state_lasts_from_its_first_millisecond_to_before_its_last():
    times = np.array([0, 999, 1000, 1999, 2000])
    found = lasting_at(coding(("seated", 1, 2)), "seated", "", times)
    assert found.tolist() == [False, False, True, True, False]
    assert not lasting_at(coding(), "seated", "", times).any()
    assert unit_middles((0, 2500), 1000).tolist() == [500, 1500]
    with pytest.raises(ValueError, match="must last"):
        unit_middles((0, 10), 0)


def test_fleiss_takes_all_observers():
    three = [coding(("seated", 0, end), observer=str(end)) for end in (30, 30, 40)]
    result = agreement(three)
    assert figure(result, "fleiss-kappa").n == 60
    assert 0.5 < figure(result, "fleiss-kappa").value < 1.0
    assert result.observers == ("30", "30", "40")


def test_only_the_time_that_all_watched_is_compared():
    one, other = coding(("seated", 0, 30)), coding(("seated", 0, 20), end_ms=20_000)
    result = agreement([one, other])
    assert result.within_ms == (0, 20_000)
    assert "from 0.000 to 20.000 s" in result.notices[0].text
    assert "Nobody coded anything of child, peer" in result.notices[1].text
    assert figure(result, "time-unit-kappa", "seated").observed == 1.0


def test_codings_that_cannot_be_compared_are_told():
    with pytest.raises(BehaviourError, match="two observers"):
        agreement([coding()])
    with pytest.raises(BehaviourError, match="share no time"):
        agreement([coding(), Coding("x", ETHOGRAM, 70_000, 80_000)])
    point = Ethogram("e", (Behaviour("seated", "point"),))
    with pytest.raises(BehaviourError, match="state for one observer"):
        agreement([coding(), Coding("x", point, 0, 60_000)])
    with pytest.raises(ValueError, match="must last"):
        AgreementParams(unit_ms=0)


def test_an_ethogram_of_points_has_no_time_to_compare():
    scheme = Ethogram("e", (Behaviour("nods", "point"),))
    result = agreement([Coding("x", scheme, 0, 1000), Coding("x", scheme, 0, 1000)])
    assert "is a state" in figure(result, "time-unit-kappa").reason.text


def test_counts_and_seconds_of_intervals_are_those_of_the_session():
    one = coding(("seated", 5, 25), ("nods", 7, 7))
    counts, seconds = interval_values([one, coding()], "seated", "", 10_000)
    assert counts[:, 0].tolist() == [1, 0, 0, 0, 0, 0]
    assert seconds[:, 0].tolist() == [5, 10, 5, 0, 0, 0]
    assert not seconds[:, 1].any()


def test_what_ended_before_all_watched_is_no_event_of_the_time_that_they_share():
    early = coding(("seated", 0, 10, "child"), ("fidgets", 5, 15, "child"), end_ms=20_000)
    late = replace(coding(("fidgets", 10, 15, "child"), end_ms=20_000), begin_ms=10_000)
    result = agreement([early, late])
    assert result.within_ms == (10_000, 20_000)
    assert all(match.is_agreed for match in result.matches)
    assert result.differences == ()
