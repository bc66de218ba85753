"""A store is opened: by a passphrase, the keyring or the recovery key; a new one is made."""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.clock import Clock, utc_now
from adibas.errors import StoreError
from adibas.files import is_there
from adibas.sessions.audit import AuditLog
from adibas.sessions.database import DATABASE_FILE, Database
from adibas.sessions.key_file import KEY_FILE
from adibas.sessions.key_wrapping import Argon2Params
from adibas.sessions.keys import make_key, open_key
from adibas.sessions.lock import StoreLock, cannot_use
from adibas.sessions.migrating import bring_up_to_date
from adibas.sessions.people_state import note_other_people
from adibas.sessions.person_keys import Unlocked
from adibas.sessions.places import PICTURES_FOLDER, RECORDINGS_FOLDER
from adibas.sessions.server_address import read_server_file
from adibas.sessions.sqlite_file import SqliteFile
from adibas.sessions.store import STORE_AS_SUBJECT, SessionStore

if TYPE_CHECKING:
    from adibas.sessions.server_address import ServerAddress

Unlock = Callable[[StoreLock | None], Unlocked]
"""Gives the key and whose it is; the lock of the folder, or None where the store is on a server."""


def open_store(
    folder: Path,
    passphrase: str | None = None,
    *,
    operator: str = "",
    clock: Clock = utc_now,
    key_params: Argon2Params | None = None,
    server_password: str | None = None,
) -> SessionStore:
    """Open a store; a new one is made where there is none.

    Where `server.json` names a server, the database is there, and several openers may write.

    Parameters
    ----------
    folder : Path
        Of the store.
    passphrase : str, optional
        A new store's key is kept behind it; without it, in the desktop's keyring.
    operator : str
        Who works.
    clock : callable
        Gives the time of day.
    key_params : Argon2Params, optional
        Of a new store's passphrase.
    server_password : str, optional
        Of the server's user; the one in the keyring, if any, where it is not given.

    Raises
    ------
    PassphraseError
        A passphrase is needed, wrong, too short, or of no use.
    ServerPasswordError
        The server needs a password, or another one.
    StoreError
        The key is lost; the database is missing, damaged or of a later version; the folder cannot
        be used. Nothing is changed.
    FileError
        The key of a new store cannot be written.
    """
    params = key_params or Argon2Params()

    def unlock(lock: StoreLock | None) -> Unlocked:
        if lock is None:
            return open_key(folder, passphrase)
        return _key(folder, passphrase, params, may_make=lock.is_held)

    return open_unlocked(
        folder, unlock, operator=operator, clock=clock, server_password=server_password
    )


def open_unlocked(
    folder: Path,
    unlock: Unlock,
    *,
    operator: str = "",
    clock: Clock = utc_now,
    server_password: str | None = None,
) -> SessionStore:
    """Open a store with the key that `unlock` gives; see `open_store`."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_use(folder, error) from error
    with ExitStack() as if_that_fails:
        address = read_server_file(folder)
        if address is None:
            lock = StoreLock(folder)
            if_that_fails.callback(lock.release)
            key, person = unlock(lock)
            database = Database(SqliteFile(folder, key), is_read_only=not lock.is_held)
        else:
            key, person = unlock(None)
            database = _on_server(folder, key, address, server_password)
        if_that_fails.callback(database.close)
        bring_up_to_date(database, key)
        _mark_as_made(folder)
        audit = AuditLog(database, clock, operator, person)
        let_go = (lambda: None) if address is not None else lock.release
        store = SessionStore(folder, database, let_go, audit, key)
        told = {} if person is None else {"role": person.role.value}
        audit.append("open", STORE_AS_SUBJECT, read_only=store.is_read_only, **told)
        note_other_people(folder, database, audit)
        with database.alone() as is_alone:
            if is_alone:
                store.tidy()
        if_that_fails.pop_all()
    return store


def _on_server(
    folder: Path, key: bytes, address: "ServerAddress", password: str | None
) -> Database:
    from adibas.sessions.server import ServerDatabase
    from adibas.sessions.server_password import kept_password

    given = kept_password(address) if password is None else password
    return Database(ServerDatabase(folder, key, address, given), is_read_only=False)


def _mark_as_made(folder: Path) -> None:
    """Make the folders of the files, so that a database that vanishes later is missed."""
    try:
        for name in (PICTURES_FOLDER, RECORDINGS_FOLDER):
            (folder / name).mkdir(exist_ok=True)
    except OSError as error:
        raise cannot_use(folder, error) from error


def _key(folder: Path, passphrase: str | None, params: Argon2Params, *, may_make: bool) -> Unlocked:
    """Return the key and whose it is; one is made only where no trace of an older store is."""
    has_key, has_data, has_database = check_traces(folder)
    if has_key or has_data or has_database:
        return open_key(folder, passphrase)
    if not may_make:
        raise StoreError(
            "Another window is just making this patient store. Wait a moment and open it again."
        )
    return Unlocked(make_key(folder, passphrase, params), None)


def check_traces(folder: Path) -> tuple[bool, bool, bool]:
    """Say whether a key, folders of files and a database are there.

    Raises
    ------
    StoreError
        The database alone is missing.
    """
    has_key = is_there(folder / KEY_FILE)
    has_data = any(is_there(folder / name) for name in (PICTURES_FOLDER, RECORDINGS_FOLDER))
    database = folder / DATABASE_FILE
    has_database = is_there(database) and database.stat().st_size > 0
    if has_key and has_data and not has_database:
        raise StoreError(
            "{file} of the patient store is missing. Restore the store's folder from a backup.",
            file=DATABASE_FILE,
        )
    return has_key, has_data, has_database
