"""How far two or more observers agree on the same session: every figure with its method."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.behaviour import interval_agreement as ioa
from adibas.behaviour.budget import Span, bin_spans
from adibas.behaviour.chance import (
    Coefficient,
    cohen_kappa,
    event_kappa,
    fleiss_kappa,
    gwet_ac1,
    pabak,
)
from adibas.behaviour.matching import Difference, Match, differences, match_table, matched
from adibas.behaviour.sampling import samples
from adibas.behaviour.units import (
    combination_counts,
    combination_table,
    combinations,
    lasting_at,
    presence_table,
    unit_middles,
)
from adibas.data.coding import MS_PER_S, Coding, Occurrence
from adibas.data.sentence import Sentence
from adibas.errors import BehaviourError
from adibas.texts import message

METHODS = (
    "time-unit-kappa",
    "time-unit-pabak",
    "time-unit-ac1",
    "fleiss-kappa",
    "event-kappa",
    "total-count",
    "mean-count-per-interval",
    "exact-count-per-interval",
    "interval-by-interval",
    "scored-intervals",
    "unscored-intervals",
    "total-duration",
    "mean-duration-per-occurrence",
    "icc-count",
    "icc-duration",
)
MOST_STATES = 60

NO_STATES = message("No behaviour of the ethogram is a state, so that no time can be compared.")
TOO_MANY_STATES = message("More than {most} states cannot be compared in combination.")
NOBODY_SAW = message("Nobody coded anything of {subjects}, who are left out.")
FIRST_TWO = message(
    "There are {n} observers: Fleiss' kappa and correlations are of all of them, all else of the "
    "first two, {first} and {second}."
)
OTHER_TIMES = message(
    "The observers watched from {begin} to {end} s together; the rest of the session is left out."
)


@dataclass(frozen=True, slots=True)
class AgreementParams:
    """How codings are compared.

    Attributes
    ----------
    unit_ms : int
        Of time-unit coefficients: 1000, as is usual with videos of people.
    tolerance_ms : int
        Events are the same where they begin no farther apart: 1000.
    interval_ms : int
        Of the interval agreements and of correlations: 10000, as wished for by observers.
    """

    unit_ms: int = 1000
    tolerance_ms: int = 1000
    interval_ms: int = 10_000

    def __post_init__(self) -> None:
        if min(self.unit_ms, self.interval_ms) <= 0 or self.tolerance_ms < 0:
            raise ValueError("units and intervals must last, and a tolerance is not negative")


@dataclass(frozen=True, slots=True)
class Figure:
    """A coefficient of one behaviour and subject.

    Attributes
    ----------
    subject, behaviour : str
        Empty: all of them together.
    coefficient : Coefficient
    """

    subject: str
    behaviour: str
    coefficient: Coefficient


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """Who called it what: rows the first observer, columns the second."""

    method: str
    names: tuple[str, ...]
    counts: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class AgreementResult:
    """What the comparison of observers gave.

    Attributes
    ----------
    observers : tuple of str
        Those of each coding.
    within_ms : (int, int)
        What all of them watched.
    figures : tuple of Figure
    tables : tuple of Table
        Of the first two observers.
    matches : tuple of Match
        Of their events.
    differences : tuple of Difference
        Time in which one of them saw a state that the other did not.
    notices : tuple of Sentence
    """

    observers: tuple[str, ...]
    within_ms: Span
    figures: tuple[Figure, ...]
    tables: tuple[Table, ...]
    matches: tuple[Match, ...]
    differences: tuple[Difference, ...]
    notices: tuple[Sentence, ...]


def agreement(codings: Sequence[Coding], params: AgreementParams | None = None) -> AgreementResult:
    """Compare codings of one session; of more than two the first two are compared event by event.

    Raises
    ------
    BehaviourError
        Fewer than two, or they share no time, or a behaviour is a state for one and a point event
        for the other.
    """
    params = params or AgreementParams()
    _check(codings)
    within = _shared(codings)
    clipped = [_clipped(coding, within) for coding in codings]
    first, second = clipped[:2]
    states, points = _behaviours(clipped)
    matches = matched(first, second, params.tolerance_ms)
    names = (*states, *points)
    event_table = match_table(matches, names)
    unit_figures, unit_table = _time_units(clipped, states, within, params)
    figures = [
        *unit_figures,
        Figure("", "", event_kappa(event_table)),
        *_intervals(first, second, names, params),
    ]
    tables = [Table("event-kappa", (*names, ""), event_table)]
    notices = []
    if len(codings) > 2:  # noqa: PLR2004
        who = [one.observer or str(number) for number, one in enumerate(codings[:2], 1)]
        told = {"n": len(codings), "first": who[0], "second": who[1]}
        notices.append(Sentence(FIRST_TWO, told))
    if any((coding.begin_ms, coding.end_ms) != within for coding in codings):
        begin_s, end_s = (time_ms / MS_PER_S for time_ms in within)
        notices.append(Sentence(OTHER_TIMES, {"begin": begin_s, "end": end_s}, decimals=3))
    unseen = {subject for one in codings for subject in one.subjects} - set(_subjects(clipped))
    if unseen - {""}:
        told = {"subjects": ", ".join(sorted(unseen - {""}))}
        notices.append(Sentence(NOBODY_SAW, told))
    return AgreementResult(
        tuple(coding.observer for coding in codings),
        within,
        tuple(figures),
        (*unit_table, *tables),
        matches,
        differences(first, second, within, states),
        tuple(notices),
    )


def interval_values(
    codings: Sequence[Coding], behaviour: str, subject: str, interval_ms: int
) -> tuple[FloatArray, FloatArray]:
    """Return counts and durations in seconds, (intervals, observers) each, of the shared time."""
    within = _shared(codings)
    spans = bin_spans(*within, interval_ms)
    counts, seconds = np.zeros((2, len(spans), len(codings)))
    for column, coding in enumerate(_clipped(one, within) for one in codings):
        for one in coding.of(behaviour, subject):
            first = min((one.begin_ms - within[0]) // interval_ms, len(spans) - 1)
            last = min((one.end_ms - within[0]) // interval_ms, len(spans) - 1)
            counts[first, column] += 1
            for number in range(first, last + 1):
                begin, end = spans[number]
                shared = max(0, min(end, one.end_ms) - max(begin, one.begin_ms))
                seconds[number, column] += shared / MS_PER_S
    return counts, seconds


def _check(codings: Sequence[Coding]) -> None:
    if len(codings) < 2:  # noqa: PLR2004
        raise BehaviourError(
            "Agreement takes the codings of two observers at least. Give another file."
        )
    kinds: dict[str, str] = {}
    for coding in codings:
        for one in coding.ethogram.behaviours:
            if kinds.setdefault(one.name, one.kind) != one.kind:
                raise BehaviourError(
                    "{behaviour} is a state for one observer and a point event for another. Code "
                    "with one ethogram.",
                    behaviour=one.name,
                )


def _shared(codings: Sequence[Coding]) -> Span:
    begin = max(coding.begin_ms for coding in codings)
    end = min(coding.end_ms for coding in codings)
    if end <= begin:
        raise BehaviourError("The observers share no time. Compare codings of the same session.")
    return begin, end


def _clipped(coding: Coding, within: Span) -> Coding:
    """Return what lies within; states that reach out of it are cut."""
    if (coding.begin_ms, coding.end_ms) == within:
        return coding
    begin, end = within
    kept = tuple(
        Occurrence(
            one.behaviour,
            max(one.begin_ms, begin),
            min(one.end_ms, end),
            one.subject,
            one.modifiers,
        )
        for one in coding.occurrences
        if begin <= one.begin_ms <= end or one.begin_ms < begin < one.end_ms
    )
    return Coding(coding.name, coding.ethogram, begin, end, kept, coding.observer)


def _behaviours(codings: Sequence[Coding]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    kinds = {one.name: one.kind for coding in codings for one in coding.ethogram.behaviours}
    states = tuple(name for name, kind in kinds.items() if kind == "state")
    return states, tuple(name for name, kind in kinds.items() if kind == "point")


def _subjects(codings: Sequence[Coding]) -> tuple[str, ...]:
    """Return whom any observer saw do anything: others would be agreement on nothing."""
    acting = {one.subject for coding in codings for one in coding.occurrences}
    return tuple(sorted(acting or {codings[0].subjects[0]}))


def _time_units(
    codings: Sequence[Coding], states: tuple[str, ...], within: Span, params: AgreementParams
) -> tuple[list[Figure], list[Table]]:
    if not states or len(states) > MOST_STATES:
        too_many = Sentence(TOO_MANY_STATES, {"most": MOST_STATES})
        reason = too_many if states else Sentence(NO_STATES)
        return [Figure("", "", Coefficient("time-unit-kappa", None, 0, reason=reason))], []
    times_ms = unit_middles(within, params.unit_ms)
    figures: list[Figure] = []
    pooled: list[list[IntArray]] = [[] for _ in codings]
    for subject in _subjects(codings):
        seen = [[lasting_at(one, name, subject, times_ms) for name in states] for one in codings]
        for name, first, second in zip(states, *seen[:2], strict=True):
            table = presence_table(first, second)
            figures += [Figure(subject, name, one) for one in _coefficients(table)]
        for observer, columns in zip(pooled, seen, strict=True):
            observer.append(combinations(columns))
    numbers = [np.concatenate(parts) for parts in pooled]
    counts, _kinds = combination_counts(numbers)
    table, kinds = combination_table(*numbers[:2])
    whole = [Figure("", "", one) for one in (*_coefficients(table), fleiss_kappa(counts))]
    names = tuple(_combined(int(kind), states) for kind in kinds)
    return [*whole, *figures], [Table("time-unit-kappa", names, table)]


def _coefficients(table: FloatArray) -> Iterator[Coefficient]:
    for name, found in (
        ("time-unit-kappa", cohen_kappa(table)),
        ("time-unit-pabak", pabak(table)),
        ("time-unit-ac1", gwet_ac1(table)),
    ):
        yield Coefficient(name, found.value, found.n, found.observed, found.expected, found.reason)


def _combined(number: int, states: Sequence[str]) -> str:
    return " + ".join(name for place, name in enumerate(states) if number >> place & 1)


def _intervals(
    first: Coding, second: Coding, names: Sequence[str], params: AgreementParams
) -> Iterator[Figure]:
    scored = [
        {
            (one.subject, one.behaviour): one.scores
            for one in samples(coding, "partial", params.interval_ms)
        }
        for coding in (first, second)
    ]
    n_intervals = len(bin_spans(first.begin_ms, first.end_ms, params.interval_ms))
    nothing = (False,) * n_intervals
    for subject in _subjects((first, second)):
        for name in names:
            here, there = first.of(name, subject), second.of(name, subject)
            counts = [
                _counts(some, first.begin_ms, params.interval_ms, n_intervals)
                for some in (here, there)
            ]
            scores = [one.get((subject, name), nothing) for one in scored]
            lasting = [[one.duration_ms for one in some] for some in (here, there)]
            works = [
                partial(ioa.total_count, *counts),
                partial(ioa.mean_count, *counts),
                partial(ioa.exact_count, *counts),
                partial(ioa.interval_by_interval, *scores),
                partial(ioa.scored_intervals, *scores),
                partial(ioa.unscored_intervals, *scores),
            ]
            if any(map(any, lasting)):
                works += [
                    partial(ioa.total_duration, *lasting),
                    partial(ioa.mean_duration, *lasting),
                ]
            yield from (Figure(subject, name, work()) for work in works)


def _counts(
    some: Sequence[Occurrence], begin_ms: int, interval_ms: int, n_intervals: int
) -> list[int]:
    counts = [0] * n_intervals
    for one in some:
        counts[min((one.begin_ms - begin_ms) // interval_ms, n_intervals - 1)] += 1
    return counts
