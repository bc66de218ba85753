"""The encrypted database: one connection, one transaction at a time, sentences for failures."""

import shutil
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import sqlcipher3.dbapi2 as sqlcipher
from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.exc import DatabaseError, IntegrityError
from sqlalchemy.pool import StaticPool

from adibas.errors import StoreError
from adibas.sessions.rows import Transaction

DATABASE_FILE = "adibas.db"
SECONDS_TO_WAIT = 10.0
LEAST_FREE_BYTES = 1 << 20
"""For the journal and its index; where less is free the database may only say that it failed."""

PRAGMAS = (
    "PRAGMA cipher_log_level = NONE",
    "PRAGMA journal_mode = WAL",
    "PRAGMA synchronous = FULL",
    "PRAGMA foreign_keys = ON",
    "PRAGMA secure_delete = ON",
    "PRAGMA temp_store = MEMORY",
)


class Database:
    """`adibas.db`, opened.

    Parameters
    ----------
    folder : Path
        The store.
    key : bytes
        32 bytes, used as they are.
    is_read_only : bool
        Refuse every change but lines of the audit log.
    name : str
        Of the file; another one for a copy.

    Raises
    ------
    StoreError
        The file is no database, or damaged, or of another key.
    """

    def __init__(
        self, folder: Path, key: bytes, *, is_read_only: bool, name: str = DATABASE_FILE
    ) -> None:
        self.path = folder / name
        self.is_read_only = is_read_only
        self._lock = threading.RLock()
        self._is_inside = False
        self._is_closed = False
        self._engine = _engine(self.path, key)
        event.listen(self._engine, "begin", self._begin)
        self._begin_word = "BEGIN"
        with self.reading() as transaction:
            _check_readable(transaction)

    @contextmanager
    def reading(self) -> Iterator[Transaction]:
        """Give a transaction that sees one state of the database."""
        with self._transaction("BEGIN") as transaction:
            yield transaction

    @contextmanager
    def changing(self) -> Iterator[Transaction]:
        """Give a transaction that is on the disk when the block is left, or undone after an error.

        Raises
        ------
        StoreError
            The store is read-only, or the disk is full; nothing was changed then.
        """
        self.check_writable()
        with self._transaction("BEGIN IMMEDIATE") as transaction:
            yield transaction

    def check_writable(self) -> None:
        """See, before long work, that this opener may change something.

        Raises
        ------
        StoreError
            The store is read-only.
        """
        if self.is_read_only:
            raise StoreError(
                "The patient store is open in another window, and this one can only read. Close "
                "the other window, then open the store again."
            )

    @contextmanager
    def logging(self) -> Iterator[Transaction]:
        """Give a transaction for a line of the audit log alone: a reader writes one too."""
        with self._transaction("BEGIN IMMEDIATE") as transaction:
            yield transaction

    def empty_journal(self) -> None:
        """Bring everything into the database file, so that the journal keeps no old content."""
        with self._alone():
            connection = self._engine.raw_connection()
            try:
                connection.cursor().execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
            finally:
                connection.close()

    def copy_to(self, path: Path, key: bytes) -> None:
        """Write a copy, encrypted with the same key; all of it is in that one file.

        Raises
        ------
        StoreError
            The disk of the copy is full, or fails; or the database is damaged.
        """
        with self._alone(), ExitStack() as at_the_end:
            source = self._engine.raw_connection()
            at_the_end.callback(source.close)
            try:
                target = _connect(path, key)
                at_the_end.callback(target.close)
                source.driver_connection.backup(target)  # type: ignore[union-attr]
                # Closing would do that, too, but say nothing where it fails.
                target.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
            except sqlcipher.DatabaseError as error:
                raise _explained(error, path.parent) from error

    def close(self) -> None:
        """Let go of the file; closing twice does no harm."""
        with self._lock:
            self._is_closed = True
            self._engine.dispose()

    def _begin(self, connection: Connection) -> None:
        connection.exec_driver_sql(self._begin_word)

    @contextmanager
    def _transaction(self, begin_word: str) -> Iterator[Transaction]:
        with self._alone():
            self._begin_word = begin_word
            with self._engine.connect() as transaction, transaction.begin():
                yield transaction

    @contextmanager
    def _alone(self) -> Iterator[None]:
        with self._lock:
            if self._is_inside:
                raise RuntimeError("a transaction stands within another one")
            if self._is_closed:
                raise StoreError("The patient store is closed. Open it again.")
            self._is_inside = True
            try:
                yield
            except IntegrityError:
                raise  # a bug, or an attempt to rewrite the audit log
            except DatabaseError as error:
                raise _explained(error.orig, self.path.parent) from error
            except UnicodeEncodeError:
                raise _no_text() from None  # the error holds the text, which may be a name
            finally:
                self._is_inside = False


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
    try:
        for statement in (log_level, f"PRAGMA key = \"x'{key.hex()}'\"", *rest):
            connection.execute(statement).fetchall()
    except sqlcipher.DatabaseError:
        connection.close()
        raise
    return connection


def _check_readable(transaction: Transaction) -> None:
    """Read the first page: with a wrong key this fails."""
    transaction.exec_driver_sql("SELECT count(*) FROM sqlite_master").scalar_one()


def _cannot_open(reason: str) -> bool:
    """Say whether the files beside the database cannot be made, for whatever reason."""
    return "i/o error" in reason or "unable to open" in reason


def _is_full(folder: Path) -> bool:
    try:
        return shutil.disk_usage(folder).free < LEAST_FREE_BYTES
    except OSError:
        return False


def _no_text() -> StoreError:
    return StoreError(
        "A text holds half a character, which nothing can keep, and nothing of this was saved. "
        "Type the text again."
    )


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
