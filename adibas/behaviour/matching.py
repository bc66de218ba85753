"""Which event of one observer is which of another, and when they saw different things."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from adibas.arrays import FloatArray
from adibas.behaviour.budget import Span, gaps, merged
from adibas.data.coding import Coding, Occurrence

SHARE_OF_TIME, SHARE_OF_NAME = 1e-4, 1e-8


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
    """Return places of events that belong together, group by group: hours take no more memory."""
    pairs = []
    for here, there in _groups(mine, theirs, tolerance_ms):
        if here and there:
            found = _assigned(
                [mine[i] for i in here], [theirs[j] for j in there], tolerance_ms, is_same=is_same
            )
            pairs += [(here[i], there[j]) for i, j in found]
    return pairs


def _groups(
    mine: Sequence[Occurrence], theirs: Sequence[Occurrence], tolerance_ms: int
) -> list[tuple[list[int], list[int]]]:
    """Return places of events, divided where for longer than the tolerance none begins."""
    order = sorted(
        [(one.begin_ms, 0, i) for i, one in enumerate(mine)]
        + [(one.begin_ms, 1, j) for j, one in enumerate(theirs)]
    )
    groups: list[tuple[list[int], list[int]]] = []
    latest_ms = 0
    for begin_ms, side, place in order:
        if not groups or begin_ms - latest_ms > tolerance_ms:
            groups.append(([], []))
        groups[-1][side].append(place)
        latest_ms = begin_ms
    return groups


def _assigned(
    mine: Sequence[Occurrence],
    theirs: Sequence[Occurrence],
    tolerance_ms: int,
    *,
    is_same: bool,
) -> list[tuple[int, int]]:
    begins = np.array([one.begin_ms for one in mine], float)
    others = np.array([one.begin_ms for one in theirs], float)
    apart_ms = np.abs(begins[:, None] - others[None])
    may_be = apart_ms <= tolerance_ms
    if is_same:
        names = np.array([one.behaviour for one in mine])
        may_be &= names[:, None] == np.array([one.behaviour for one in theirs])[None]
    apart_ms = apart_ms + _preferences(mine)[:, None] + _preferences(theirs)[None]
    # One pair more outweighs any distances.
    never = (tolerance_ms + 1.0) * (min(len(mine), len(theirs)) + 1)
    rows, columns = linear_sum_assignment(np.where(may_be, apart_ms, never))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if may_be[i, j]]


def _preferences(events: Sequence[Occurrence]) -> FloatArray:
    """Return parts of a millisecond that decide between equals: the earlier, then by name.

    So the same events are paired, whichever observer comes first.
    """
    first, last = events[0].begin_ms, events[-1].begin_ms
    names = sorted({one.behaviour for one in events})
    return np.array(
        [
            SHARE_OF_TIME * (one.begin_ms - first) / max(last - first, 1)
            + SHARE_OF_NAME * names.index(one.behaviour) / len(names)
            for one in events
        ]
    )


def _left(events: Sequence[Occurrence], taken: set[int]) -> list[Occurrence]:
    return [one for place, one in enumerate(events) if place not in taken]


def _both(spans: Sequence[Span], others: Sequence[Span]) -> list[Span]:
    """Return the time in both; each in order and not overlapping."""
    shared = []
    for begin, end in spans:
        k = bisect_right(others, begin, key=lambda other: other[1])
        while k < len(others) and others[k][0] < end:
            shared.append((max(begin, others[k][0]), min(end, others[k][1])))
            k += 1
    return [(begin, end) for begin, end in shared if end > begin]
