"""Adds a landmark or a measure to the text of a protocol; everything else stays as it was typed."""

import json
import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from adibas.data.protocols import KINDS, UNITS
from adibas.errors import ProtocolError

LANDMARKS, DERIVED, MEASURES = "landmarks", "derived", "measures"
DECODER = json.JSONDecoder()
SPACE = re.compile(r"[\s,:]*")
INDENT = "  "


@dataclass(frozen=True, slots=True)
class NewEntry:
    """What a landmark and a measure have in common.

    Attributes
    ----------
    name : str
        For people, in `language`; its id is made of it where it has letters.
    language : str
        Two letters.
    views : tuple of str
        Of `VIEWS`.
    """

    name: str
    language: str
    views: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class NewMeasure:
    """A measure beside its name and views.

    Attributes
    ----------
    kind : str
        Of `KINDS`.
    points : tuple of str
        Landmarks, as many as the kind needs.
    axis : str
        Empty where the kind has none.
    positive : str
        What a positive value means; may be empty.
    """

    kind: str
    points: tuple[str, ...]
    axis: str = ""
    positive: str = ""


def with_landmark(text: str, entry: NewEntry) -> str:
    """Return the text with one landmark more.

    Raises
    ------
    ProtocolError
        The text cannot be read, or has no list of landmarks.
    """
    return _with(text, LANDMARKS, _common(text, entry, "_", str.lower))


def with_measure(text: str, entry: NewEntry, measure: NewMeasure) -> str:
    """Return the text with one measure more, in the usual unit of its kind.

    Raises
    ------
    ProtocolError
        The text cannot be read, or has no list of measures.
    """
    quantity = KINDS[measure.kind].quantity
    unit = next(unit for unit, (of, _one) in UNITS.items() if of == quantity)
    axis = {"axis": measure.axis} if measure.axis else {}
    told = measure.positive.strip()
    positive = {"positive": {entry.language: told}} if told else {}
    details = {"kind": measure.kind, "points": list(measure.points), "unit": unit}
    return _with(
        text, MEASURES, {**_common(text, entry, ".", str.upper), **details, **axis, **positive}
    )


def landmarks_of(text: str) -> dict[str, str]:
    """Return the names of landmarks, derived ones among them, by id, in their order.

    Raises
    ------
    ProtocolError
        The text cannot be read.
    """
    document = _document(text)
    found = {}
    for section in (LANDMARKS, DERIVED):
        for part in _entries(document, section):
            names = part.get("name")
            told = next(iter(names.values()), "") if isinstance(names, dict) else names
            found[str(part.get("id", ""))] = str(told or part.get("id", ""))
    return found


def _entries(document: Mapping[str, object], section: str) -> list[dict[str, object]]:
    listed = document.get(section)
    return [part for part in listed if isinstance(part, dict)] if isinstance(listed, list) else []


def _document(text: str) -> dict[str, object]:
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise _unreadable() from error
    if not isinstance(document, dict):
        raise _unreadable()
    return document


def _unreadable() -> ProtocolError:
    return ProtocolError("The text has mistakes of writing. Mend those listed below it first.")


def _common(
    text: str, entry: NewEntry, joint: str, case: Callable[[str], str]
) -> dict[str, object]:
    """Return id, name and views; the id is one that nothing has."""
    document = _document(text)
    taken = {
        str(part.get("id")).lower()
        for section in (LANDMARKS, DERIVED, MEASURES)
        for part in _entries(document, section)
    }
    name = entry.name.strip()
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    words = re.findall("[A-Za-z0-9]+", plain) or ["new"]
    stem = case(joint.join(words))
    chosen, number = stem, 2
    while chosen.lower() in taken:
        chosen, number = f"{stem}{joint}{number}", number + 1
    return {"id": chosen, "name": {entry.language: name}, "views": list(entry.views)}


def _with(text: str, section: str, entry: Mapping[str, object]) -> str:
    end = _end_of(text, section)
    before = text[:end].rstrip()
    comma = "" if before.endswith("[") else ","
    written = json.dumps(entry, ensure_ascii=False)
    return f"{before}{comma}\n{INDENT}{written}\n {text[end:]}"


def _end_of(text: str, section: str) -> int:
    """Return where the closing bracket of a list of the whole document stands."""
    listed = _document(text).get(section)
    at = text.index("{") + 1
    while isinstance(listed, list):
        at = _skipped(text, at)
        if text[at] == "}":
            break
        name, at = DECODER.raw_decode(text, at)
        _value, at = DECODER.raw_decode(text, _skipped(text, at))
        if name == section:
            return at - 1
    raise ProtocolError(
        'The text has no list "{section}". Begin with a new protocol.', section=section
    )


def _skipped(text: str, at: int) -> int:
    found = SPACE.match(text, at)
    return at if found is None else found.end()
