"""Codings as BORIS projects."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from adibas.data.coding import MS_PER_S, Coding
from adibas.data.ethogram import Behaviour, Selection
from adibas.errors import BehaviourError
from adibas.files import whole_letters, written_whole

PROJECT_VERSION = "7.0"
OBSERVER, SECTIONS = "observer", "adibas sections"
"""Variables of an observation that carry what BORIS has no place for."""
STATE_TYPE, POINT_TYPE = "State event", "Point event"
SELECTIONS: tuple[Selection, ...] = ("one", "several", "number", "number")
NOT_TOLD = "None"
NOBODY = "No focal subject"
"""What tables of BORIS have in place of a subject; projects leave it empty."""


def write_boris(path: Path, codings: Sequence[Coding]) -> None:
    """Write codings of one ethogram as a project.

    Raises
    ------
    BehaviourError
        They are of different ethograms, or two have the same name.
    FileError
        The file cannot be written.
    """
    with written_whole(path) as unfinished:
        text = json.dumps(project_document(codings), indent=1, ensure_ascii=False, allow_nan=False)
        unfinished.write_text(whole_letters(text), "utf-8")


def project_document(codings: Sequence[Coding]) -> dict[str, Any]:
    """Return codings as BORIS has them.

    Raises
    ------
    BehaviourError
        They are of different ethograms, two have the same name, or there is none.
    """
    check_one_scheme(codings)
    ethogram = codings[0].ethogram
    labels = list(dict.fromkeys(label for one in codings for label, _ in _variables(one)))
    return {
        "time_format": "s",
        "project_date": codings[0].date,
        "project_name": ethogram.name,
        "project_description": ethogram.description,
        "project_format_version": PROJECT_VERSION,
        "subjects_conf": {
            str(place): {"key": one.key, "name": one.name, "description": one.description}
            for place, one in enumerate(ethogram.subjects)
        },
        "behaviors_conf": {
            str(place): _behaviour_document(one) for place, one in enumerate(ethogram.behaviours)
        },
        "behavioral_categories": list(
            dict.fromkeys(one.category for one in ethogram.behaviours if one.category)
        ),
        "independent_variables": {
            str(place): {
                "label": label,
                "description": "",
                "type": "text",
                "default value": "",
                "possible values": "",
            }
            for place, label in enumerate(labels)
        },
        "coding_map": {},
        "behaviors_coding_map": [],
        "converters": {},
        "observations": {one.name: _observation(one) for one in codings},
        # BORIS does not know this; it carries what its own format has no place for.
        "adibas": {
            "sources": list(ethogram.sources),
            "locked": ethogram.is_locked,
            "behaviour_sources": {one.name: list(one.sources) for one in ethogram.behaviours},
        },
    }


def check_one_scheme(codings: Sequence[Coding]) -> None:
    """See that codings fit in one file.

    Raises
    ------
    BehaviourError
        There is none, they have different ethograms, or two have one name.
    """
    if not codings:
        raise BehaviourError("There is no coding to write. Code a session first.")
    names = [one.name for one in codings]
    if any(one.ethogram != codings[0].ethogram for one in codings) or len(set(names)) < len(names):
        raise BehaviourError(
            "These codings have different ethograms, or two have the same name. Write them into "
            "files of their own."
        )


def told_modifiers(behaviour: Behaviour | None, values: Sequence[str]) -> str:
    """Return the values as BORIS writes them."""
    n_modifiers = 0 if behaviour is None else len(behaviour.modifiers)
    padded = [*values, *[""] * (n_modifiers - len(values))]
    return "|".join(one or NOT_TOLD for one in padded)


def modifier_values(told: str) -> tuple[str, ...]:
    """Return the values that `told_modifiers` gave; empty where none was told."""
    return tuple("" if one == NOT_TOLD else one for one in told.split("|"))


def _behaviour_document(one: Behaviour) -> dict[str, Any]:
    return {
        "type": STATE_TYPE if one.kind == "state" else POINT_TYPE,
        "key": one.key,
        "code": one.name,
        "description": one.description,
        "color": one.color,
        "category": one.category,
        "modifiers": {
            str(place): {
                "name": modifier.name,
                "description": modifier.description,
                "type": SELECTIONS.index(modifier.selection),
                "values": list(modifier.values),
            }
            for place, modifier in enumerate(one.modifiers)
        },
        "excluded": ",".join(one.excludes),
        "coding map": "",
    }


def _variables(one: Coding) -> list[tuple[str, str]]:
    told = list(one.variables)
    if one.observer:
        told.append((OBSERVER, one.observer))
    if one.sections:
        sections = [[part.name, part.begin_ms, part.end_ms] for part in one.sections]
        told.append((SECTIONS, json.dumps(sections, ensure_ascii=False)))
    return told


def _observation(one: Coding) -> dict[str, Any]:
    events = []
    for part in one.occurrences:
        behaviour = one.ethogram.behaviour(part.behaviour)
        told = told_modifiers(behaviour, part.modifiers)
        is_state = behaviour is not None and behaviour.kind == "state"
        first = [part.begin_ms / MS_PER_S, part.subject, part.behaviour, told, part.comment]
        events.append(first)
        if is_state:
            events.append([part.end_ms / MS_PER_S, *first[1:4], part.end_comment])
    return {
        "file": {"1": list(one.media)} if one.media else {},
        "type": "MEDIA" if one.media else "LIVE",
        "date": one.date,
        "description": one.description,
        "time offset": 0.0,
        # A stable sort leaves an end before the next beginning of the same time.
        "events": sorted(events, key=lambda event: float(str(event[0]))),
        "observation time interval": [one.begin_ms / MS_PER_S, one.end_ms / MS_PER_S],
        "independent_variables": dict(_variables(one)),
        "visualize_spectrogram": False,
        "visualize_waveform": False,
        "close_behaviors_between_videos": False,
        "scan_sampling_time": 0,
        "media_info": {
            "length": dict.fromkeys(one.media, one.end_ms / MS_PER_S),
            "fps": {},
            "hasVideo": {},
            "hasAudio": {},
            "offset": {"1": 0.0},
        },
    }
