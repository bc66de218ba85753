"""A store whose passphrase or keyring is lost opens by its recovery key, for a new passphrase."""

from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from adibas.clock import Clock, utc_now
from adibas.errors import PassphraseError, StoreError
from adibas.sessions.key_file import KeyFile, damaged, fingerprint_of, read_key_file
from adibas.sessions.key_wrapping import Argon2Params
from adibas.sessions.keys import key_by_recovery
from adibas.sessions.lock import StoreLock
from adibas.sessions.opening import check_traces, open_unlocked
from adibas.sessions.person_keys import Person, Unlocked, check_length, people_in
from adibas.sessions.recovery_key import read_recovery_key
from adibas.sessions.roles import Role
from adibas.sessions.store import SessionStore


@dataclass(frozen=True, slots=True)
class RecoveryWish:
    """With what a store is opened again.

    Attributes
    ----------
    recovery_key : str
        As typed.
    new_passphrase : str
        In place of the one that is lost.
    name : str
        Of the administrator who gets it; not needed of a store without people or with one
        administrator.
    """

    recovery_key: str = field(repr=False)
    new_passphrase: str = field(repr=False)
    name: str = ""


def administrators(folder: Path, recovery_key: str) -> tuple[str, ...]:
    """Return who may get the new passphrase, by name; nobody in a store without people.

    Raises
    ------
    RecoveryKeyTypedError
        It is mistyped.
    PassphraseError
        It is another one.
    StoreError
        The store has no recovery key, or `key.json` is missing or damaged.
    """
    file, key = _opened(folder, recovery_key)
    return tuple(one.name for one in _administrators(file, key))


def chosen_name(names: tuple[str, ...], wished: str) -> str:
    """Return which administrator is meant; empty in a store without people.

    Raises
    ------
    StoreError
        It has to be said, or nobody of them has that name.
    """
    if not names:
        return ""
    wished = wished.strip().casefold()
    found = [name for name in names if wished in ("", name.casefold())]
    if len(found) != 1:
        raise StoreError(
            "Say which administrator gets the new passphrase: {names}.", names=", ".join(names)
        )
    return found[0]


def recover_store(
    folder: Path,
    wish: RecoveryWish,
    *,
    operator: str = "",
    clock: Clock = utc_now,
    key_params: Argon2Params | None = None,
    server_password: str | None = None,
) -> SessionStore:
    """Open a store with its recovery key and put a new passphrase in the place of the lost one.

    Raises
    ------
    RecoveryKeyTypedError
        The recovery key is mistyped.
    PassphraseError
        It is another one; or the passphrase is too short, or somebody else's.
    ServerPasswordError
        The server of the database needs a password, or another one.
    StoreError
        There is no recovery key, it has to be said whose passphrase is meant, another window has
        the store open, or it cannot be opened at all. What opened the store before still does.
    FileError
        The disk is full.
    """
    check_length(wish.new_passphrase)

    def unlock(lock: StoreLock | None) -> Unlocked:
        if lock is not None:
            check_traces(folder)
        file, key = _opened(folder, wish.recovery_key)
        return Unlocked(key, _chosen(_administrators(file, key), wish.name))

    store = open_unlocked(
        folder, unlock, operator=operator, clock=clock, server_password=server_password
    )
    with ExitStack() as if_that_fails:
        if_that_fails.callback(store.close)
        store.people.replace_lost_passphrase(wish.new_passphrase, key_params)
        if_that_fails.pop_all()
    return store


def _opened(folder: Path, typed: str) -> tuple[KeyFile, bytes]:
    recovery_key = read_recovery_key(typed)
    file = read_key_file(folder)
    if file is None or file.recovery is None:
        raise StoreError(
            "This patient store has no recovery key: none was made, or its key.json is not there. "
            "Give the passphrase, or restore the keyring or a backup."
        )
    key = key_by_recovery(file, recovery_key)
    if key is None:
        raise PassphraseError(
            "This is not the recovery key of this patient store: it is typed rightly, but belongs "
            "to another store, or a newer one took its place. Nothing was changed."
        )
    if fingerprint_of(key) != file.fingerprint:
        raise damaged("the copy for the recovery key belongs to another store")
    return file, key


def _administrators(file: KeyFile, key: bytes) -> tuple[Person, ...]:
    if file.place != "people":
        return ()
    return tuple(one for one in people_in(file, key) if one.role is Role.ADMINISTRATOR)


def _chosen(people: tuple[Person, ...], name: str) -> Person | None:
    """Return whose passphrase is replaced; nobody's in a store without people."""
    chosen = chosen_name(tuple(one.name for one in people), name)
    return next((one for one in people if one.name == chosen), None)
