"""What two operators changed at the same time: brought together, or shown to the second one.

Whoever changes something says what he saw before. Where the store holds something else by now,
fields that only one of the two changed are brought together; a field that both changed is a
conflict, and nothing is saved before the second one has decided.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from adibas.data.markers import Marker
from adibas.errors import StoreError

Choice = Literal["theirs", "mine", "both"]
Version = str | Marker | None
"""A text, or a marker; None of a marker that was deleted."""


@dataclass(frozen=True, slots=True, eq=False)
class Conflict:
    """One field, or one landmark, with two new versions.

    Attributes
    ----------
    field : str
        Such as ``notes``, ``setup.protocol`` or ``name``; of a marker its name.
    theirs, mine : str or Marker or None
        What was saved meanwhile, and what is to be saved.
    operator : str
        Who saved theirs.
    changed_utc : datetime
        When.
    """

    field: str
    theirs: Version
    mine: Version
    operator: str
    changed_utc: datetime

    def is_same(self, other: "Conflict") -> bool:
        """Say whether the same versions of the same field are meant."""
        return (self.field, _told(self.theirs), _told(self.mine)) == (
            other.field,
            _told(other.theirs),
            _told(other.mine),
        )


@dataclass(frozen=True, slots=True)
class Decision:
    """Which version of a conflict is to hold; both only of texts, one below the other."""

    conflict: Conflict
    takes: Choice


class ConflictError(StoreError):
    """Somebody else changed the same meanwhile; nothing was saved or overwritten.

    Parameters
    ----------
    conflicts : tuple of Conflict
        One at least.
    """

    def __init__(self, conflicts: tuple[Conflict, ...]) -> None:
        last = max(conflicts, key=lambda one: one.changed_utc)
        super().__init__(
            "{operator} changed the same meanwhile, at {time}. Nothing was overwritten, and "
            "nothing of yours is saved yet: look at both versions and choose.",
            operator=last.operator or "-",
            time=f"{last.changed_utc.astimezone():%H:%M}",
        )
        self.conflicts = conflicts


def merge_fields(
    base: Mapping[str, str], theirs: Mapping[str, str], mine: Mapping[str, str]
) -> tuple[dict[str, str], tuple[str, ...]]:
    """Bring two changes of the same fields together.

    Parameters
    ----------
    base : Mapping
        What both began from.

    Returns
    -------
    values : dict
        Each field as whoever changed it wants it; theirs where both did.
    conflicts : tuple of str
        Fields that both changed, each in another way.
    """
    values = {name: mine[name] if theirs[name] == base[name] else theirs[name] for name in mine}
    both = (name for name in mine if base[name] not in (theirs[name], mine[name]))
    return values, tuple(name for name in both if theirs[name] != mine[name])


def settle(conflicts: Collection[Conflict], decisions: Collection[Decision]) -> dict[str, Choice]:
    """Return which version of each conflict holds.

    Raises
    ------
    ConflictError
        Somebody has to decide first; also where something else was saved since it was decided.
    """
    taken: dict[str, Choice] = {}
    for conflict in conflicts:
        for decision in decisions:
            if decision.conflict.is_same(conflict):
                taken[conflict.field] = decision.takes
    if any(one.field not in taken for one in conflicts):
        raise ConflictError(tuple(conflicts))
    return taken


def _told(version: Version) -> object:
    return (version.label, version.u, version.v) if isinstance(version, Marker) else version
