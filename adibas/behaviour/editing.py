"""What an observer does to a coding, step by step; every step gives a new draft, or says why not.

A coding holds no state without an end. While somebody codes, states that were begun wait beside it
until they are ended.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Generic, TypeVar

from adibas.data.coding import (
    Coding,
    Occurrence,
    Section,
    are_exclusive,
    in_time,
    problems_of,
)
from adibas.data.ethogram import Ethogram, Subject
from adibas.errors import BehaviourError

Thing = TypeVar("Thing")


@dataclass(frozen=True, slots=True)
class Draft:
    """A coding in the making.

    Attributes
    ----------
    coding : Coding
    begun : tuple of Occurrence
        States without an end yet; each ends where it begins.
    detected : Coding or None
        What the program saw and the observer neither accepted nor rejected.
    """

    coding: Coding
    begun: tuple[Occurrence, ...] = ()
    detected: Coding | None = None

    @property
    def proposed(self) -> tuple[Occurrence, ...]:
        """Return what the program saw and nobody decided yet."""
        return () if self.detected is None else self.detected.occurrences

    def settled(self, at_ms: int) -> Coding:
        """Return the coding with what was begun ended at `at_ms`, or before what it excludes."""
        coding = self.coding
        for one in sorted(self.begun, key=in_time, reverse=True):
            ends = [at_ms, coding.end_ms]
            ends += [
                other.begin_ms
                for other in coding.occurrences
                if other.begin_ms >= one.begin_ms and _cannot_last_together(coding, one, other)
            ]
            ended = replace(one, end_ms=max(min(ends), one.begin_ms))
            coding = replace(coding, occurrences=(*coding.occurrences, ended))
        return coding


@dataclass(frozen=True, slots=True)
class History(Generic[Thing]):
    """Something that changes step by step, and can go back and forth."""

    now: Thing
    before: tuple[Thing, ...] = ()
    after: tuple[Thing, ...] = ()

    def changed(self, thing: Thing) -> "History[Thing]":
        """Return the history with one more step; what was undone is forgotten."""
        return History(thing, (*self.before, self.now))

    def undone(self) -> "History[Thing]":
        """Return the history one step back; the same where there is none."""
        if not self.before:
            return self
        return History(self.before[-1], self.before[:-1], (self.now, *self.after))

    def redone(self) -> "History[Thing]":
        """Return the history one step forth; the same where there is none."""
        if not self.after:
            return self
        return History(self.after[0], (*self.before, self.now), self.after[1:])


def pressed(draft: Draft, behaviour: str, subject: str, at_ms: int) -> Draft:
    """Note a point event, begin a state, or end it where it was begun.

    A state that begins ends what was begun and cannot last beside it. One that would last no time
    is taken back.

    Raises
    ------
    BehaviourError
        It cannot be at that time: another one that is excluded lasts, or it ends before it begins.
    """
    new = Occurrence(behaviour, at_ms, at_ms, subject)
    if not draft.coding.ethogram.is_state(behaviour):
        return added(draft, new)
    if begun_of(draft, behaviour, subject) is not None:
        return released(draft, behaviour, subject, at_ms)
    _check(draft.coding, (*draft.coding.occurrences, new))
    for one in draft.begun:
        if _cannot_last_together(draft.coding, one, new):
            draft = released(draft, one.behaviour, subject, at_ms)
    return replace(draft, begun=(*draft.begun, new))


def released(draft: Draft, behaviour: str, subject: str, at_ms: int) -> Draft:
    """End a state that was begun; the same draft where it was not.

    Raises
    ------
    BehaviourError
        It would end before it begins, or reach into what it excludes.
    """
    one = begun_of(draft, behaviour, subject)
    if one is None:
        return draft
    rest = replace(draft, begun=tuple(other for other in draft.begun if other is not one))
    if at_ms == one.begin_ms:
        return rest
    return added(rest, replace(one, end_ms=at_ms))


def begun_of(draft: Draft, behaviour: str, subject: str) -> Occurrence | None:
    """Return the state that was begun and not ended; None where it was not begun."""
    return next(
        (one for one in draft.begun if (one.behaviour, one.subject) == (behaviour, subject)), None
    )


def added(draft: Draft, new: Occurrence) -> Draft:
    """Return the draft with one more event in the coding.

    Raises
    ------
    BehaviourError
        It does not fit.
    """
    return _with(draft, (*draft.coding.occurrences, new))


def changed(draft: Draft, old: Occurrence, new: Occurrence) -> Draft:
    """Return the draft with another event in the place of one: coded, begun or detected.

    Raises
    ------
    BehaviourError
        It does not fit beside the others of its coding.
    """
    if old in draft.coding.occurrences:
        return _with(draft, _replaced(draft.coding.occurrences, old, (new,)))
    if old in draft.begun:
        kept = replace(new, end_ms=new.begin_ms)
        _check(draft.coding, (*draft.coding.occurrences, kept))
        return replace(draft, begun=_replaced(draft.begun, old, (kept,)))
    return _with_proposed(draft, _replaced(draft.proposed, old, (new,)))


def removed(draft: Draft, old: Occurrence) -> Draft:
    """Return the draft without an event: deleted where it is coded, rejected where detected."""
    if old in draft.coding.occurrences:
        return _with(draft, _replaced(draft.coding.occurrences, old, ()))
    if old in draft.begun:
        return replace(draft, begun=_replaced(draft.begun, old, ()))
    if old in draft.proposed:
        return _with_proposed(draft, _replaced(draft.proposed, old, ()))
    return draft


def accepted(draft: Draft, found: Occurrence, subject: str) -> Draft:
    """Take a detected event into the coding.

    Parameters
    ----------
    draft : Draft
    found : Occurrence
        One of `draft.proposed`.
    subject : str
        Who it was, where the ethogram has nobody of the name that the program gave.

    Raises
    ------
    BehaviourError
        It does not fit beside what is coded, or the ethogram lacks its behaviour and is locked.
    """
    draft = _knowing(draft, found)
    names = draft.coding.ethogram.subject_names
    new = replace(found, subject=found.subject if found.subject in names else subject)
    rest = _with_proposed(draft, _replaced(draft.proposed, found, ()))
    return added(rest, new)


def _knowing(draft: Draft, found: Occurrence) -> Draft:
    """Return the draft whose scheme has the behaviour of a detected event, if it may have it."""
    ethogram = draft.coding.ethogram
    told = None if draft.detected is None else draft.detected.ethogram.behaviour(found.behaviour)
    if told is None or ethogram.is_locked or ethogram.behaviour(found.behaviour) is not None:
        return draft
    return with_ethogram(draft, replace(ethogram, behaviours=(*ethogram.behaviours, told)))


def with_detected(draft: Draft, found: Coding) -> Draft:
    """Return the draft with other proposals; what is coded already is not proposed again.

    Coded already is the same behaviour at half of the same time or more.
    """
    coded: dict[str, list[Occurrence]] = {}
    for one in draft.coding.occurrences:
        coded.setdefault(one.behaviour, []).append(one)
    left = tuple(
        one
        for one in found.occurrences
        if not any(_is_the_same(one, other) for other in coded.get(one.behaviour, ()))
    )
    return replace(draft, detected=replace(found, occurrences=left))


def _is_the_same(one: Occurrence, other: Occurrence) -> bool:
    shared_ms = min(one.end_ms, other.end_ms) - max(one.begin_ms, other.begin_ms)
    spanned_ms = max(one.end_ms, other.end_ms) - min(one.begin_ms, other.begin_ms)
    return 2 * shared_ms >= spanned_ms


def with_ethogram(
    draft: Draft, ethogram: Ethogram, called: Mapping[str, str] | None = None
) -> Draft:
    """Code by another scheme, which must know all that is coded.

    Parameters
    ----------
    draft : Draft
    ethogram : Ethogram
    called : mapping, optional
        What each behaviour that stays is called from now on, by what it was called; the same names
        if not given.

    Raises
    ------
    BehaviourError
        The scheme in use is locked, or the other one does not fit what is coded.
    """
    coding = draft.coding
    if coding.ethogram.is_locked:
        raise BehaviourError(
            "The coding scheme is locked: a second observer codes by the same one. Begin a coding "
            "of your own to change it."
        )
    occurrences = tuple(_called(one, called) for one in coding.occurrences)
    begun = tuple(_called(one, called) for one in draft.begun)
    _raise_first(ethogram, (*occurrences, *begun), (coding.begin_ms, coding.end_ms))
    return replace(
        draft, coding=replace(coding, ethogram=ethogram, occurrences=occurrences), begun=begun
    )


def _called(one: Occurrence, called: Mapping[str, str] | None) -> Occurrence:
    if called is None:
        return one
    if one.behaviour not in called:
        raise BehaviourError(
            "{behaviour} is coded, and the new scheme lacks it. Keep it, or delete its events "
            "first.",
            behaviour=one.behaviour,
        )
    return replace(one, behaviour=called[one.behaviour])


def with_subject(draft: Draft, name: str) -> Draft:
    """Return the draft whose scheme has one more subject; the same where it has that one."""
    ethogram = draft.coding.ethogram
    if name in ethogram.subject_names:
        return draft
    return with_ethogram(draft, replace(ethogram, subjects=(*ethogram.subjects, Subject(name))))


def with_section(draft: Draft, section: Section) -> Draft:
    """Return the draft with one more section; what of others lies in it is cut away.

    Raises
    ------
    BehaviourError
        It does not last, or lies outside the session.
    """
    coding = draft.coding
    if not coding.begin_ms <= section.begin_ms < section.end_ms <= coding.end_ms:
        raise BehaviourError(
            "A section begins before it ends, both within the session. Mark its begin and its end."
        )
    kept = chain.from_iterable(_outside(one, section) for one in coding.sections)
    sections = sorted((*kept, section), key=lambda one: one.begin_ms)
    return replace(draft, coding=replace(coding, sections=tuple(sections)))


def without_section(draft: Draft, section: Section) -> Draft:
    """Return the draft without a section."""
    kept = tuple(one for one in draft.coding.sections if one != section)
    return replace(draft, coding=replace(draft.coding, sections=kept))


def _outside(one: Section, cut: Section) -> list[Section]:
    """Return what of a section lies before and after another."""
    parts = [
        replace(one, end_ms=min(one.end_ms, cut.begin_ms)),
        replace(one, begin_ms=max(one.begin_ms, cut.end_ms)),
    ]
    return [part for part in parts if part.begin_ms < part.end_ms]


def _with(draft: Draft, occurrences: Sequence[Occurrence]) -> Draft:
    _check(draft.coding, (*occurrences, *draft.begun))
    return replace(draft, coding=replace(draft.coding, occurrences=tuple(occurrences)))


def _with_proposed(draft: Draft, occurrences: Sequence[Occurrence]) -> Draft:
    if draft.detected is None:
        return draft
    _check(draft.detected, occurrences)
    return replace(draft, detected=replace(draft.detected, occurrences=tuple(occurrences)))


def _check(coding: Coding, occurrences: Sequence[Occurrence]) -> None:
    _raise_first(coding.ethogram, occurrences, (coding.begin_ms, coding.end_ms))


def _raise_first(
    ethogram: Ethogram, occurrences: Iterable[Occurrence], observed_ms: tuple[int, int]
) -> None:
    for problem in problems_of(ethogram, tuple(occurrences), observed_ms):
        raise BehaviourError("Not noted: {problem}", problem=problem.sentence.text)


def _replaced(
    some: Sequence[Occurrence], old: Occurrence, new: tuple[Occurrence, ...]
) -> tuple[Occurrence, ...]:
    place = some.index(old)
    return (*some[:place], *new, *some[place + 1 :])


def _cannot_last_together(coding: Coding, one: Occurrence, other: Occurrence) -> bool:
    is_alike = one.subject == other.subject and coding.ethogram.is_state(other.behaviour)
    return is_alike and are_exclusive(one, other, coding.ethogram.exclusions)
