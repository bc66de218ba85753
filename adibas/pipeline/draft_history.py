"""Every step of a coding, so that it can be taken back on another day.

Beside the coding itself a text holds the draft that was kept last in full, and each step from it
back and forth as what changed: events that stand in the place of others, and the rest of a coding
where that changed, too.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from adibas.behaviour.editing import Draft, History
from adibas.data.coding import Coding, Occurrence
from adibas.data.sentence import Sentence
from adibas.errors import AdibasError
from adibas.files import DAMAGED_JSON, check_document, whole_letters
from adibas.pipeline.coding_drafts import CODED, DETECTED, DraftPlace, read_draft, write_draft
from adibas.recordings.coding_csv import coding_csv_text, codings_of_csv
from adibas.texts import message

STEPS, BLIND = "steps", "blind"
FORMAT, VERSION = "adibas-coding-steps", 1
MOST_STEPS = 100
"""That are kept in each direction."""
DAMAGED = message(
    "What was coded is all there, but its steps cannot be read: it cannot be undone step by step."
)

Document = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Kept:
    """What was kept of a coding, with its steps, and what is to be said of it."""

    history: History[Draft]
    notice: Sentence | None = None


def write_history(place: DraftPlace, history: History[Draft], at_ms: int) -> None:
    """Keep a draft and its steps; states without an end are kept as if they ended at `at_ms`.

    Raises
    ------
    FileError, StoreError
        It cannot be written.
    """
    write_draft(place, history.now, at_ms)
    now = history.now
    base = Draft(now.settled(at_ms), (), now.detected)
    before, after = history.before, history.after
    if base != now:  # what lasts now is one step back: undone, it lasts again
        before, after = (*before, now), ()
    document = {
        "format": FORMAT,
        "version": VERSION,
        "base": _whole(base),
        "back": _steps(base, before[: -MOST_STEPS - 1 : -1]),
        "forth": _steps(base, after[:MOST_STEPS]),
    }
    place.write(STEPS, whole_letters(json.dumps(document, ensure_ascii=False)))


def read_history(place: DraftPlace) -> Kept | None:
    """Return the draft that is kept at a place, with its steps; None where there is none.

    A draft that was changed by another program since is one step more.

    Raises
    ------
    RecordingError, StoreError
        A part cannot be read.
    BehaviourError, ProtocolError
        It is no coding any more.
    """
    draft = read_draft(place)
    if draft is None:
        return None
    text = place.read(STEPS)
    if text is None:
        return Kept(History(draft))
    try:
        history = _history(json.loads(text))
    except (AdibasError, LookupError, TypeError, AttributeError, *DAMAGED_JSON):
        return Kept(History(draft), Sentence(DAMAGED))
    return Kept(history if history.now == draft else history.changed(draft))


def note_blind(place: DraftPlace, observer: str) -> None:
    """Note beside the first observer's coding that a second one codes blind; empty: nobody.

    Raises
    ------
    FileError, StoreError
        It cannot be written.
    """
    place.write(BLIND, observer)


def blind_observer(place: DraftPlace) -> str:
    """Return the initials of who codes blind; empty for nobody.

    Raises
    ------
    RecordingError, StoreError
        The note cannot be read.
    """
    return (place.read(BLIND) or "").strip()


def _history(document: Document) -> History[Draft]:
    check_document(document, FORMAT, VERSION)
    base = _draft(document["base"])
    back = _drafts(base, document["back"])
    return History(base, tuple(reversed(back)), tuple(_drafts(base, document["forth"])))


def _steps(base: Draft, drafts: Sequence[Draft]) -> list[Document]:
    """Return what changes from each draft to the next, from `base` on."""
    return [_step(one, other) for one, other in pairwise((base, *drafts))]


def _drafts(base: Draft, steps: Sequence[Document]) -> list[Draft]:
    found = []
    for step in steps:
        base = _stepped(base, step)
        found.append(base)
    return found


def _step(old: Draft, new: Draft) -> Document:
    step: Document = {}
    if _frame(old.coding) != _frame(new.coding):
        step[CODED] = coding_csv_text([_frame(new.coding)])
    seen = [None if one.detected is None else _frame(one.detected) for one in (old, new)]
    if seen[0] != seen[1]:
        step[DETECTED] = _told(seen[1])
    for name, before, after in (
        ("events", old.coding.occurrences, new.coding.occurrences),
        ("begun", old.begun, new.begun),
        ("proposed", old.proposed, new.proposed),
    ):
        if before != after:
            step[name] = _change(before, after)
    return step


def _stepped(draft: Draft, step: Document) -> Draft:
    coding = _coding(step[CODED]) if CODED in step else draft.coding
    detected = _detected(step[DETECTED]) if DETECTED in step else draft.detected
    proposed = _changed(draft.proposed, step.get("proposed"))
    return Draft(
        replace(coding, occurrences=_changed(draft.coding.occurrences, step.get("events"))),
        _changed(draft.begun, step.get("begun")),
        None if detected is None else replace(detected, occurrences=proposed),
    )


def _frame(coding: Coding) -> Coding:
    """Return a coding without its events."""
    return replace(coding, occurrences=())


def _change(old: Sequence[Occurrence], new: Sequence[Occurrence]) -> list[Any]:
    """Return where `new` differs: from, to in `old`, and the events that stand there."""
    least = min(len(old), len(new))
    same = next((k for k in range(least) if not _is_same(old[k], new[k])), least)
    left = least - same
    end = next((k for k in range(left) if not _is_same(old[-1 - k], new[-1 - k])), left)
    return [same, len(old) - end, [_listed(one) for one in new[same : len(new) - end]]]


def _is_same(one: Occurrence, other: Occurrence) -> bool:
    return one is other or one == other


def _changed(old: tuple[Occurrence, ...], change: list[Any] | None) -> tuple[Occurrence, ...]:
    if change is None:
        return old
    begin, end, some = change
    return (*old[:begin], *map(_occurrence, some), *old[end:])


def _listed(one: Occurrence) -> list[Any]:
    return [
        *(one.behaviour, one.begin_ms, one.end_ms, one.subject),
        *(list(one.modifiers), one.comment, one.end_comment),
    ]


def _occurrence(listed: list[Any]) -> Occurrence:
    behaviour, begin_ms, end_ms, subject, modifiers, *comments = listed
    return Occurrence(behaviour, begin_ms, end_ms, subject, tuple(modifiers), *comments)


def _whole(draft: Draft) -> Document:
    return {CODED: coding_csv_text([draft.coding]), DETECTED: _told(draft.detected)}


def _draft(whole: Document) -> Draft:
    return Draft(_coding(whole[CODED]), (), _detected(whole[DETECTED]))


def _told(detected: Coding | None) -> str | None:
    return None if detected is None else coding_csv_text([detected])


def _detected(told: str | None) -> Coding | None:
    return None if told is None else _coding(told)


def _coding(told: str) -> Coding:
    (coding,) = codings_of_csv(told, STEPS)
    return coding
