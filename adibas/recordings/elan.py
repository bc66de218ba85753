"""ELAN annotation files (`.eaf`): a tier for each subject and behaviour, read and written.

Source: EAF Annotation Format, schema EAFv3.0.xsd, Max Planck Institute for Psycholinguistics.
"""

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from adibas.data.coding import Coding, Occurrence, Section, problems_of
from adibas.data.ethogram import Behaviour, Ethogram, Subject
from adibas.errors import BehaviourError
from adibas.files import DAMAGED_JSON
from adibas.recordings.elan_writing import INSTANT, PROPERTY, SECTION_TIER
from adibas.recordings.ethogram_json import ethogram_of_text

BETWEEN = "@"
"""Between behaviour and subject in the names of other people's tiers."""
LARGEST_FILE_BYTES = 200_000_000
DOCTYPE = re.compile(rb"<!(DOCTYPE|ENTITY)", re.IGNORECASE)


def read_elan(path: Path, ethogram: Ethogram | None = None) -> Coding:
    """Read annotations that have times of their own.

    In a file of ours everything is as it was, with what was moved in ELAN. In any other one, and in
    tiers that were added to ours, each tier is a behaviour (``behaviour@participant`` as ELAN's
    users name them), each annotation a state, and its text the comment.

    Raises
    ------
    BehaviourError
        The file is missing, no annotation file, or does not fit the ethogram.
    """
    root = _root(path)
    try:
        ours = json.loads(_property(root, PROPERTY) or "{}")
        return _ours(path, root, ours, ethogram) if ours else _others(path, root, ethogram)
    except (KeyError, TypeError, AttributeError, *DAMAGED_JSON) as error:
        raise BehaviourError(
            "{file} is damaged: a part of the ELAN file is missing or wrong. Open it in ELAN and "
            "save it again.",
            file=path.name,
        ) from error


def _root(path: Path) -> ET.Element:
    try:
        if path.stat().st_size > LARGEST_FILE_BYTES:
            raise BehaviourError("{file} is larger than any ELAN file.", file=path.name)
        text = path.read_bytes()
        if DOCTYPE.search(text):  # ELAN writes none, and entities can grow without end
            raise BehaviourError("{file} is no ELAN file. Give one.", file=path.name)
        root = ET.fromstring(text)  # noqa: S314  (no entities: see above)
    except (OSError, LookupError, ValueError, ET.ParseError) as error:  # of an unknown encoding
        raise BehaviourError(
            "{file} cannot be read: {reason}. Give an ELAN file.",
            file=path.name,
            reason=getattr(error, "strerror", None) or str(error),
        ) from error
    if root.tag != "ANNOTATION_DOCUMENT":
        raise BehaviourError("{file} is no ELAN file. Give one.", file=path.name)
    return root


def _property(root: ET.Element, name: str) -> str:
    found = root.find(f"HEADER/PROPERTY[@NAME='{name}']")
    return "" if found is None else found.text or ""


def _annotations(root: ET.Element) -> dict[str, list[tuple[int, int, str]]]:
    """Return begin, end and text of each annotation with times, by tier."""
    times = {
        slot.attrib["TIME_SLOT_ID"]: int(slot.attrib["TIME_VALUE"])
        for slot in root.iter("TIME_SLOT")
        if "TIME_VALUE" in slot.attrib
    }
    found: dict[str, list[tuple[int, int, str]]] = {}
    for tier in root.iter("TIER"):
        spans = found.setdefault(tier.attrib["TIER_ID"], [])
        for one in tier.iter("ALIGNABLE_ANNOTATION"):
            slots = [one.attrib[f"TIME_SLOT_REF{end}"] for end in (1, 2)]
            if all(slot in times for slot in slots):
                text = one.findtext("ANNOTATION_VALUE") or ""
                spans.append((times[slots[0]], times[slots[1]], text))
    return found


def _ours(path: Path, root: ET.Element, ours: dict[str, Any], ethogram: Ethogram | None) -> Coding:
    own = ethogram_of_text(json.dumps(ours["ethogram"]), path.name)
    scheme = ethogram or own
    annotations = _annotations(root)
    tiers = {tier: (behaviour, subject) for tier, behaviour, subject in ours["tiers"]}
    added = {tier: _named(tier, who) for tier, who in _people(root).items() if tier not in tiers}
    added.pop(SECTION_TIER, None)
    occurrences = [
        _occurrence(scheme if tier in added else own, behaviour, subject, span)
        for tier, (behaviour, subject) in (tiers | added).items()
        for span in annotations.get(tier, ())
    ]
    begin_ms, end_ms = ours["observed_ms"]
    _check(path, scheme, occurrences, (begin_ms, end_ms))
    sections = tuple(
        Section(name, begin, begin if (begin, name) in instants else end)
        for instants in [{(at, name) for name, at in ours["instant_sections"]}]
        for begin, end, name in annotations.get(SECTION_TIER, ())
    )
    return Coding(
        *(ours["name"], scheme, begin_ms, end_ms, tuple(occurrences)),
        root.attrib.get("AUTHOR", ""),
        sections,
        ours["description"],
        ours["date"],
        tuple(one.attrib["MEDIA_URL"] for one in root.iter("MEDIA_DESCRIPTOR")),
        tuple((str(name), str(value)) for name, value in ours["variables"]),
    )


def _occurrence(
    ethogram: Ethogram, name: str, subject: str, span: tuple[int, int, str]
) -> Occurrence:
    begin, end, text = span
    told = json.loads(text) if text.startswith("{") else {"comment": text}
    behaviour = ethogram.behaviour(name)
    is_point = behaviour is not None and behaviour.kind == "point"
    return Occurrence(
        name,
        begin,
        begin if is_point or told.get(INSTANT) else end,
        subject,
        tuple(map(str, told.get("modifiers", ()))),
        str(told.get("comment", "")),
        str(told.get("end", "")),
    )


def _people(root: ET.Element) -> dict[str, str]:
    """Return the participant of each tier; empty where none is told."""
    return {
        tier.attrib["TIER_ID"]: tier.attrib.get("PARTICIPANT", "") for tier in root.iter("TIER")
    }


def _named(tier: str, participant: str) -> tuple[str, str]:
    """Return behaviour and subject of a tier that somebody named."""
    behaviour, _at, subject = tier.partition(BETWEEN)
    return behaviour, participant or subject


def _others(path: Path, root: ET.Element, ethogram: Ethogram | None) -> Coding:
    people = _people(root)
    found = []
    for tier, spans in _annotations(root).items():
        behaviour, who = _named(tier, people[tier])
        found += [Occurrence(behaviour, *span[:2], who, comment=span[2]) for span in spans]
    if ethogram is None:
        names = dict.fromkeys(one.behaviour for one in found)
        subjects = dict.fromkeys(one.subject for one in found if one.subject)
        ethogram = Ethogram(path.stem, tuple(map(Behaviour, names)), tuple(map(Subject, subjects)))
    observed = (
        min([0, *(one.begin_ms for one in found)]),
        max([0, *(one.end_ms for one in found)]),
    )
    _check(path, ethogram, found, observed)
    media = tuple(one.attrib["MEDIA_URL"] for one in root.iter("MEDIA_DESCRIPTOR"))
    author = root.attrib.get("AUTHOR", "")
    date = root.attrib.get("DATE", "")
    return Coding(path.stem, ethogram, *observed, tuple(found), author, date=date, media=media)


def _check(
    path: Path, ethogram: Ethogram, found: list[Occurrence], observed_ms: tuple[int, int]
) -> None:
    for problem in problems_of(ethogram, found, observed_ms):
        raise BehaviourError("{file}: {problem}", file=path.name, problem=problem.sentence.text)
