"""What other ways of watching would have seen: interval and momentary sampling of a coding.

Source: Altmann, Observational study of behavior: sampling methods, Behaviour 49 (1974), for
one-zero (partial interval) and instantaneous (momentary) sampling; Powell, Martindale & Kulp, An
evaluation of time-sample measures of behavior, Journal of Applied Behavior Analysis 8 (1975), for
whole-interval sampling.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from adibas.behaviour.budget import Span, bin_spans, merged
from adibas.data.coding import Coding

Sampling: TypeAlias = Literal["partial", "whole", "momentary"]
SAMPLINGS: tuple[Sampling, ...] = ("partial", "whole", "momentary")


@dataclass(frozen=True, slots=True)
class Samples:
    """Scored intervals of one behaviour of one subject.

    Attributes
    ----------
    subject, behaviour : str
    scores : tuple of bool
        One for each interval.
    true_share : float or None
        Of the time in which it lasted; None for a point event.
    """

    subject: str
    behaviour: str
    scores: tuple[bool, ...]
    true_share: float | None

    @property
    def share(self) -> float | None:
        """Return the share of intervals that are scored; None where there is none."""
        return sum(self.scores) / len(self.scores) if self.scores else None


def samples(coding: Coding, sampling: Sampling, interval_ms: int) -> tuple[Samples, ...]:
    """Score every interval of a coding.

    Parameters
    ----------
    coding : Coding
    sampling : str
        ``partial``: anything of it within the interval; ``whole``: all of the interval;
        ``momentary``: at the interval's last moment. A point event lasts no interval, and is
        sampled at no moment.
    interval_ms : int
        The last interval may be shorter.

    Raises
    ------
    ValueError
        The interval does not last.
    """
    bins = bin_spans(coding.begin_ms, coding.end_ms, interval_ms)
    found = []
    for subject in coding.subjects:
        for behaviour in coding.ethogram.behaviours:
            seen = coding.of(behaviour.name, subject)
            is_state = behaviour.kind == "state"
            lasting = merged((one.begin_ms, one.end_ms) for one in seen) if is_state else []
            scores = _scores(sampling, bins, interval_ms, lasting)
            if sampling == "partial":
                for one in seen:
                    scores[_bin_at(one.begin_ms, bins, interval_ms)] = True
            total_ms = sum(end - begin for begin, end in lasting)
            share = total_ms / coding.duration_ms if is_state and coding.duration_ms else None
            found.append(Samples(subject, behaviour.name, tuple(scores), share))
    return tuple(found)


def _scores(
    sampling: Sampling, bins: Sequence[Span], interval_ms: int, lasting: Sequence[Span]
) -> list[bool]:
    """Score the bins that states reach into; each state is held against its own bins alone."""
    scores = [False] * len(bins)
    for begin, end in lasting:
        first, last = (_bin_at(time_ms, bins, interval_ms) for time_ms in (begin, end))
        for number in range(first, last + 1):
            bin_begin, bin_end = bins[number]
            scores[number] |= {
                "partial": min(end, bin_end) > max(begin, bin_begin),
                "whole": begin <= bin_begin < bin_end <= end,
                "momentary": begin < bin_end <= end,
            }[sampling]
    return scores


def _bin_at(time_ms: int, bins: Sequence[Span], interval_ms: int) -> int:
    """Return the bin in which a moment lies; the end of the session lies in the last one."""
    return min((time_ms - bins[0][0]) // interval_ms, len(bins) - 1)
