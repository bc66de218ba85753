"""The database as an encrypted file of the store: SQLCipher, for one writer at a time."""

import shutil
from contextlib import ExitStack
from pathlib import Path

import sqlcipher3.dbapi2 as sqlcipher
from sqlalchemy import Engine, create_engine
from sqlalchemy.pool import StaticPool

from adibas.errors import StoreError
from adibas.files import is_there
from adibas.sessions.database import DATABASE_FILE, DatabaseKind
from adibas.sessions.network_disks import is_on_network
from adibas.sessions.rows import Transaction
from adibas.sessions.server_address import SERVER_FILE

SECONDS_TO_WAIT = 10.0
LEAST_FREE_BYTES = 1 << 20
"""For the journal and its index; where less is free the database may only say that it failed."""

JOURNAL, JOURNAL_ON_NETWORK = "PRAGMA journal_mode = WAL", "PRAGMA journal_mode = TRUNCATE"
"""The first maps a file into memory: where a share goes, the system would end the program."""

ALONE = ("PRAGMA locking_mode = EXCLUSIVE", "PRAGMA journal_mode = DELETE")
"""The second fails where another connection has the first kind of journal."""

PRAGMAS = (
    "PRAGMA cipher_log_level = NONE",
    "PRAGMA synchronous = FULL",
    "PRAGMA foreign_keys = ON",
    "PRAGMA secure_delete = ON",
    "PRAGMA temp_store = MEMORY",
)


class SqliteFile(DatabaseKind):
    """`adibas.db` in the folder of a store.

    Parameters
    ----------
    folder : Path
        The store.
    key : bytes
        32 bytes, used as they are.
    name : str
        Of the file; another one for a copy.
    """

    server = ""
    seals_columns = False
    reading_words = ("BEGIN",)
    changing_words = ("BEGIN IMMEDIATE",)

    def __init__(self, folder: Path, key: bytes, name: str = DATABASE_FILE) -> None:
        self.folder = folder
        self.engine = _engine(folder / name, key)
        self._may_move = name == DATABASE_FILE

    def check_readable(self, transaction: Transaction) -> None:
        """Read the first page: with a wrong key this fails."""
        transaction.exec_driver_sql("SELECT count(*) FROM sqlite_master").scalar_one()

    def check_in_place(self) -> None:
        """See that the database has not gone to a server."""
        if self._may_move and is_there(self.folder / SERVER_FILE):
            raise StoreError(
                "The database of this patient store has gone to a server meanwhile, and nothing "
                "of this was saved. Close the store and open it again."
            )

    def keep_others_out(self) -> bool:
        """Let nobody else open the file until it is closed; False where somebody has it open.

        On a network disk an idle one is not noticed here: its next transaction waits, and fails.
        """
        connection = self.engine.raw_connection()
        try:
            for statement in ALONE:
                connection.cursor().execute(statement).fetchall()
        except sqlcipher.OperationalError as error:
            if "locked" in str(error):
                return False
            raise _explained(error, self.folder) from error
        finally:
            connection.close()
        return True

    def is_sound(self, transaction: Transaction) -> bool:
        """Check every page, every row and every link."""
        pages = transaction.exec_driver_sql("PRAGMA cipher_integrity_check").scalars().all()
        rows = transaction.exec_driver_sql("PRAGMA integrity_check").scalars().all()
        links = transaction.exec_driver_sql("PRAGMA foreign_key_check").all()
        return not pages and rows == ["ok"] and not links

    def is_alone(self, transaction: Transaction) -> bool:
        """Say yes: who may write holds the lock of the folder."""
        del transaction
        return True

    def let_others_in(self, transaction: Transaction) -> None:
        """Do nothing: readers come and go."""

    def begin_restore(self, transaction: Transaction) -> bool:
        """Say yes: who may write holds the lock of the folder."""
        del transaction
        return True

    def is_restoring(self, transaction: Transaction) -> bool:
        """Say yes: that lock does not end before the store is closed."""
        del transaction
        return True

    def end_restore(self, transaction: Transaction) -> None:
        """Do nothing: others cannot write."""

    def forget_removed(self) -> None:
        """Bring everything into the database file, so that the journal keeps no old content."""
        connection = self.engine.raw_connection()
        try:
            connection.cursor().execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
        finally:
            connection.close()

    def copy_to(self, path: Path, key: bytes) -> None:
        """Write a copy, encrypted with the same key; all of it is in that one file."""
        with ExitStack() as at_the_end:
            source = self.engine.raw_connection()
            at_the_end.callback(source.close)
            try:
                target = _connect(path, key)
                at_the_end.callback(target.close)
                source.driver_connection.backup(target)  # type: ignore[union-attr]
                # Closing would do that, too, but say nothing where it fails.
                target.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
            except sqlcipher.DatabaseError as error:
                raise _explained(error, path.parent) from error

    def explained(self, error: BaseException | None, *, is_saving: bool) -> StoreError:
        """Say in words what the driver says; its own words may hold what was being written."""
        del is_saving
        return _explained(error, self.folder)


def _engine(path: Path, key: bytes) -> Engine:
    return create_engine(
        "sqlite://",
        module=sqlcipher,
        creator=lambda: _connect(path, key),
        poolclass=StaticPool,
        hide_parameters=True,  # they may be names, and errors end up in logs
    )


def _connect(path: Path, key: bytes) -> sqlcipher.Connection:
    connection = sqlcipher.connect(
        str(path), isolation_level=None, check_same_thread=False, timeout=SECONDS_TO_WAIT
    )
    log_level, *rest = PRAGMAS
    journal = JOURNAL_ON_NETWORK if is_on_network(path.parent) else JOURNAL
    try:
        for statement in (log_level, f"PRAGMA key = \"x'{key.hex()}'\"", journal, *rest):
            connection.execute(statement).fetchall()
    except sqlcipher.DatabaseError:
        connection.close()
        raise
    return connection


def _cannot_open(reason: str) -> bool:
    """Say whether the files beside the database cannot be made, for whatever reason."""
    return "i/o error" in reason or "unable to open" in reason


def _is_full(folder: Path) -> bool:
    try:
        return shutil.disk_usage(folder).free < LEAST_FREE_BYTES
    except OSError:
        return False


def _explained(error: BaseException | None, folder: Path) -> StoreError:
    """Say in words what the driver says; its own words may hold what was being written."""
    reason = str(error).lower()
    if "full" in reason or (_cannot_open(reason) and _is_full(folder)):
        return StoreError(
            "The disk is full, and nothing of this was saved. Free some space and try again."
        )
    if "locked" in reason or "busy" in reason:
        return StoreError(
            "Another program holds the patient store, and nothing of this was saved. Close backup "
            "or synchronisation programs and try again."
        )
    if "not a database" in reason or "malformed" in reason or "encrypted" in reason:
        return StoreError(
            "{file} of the patient store is damaged, or is no database of this store. Nothing was "
            "changed. Restore the store's folder from a backup.",
            file=DATABASE_FILE,
        )
    return StoreError(
        "{file} of the patient store cannot be used ({reason}), and nothing of this was saved. "
        "Check the disk and try again.",
        file=DATABASE_FILE,
        reason=type(error).__name__,
    )
