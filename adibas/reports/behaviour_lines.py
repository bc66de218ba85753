"""What is in a plot over the time of a session, on paper and in the window."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from adibas.behaviour.budget import Span
from adibas.data.coding import Coding
from adibas.reports.behaviour_texts import behaviour_text, subject_text
from adibas.texts import translate as _

S_PER_MINUTE = 60.0
MOST_MINUTES_IN_SECONDS = 5


@dataclass(frozen=True, slots=True)
class EventLine:
    """The line of one behaviour of one subject in the coding of one observer.

    Attributes
    ----------
    label, color : str
    spans_ms : tuple of (begin, end)
    is_state : bool
        False: each is a moment.
    """

    label: str
    color: str
    spans_ms: tuple[Span, ...]
    is_state: bool


def event_lines(codings: Sequence[Coding | None], colors: Sequence[str]) -> Iterator[EventLine]:
    """Yield what occurs in codings, one after the other; a scheme without a colour gets these."""
    for coding in codings:
        if coding is None:
            continue
        for subject in coding.subjects:
            for place, behaviour in enumerate(coding.ethogram.behaviours):
                spans_ms = tuple(
                    (one.begin_ms, one.end_ms) for one in coding.of(behaviour.name, subject)
                )
                if spans_ms:
                    who = ", ".join(filter(None, (subject_text(subject), coding.observer)))
                    yield EventLine(
                        f"{behaviour_text(behaviour.name)} ({who})",
                        behaviour.color or colors[place % len(colors)],
                        spans_ms,
                        behaviour.kind == "state",
                    )


def time_axis(duration_s: float) -> tuple[float, str]:
    """Return the seconds of one unit of the axis, and its title: a short session in seconds."""
    if duration_s > MOST_MINUTES_IN_SECONDS * S_PER_MINUTE:
        return S_PER_MINUTE, _("Time [min]")
    return 1.0, _("Time [s]")
