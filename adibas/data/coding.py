"""What an observer noted down of one session, checked so that totals add up.

Times are whole milliseconds, as the programs of observers keep them: sums are exact, and what is
written and read again is the same.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

from adibas.data.ethogram import NO_VALUE, Behaviour, Ethogram
from adibas.data.sentence import Sentence
from adibas.texts import message

MS_PER_S = 1000
LONGEST_MS = 2**53
"""Longer than anything lasts; up to it every whole number is a float, too."""

UNKNOWN_BEHAVIOUR = message("the behaviour {behaviour} is not in the ethogram. Add it, or correct.")
UNKNOWN_SUBJECT = message("the subject {subject} is not in the ethogram. Add it, or correct.")
OUTSIDE = message("{behaviour} at {at} s lies outside the session. Correct the time.")
BACKWARD = message("{behaviour} at {at} s ends before it begins. Correct the times.")
POINT_LASTS = message("{behaviour} at {at} s is a point event, but it lasts. Give it one time.")
WRONG_MODIFIER = message(
    "{behaviour} at {at} s has the modifier {value}, which the ethogram does not know. Correct it."
)
OVERLAPS = message(
    "{behaviour} at {at} s begins while {other} still lasts, which the ethogram excludes. End one "
    "of them first."
)


def whole_ms(seconds: float) -> int:
    """Return seconds in whole milliseconds; more than `LONGEST_MS` is as long as that."""
    return round(min(seconds * MS_PER_S, LONGEST_MS))


@dataclass(frozen=True, slots=True)
class Occurrence:
    """One time that a behaviour was seen.

    Attributes
    ----------
    behaviour : str
    begin_ms, end_ms : int
        On the recording's clock; equal for a point event.
    subject : str
        Who; empty for nobody in particular.
    modifiers : tuple of str
        One for each modifier of the behaviour, in its order; empty where none was told, and left
        out where none follows.
    comment, end_comment : str
        Of the beginning and of the end.
    """

    behaviour: str
    begin_ms: int
    end_ms: int
    subject: str = ""
    modifiers: tuple[str, ...] = ()
    comment: str = ""
    end_comment: str = ""

    def __post_init__(self) -> None:
        told = list(self.modifiers)
        while told and told[-1] == NO_VALUE:
            told.pop()
        object.__setattr__(self, "modifiers", tuple(told))

    @property
    def duration_ms(self) -> int:
        """Return how long it lasted."""
        return self.end_ms - self.begin_ms


@dataclass(frozen=True, slots=True)
class Section:
    """A part of the session under one condition, such as a task that motivates."""

    name: str
    begin_ms: int
    end_ms: int


@dataclass(frozen=True, slots=True)
class Problem:
    """What is wrong with the event at `place` of a list."""

    place: int
    sentence: Sentence


@dataclass(frozen=True, slots=True)
class Coding:
    """What one observer noted of one session.

    Attributes
    ----------
    name : str
        Of the session.
    ethogram : Ethogram
    begin_ms, end_ms : int
        From when to when was observed.
    occurrences : tuple of Occurrence
        In the order of time.
    observer : str
        Initials or a pseudonym.
    sections : tuple of Section
        Not overlapping, in the order of time.
    description, date : str
    media : tuple of str
        Names of the recordings.
    variables : tuple of (str, str)
        Whatever else is known of the session.
    """

    name: str
    ethogram: Ethogram
    begin_ms: int
    end_ms: int
    occurrences: tuple[Occurrence, ...] = ()
    observer: str = ""
    sections: tuple[Section, ...] = ()
    description: str = ""
    date: str = ""
    media: tuple[str, ...] = ()
    variables: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        if self.end_ms < self.begin_ms:
            raise ValueError(f"a session ends before it begins: {self.begin_ms}, {self.end_ms}")
        for problem in problems_of(self.ethogram, self.occurrences, (self.begin_ms, self.end_ms)):
            raise ValueError(problem.sentence.text)
        latest = self.begin_ms
        for section in self.sections:
            if not latest <= section.begin_ms <= section.end_ms <= self.end_ms:
                raise ValueError(f"the section {section.name} overlaps or lies outside")
            latest = section.end_ms
        object.__setattr__(self, "occurrences", tuple(sorted(self.occurrences, key=in_time)))

    @property
    def duration_ms(self) -> int:
        """Return how long was observed."""
        return self.end_ms - self.begin_ms

    @property
    def subjects(self) -> tuple[str, ...]:
        """Return who acts: those of the ethogram, and nobody in particular where that occurs."""
        named = tuple(subject.name for subject in self.ethogram.subjects)
        has_others = not named or any(not one.subject for one in self.occurrences)
        return (("",) if has_others else ()) + named

    def of(self, behaviour: str, subject: str) -> tuple[Occurrence, ...]:
        """Return the occurrences of one behaviour of one subject."""
        return tuple(
            one for one in self.occurrences if one.behaviour == behaviour and one.subject == subject
        )


def in_time(one: Occurrence) -> tuple[int, int, str, str, tuple[str, ...]]:
    """Return by what occurrences are sorted."""
    return one.begin_ms, one.end_ms, one.subject, one.behaviour, one.modifiers


def problems_of(
    ethogram: Ethogram, occurrences: Sequence[Occurrence], observed_ms: tuple[int, int]
) -> Iterator[Problem]:
    """Yield what keeps occurrences from being a coding, each once, wrong ones before overlaps."""
    behaviours = {behaviour.name: behaviour for behaviour in ethogram.behaviours}
    is_whole = True
    for place, one in enumerate(occurrences):
        sentence = _mistake(one, behaviours.get(one.behaviour), ethogram, observed_ms)
        if sentence is not None:
            is_whole = False
            yield Problem(place, sentence)
    if is_whole:
        yield from _overlaps(occurrences, behaviours, ethogram.exclusions)


def _mistake(
    one: Occurrence,
    behaviour: Behaviour | None,
    ethogram: Ethogram,
    observed_ms: tuple[int, int],
) -> Sentence | None:
    told = {"behaviour": one.behaviour, "at": one.begin_ms / MS_PER_S}
    if behaviour is None:
        return Sentence(UNKNOWN_BEHAVIOUR, {"behaviour": one.behaviour})
    if one.subject not in ethogram.subject_names:
        return Sentence(UNKNOWN_SUBJECT, {"subject": one.subject})
    if one.end_ms < one.begin_ms:
        return Sentence(BACKWARD, told, decimals=3)
    if not observed_ms[0] <= one.begin_ms <= one.end_ms <= observed_ms[1]:
        return Sentence(OUTSIDE, told, decimals=3)
    if behaviour.kind == "point" and one.duration_ms:
        return Sentence(POINT_LASTS, told, decimals=3)
    return _wrong_modifier(one, behaviour, told)


def _wrong_modifier(
    one: Occurrence, behaviour: Behaviour, told: dict[str, object]
) -> Sentence | None:
    for number, value in enumerate(one.modifiers):
        is_known = number < len(behaviour.modifiers)
        if not (is_known and behaviour.modifiers[number].allows(value)):
            return Sentence(WRONG_MODIFIER, {**told, "value": value}, decimals=3)
    return None


def _overlaps(
    occurrences: Sequence[Occurrence],
    behaviours: dict[str, Behaviour],
    exclusions: frozenset[tuple[str, str]],
) -> Iterator[Problem]:
    """Yield states that begin while one lasts that they exclude, or the same with its modifiers."""
    states = [
        (one.subject, one.begin_ms, one.end_ms, place)
        for place, one in enumerate(occurrences)
        if behaviours[one.behaviour].kind == "state"
    ]
    for _subject, group in groupby(sorted(states), key=lambda state: state[0]):
        lasting: list[Occurrence] = []
        for _who, begin_ms, _end_ms, place in group:
            one = occurrences[place]
            lasting = [other for other in lasting if other.end_ms > begin_ms]
            for other in lasting:
                if are_exclusive(one, other, exclusions):
                    told = {
                        "behaviour": one.behaviour,
                        "at": one.begin_ms / MS_PER_S,
                        "other": other.behaviour,
                    }
                    yield Problem(place, Sentence(OVERLAPS, told, decimals=3))
                    break
            lasting.append(one)


def are_exclusive(
    one: Occurrence, other: Occurrence, exclusions: frozenset[tuple[str, str]]
) -> bool:
    """Return whether two states of one subject cannot last at the same time."""
    if one.behaviour == other.behaviour:
        return one.modifiers == other.modifiers
    return (one.behaviour, other.behaviour) in exclusions
