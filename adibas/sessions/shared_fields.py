"""The fields of a patient and of a session, one by one: two operators may change different ones."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields
from datetime import date

from adibas.data.patients import Identity
from adibas.data.sessions import SessionSetup
from adibas.sessions.audit import last_change
from adibas.sessions.conflicts import Choice, Conflict, Decision, merge_fields, settle
from adibas.sessions.json_line import from_json, to_json
from adibas.sessions.rows import Transaction

SETUP = "setup."
IDENTITY = ("name", "birth_date", "record_number")


@dataclass(frozen=True, slots=True)
class Change:
    """What somebody saw, what stands there now, and what is to stand there; all by field."""

    seen: Mapping[str, str]
    theirs: Mapping[str, str]
    mine: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Settled:
    """What a change comes to.

    Attributes
    ----------
    values : Mapping
        Every field.
    groups : tuple of str
        Of the fields that become other ones, as the audit log names them.
    detail : Mapping
        For the log: over whose versions, and for whose, somebody decided.
    """

    values: Mapping[str, str]
    groups: tuple[str, ...]
    detail: Mapping[str, object]


def settle_fields(
    transaction: Transaction, subject: str, change: Change, decisions: Collection[Decision]
) -> Settled:
    """Bring a change together with what was changed meanwhile.

    Raises
    ------
    ConflictError
        Both changed the same field, and nobody decided.
    """
    values, names = merge_fields(change.seen, change.theirs, change.mine)
    conflicts = [
        Conflict(
            name,
            change.theirs[name],
            change.mine[name],
            *last_change(transaction, subject, group_of(name)),
        )
        for name in names
    ]
    taken = settle(conflicts, decisions)
    values |= {name: _chosen(change, name, choice) for name, choice in taken.items()}
    changed = [name for name, value in values.items() if value != change.theirs[name]]
    words = {"over": "mine", "kept": "theirs", "both": "both"}
    told = {word: sorted(one for one in taken if taken[one] == by) for word, by in words.items()}
    groups = tuple(dict.fromkeys(map(group_of, changed)))
    return Settled(values, groups, {word: names for word, names in told.items() if names})


def _chosen(change: Change, name: str, choice: Choice) -> str:
    theirs, mine = change.theirs[name], change.mine[name]
    return {"theirs": theirs, "mine": mine, "both": f"{theirs}\n{mine}"}[choice]


def group_of(name: str) -> str:
    """Return what the audit log calls the fields that `name` is one of."""
    if name in IDENTITY:
        return "identity"
    return "setup" if name.startswith(SETUP) else name


def session_fields(notes: str, setup: SessionSetup) -> dict[str, str]:
    """Return what can be changed of a session."""
    parts = {f"{SETUP}{one.name}": to_json(getattr(setup, one.name)) for one in fields(setup)}
    return {"notes": notes, **parts}


def setup_of(values: Mapping[str, str]) -> SessionSetup:
    """Return the set-up among the fields of a session."""
    parts = {one.name: from_json(values[f"{SETUP}{one.name}"]) for one in fields(SessionSetup)}
    width, height = parts.pop("color_size")
    return SessionSetup(color_size=(width, height), **parts)


def patient_fields(identity: Identity, sex: str, notes: str) -> dict[str, str]:
    """Return what can be changed of a patient."""
    born = "" if identity.birth_date is None else identity.birth_date.isoformat()
    known = (identity.name, born, identity.record_number)
    return {**dict(zip(IDENTITY, known, strict=True)), "sex": sex, "notes": notes}


def identity_of_fields(values: Mapping[str, str]) -> Identity:
    """Return the identity among the fields of a patient."""
    born = values["birth_date"]
    return Identity(
        values["name"], date.fromisoformat(born) if born else None, values["record_number"]
    )
