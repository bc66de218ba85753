"""A coding scheme as it is typed: exclusions as groups, modifiers as texts. Knows nothing of Qt."""

import json
from dataclasses import asdict, dataclass, replace
from typing import Any

from adibas.data.ethogram import BETWEEN_VALUES, Behaviour, Ethogram, Kind, Modifier, Subject
from adibas.errors import BehaviourError

BETWEEN_GROUPS, BETWEEN_MODIFIERS = ",", ";"
NUMBER, SEVERAL = "#", "+"


@dataclass(frozen=True, slots=True)
class BehaviourFields:
    """What is typed of one behaviour.

    Attributes
    ----------
    name, kind, key, category, color, description : str
        As in the scheme.
    group : str
        Names of exclusive groups, with commas between.
    modifiers : str
        ``with: pen, hair; times: #``; values that begin with ``+``: several may be told.
    before : str
        What it was called when the editing began; empty for a new one.
    """

    name: str
    kind: str = "state"
    key: str = ""
    category: str = ""
    color: str = ""
    group: str = ""
    modifiers: str = ""
    description: str = ""
    before: str = ""


@dataclass(frozen=True, slots=True)
class SchemeFields:
    """What is typed of a scheme; `subjects` as ``child=1, peer=2``."""

    behaviours: tuple[BehaviourFields, ...]
    subjects: str


def fields_of(ethogram: Ethogram) -> SchemeFields:
    """Return a scheme as it is typed."""
    groups = _groups(ethogram)
    behaviours = tuple(
        BehaviourFields(
            *(one.name, one.kind, one.key, one.category, one.color),
            f"{BETWEEN_GROUPS} ".join(name for name, some in groups.items() if one.name in some),
            f"{BETWEEN_MODIFIERS} ".join(map(_modifier_text, one.modifiers)),
            one.description,
            one.name,
        )
        for one in ethogram.behaviours
    )
    subjects = ", ".join(
        f"{one.name}={one.key}" if one.key else one.name for one in ethogram.subjects
    )
    return SchemeFields(behaviours, subjects)


@dataclass(frozen=True, slots=True)
class TypedScheme:
    """What was typed into a scheme and is not in use: `opened` is what it was before."""

    opened: SchemeFields
    fields: SchemeFields

    def to_text(self) -> str:
        """Return it as a text that `from_text` reads."""
        return json.dumps(asdict(self))

    @classmethod
    def from_text(cls, text: str) -> "TypedScheme":
        """Read what `to_text` gave."""
        found = json.loads(text)
        return cls(*(_fields_from(found[name]) for name in ("opened", "fields")))


def _fields_from(document: dict[str, Any]) -> SchemeFields:
    behaviours = tuple(BehaviourFields(**one) for one in document["behaviours"])
    return SchemeFields(behaviours, document["subjects"])


def with_new(fields: SchemeFields, name: str) -> SchemeFields:
    """Return the fields with one more behaviour."""
    return replace(fields, behaviours=(*fields.behaviours, BehaviourFields(name)))


def without(fields: SchemeFields, row: int) -> SchemeFields:
    """Return the fields without a behaviour."""
    some = fields.behaviours
    return replace(fields, behaviours=(*some[:row], *some[row + 1 :]))


def kept_names(fields: SchemeFields) -> dict[str, str]:
    """Return what the behaviours that stay are called now, by what they were called."""
    return {one.before: one.name.strip() for one in fields.behaviours if one.before}


def ethogram_of(fields: SchemeFields, before: Ethogram) -> Ethogram:
    """Return the scheme that was typed; what cannot be typed stays as it was.

    Raises
    ------
    BehaviourError
        A name is missing or stands twice, or two have the same key.
    """
    behaviours = [_behaviour(one, before) for one in fields.behaviours]
    subjects = _subjects(fields.subjects, before)
    _check_once([one.name for one in behaviours])
    _check_once([one.name for one in subjects])
    keys = [one.key for one in behaviours if one.key] + [one.key for one in subjects if one.key]
    for place, key in enumerate(keys):
        if key in keys[:place]:
            raise BehaviourError("The key {key} stands twice. Give each its own.", key=key)
    members: dict[str, list[str]] = {}
    for one in fields.behaviours:
        for group in _parts(one.group, BETWEEN_GROUPS):
            members.setdefault(group, []).append(one.name.strip())
    grouped = tuple(
        replace(
            one,
            excludes=tuple(
                dict.fromkeys(
                    other
                    for some in members.values()
                    if one.name in some
                    for other in some
                    if other != one.name
                )
            ),
        )
        for one in behaviours
    )
    return replace(before, behaviours=grouped, subjects=subjects)


def _check_once(names: list[str]) -> None:
    for place, name in enumerate(names):
        if not name:
            raise BehaviourError("A behaviour has no name. Type one, or remove it.")
        if name in names[:place]:
            raise BehaviourError("The name {name} stands twice. Change one.", name=name)


def _behaviour(typed: BehaviourFields, before: Ethogram) -> Behaviour:
    kind: Kind = "point" if typed.kind == "point" else "state"
    old = before.behaviour(typed.before)
    return Behaviour(
        *(typed.name.strip(), kind, typed.description.strip(), typed.key.strip()),
        *(typed.category.strip(), typed.color.strip()),
        tuple(
            _modifier(part, () if old is None else old.modifiers)
            for part in _parts(typed.modifiers, BETWEEN_MODIFIERS)
        ),
        (),
        () if old is None else old.sources,
    )


def _modifier(text: str, before: tuple[Modifier, ...]) -> Modifier:
    name, _colon, told = (part.strip() for part in text.partition(":"))
    description = next((one.description for one in before if one.name == name), "")
    if not name or "|" in text:
        raise BehaviourError(
            "{text} is no modifier. Type a name, a colon, and its values.", text=text
        )
    if told in (NUMBER, ""):
        return Modifier(name, (), "number", description)
    is_several = told.startswith(SEVERAL)
    values = tuple(_parts(told.removeprefix(SEVERAL), BETWEEN_VALUES))
    return Modifier(name, values, "several" if is_several else "one", description)


def _modifier_text(one: Modifier) -> str:
    if one.selection == "number":
        return f"{one.name}: {NUMBER}"
    several = SEVERAL if one.selection == "several" else ""
    return f"{one.name}: {several}{f'{BETWEEN_VALUES} '.join(one.values)}"


def _subjects(text: str, before: Ethogram) -> tuple[Subject, ...]:
    told = {one.name: one.description for one in before.subjects}
    found = []
    for part in _parts(text, ","):
        name, _equals, key = (one.strip() for one in part.partition("="))
        found.append(Subject(name, key, told.get(name, "")))
    return tuple(found)


def _parts(text: str, between: str) -> list[str]:
    return [part.strip() for part in text.split(between) if part.strip()]


def _groups(ethogram: Ethogram) -> dict[str, tuple[str, ...]]:
    """Return exclusive groups by a number: as few as hold every exclusion and nothing more."""
    names = [one.name for one in ethogram.behaviours]
    left = {pair for pair in ethogram.exclusions if names.index(pair[0]) < names.index(pair[1])}
    found: dict[str, tuple[str, ...]] = {}
    for first, second in sorted(
        left, key=lambda pair: (names.index(pair[0]), names.index(pair[1]))
    ):
        if (first, second) not in left:
            continue
        group = [first, second]
        for name in names:
            if name not in group and all((name, one) in ethogram.exclusions for one in group):
                group.append(name)
        left -= {(one, other) for one in group for other in group}
        found[str(len(found) + 1)] = tuple(group)
    return found
