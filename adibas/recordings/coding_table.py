"""Codings as one table, the same for CSV and Excel: rows of events, sessions and sections.

The columns begin as those of `events.csv`; rows of kind ``session`` and ``section`` say from when
to when was observed and under which condition.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest

from adibas.data.coding import Coding, Occurrence, Section, problems_of
from adibas.data.ethogram import (
    BETWEEN_VALUES,
    NO_VALUE,
    Behaviour,
    Ethogram,
    Modifier,
    Subject,
)
from adibas.errors import BehaviourError
from adibas.recordings.boris_writing import modifier_values, told_modifiers
from adibas.recordings.coding_times import milliseconds, seconds_text

NEEDED = ("recording", "label", "begin_s", "end_s")
COLUMNS = (
    *NEEDED,
    *("subject", "kind", "observer", "modifiers", "comment", "end_comment", "details"),
)
SESSION, SECTION, STATE, POINT = "session", "section", "state", "point"
FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r", "'")

Row = tuple[int, Mapping[str, str]]
"""The line or row in the file, and the cells by the names of their columns."""


@dataclass(slots=True)
class _Session:
    """What the rows of one observer and recording say."""

    line: int
    observed_ms: tuple[int, int] | None = None
    date: str = ""
    media: tuple[str, ...] = ()
    variables: tuple[tuple[str, str], ...] = ()
    description: str = ""
    occurrences: list[Occurrence] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    sections: list[Section] = field(default_factory=list)


def rows_of(codings: Sequence[Coding]) -> Iterator[dict[str, str]]:
    """Yield the cells of each row."""
    for one in codings:
        whose = {"recording": one.name, "observer": one.observer}
        details = {"date": one.date, "media": list(one.media), "variables": list(one.variables)}
        yield {
            **whose,
            **_span("", one.begin_ms, one.end_ms),
            "kind": SESSION,
            "comment": one.description,
            "details": json.dumps(details, ensure_ascii=False),
        }
        for section in one.sections:
            yield {
                **whose,
                **_span(section.name, section.begin_ms, section.end_ms),
                "kind": SECTION,
            }
        for part in one.occurrences:
            behaviour = one.ethogram.behaviour(part.behaviour)
            yield {
                **whose,
                **_span(part.behaviour, part.begin_ms, part.end_ms),
                "subject": part.subject,
                "kind": STATE if behaviour is None else behaviour.kind,
                "modifiers": told_modifiers(behaviour, part.modifiers) if part.modifiers else "",
                "comment": part.comment,
                "end_comment": part.end_comment,
            }


def codings_of_rows(
    file: str, rows: Sequence[Row], ethogram: Ethogram | None
) -> tuple[Coding, ...]:
    """Return the codings that rows say.

    Parameters
    ----------
    file : str
        Its name, for errors.
    rows : sequence of Row
    ethogram : Ethogram or None
        None: what occurs is the ethogram.

    Raises
    ------
    BehaviourError
        A row is no event, session or section, or does not fit the ethogram; its line is told.
    """
    sessions: dict[tuple[str, str], _Session] = {}
    for line, row in rows:
        try:
            _take(sessions, line, row)
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise BehaviourError(
                "{file}, line {line} is no event: it needs a recording, a label, and times in "
                "seconds.",
                file=file,
                line=line,
            ) from error
    scheme = ethogram or _ethogram(rows)
    return tuple(
        _coding(file, name, observer, session, scheme)
        for (name, observer), session in sessions.items()
    )


def shielded(text: str) -> str:
    """Return text that no spreadsheet runs as a formula.

    Source: OWASP, CSV Injection.
    """
    return f"'{text}" if text.startswith(FORMULA_STARTS) else text


def unshielded(text: str) -> str:
    """Return what `shielded` was given."""
    return text.removeprefix("'")


def _span(label: str, begin_ms: int, end_ms: int) -> dict[str, str]:
    return {"label": label, "begin_s": seconds_text(begin_ms), "end_s": seconds_text(end_ms)}


def _take(sessions: dict[tuple[str, str], _Session], line: int, row: Mapping[str, str]) -> None:
    name, kind = row["recording"], row.get("kind") or STATE
    label, begin_ms, end_ms = row["label"], milliseconds(row["begin_s"]), milliseconds(row["end_s"])
    if not name or kind not in (SESSION, SECTION, STATE, POINT) or not (label or kind == SESSION):
        raise ValueError(f"no such row: {kind}")
    session = sessions.setdefault((name, row.get("observer", "")), _Session(line))
    if kind == SESSION:
        session.observed_ms = (begin_ms, end_ms)
        _take_details(session, row.get("details") or "{}")
        session.description = row.get("comment", "")
    elif kind == SECTION:
        session.sections.append(Section(label, begin_ms, end_ms))
    else:
        modifiers = modifier_values(row.get("modifiers", ""))
        session.occurrences.append(
            Occurrence(
                *(label, begin_ms, end_ms, row.get("subject", ""), modifiers),
                row.get("comment", ""),
                row.get("end_comment", ""),
            )
        )
        session.lines.append(line)


def _take_details(session: _Session, text: str) -> None:
    """Take what columns have no place for.

    Raises
    ------
    ValueError, TypeError, RecursionError
        It is no JSON, or not of `rows_of`.
    """
    details = json.loads(text)
    if not isinstance(details, dict):
        raise TypeError("the details of a session are an object")
    session.date = str(details.get("date", ""))
    session.media = tuple(map(str, details.get("media", ())))
    session.variables = tuple((str(a), str(b)) for a, b in details.get("variables", ()))


def _ethogram(rows: Sequence[Row]) -> Ethogram:
    """Return the ethogram of what occurs; it knows no exclusions or keys."""
    kinds: dict[str, str] = {}
    told: dict[str, list[tuple[str, ...]]] = {}
    subjects: dict[str, None] = {}
    for _line, row in rows:
        kind = row.get("kind") or STATE
        if kind in (STATE, POINT):
            kinds.setdefault(row["label"], kind)
            told.setdefault(row["label"], []).append(modifier_values(row.get("modifiers", "")))
            subjects[row.get("subject", "")] = None
    subjects.pop("", None)
    behaviours = tuple(
        Behaviour(name, "point" if kind == POINT else "state", modifiers=_modifiers(told[name]))
        for name, kind in kinds.items()
    )
    return Ethogram("", behaviours, tuple(map(Subject, subjects)))


def _modifiers(told: Sequence[tuple[str, ...]]) -> tuple[Modifier, ...]:
    """Return modifiers that know the values of all events of a behaviour."""
    places = zip_longest(*told, fillvalue=NO_VALUE)
    found = [{one for one in values if one != NO_VALUE} for values in places]
    return tuple(
        Modifier(
            f"modifier {number}",
            tuple(sorted({part for one in values for part in one.split(BETWEEN_VALUES)})),
            "several" if any(BETWEEN_VALUES in one for one in values) else "one",
        )
        for number, values in enumerate(found, 1)
        if any(found)
    )


def _coding(file: str, name: str, observer: str, session: _Session, ethogram: Ethogram) -> Coding:
    ends = [one.end_ms for one in session.occurrences] + [one.end_ms for one in session.sections]
    begins = [one.begin_ms for one in session.occurrences]
    observed = session.observed_ms or (min([0, *begins]), max([0, *ends]))
    for problem in problems_of(ethogram, session.occurrences, observed):
        raise BehaviourError(
            "{file}, line {line}: {problem}",
            file=file,
            line=session.lines[problem.place],
            problem=problem.sentence.text,
        )
    try:
        return Coding(
            *(name, ethogram, *observed, tuple(session.occurrences), observer),
            tuple(session.sections),
            session.description,
            session.date,
            session.media,
            session.variables,
        )
    except ValueError as error:
        raise BehaviourError(
            "{file}, line {line}: the session ends before it begins, or its sections overlap or "
            "lie outside. Correct the times.",
            file=file,
            line=session.line,
        ) from error
