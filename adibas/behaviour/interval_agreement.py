"""Agreement as applied behaviour analysis counts it (IOA), as shares from 0 to 1.

Source: Cooper, Heron & Heward, Applied Behavior Analysis, 2nd ed. (2007), chapter 5. Worked
examples: Reed & Azulay, A Microsoft Excel 2010 based tool for calculating interobserver agreement,
Behavior Analysis in Practice 4 (2011), doi 10.1007/BF03391783.
"""

from collections.abc import Sequence
from itertools import zip_longest

from adibas.behaviour.chance import Coefficient
from adibas.data.sentence import Sentence
from adibas.texts import Message, message

NEITHER_SAW = message("Neither observer saw it, so that there is nothing to agree on.")
NOTHING_SCORED = message("Neither observer scored an interval. Look at the unscored ones.")
ALL_SCORED = message("Both observers scored every interval. Look at the scored ones.")


def total_count(counts: Sequence[int], others: Sequence[int]) -> Coefficient:
    """Return the smaller over the larger total of counts in intervals."""
    first, second = sum(counts), sum(others)
    return _smaller_over_larger("total-count", first, second, max(first, second))


def mean_count(counts: Sequence[int], others: Sequence[int]) -> Coefficient:
    """Return the mean over intervals of the smaller over the larger count; 0 beside 0 agree."""
    shares = [
        1.0 if max(pair) == 0 else min(pair) / max(pair)
        for pair in zip(counts, others, strict=True)
    ]
    return _of_intervals("mean-count-per-interval", sum(shares), len(shares), NEITHER_SAW)


def exact_count(counts: Sequence[int], others: Sequence[int]) -> Coefficient:
    """Return the share of intervals with the same count."""
    same = sum(one == other for one, other in zip(counts, others, strict=True))
    return _of_intervals("exact-count-per-interval", same, len(counts), NEITHER_SAW)


def interval_by_interval(scores: Sequence[bool], others: Sequence[bool]) -> Coefficient:
    """Return the share of intervals that both scored or both did not."""
    same = sum(one == other for one, other in zip(scores, others, strict=True))
    return _of_intervals("interval-by-interval", same, len(scores), NEITHER_SAW)


def scored_intervals(scores: Sequence[bool], others: Sequence[bool]) -> Coefficient:
    """Return how many of the intervals that either scored both did."""
    pairs = list(zip(scores, others, strict=True))
    both = sum(one and other for one, other in pairs)
    return _of_intervals(
        "scored-intervals", both, sum(one or other for one, other in pairs), NOTHING_SCORED
    )


def unscored_intervals(scores: Sequence[bool], others: Sequence[bool]) -> Coefficient:
    """Return how many of the intervals that either left unscored both did."""
    inverse = ([not one for one in scores], [not other for other in others])
    found = scored_intervals(*inverse)
    reason = None if found.value is not None else Sentence(ALL_SCORED)
    return Coefficient("unscored-intervals", found.value, found.n, found.value, reason=reason)


def total_duration(durations_ms: Sequence[int], others_ms: Sequence[int]) -> Coefficient:
    """Return the shorter over the longer of both total durations."""
    first, second = sum(durations_ms), sum(others_ms)
    n = max(len(durations_ms), len(others_ms))
    return _smaller_over_larger("total-duration", first, second, n)


def mean_duration(durations_ms: Sequence[int], others_ms: Sequence[int]) -> Coefficient:
    """Return the mean over occurrences, in their order, of the shorter over the longer duration.

    What one observer alone saw agrees with nothing; 0 beside 0 agree.
    """
    shares = [
        0.0 if None in pair else 1.0 if max(pair) == 0 else min(pair) / max(pair)
        for pair in zip_longest(durations_ms, others_ms)
    ]
    return _of_intervals("mean-duration-per-occurrence", sum(shares), len(shares), NEITHER_SAW)


def _smaller_over_larger(method: str, first: int, second: int, n: int) -> Coefficient:
    if max(first, second) == 0:
        return Coefficient(method, None, 0, reason=Sentence(NEITHER_SAW))
    value = min(first, second) / max(first, second)
    return Coefficient(method, value, n, value)


def _of_intervals(method: str, agreed: float, n: int, reason: Message) -> Coefficient:
    if n == 0:
        return Coefficient(method, None, 0, reason=Sentence(reason))
    return Coefficient(method, agreed / n, n, agreed / n)
