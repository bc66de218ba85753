"""What an observer may note down: behaviours, subjects and modifiers. No behaviour has a score."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

Kind: TypeAlias = Literal["state", "point"]
Selection: TypeAlias = Literal["one", "several", "number"]
NO_VALUE = ""
"""Of a modifier that was not told."""
BETWEEN_VALUES = ","
"""Where a modifier takes several values; no value contains it."""


@dataclass(frozen=True, slots=True)
class Modifier:
    """What is told of a behaviour besides that it happened.

    Attributes
    ----------
    name : str
    values : tuple of str
        To choose from; empty for a number.
    selection : str
        ``one``, ``several`` or ``number``.
    description : str
    """

    name: str
    values: tuple[str, ...] = ()
    selection: Selection = "one"
    description: str = ""

    def allows(self, text: str) -> bool:
        """Return whether `text` is a value of this modifier, or none was told."""
        if text == NO_VALUE:
            return True
        if self.selection == "number":
            return _is_number(text)
        chosen = text.split(BETWEEN_VALUES) if self.selection == "several" else [text]
        return set(chosen) <= set(self.values)


@dataclass(frozen=True, slots=True)
class Behaviour:
    """One kind of behaviour that can be seen.

    Attributes
    ----------
    name : str
    kind : str
        ``state`` lasts, ``point`` only happens.
    description : str
        By what it is told from others.
    key : str
        That codes it.
    category, color : str
        For the reader's order; a colour such as ``#0072B2``.
    modifiers : tuple of Modifier
    excludes : tuple of str
        Behaviours that cannot last at the same time in the same subject.
    sources : tuple of str
        Where the definition is from.
    """

    name: str
    kind: Kind = "state"
    description: str = ""
    key: str = ""
    category: str = ""
    color: str = ""
    modifiers: tuple[Modifier, ...] = ()
    excludes: tuple[str, ...] = ()
    sources: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Subject:
    """Who is observed: a pseudonym or a role, never a name."""

    name: str
    key: str = ""
    description: str = ""


@dataclass(frozen=True, slots=True)
class Ethogram:
    """A coding scheme.

    Attributes
    ----------
    name, description : str
    behaviours : tuple of Behaviour
    subjects : tuple of Subject
        Besides these an event may have no subject.
    sources : tuple of str
    is_locked : bool
        Observers code by it and may not change it.
    """

    name: str
    behaviours: tuple[Behaviour, ...]
    subjects: tuple[Subject, ...] = ()
    description: str = ""
    sources: tuple[str, ...] = ()
    is_locked: bool = False

    def __post_init__(self) -> None:
        names = [behaviour.name for behaviour in self.behaviours]
        _check_names("behaviour", names)
        _check_names("subject", [subject.name for subject in self.subjects])
        for behaviour in self.behaviours:
            unknown = set(behaviour.excludes) - set(names)
            if unknown or behaviour.name in behaviour.excludes:
                raise ValueError(f"{behaviour.name} excludes itself or what is unknown: {unknown}")

    def behaviour(self, name: str) -> Behaviour | None:
        """Return the behaviour of that name; None where there is none."""
        return next((one for one in self.behaviours if one.name == name), None)

    def is_state(self, name: str) -> bool:
        """Return whether the behaviour of that name lasts; one that is not known does not."""
        found = self.behaviour(name)
        return found is not None and found.kind == "state"

    @property
    def subject_names(self) -> frozenset[str]:
        """Return who may act; the empty name stands for nobody in particular."""
        return frozenset({"", *(subject.name for subject in self.subjects)})

    @property
    def exclusions(self) -> frozenset[tuple[str, str]]:
        """Return the pairs that cannot last at the same time, in both orders."""
        pairs = {(one.name, other) for one in self.behaviours for other in one.excludes}
        return frozenset(pairs | {(other, name) for name, other in pairs})


def _check_names(what: str, names: Iterable[str]) -> None:
    seen = set()
    for name in names:
        if not name or name in seen:
            raise ValueError(f"a {what} has no name of its own: {name!r}")
        seen.add(name)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
