"""A store's database goes from its file to a server, for several workstations."""

from contextlib import ExitStack
from pathlib import Path

from adibas.clock import utc_now
from adibas.errors import PassphraseError, StoreError
from adibas.files import flush_folder
from adibas.sessions.audit import AuditLog
from adibas.sessions.copied_rows import copy_rows
from adibas.sessions.database import DATABASE_FILE, Database
from adibas.sessions.key_file import read_key_file
from adibas.sessions.keys import open_key
from adibas.sessions.lock import StoreLock, cannot_use
from adibas.sessions.migrating import HEAD, bring_up_to_date
from adibas.sessions.roles import Permission
from adibas.sessions.server import ServerDatabase, told_in_words
from adibas.sessions.server_address import ServerAddress, read_server_file, write_server_file
from adibas.sessions.sqlite_file import SqliteFile

KEPT = f"{DATABASE_FILE}.before-server"
"""The file as it was; like copies from before a migration it goes with the next purge."""


def move_to_server(
    folder: Path, passphrase: str | None, address: ServerAddress, password: str | None
) -> None:
    """Copy the database of a store, which nobody has open, to an empty one on a server.

    From then on whoever opens the folder works on the server. The sealed files stay in the folder.

    Parameters
    ----------
    passphrase : str or None
        Of the store.
    password : str or None
        Of the server's user, where it asks for one.

    Raises
    ------
    NotAllowedError
        Of the store's people only administrators may.
    PassphraseError
        The passphrase is missing or wrong, or the key is in the keyring of this computer alone.
    ServerPasswordError
        The server needs a password, or another one.
    StoreError
        The store is open, or on a server already; the database there is not empty, or does not
        answer. The store is as it was.
    FileError
        `server.json` cannot be written; the store is as it was.
    """
    with ExitStack() as at_the_end:
        lock = StoreLock(folder)
        at_the_end.callback(lock.release)
        _check(folder, is_held=lock.is_held)
        key, person = open_key(folder, passphrase)
        file = SqliteFile(folder, key)
        source = Database(file, is_read_only=False)
        at_the_end.callback(source.close)
        AuditLog(source, utc_now, "", person).require(Permission.PROTECT)
        if not file.keep_others_out():  # a window that only reads writes its lines of the log
            raise _is_open()
        bring_up_to_date(source, key)
        server = ServerDatabase(folder, key, address, password)
        at_the_end.callback(server.engine.dispose)
        with source.changing() as rows, told_in_words(server), server.engine.begin() as target:
            server.make_tables(target, HEAD)
            copy_rows(rows, target)
        write_server_file(folder, address)
        source.close()
        _put_aside(folder)


def _check(folder: Path, *, is_held: bool) -> None:
    """See that the database is a file, that nobody has it open, and that others can get the key."""
    if read_server_file(folder) is not None:
        raise StoreError("The database of this patient store is on a server already.")
    if not is_held:
        raise _is_open()
    file = read_key_file(folder)
    if file is None or not (folder / DATABASE_FILE).exists():
        raise StoreError(
            "There is no patient store in {folder}. Give its folder with --store DIR.",
            folder=folder.name,
        )
    if file.place == "keyring":
        raise PassphraseError(
            "The key of this patient store is in the keyring of this computer, where no other "
            "workstation finds it. Put the store behind a passphrase first."
        )


def _is_open() -> StoreError:
    return StoreError(
        "The patient store is open in another window. Close that window, then move the database "
        "to the server."
    )


def _put_aside(folder: Path) -> None:
    try:
        (folder / DATABASE_FILE).replace(folder / KEPT)
        for ending in ("-wal", "-shm"):
            (folder / f"{DATABASE_FILE}{ending}").unlink(missing_ok=True)
        flush_folder(folder)
    except OSError as error:
        raise cannot_use(folder, error) from error
