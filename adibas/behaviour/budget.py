"""How often and how long: totals, rates, time bins, conditions and transitions of a coding.

Durations are whole milliseconds and intervals are closed at their beginning and open at their end
(the last one is closed), so that bins and conditions add up to the session exactly.
"""

from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise

from adibas.data.coding import MS_PER_S, Coding, Occurrence, Section

MS_PER_MINUTE = 60 * MS_PER_S
UNTAGGED = ""
"""The condition of the time in no section."""

Span = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Budget:
    """One behaviour of one subject in some observed time.

    Attributes
    ----------
    subject, behaviour : str
    is_state : bool
    count : int
        Occurrences that begin in the time.
    total_ms : int
        Time in which it lasts, overlaps once; 0 for a point event.
    observed_ms : int
    durations_ms : tuple of int
        Of the whole occurrences that begin in the time.
    latency_ms : int or None
        From the beginning of the time to the first beginning.
    """

    subject: str
    behaviour: str
    is_state: bool
    count: int
    total_ms: int
    observed_ms: int
    durations_ms: tuple[int, ...]
    latency_ms: int | None

    @property
    def share(self) -> float | None:
        """Return the share of the time in which it lasts; None for a point event or no time."""
        return self.total_ms / self.observed_ms if self.is_state and self.observed_ms else None

    @property
    def per_minute(self) -> float | None:
        """Return how often it begins in a minute; None without time."""
        return self.count * MS_PER_MINUTE / self.observed_ms if self.observed_ms else None

    @property
    def mean_ms(self) -> float | None:
        """Return the mean duration of an occurrence; None for a point event or where none is."""
        if not self.is_state or not self.durations_ms:
            return None
        return sum(self.durations_ms) / len(self.durations_ms)


@dataclass(frozen=True, slots=True)
class TimeBin:
    """Some of the session, and what was in it."""

    begin_ms: int
    end_ms: int
    budgets: tuple[Budget, ...]


@dataclass(frozen=True, slots=True)
class Condition:
    """All sections of one name together, and what was in them."""

    name: str
    observed_ms: int
    budgets: tuple[Budget, ...]


@dataclass(frozen=True, slots=True)
class Transitions:
    """What followed what in one subject.

    Attributes
    ----------
    subject : str
    behaviours : tuple of str
    counts : tuple of tuples of int
        Row: behaviour before; column: the next to begin.
    """

    subject: str
    behaviours: tuple[str, ...]
    counts: tuple[tuple[int, ...], ...]

    def share(self, before: int, after: int) -> float | None:
        """Return how many of what followed `before` was `after`; None where nothing followed."""
        total = sum(self.counts[before])
        return self.counts[before][after] / total if total else None


def budgets(coding: Coding, spans: Sequence[Span] | None = None) -> tuple[Budget, ...]:
    """Return the budget of each subject and behaviour.

    Parameters
    ----------
    coding : Coding
    spans : sequence of (begin_ms, end_ms), optional
        Observed time, in order and not overlapping; the whole session if not given.
    """
    observed = [(coding.begin_ms, coding.end_ms)] if spans is None else list(spans)
    return _budgets(_kinds(coding), observed, coding.end_ms)


def time_bins(coding: Coding, length_ms: int) -> tuple[TimeBin, ...]:
    """Return the session in bins of `length_ms`; the last one may be shorter.

    Raises
    ------
    ValueError
        The length is not above zero.
    """
    spans = bin_spans(coding.begin_ms, coding.end_ms, length_ms)
    kinds = _kinds(coding)
    return tuple(TimeBin(*span, _budgets(kinds, [span], coding.end_ms)) for span in spans)


def bin_spans(begin_ms: int, end_ms: int, length_ms: int) -> list[Span]:
    """Return the bounds of bins of `length_ms`, of which the last may be shorter."""
    if length_ms <= 0:
        raise ValueError(f"a bin must last, got {length_ms} ms")
    starts = range(begin_ms, max(end_ms, begin_ms + 1), length_ms)
    return [(start, min(start + length_ms, end_ms)) for start in starts]


def condition_spans(sections: Iterable[Section], session_ms: Span) -> dict[str, list[Span]]:
    """Return when each condition was: tagged sections of one name together, then what is left.

    What is left is `UNTAGGED`. Nothing where no section is tagged.
    """
    spans: dict[str, list[Span]] = {}
    for section in sections:
        spans.setdefault(section.name, []).append((section.begin_ms, section.end_ms))
    rest = gaps(chain.from_iterable(spans.values()), session_ms) if spans else []
    if rest:
        spans.setdefault(UNTAGGED, []).extend(rest)
    return {name: sorted(some) for name, some in spans.items()}


def conditions(coding: Coding) -> tuple[Condition, ...]:
    """Return what was in the sections of each name together, and in what is left as `UNTAGGED`.

    Nothing where no section is tagged.
    """
    spans = condition_spans(coding.sections, (coding.begin_ms, coding.end_ms))
    return tuple(
        Condition(name, sum(end - begin for begin, end in some), budgets(coding, some))
        for name, some in spans.items()
    )


def transitions(coding: Coding) -> tuple[Transitions, ...]:
    """Return for each subject which behaviour began after which.

    Those that begin at the same millisecond count in the order of their names.
    """
    names = tuple(behaviour.name for behaviour in coding.ethogram.behaviours)
    found = []
    for subject in coding.subjects:
        order = sorted(
            (one.begin_ms, one.behaviour) for one in coding.occurrences if one.subject == subject
        )
        pairs = Counter((before, after) for (_, before), (_, after) in pairwise(order))
        counts = tuple(tuple(pairs[before, after] for after in names) for before in names)
        found.append(Transitions(subject, names, counts))
    return tuple(found)


def gaps(spans: Iterable[Span], within: Span) -> list[Span]:
    """Return what of `within` is in none of `spans`."""
    free = []
    at = within[0]
    for begin, end in merged(spans):
        if begin > at:
            free.append((at, min(begin, within[1])))
        at = max(at, end)
    if at < within[1]:
        free.append((at, within[1]))
    return [(begin, end) for begin, end in free if end > begin]


def merged(spans: Iterable[Span]) -> list[Span]:
    """Return the same time in spans that do not touch, in order."""
    found: list[Span] = []
    for begin, end in sorted(spans):
        if found and begin <= found[-1][1]:
            found[-1] = (found[-1][0], max(found[-1][1], end))
        else:
            found.append((begin, end))
    return found


def shared_ms(spans: Sequence[Span], others: Sequence[Span]) -> int:
    """Return the time in both; each in order and not overlapping."""
    total = 0
    for begin, end in spans:
        k = bisect_right(others, begin, key=lambda other: other[1])
        while k < len(others) and others[k][0] < end:
            total += min(end, others[k][1]) - max(begin, others[k][0])
            k += 1
    return total


@dataclass(frozen=True, slots=True)
class _Kind:
    """Everything that one subject did of one behaviour, in the order of time."""

    subject: str
    behaviour: str
    is_state: bool
    occurrences: tuple[Occurrence, ...]
    lasting: tuple[Span, ...]

    def begun(self, spans: Sequence[Span], session_end_ms: int) -> list[Occurrence]:
        """Return what begins in the spans; the last moment of the session belongs to its end."""
        found: list[Occurrence] = []
        for begin, end in spans:
            first = bisect_left(self.occurrences, begin, key=_begin_ms)
            find_last = bisect_right if end == session_end_ms else bisect_left
            found += self.occurrences[first : find_last(self.occurrences, end, key=_begin_ms)]
        return found


def _begin_ms(one: Occurrence) -> int:
    return one.begin_ms


def _kinds(coding: Coding) -> list[_Kind]:
    by_kind: dict[tuple[str, str], list[Occurrence]] = {}
    for one in coding.occurrences:
        by_kind.setdefault((one.subject, one.behaviour), []).append(one)
    found = []
    for subject in coding.subjects:
        for behaviour in coding.ethogram.behaviours:
            some = by_kind.get((subject, behaviour.name), [])
            is_state = behaviour.kind == "state"
            lasting = merged((one.begin_ms, one.end_ms) for one in some) if is_state else []
            found.append(_Kind(subject, behaviour.name, is_state, tuple(some), tuple(lasting)))
    return found


def _budgets(
    kinds: Sequence[_Kind], observed: Sequence[Span], session_end_ms: int
) -> tuple[Budget, ...]:
    return tuple(_budget(kind, observed, session_end_ms) for kind in kinds)


def _budget(kind: _Kind, observed: Sequence[Span], session_end_ms: int) -> Budget:
    begun = kind.begun(observed, session_end_ms)
    first_ms = min(map(_begin_ms, begun), default=None)
    return Budget(
        *(kind.subject, kind.behaviour, kind.is_state, len(begun)),
        shared_ms(observed, kind.lasting),
        sum(end - begin for begin, end in observed),
        tuple(one.duration_ms for one in begun),
        None if first_ms is None else first_ms - observed[0][0],
    )
