"""Codings as ELAN annotation files, which ELAN opens and other programs read."""

import json
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from adibas.data.coding import Coding, Occurrence
from adibas.data.ethogram import Behaviour
from adibas.files import printable, written_whole
from adibas.recordings.ethogram_json import ethogram_document

XSI = "http://www.w3.org/2001/XMLSchema-instance"
SCHEMA = "http://www.mpi.nl/tools/elan/EAFv3.0.xsd"
PROPERTY, SECTION_TIER, TYPE, INSTANT = "adibas", "adibas sections", "behaviour", "instant"
POINT_MS = 1
"""How long a point event is drawn: ELAN has none, and holds nothing that does not last."""
NO_DATE = "1970-01-01T00:00:00+00:00"
CONSTRAINTS = {
    "Time_Subdivision": "Time subdivision of parent annotation's time interval, no time gaps "
    "allowed within this interval",
    "Symbolic_Subdivision": "Symbolic subdivision of a parent annotation. Annotations refering to "
    "the same parent are ordered",
    "Symbolic_Association": "1-1 association with a parent annotation",
    "Included_In": "Time alignable annotations within the parent annotation's time interval, gaps "
    "are allowed",
}

Span = tuple[int, int, str]


@dataclass(frozen=True, slots=True)
class _Tier:
    name: str
    behaviour: str
    subject: str
    spans: Sequence[Span]


def write_elan(path: Path, coding: Coding) -> None:
    """Write a coding as an ELAN file.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    tree = ET.ElementTree(elan_document(coding))
    ET.indent(tree, " ")
    with written_whole(path) as unfinished:
        tree.write(unfinished, encoding="UTF-8", xml_declaration=True)


def elan_document(coding: Coding) -> ET.Element:
    """Return the XML of a coding."""
    tiers = list(_tiers(coding))
    root = ET.Element(
        "ANNOTATION_DOCUMENT",
        {
            "AUTHOR": coding.observer,
            "DATE": _date(coding.date),
            "FORMAT": "3.0",
            "VERSION": "3.0",
            f"{{{XSI}}}noNamespaceSchemaLocation": SCHEMA,
        },
    )
    header = ET.SubElement(root, "HEADER", {"MEDIA_FILE": "", "TIME_UNITS": "milliseconds"})
    for name in coding.media:
        ET.SubElement(header, "MEDIA_DESCRIPTOR", {"MEDIA_URL": name, "MIME_TYPE": "unknown"})
    ET.SubElement(header, "PROPERTY", {"NAME": PROPERTY}).text = json.dumps(
        _ours(coding, tiers), ensure_ascii=False
    )
    times = sorted({time for tier in tiers for span in tier.spans for time in span[:2]})
    order = ET.SubElement(root, "TIME_ORDER")
    slots = {time: f"ts{number}" for number, time in enumerate(times, 1)}
    for time, slot in slots.items():
        ET.SubElement(order, "TIME_SLOT", {"TIME_SLOT_ID": slot, "TIME_VALUE": str(time)})
    _add_tiers(root, tiers, slots, coding.observer)
    told = {"GRAPHIC_REFERENCES": "false", "LINGUISTIC_TYPE_ID": TYPE, "TIME_ALIGNABLE": "true"}
    ET.SubElement(root, "LINGUISTIC_TYPE", told)
    for name, description in CONSTRAINTS.items():
        ET.SubElement(root, "CONSTRAINT", {"DESCRIPTION": description, "STEREOTYPE": name})
    _make_printable(root)
    return root


def _make_printable(root: ET.Element) -> None:
    """Put a box where somebody typed what no XML holds: the file would not open any more."""
    for element in root.iter():
        element.text = printable(element.text or "") or None
        element.attrib.update({key: printable(told) for key, told in element.items()})


def _add_tiers(
    root: ET.Element, tiers: Sequence[_Tier], slots: dict[int, str], observer: str
) -> None:
    number = 0
    for tier in tiers:
        told = {"LINGUISTIC_TYPE_REF": TYPE, "TIER_ID": tier.name}
        told |= {"PARTICIPANT": tier.subject} if tier.subject else {}
        told |= {"ANNOTATOR": observer} if observer else {}
        parent = ET.SubElement(root, "TIER", told)
        for begin, end, text in tier.spans:
            number += 1
            one = ET.SubElement(
                ET.SubElement(parent, "ANNOTATION"),
                "ALIGNABLE_ANNOTATION",
                {
                    "ANNOTATION_ID": f"a{number}",
                    "TIME_SLOT_REF1": slots[begin],
                    "TIME_SLOT_REF2": slots[end],
                },
            )
            ET.SubElement(one, "ANNOTATION_VALUE").text = text


def _ours(coding: Coding, tiers: Sequence[_Tier]) -> dict[str, Any]:
    """Return what ELAN has no place for."""
    return {
        "name": coding.name,
        "observed_ms": [coding.begin_ms, coding.end_ms],
        "description": coding.description,
        "date": coding.date,
        "variables": [list(pair) for pair in coding.variables],
        "instant_sections": [
            [one.name, one.begin_ms] for one in coding.sections if one.begin_ms == one.end_ms
        ],
        "tiers": [[one.name, one.behaviour, one.subject] for one in tiers if one.behaviour],
        "ethogram": ethogram_document(coding.ethogram),
    }


def _tiers(coding: Coding) -> Iterator[_Tier]:
    """Yield the tiers; annotations of one tier do not overlap."""
    taken = {SECTION_TIER}
    for subject in coding.subjects:
        for behaviour in coding.ethogram.behaviours:
            wished = printable(f"{behaviour.name}@{subject}" if subject else behaviour.name)
            lanes = _lanes(_span(one, behaviour) for one in coding.of(behaviour.name, subject))
            for lane in lanes:
                name, number = wished, 1
                while name in taken:
                    number += 1
                    name = f"{wished} ({number})"
                taken.add(name)
                yield _Tier(name, behaviour.name, subject, lane)
    if coding.sections:
        spans = [
            (one.begin_ms, max(one.end_ms, one.begin_ms + POINT_MS), one.name)
            for one in coding.sections
        ]
        yield _Tier(SECTION_TIER, "", "", spans)


def _lanes(spans: Iterator[Span]) -> list[list[Span]]:
    """Return annotations in as few rows as hold them without overlaps; one row at least."""
    lanes: list[list[Span]] = [[]]
    for span in sorted(spans):
        lane = next((one for one in lanes if not one or one[-1][1] <= span[0]), None)
        if lane is None:
            lanes.append([span])
        else:
            lane.append(span)
    return lanes


def _span(one: Occurrence, behaviour: Behaviour) -> Span:
    told: dict[str, Any] = {}
    if one.modifiers:
        told["modifiers"] = list(one.modifiers)
    if one.end_comment:
        told["end"] = one.end_comment
    if behaviour.kind == "state" and not one.duration_ms:
        told[INSTANT] = True
    text = one.comment
    if told or text.startswith("{"):
        text = json.dumps({**told, "comment": text} if text else told, ensure_ascii=False)
    return one.begin_ms, max(one.end_ms, one.begin_ms + POINT_MS), text


def _date(date: str) -> str:
    """Return a date and time with its zone, as the schema wants it."""
    if len(date) < len("2026-11-21T10:00:00"):
        return NO_DATE
    return date if "+" in date or date.endswith("Z") else f"{date}+00:00"
