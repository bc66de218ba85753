"""The people of a store in `key.json`: a sealed copy of the store's key for each of them.

Each copy is sealed by that person's own passphrase and bound to that person; all have one salt, so
that one derivation tells whose passphrase it is, however many they are. Who they are and what
they may is sealed under the store's key, all in one piece: without a passphrase nobody reads it,
and nobody makes himself an administrator with a text editor.
"""

import base64
import binascii
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

from adibas.errors import PassphraseError
from adibas.recordings.seal import SealError
from adibas.sessions.key_file import KeyFile, damaged, fingerprint_of
from adibas.sessions.key_wrapping import (
    SHORTEST_PASSPHRASE,
    Argon2Params,
    Derived,
    derivation_of,
    unwrap_key,
    wrap_key,
)
from adibas.sessions.roles import Role
from adibas.sessions.sealing import AesSeal, key_for

SCOPE = "adibas-people-1"
MOST_PEOPLE = 50
"""Who guesses at a stolen file guesses at all of them at once."""
ID_LENGTH = 32


@dataclass(frozen=True, slots=True)
class Person:
    """Somebody who opens the store with a passphrase of their own.

    Attributes
    ----------
    person_id : str
        Random.
    name : str
        As the audit log tells it.
    """

    person_id: str
    name: str
    role: Role


class Unlocked(NamedTuple):
    """The store's key, and whose passphrase gave it; nobody's where the store has no people."""

    key: bytes
    person: Person | None


def unlock(file: KeyFile, passphrase: str) -> Unlocked | None:
    """Try the passphrase on the copy of each person; None where it is nobody's.

    Raises
    ------
    StoreError
        The file is damaged.
    """
    found = _found(file, passphrase)
    if found is None:
        return None
    key, person_id = found
    if fingerprint_of(key) != file.fingerprint:
        raise damaged("a person's key belongs to another store")
    by_id = {one.person_id: one for one in people_in(file, key)}
    return Unlocked(key, by_id[person_id])


def opens(file: KeyFile, passphrase: str) -> bool:
    """Say whether it is somebody's passphrase."""
    return _found(file, passphrase) is not None


def people_in(file: KeyFile, key: bytes) -> tuple[Person, ...]:
    """Return who may open the store, in the order in which they were added.

    Raises
    ------
    StoreError
        The file is damaged, or was changed by hand.
    """
    people = _opened_people(file, key)
    if {one.person_id for one in people} != {one["person_id"] for one in slots_of(file.wrapped)}:
        raise damaged("its people and their keys do not belong together")
    return people


def slot_for(
    file: KeyFile, key: bytes, person_id: str, passphrase: str, params: Argon2Params
) -> dict[str, object]:
    """Return the copy of the key for one person; made as those that are there, if any.

    Parameters
    ----------
    params : Argon2Params
        Of the first person; the others have the same.

    Raises
    ------
    PassphraseError
        It is too short.
    """
    check_length(passphrase)
    salt = None
    if file.place == "people":
        try:
            params, salt = derivation_of(slots_of(file.wrapped)[0])
        except ValueError as error:
            raise damaged(str(error)) from error
    wrapped = wrap_key(key, passphrase, _bound_to(file, person_id), params, salt)
    return {"person_id": person_id, **wrapped}


def with_people(
    file: KeyFile, key: bytes, people: Sequence[Person], slots: Sequence[Mapping[str, object]]
) -> KeyFile:
    """Return the file of a store that these people open, and else its recovery key alone."""
    listed = [{**asdict(one), "role": one.role.value} for one in people]
    told = json.dumps(listed, ensure_ascii=False)
    sealed = _seal(key).seal(file.store_id, told.encode())
    wrapped = {"slots": list(slots), "people": base64.b64encode(sealed).decode()}
    return replace(file, place="people", wrapped=wrapped)


def slots_of(wrapped: Mapping[str, object]) -> list[Mapping[str, object]]:
    """Return the copies of the key.

    Raises
    ------
    StoreError
        They are damaged.
    """
    slots = wrapped.get("slots")
    if not isinstance(slots, list) or not 1 <= len(slots) <= MOST_PEOPLE:
        raise damaged("the keys of its people are missing")
    if not all(isinstance(slot, Mapping) and _is_id(slot.get("person_id")) for slot in slots):
        raise damaged("the key of a person is cut short")
    return slots


def check_length(passphrase: str) -> None:
    """See that a passphrase is long enough.

    Raises
    ------
    PassphraseError
        It is too short.
    """
    if len(passphrase) < SHORTEST_PASSPHRASE:
        raise PassphraseError(
            "A passphrase has {least} characters at least. Several words are safer and easier to "
            "remember than one.",
            least=SHORTEST_PASSPHRASE,
        )


def _found(file: KeyFile, passphrase: str) -> tuple[bytes, str] | None:
    """Return the key, and the id of the person whose passphrase it was."""
    derived: Derived = {}
    for slot in slots_of(file.wrapped):
        person_id = str(slot["person_id"])
        key = _unwrapped(slot, passphrase, _bound_to(file, person_id), derived)
        if key is not None:
            return key, person_id
    return None


def _opened_people(file: KeyFile, key: bytes) -> tuple[Person, ...]:
    try:
        sealed = base64.b64decode(str(file.wrapped.get("people")), validate=True)
        told = json.loads(_seal(key).open(file.store_id, sealed))
        return tuple(_person(one) for one in told)
    except (binascii.Error, SealError, ValueError, TypeError, KeyError) as error:
        raise damaged("the list of its people was changed") from error


def _person(told: Mapping[str, Any]) -> Person:
    return Person(str(told["person_id"]), str(told["name"]), Role(told["role"]))


def _unwrapped(
    slot: Mapping[str, object], passphrase: str, bound_to: str, derived: Derived
) -> bytes | None:
    try:
        return unwrap_key(slot, passphrase, bound_to, derived)
    except ValueError as error:
        raise damaged(str(error)) from error


def _bound_to(file: KeyFile, person_id: str) -> str:
    return f"{file.store_id}/{person_id}"


def _is_id(value: object) -> bool:
    return isinstance(value, str) and len(value) == ID_LENGTH


def _seal(key: bytes) -> AesSeal:
    return AesSeal(key_for(SCOPE, key), SCOPE)
