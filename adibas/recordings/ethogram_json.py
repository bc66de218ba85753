"""Ethograms as JSON files; a mistake is told with its line.

The format is described in docs/behaviour.md.
"""

import json
from pathlib import Path
from typing import Any

from adibas.data.ethogram import BETWEEN_VALUES, Behaviour, Ethogram, Modifier, Subject
from adibas.errors import BehaviourError
from adibas.files import whole_letters, written_whole
from adibas.measures.json_lines import LARGEST_FILE, parse_lines
from adibas.measures.protocol_fields import Findings, Group
from adibas.resources import resource_path
from adibas.texts import spoken_language

FORMAT, VERSION = "adibas-ethogram", 1
SHIPPED = "observation-example.{language}.json"
SELECTIONS = ("one", "several", "number")
KINDS = ("state", "point")


def shipped_ethogram() -> Ethogram:
    """Return the example that comes with the program, in the language in use."""
    return read_ethogram(resource_path("ethograms", SHIPPED.format(language=spoken_language())))


def read_ethogram(path: Path) -> Ethogram:
    """Read an ethogram.

    Raises
    ------
    BehaviourError
        The file is missing or no ethogram.
    ProtocolError
        The first mistake in it, with its line.
    """
    try:
        with path.open("rb") as file:
            text = file.read(4 * LARGEST_FILE + 1).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise BehaviourError(
            "{file} cannot be read: {reason}. Give an ethogram.",
            file=path.name,
            reason=getattr(error, "strerror", None) or str(error),
        ) from error
    return ethogram_of_text(text, path.name)


def ethogram_of_text(text: str, file: str) -> Ethogram:
    """Return the ethogram in `text`, the content of the file named `file`; see `read_ethogram`."""
    findings = Findings(file)
    found = _ethogram(Group(parse_lines(text, file), findings))
    if findings.errors:
        raise min(findings.errors, key=lambda error: int(str(error.fields["line"])))
    if found is None:
        raise BehaviourError("{file} is no ethogram. Give one.", file=file)
    return found


def write_ethogram(path: Path, ethogram: Ethogram) -> None:
    """Write an ethogram.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    with written_whole(path) as unfinished:
        text = json.dumps(ethogram_document(ethogram), indent=1, ensure_ascii=False)
        unfinished.write_text(f"{whole_letters(text)}\n", "utf-8")


def ethogram_document(ethogram: Ethogram) -> dict[str, Any]:
    """Return an ethogram as plain values; what is empty is left out."""
    whole = {
        "format": FORMAT,
        "version": VERSION,
        "name": ethogram.name,
        "description": ethogram.description,
        "sources": list(ethogram.sources),
        "locked": ethogram.is_locked,
        "subjects": [
            _told({"name": one.name, "key": one.key, "description": one.description})
            for one in ethogram.subjects
        ],
        "behaviours": [_behaviour_document(one) for one in ethogram.behaviours],
    }
    return _told(whole)


def _behaviour_document(one: Behaviour) -> dict[str, Any]:
    return _told(
        {
            "name": one.name,
            "kind": one.kind,
            "description": one.description,
            "key": one.key,
            "category": one.category,
            "color": one.color,
            "modifiers": [
                _told(
                    {
                        "name": modifier.name,
                        "selection": modifier.selection,
                        "values": list(modifier.values),
                        "description": modifier.description,
                    }
                )
                for modifier in one.modifiers
            ],
            "excludes": list(one.excludes),
            "sources": list(one.sources),
        }
    )


def _told(values: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value not in ("", [], False)}


def _ethogram(whole: Group) -> Ethogram | None:
    whole.allow_only(
        *("format", "version", "name", "description", "sources", "locked", "subjects"),
        *("behaviours", "exclusive_groups"),
    )
    if whole.text("format") != FORMAT or whole.number("version") != VERSION:
        whole.findings.mistake(
            whole.node,
            "{file}, line {line}: this is no ethogram of this version of ADiBAS. Its format must "
            "be {name}, version {version}.",
            name=FORMAT,
            version=VERSION,
        )
        return None
    subjects = tuple(_subject(one) for one in whole.groups("subjects", is_needed=False))
    behaviours = [_behaviour(one) for one in whole.groups("behaviours")]
    groups = _exclusive_groups(whole)
    _check_names(whole, behaviours, groups)
    if whole.findings.errors:
        return None
    return Ethogram(
        whole.text("name"),
        tuple(_grouped(one, groups) for one in behaviours),
        subjects,
        whole.text("description", is_needed=False),
        whole.texts("sources", is_needed=False),
        whole.truth("locked"),
    )


def _exclusive_groups(whole: Group) -> list[tuple[str, ...]]:
    found = []
    for node in whole.items("exclusive_groups", is_needed=False):
        values = node.value if isinstance(node.value, list) else []
        found.append(tuple(str(one.value) for one in values))
    return found


def _grouped(one: Behaviour, groups: list[tuple[str, ...]]) -> Behaviour:
    """Return the behaviour that also excludes all others of its groups."""
    others = [name for group in groups if one.name in group for name in group if name != one.name]
    excludes = tuple(dict.fromkeys([*one.excludes, *others]))
    return Behaviour(
        *(one.name, one.kind, one.description, one.key, one.category, one.color),
        *(one.modifiers, excludes, one.sources),
    )


def _check_names(whole: Group, behaviours: list[Behaviour], groups: list[tuple[str, ...]]) -> None:
    """Tell of names that stand twice, and of exclusions that name nothing."""
    names = [one.name for one in behaviours]
    nodes = [group.node for group in whole.groups("behaviours")]
    for place, (one, node) in enumerate(zip(behaviours, nodes, strict=True)):
        if one.name in names[:place]:
            whole.findings.mistake(
                node,
                "{file}, line {line}: the name {name} stands twice. Change one.",
                name=one.name,
            )
        for other in one.excludes:
            if other not in names or other == one.name:
                whole.findings.mistake(
                    node,
                    "{file}, line {line}: {name} cannot exclude {other}. Name another behaviour.",
                    name=one.name,
                    other=other,
                )
    for other in {name for group in groups for name in group} - set(names):
        whole.findings.mistake(
            whole.node,
            "{file}, line {line}: an exclusive group names {other}, which is no behaviour. "
            "Correct it.",
            other=other,
        )


def _subject(group: Group) -> Subject:
    group.allow_only("name", "key", "description")
    return Subject(
        group.text("name"),
        group.text("key", is_needed=False),
        group.text("description", is_needed=False),
    )


def _behaviour(group: Group) -> Behaviour:
    group.allow_only(
        *("name", "kind", "description", "key", "category", "color", "modifiers", "excludes"),
        "sources",
    )
    kind = _one_of(group, "kind", KINDS)
    return Behaviour(
        group.text("name"),
        "point" if kind == "point" else "state",
        group.text("description", is_needed=False),
        group.text("key", is_needed=False),
        group.text("category", is_needed=False),
        group.text("color", is_needed=False),
        tuple(_modifier(one) for one in group.groups("modifiers", is_needed=False)),
        group.texts("excludes", is_needed=False),
        group.texts("sources", is_needed=False),
    )


def _modifier(group: Group) -> Modifier:
    group.allow_only("name", "selection", "values", "description")
    selection = _one_of(group, "selection", SELECTIONS) or "one"
    values = group.texts("values", is_needed=selection != "number")
    if any(BETWEEN_VALUES in value or "|" in value for value in values):
        group.findings.mistake(
            group.node,
            "{file}, line {line}: a value of a modifier may hold no comma and no upright line. "
            "Change it.",
        )
    return Modifier(
        group.text("name"),
        values,
        "number" if selection == "number" else "several" if selection == "several" else "one",
        group.text("description", is_needed=False),
    )


def _one_of(group: Group, name: str, known: tuple[str, ...]) -> str:
    found = group.text(name, is_needed=False)
    node = group.get(name)
    if found and node is not None and found not in known:
        group.findings.mistake(
            node,
            "{file}, line {line}: {value} is not known here. Known are: {names}. Correct it.",
            value=found,
            names=", ".join(known),
        )
    return found
