"""Which event of one observer is which of another, and when they saw different things."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from adibas.arrays import FloatArray
from adibas.behaviour.budget import Span, gaps, merged
from adibas.data.coding import Coding, Occurrence


@dataclass(frozen=True, slots=True)
class Match:
    """An event of one observer with that of the other; None where he saw nothing."""

    first: Occurrence | None
    second: Occurrence | None

    @property
    def is_agreed(self) -> bool:
        """Return whether both saw the same behaviour."""
        if self.first is None or self.second is None:
            return False
        return self.first.behaviour == self.second.behaviour

    @property
    def begin_ms(self) -> int:
        """Return when the earlier one begins."""
        return min(one.begin_ms for one in (self.first, self.second) if one is not None)


@dataclass(frozen=True, slots=True)
class Difference:
    """Time in which one observer saw a state and the other did not.

    Attributes
    ----------
    subject, behaviour : str
    begin_ms, end_ms : int
    is_first : bool
        Whether the first observer is the one who saw it.
    """

    subject: str
    behaviour: str
    begin_ms: int
    end_ms: int
    is_first: bool


def matched(first: Coding, second: Coding, tolerance_ms: int) -> tuple[Match, ...]:
    """Pair events that begin within `tolerance_ms` of each other.

    Of each subject the same behaviours first, as many pairs as possible and of those the nearest;
    then what is left, which was seen by both and named differently.
    """
    found: list[Match] = []
    for subject in sorted({*first.subjects, *second.subjects}):
        mine = [one for one in first.occurrences if one.subject == subject]
        theirs = [one for one in second.occurrences if one.subject == subject]
        for is_same in (True, False):
            pairs = _pairs(mine, theirs, tolerance_ms, is_same=is_same)
            found += [Match(mine[i], theirs[j]) for i, j in pairs]
            mine = _left(mine, {i for i, _ in pairs})
            theirs = _left(theirs, {j for _, j in pairs})
        found += [Match(one, None) for one in mine]
        found += [Match(None, one) for one in theirs]
    return tuple(sorted(found, key=lambda match: match.begin_ms))


def match_table(matches: Sequence[Match], behaviours: Sequence[str]) -> FloatArray:
    """Return (k + 1, k + 1) counts of behaviours; the last row and column: the other saw none."""
    places = {name: number for number, name in enumerate(behaviours)}
    table = np.zeros((len(behaviours) + 1, len(behaviours) + 1))
    for match in matches:
        row, column = (
            len(behaviours) if one is None else places[one.behaviour]
            for one in (match.first, match.second)
        )
        table[row, column] += 1
    return table


def differences(
    first: Coding, second: Coding, within: Span, behaviours: Sequence[str]
) -> tuple[Difference, ...]:
    """Return when the states `behaviours` were seen by one observer alone, in order of time."""
    found = []
    for subject in sorted({*first.subjects, *second.subjects}):
        for name in behaviours:
            spans = [
                merged((one.begin_ms, one.end_ms) for one in coding.of(name, subject))
                for coding in (first, second)
            ]
            for is_first in (True, False):
                here, there = spans if is_first else reversed(spans)
                absent = gaps(there, within)
                found += [
                    Difference(subject, name, begin, end, is_first)
                    for begin, end in _both(here, absent)
                ]
    return tuple(sorted(found, key=lambda one: (one.begin_ms, one.end_ms, one.behaviour)))


def _pairs(
    mine: Sequence[Occurrence],
    theirs: Sequence[Occurrence],
    tolerance_ms: int,
    *,
    is_same: bool,
) -> list[tuple[int, int]]:
    if not mine or not theirs:
        return []
    begins = np.array([one.begin_ms for one in mine], float)
    others = np.array([one.begin_ms for one in theirs], float)
    apart_ms = np.abs(begins[:, None] - others[None])
    may_be = apart_ms <= tolerance_ms
    if is_same:
        names = np.array([one.behaviour for one in mine])
        may_be &= names[:, None] == np.array([one.behaviour for one in theirs])[None]
    # One pair more outweighs any distances.
    never = (tolerance_ms + 1.0) * (min(len(mine), len(theirs)) + 1)
    rows, columns = linear_sum_assignment(np.where(may_be, apart_ms, never))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if may_be[i, j]]


def _left(events: Sequence[Occurrence], taken: set[int]) -> list[Occurrence]:
    return [one for place, one in enumerate(events) if place not in taken]


def _both(spans: Sequence[Span], others: Sequence[Span]) -> list[Span]:
    shared = [(max(begin, first), min(end, last)) for begin, end in spans for first, last in others]
    return [(begin, end) for begin, end in shared if end > begin]
