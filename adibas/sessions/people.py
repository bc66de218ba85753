"""The people of an open store: who they are, and the administrators' changes of that.

`key.json` is read and written within a transaction of the database: its line in the audit log and
the change go together, and two workstations do not overwrite each other's change.
"""

import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from adibas.errors import PassphraseError, StoreError
from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.key_file import KeyFile, read_key_file, write_key_file
from adibas.sessions.key_wrapping import Argon2Params
from adibas.sessions.keys import (
    change_passphrase,
    leave_keyring,
    moved_behind,
    wrong_passphrase,
)
from adibas.sessions.people_state import PEOPLE_AS_SUBJECT, state_of
from adibas.sessions.person_keys import (
    MOST_PEOPLE,
    Person,
    check_length,
    opens,
    people_in,
    slot_for,
    slots_of,
    unlock,
    with_people,
)
from adibas.sessions.roles import Permission, Role

LONGEST_NAME = 80
RECOVERED = "recovery key used"
"""What the audit log says of a passphrase that was replaced because the old one was lost."""

Slot = Mapping[str, object]


@dataclass(frozen=True, slots=True)
class _State:
    """What `key.json` says, opened."""

    file: KeyFile
    people: tuple[Person, ...]
    slots: tuple[Slot, ...]

    def named(self, name: str) -> Person:
        """Return somebody by name; capitals do not matter."""
        for one in self.people:
            if one.name.casefold() == name.strip().casefold():
                return one
        raise StoreError(
            "Nobody called {name} may open this patient store. `adibas sessions people list` tells "
            "who may.",
            name=name,
        )

    def slots_but(self, person: Person) -> tuple[Slot, ...]:
        """Return the keys of all others."""
        return tuple(slot for slot in self.slots if slot["person_id"] != person.person_id)


class People:
    """Who may open a store, each with a passphrase and a role of their own.

    A store without people is opened by one passphrase, or by the keyring, and whoever opens it is
    its administrator. The first person who is added is one, too, and from then on only people open
    the store.
    """

    def __init__(self, folder: Path, database: Database, audit: AuditLog, key: bytes) -> None:
        self._folder = folder
        self._database = database
        self._audit = audit
        self._key = key

    def all(self) -> tuple[Person, ...]:
        """Return who may open the store, in the order in which they were added; maybe nobody.

        Raises
        ------
        NotAllowedError
            Only administrators may see it.
        StoreError
            `key.json` is missing or damaged.
        """
        self._audit.require(Permission.MANAGE_PEOPLE, PEOPLE_AS_SUBJECT)
        return self._state().people

    def add(
        self, name: str, role: Role, passphrase: str, params: Argon2Params | None = None
    ) -> Person:
        """Let somebody open the store with a passphrase of their own.

        The first one takes the place of the store's passphrase, or of the keyring's entry, which
        open it no more; whoever has the store open is that person then.

        Raises
        ------
        NotAllowedError
            Only administrators may.
        PassphraseError
            It is too short, or somebody else's.
        StoreError
            The name is taken or cannot be used, the first one is no administrator, there are too
            many, or the store is read-only.
        FileError
            The disk is full. Whoever opened the store before still does.
        """
        check_length(passphrase)
        name = _tidy(name)
        with self._changing(name, "added", role) as (state, save):
            _check_new(state, name, role)
            _check_is_new_passphrase(state, passphrase)
            person = Person(uuid.uuid4().hex, name, role)
            slot = self._slot(state, person, passphrase, params)
            save((*state.people, person), (*state.slots, slot))
        if not state.people:
            leave_keyring(state.file)
            self._audit.become(person)
        return person

    def remove(self, name: str) -> None:
        """Destroy somebody's copy of the key: that passphrase opens the store no more.

        Raises
        ------
        NotAllowedError
            Only administrators may.
        StoreError
            Nobody has that name, it is the last administrator, or the store is read-only.
        """
        with self._changing(name, "removed") as (state, save):
            person = state.named(name)
            left = tuple(one for one in state.people if one != person)
            _check_administrator_in(left)
            save(left, state.slots_but(person))

    def change(
        self,
        name: str,
        *,
        role: Role | None = None,
        passphrase: str | None = None,
        params: Argon2Params | None = None,
    ) -> None:
        """Give somebody another role, a new passphrase, or both: all of it or nothing.

        The role holds from the next time they open the store; None changes nothing.

        Raises
        ------
        NotAllowedError
            Only administrators may.
        PassphraseError
            It is too short, or somebody else's.
        StoreError
            Nobody has that name, it is the last administrator, or the store is read-only.
        """
        if passphrase is not None:
            check_length(passphrase)
        wished = {"role": role, "passphrase": passphrase}
        did = " and ".join(one for one, wish in wished.items() if wish is not None)
        if not did:
            return
        with self._changing(name, did, role) as (state, save):
            person = state.named(name)
            people, slots = state.people, state.slots
            if role is not None:
                people = tuple(replace(one, role=role) if one == person else one for one in people)
                _check_administrator_in(people)
            if passphrase is not None:
                slots = self._slots_with(state, person, passphrase, params)
            save(people, slots)

    def change_passphrase(
        self, old: str | None, new: str, params: Argon2Params | None = None
    ) -> None:
        """Change one's own passphrase; in a store without people, the one of the store.

        Parameters
        ----------
        old : str or None
            The passphrase until now; None where the key is in the keyring.

        Raises
        ------
        PassphraseError
            `old` is wrong, or `new` is too short or somebody else's.
        StoreError
            The store is read-only, or its key is lost.
        """
        person = self._audit.person
        if person is None:
            self._database.check_writable()
            change_passphrase(self._folder, old, new, params)
            state_now = state_of(self._state().file)
            self._audit.append("change", PEOPLE_AS_SUBJECT, did="passphrase", state=state_now)
            return
        check_length(new)
        with self._saving(person.name, "passphrase") as (state, save):
            found = unlock(state.file, old or "")
            if found is None or found.person is None or found.person.person_id != person.person_id:
                raise wrong_passphrase(state.file)
            save(state.people, self._slots_with(state, person, new, params))

    def replace_lost_passphrase(self, new: str, params: Argon2Params | None = None) -> None:
        """Put a new passphrase in the place of the one that is lost: the store's, or one's own.

        For whoever opened the store with its recovery key; a key in the keyring leaves it.

        Raises
        ------
        PassphraseError
            It is too short, or somebody else's.
        StoreError
            The store is read-only.
        FileError
            The disk is full. What opened the store before still does.
        """
        check_length(new)
        person = self._audit.person
        if person is not None:
            with self._saving(person.name, RECOVERED) as (state, save):
                save(state.people, self._slots_with(state, person, new, params))
            return
        with self._database.changing() as transaction:
            before = self._state().file
            file = moved_behind(before, self._key, new, params or Argon2Params())
            write_key_file(self._folder, file)
            told = {"did": RECOVERED, "state": state_of(file)}
            self._audit.write(transaction, "change", PEOPLE_AS_SUBJECT, **told)
        leave_keyring(before)

    @contextmanager
    def _changing(
        self, name: str, did: str, role: Role | None = None
    ) -> "Iterator[tuple[_State, _Save]]":
        self._audit.require(Permission.MANAGE_PEOPLE, PEOPLE_AS_SUBJECT)
        with self._saving(name, did, role) as given:
            yield given

    @contextmanager
    def _saving(
        self, name: str, did: str, role: Role | None = None
    ) -> "Iterator[tuple[_State, _Save]]":
        """Give the present state, and what writes another one, within one transaction."""
        told = {"did": did, "person": name.strip()} | ({} if role is None else {"role": role.value})
        with self._database.changing() as transaction:
            state = self._state()

            def save(people: tuple[Person, ...], slots: tuple[Slot, ...]) -> None:
                file = with_people(state.file, self._key, people, slots)
                write_key_file(self._folder, file)
                self._audit.write(
                    transaction, "change", PEOPLE_AS_SUBJECT, **told, state=state_of(file)
                )

            yield state, save

    def _state(self) -> _State:
        file = read_key_file(self._folder)
        if file is None:
            raise StoreError(
                "The patient store has lost its key.json. Restore that file from a backup; without "
                "it the patients cannot be read."
            )
        if file.place != "people":
            return _State(file, (), ())
        return _State(file, people_in(file, self._key), tuple(slots_of(file.wrapped)))

    def _slots_with(
        self, state: _State, person: Person, passphrase: str, params: Argon2Params | None
    ) -> tuple[Slot, ...]:
        """Return the keys of all, that of one person behind a passphrase nobody else has."""
        others = state.slots_but(person)
        _check_is_new_passphrase(replace(state, slots=others), passphrase)
        return (*others, self._slot(state, person, passphrase, params))

    def _slot(
        self, state: _State, person: Person, passphrase: str, params: Argon2Params | None
    ) -> Slot:
        params = params or Argon2Params()
        return slot_for(state.file, self._key, person.person_id, passphrase, params)


_Save = Callable[[tuple[Person, ...], tuple[Slot, ...]], None]


def _tidy(name: str) -> str:
    """Return a name as it is kept: on one line."""
    tidy = " ".join(name.split())
    if not tidy or len(tidy) > LONGEST_NAME or not tidy.isprintable():
        raise StoreError(
            "A person's name has one letter at least and {most} at most. Type it as the audit log "
            "shall tell it.",
            most=LONGEST_NAME,
        )
    return tidy


def _check_new(state: _State, name: str, role: Role) -> None:
    if not state.people and role is not Role.ADMINISTRATOR:
        raise StoreError(
            "The first person of a patient store is an administrator: nobody else could let the "
            "others in. Add that person first, as administrator."
        )
    if len(state.people) >= MOST_PEOPLE:
        raise StoreError(
            "A patient store has {most} people at most. Remove somebody who works here no more.",
            most=MOST_PEOPLE,
        )
    if name.casefold() in (one.name.casefold() for one in state.people):
        raise StoreError(
            "Somebody called {name} may open this patient store already. Give a name that tells "
            "the two apart.",
            name=name,
        )


def _check_administrator_in(people: tuple[Person, ...]) -> None:
    if all(one.role is not Role.ADMINISTRATOR for one in people):
        raise StoreError(
            "That is the last administrator, and without one nobody could look after the store. "
            "Make somebody else an administrator first."
        )


def _check_is_new_passphrase(state: _State, passphrase: str) -> None:
    """See that a passphrase tells its person from the others."""
    if not state.slots:
        return
    file = replace(state.file, wrapped={**state.file.wrapped, "slots": list(state.slots)})
    if opens(file, passphrase):
        raise PassphraseError(
            "This passphrase cannot be used in this patient store. Choose another one."
        )
