"""BORIS projects (`.boris`, JSON): ethogram, subjects and observations, read and written.

A state is two events of the same subject, behaviour and modifiers, the first its beginning.

Source: Friard & Gamba, BORIS: a free, versatile open-source event-logging software, Methods in
Ecology and Evolution 7 (2016); files of format 7.0 as versions 7 to 9 of the program write them.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from adibas.data.coding import Coding, Occurrence, Section, problems_of
from adibas.data.ethogram import Behaviour, Ethogram, Kind, Modifier, Subject
from adibas.errors import BehaviourError
from adibas.files import DAMAGED_JSON
from adibas.recordings.boris_writing import (
    NOBODY,
    OBSERVER,
    SECTIONS,
    SELECTIONS,
    modifier_values,
)
from adibas.recordings.coding_times import milliseconds

LARGEST_FILE_BYTES = 200_000_000
POINT_TYPES = ("Point event", "Point event with coding map")
N_FIELDS = 5


def read_boris(path: Path, ethogram: Ethogram | None = None) -> tuple[Coding, ...]:
    """Read every observation of a project, in the order of the file.

    Parameters
    ----------
    path : Path
    ethogram : Ethogram, optional
        In place of the project's own.

    Raises
    ------
    BehaviourError
        The file is missing, no project, or an event of it cannot be: which one is said.
    """
    document = _document(path)
    try:
        own = _ethogram(document)
        scheme = ethogram or own
        # What the project knows as a state has two events, whatever the scheme in its place says.
        kinds = {one.name: one.kind for one in (*scheme.behaviours, *own.behaviours)}
        return tuple(
            _coding(path, str(name), one, scheme, kinds)
            for name, one in document["observations"].items()
        )
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise BehaviourError(
            "{file} is damaged: a part of the BORIS project is missing or wrong. Open it in BORIS "
            "and save it again.",
            file=path.name,
        ) from error


def _document(path: Path) -> Mapping[str, Any]:
    try:
        if path.stat().st_size > LARGEST_FILE_BYTES:
            raise BehaviourError("{file} is larger than any BORIS project.", file=path.name)
        document = json.loads(path.read_text("utf-8-sig"))
    except (OSError, *DAMAGED_JSON) as error:
        raise BehaviourError(
            "{file} cannot be read: {reason}. Give a BORIS project.",
            file=path.name,
            reason=getattr(error, "strerror", None) or str(error),
        ) from error
    if not isinstance(document, dict) or not {"behaviors_conf", "observations"} <= set(document):
        raise BehaviourError("{file} is no BORIS project. Give one.", file=path.name)
    return document


def _ethogram(document: Mapping[str, Any]) -> Ethogram:
    ours = document.get("adibas", {})
    sources = ours.get("behaviour_sources", {})
    behaviours = [_behaviour(one, sources) for one in _ordered(document["behaviors_conf"])]
    names = {one.name for one in behaviours}
    known = tuple(
        replace(
            one,
            excludes=tuple(other for other in one.excludes if other in names and other != one.name),
        )
        for one in behaviours
    )
    return Ethogram(
        str(document.get("project_name", "")),
        known,
        tuple(
            Subject(str(one["name"]), str(one.get("key", "")), str(one.get("description", "")))
            for one in _ordered(document.get("subjects_conf", {}))
        ),
        str(document.get("project_description", "")),
        tuple(map(str, ours.get("sources", ()))),
        bool(ours.get("locked", False)),
    )


def _ordered(numbered: Mapping[str, Any]) -> list[Any]:
    return [numbered[number] for number in sorted(numbered, key=int)]


def _behaviour(conf: Mapping[str, Any], sources: Mapping[str, Any]) -> Behaviour:
    name = str(conf["code"])
    modifiers = conf.get("modifiers") or {}
    if isinstance(modifiers, str):  # version 2: the values of one set, between commas
        modifiers = {"0": {"name": "", "type": 0, "values": modifiers.split(",")}}
    return Behaviour(
        name,
        "point" if conf["type"] in POINT_TYPES else "state",
        str(conf.get("description", "")),
        str(conf.get("key", "")),
        str(conf.get("category", "")),
        str(conf.get("color", "")),
        tuple(_modifier(one) for one in _ordered(modifiers)),
        tuple(one for one in str(conf.get("excluded", "")).split(",") if one),
        tuple(map(str, sources.get(name, ()))),
    )


def _modifier(conf: Mapping[str, Any]) -> Modifier:
    # A key in brackets may follow a value: "walking (w)".
    values = (str(value).split(" (", maxsplit=1)[0].strip() for value in conf.get("values", ()))
    return Modifier(
        str(conf.get("name", "")),
        tuple(value for value in values if value),
        SELECTIONS[int(conf.get("type", 0))],
        str(conf.get("description", "")),
    )


def _coding(
    path: Path,
    name: str,
    conf: Mapping[str, Any],
    ethogram: Ethogram,
    kinds: Mapping[str, Kind],
) -> Coding:
    events = [list(event) for event in conf["events"]]
    occurrences, places = _paired(path, name, events, kinds)
    begin_ms, end_ms = _observed_ms(conf, occurrences)
    for problem in problems_of(ethogram, occurrences, (begin_ms, end_ms)):
        raise BehaviourError(
            "{file}, observation {name}, event {number}: {problem}",
            file=path.name,
            name=name,
            number=places[problem.place] + 1,
            problem=problem.sentence.text,
        )
    told = {str(key): str(value) for key, value in conf.get("independent_variables", {}).items()}
    observer, sections = told.pop(OBSERVER, ""), told.pop(SECTIONS, "[]")
    return Coding(
        name,
        ethogram,
        begin_ms,
        end_ms,
        tuple(occurrences),
        observer,
        tuple(Section(str(kind), int(a), int(b)) for kind, a, b in json.loads(sections or "[]")),
        str(conf.get("description", "")),
        str(conf.get("date", "")),
        tuple(_media(conf)),
        tuple(told.items()),
    )


def _media(conf: Mapping[str, Any]) -> list[str]:
    files = conf.get("file") or {}
    return [str(one) for one in files.get("1", ())] if isinstance(files, dict) else []


def _observed_ms(conf: Mapping[str, Any], occurrences: Sequence[Occurrence]) -> tuple[int, int]:
    """Return the interval that was told, or the length of the media; to the last event at least."""
    told = conf.get("observation time interval", (0, 0))
    begin_ms, end_ms = (milliseconds(one) for one in told)
    last_ms = max((one.end_ms for one in occurrences), default=0)
    first_ms = min((one.begin_ms for one in occurrences), default=0)
    if end_ms <= begin_ms:
        lengths = conf.get("media_info", {}).get("length", {})
        end_ms = sum(milliseconds(lengths[one]) for one in _media(conf) if one in lengths)
    return min(begin_ms, first_ms), max(end_ms, last_ms, begin_ms)


def _paired(
    path: Path, name: str, events: Sequence[Sequence[Any]], kinds: Mapping[str, Kind]
) -> tuple[list[Occurrence], list[int]]:
    """Return occurrences, and the place of the event that began each.

    Raises
    ------
    BehaviourError
        A state does not end.
    """
    begun: dict[tuple[str, str, str], int] = {}
    found: list[Occurrence] = []
    places: list[int] = []
    for place in sorted(range(len(events)), key=lambda at: float(events[at][0])):
        _time, subject, code, told, _comment = map(str, events[place][:N_FIELDS])
        is_state = kinds.get(code) == "state"
        key = (subject, code, told)
        if is_state and key not in begun:
            begun[key] = place
            continue
        first = begun.pop(key) if is_state else place
        found.append(_occurrence(events[first], events[place], is_state=is_state))
        places.append(first)
    if begun:
        (_subject, code, _told), place = min(begun.items(), key=lambda item: item[1])
        raise BehaviourError(
            "{file}, observation {name}, event {number}: {behaviour} begins at {at} s and does not "
            "end. Add its end, or remove it.",
            file=path.name,
            name=name,
            number=place + 1,
            behaviour=code,
            at=events[place][0],
        )
    return found, places


def _occurrence(first: Sequence[Any], last: Sequence[Any], *, is_state: bool) -> Occurrence:
    return Occurrence(
        str(first[2]),
        milliseconds(first[0]),
        milliseconds(last[0]),
        "" if str(first[1]) == NOBODY else str(first[1]),
        modifier_values(str(first[3])),
        str(first[4]),
        str(last[4]) if is_state else "",
    )
