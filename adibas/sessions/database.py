"""The database: one connection, one transaction at a time, sentences for failures.

It is a file of the store (`sqlite_file`) or on a server (`server`): what differs between the two is
in those modules, behind `DatabaseKind`.
"""

import threading
from abc import abstractmethod
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Protocol

from sqlalchemy import Connection, Engine, event
from sqlalchemy.exc import DatabaseError, IntegrityError, StatementError

from adibas.errors import StoreError
from adibas.sessions.rows import Transaction

DATABASE_FILE = "adibas.db"


class DatabaseKind(Protocol):
    """Where the tables are, and what differs there.

    Attributes
    ----------
    folder : Path
        Of the store, with its sealed files.
    engine : Engine
        Gives one connection at a time.
    server : str
        Name of the computer through which several workstations write; empty where one does.
    seals_columns : bool
        Whether contents are sealed one by one, so that no statement can search or sort them.
    reading_words, changing_words : tuple of str
        Statements that begin a transaction that sees one state, and one that changes alone.
    """

    folder: Path
    engine: Engine
    server: str
    seals_columns: bool
    reading_words: tuple[str, ...]
    changing_words: tuple[str, ...]

    @abstractmethod
    def check_readable(self, transaction: Transaction) -> None:
        """Read something: of another key, or damaged, this fails."""

    @abstractmethod
    def check_in_place(self) -> None:
        """See that the tables are still those of the store."""

    @abstractmethod
    def is_sound(self, transaction: Transaction) -> bool:
        """Say whether the tables are whole."""

    @abstractmethod
    def is_alone(self, transaction: Transaction) -> bool:
        """Say whether nobody else has the store open; if so, nobody can open it from now on."""

    @abstractmethod
    def let_others_in(self, transaction: Transaction) -> None:
        """Let others open the store again."""

    @abstractmethod
    def begin_restore(self, transaction: Transaction) -> bool:
        """Keep others from restoring a backup; False where another one is just doing that."""

    @abstractmethod
    def is_restoring(self, transaction: Transaction) -> bool:
        """Say whether others have been kept from restoring without a break."""

    @abstractmethod
    def end_restore(self, transaction: Transaction) -> None:
        """Let others restore again."""

    @abstractmethod
    def copy_to(self, path: Path, key: bytes) -> None:
        """Write a copy into one file, encrypted with the store's key."""

    @abstractmethod
    def forget_removed(self) -> None:
        """Leave nothing of removed rows where the database keeps its journal or old rows."""

    @abstractmethod
    def explained(self, error: BaseException | None, *, is_saving: bool) -> StoreError:
        """Say in words what the driver says; its own words may hold what was being written."""


class Database:
    """The tables of a store, opened.

    Parameters
    ----------
    kind : DatabaseKind
        Where they are.
    is_read_only : bool
        Refuse every change but lines of the audit log.

    Raises
    ------
    StoreError
        There is no database, or it is damaged, or of another key.
    """

    def __init__(self, kind: DatabaseKind, *, is_read_only: bool) -> None:
        self.folder = kind.folder
        self.is_read_only = is_read_only
        self.is_shared = bool(kind.server)
        self.server = kind.server
        self.seals_columns = kind.seals_columns
        self._kind = kind
        self._lock = threading.RLock()
        self._is_inside = self._is_saving = False
        self._is_closed = False
        event.listen(kind.engine, "begin", self._begin)
        self._words = kind.reading_words
        with ExitStack() as on_failure:
            on_failure.callback(kind.engine.dispose)
            with self.reading() as transaction:
                kind.check_readable(transaction)
            on_failure.pop_all()

    @contextmanager
    def reading(self) -> Iterator[Transaction]:
        """Give a transaction that sees one state of the database."""
        with self._transaction(self._kind.reading_words) as transaction:
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
        with self._transaction(self._kind.changing_words) as transaction:
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
        with self._transaction(self._kind.changing_words) as transaction:
            yield transaction

    @contextmanager
    def alone(self) -> Iterator[bool]:
        """Say whether this opener may finish what others left; none opens the store meanwhile."""
        if self.is_read_only:
            yield False
            return
        with self.reading() as transaction:
            is_alone = self._kind.is_alone(transaction)
        yield is_alone
        if is_alone:
            with self.reading() as transaction:
                self._kind.let_others_in(transaction)

    @contextmanager
    def one_restore(self) -> Iterator[None]:
        """Let no other opener restore a backup meanwhile; one within another does no harm.

        Raises
        ------
        StoreError
            Another one is just doing that.
        """
        with self.reading() as transaction:
            has_begun = self._kind.begin_restore(transaction)
        if not has_begun:
            raise StoreError(
                "Another workstation is just restoring a backup into this patient store. Wait "
                "until it is done, then try again."
            )
        try:
            yield
        finally:
            # Where the server is gone, so is what it kept for us.
            with suppress(StoreError), self.reading() as transaction:
                self._kind.end_restore(transaction)

    def check_one_restore(self, transaction: Transaction) -> None:
        """See, before its change, that nobody else restored since `one_restore` began.

        Raises
        ------
        StoreError
            Somebody may have: the connection broke meanwhile.
        """
        if not self._kind.is_restoring(transaction):
            raise StoreError(
                "{server}, which keeps the patients' database, went away while the backup was "
                "being read, and nothing was changed. Restore it again.",
                server=self.server,
            )

    def is_sound(self, transaction: Transaction) -> bool:
        """Say whether the tables are whole."""
        return self._kind.is_sound(transaction)

    def empty_journal(self) -> None:
        """Let nothing of removed rows be kept beside the tables."""
        with self._alone():
            self._words = ()
            self._kind.forget_removed()

    def copy_to(self, path: Path, key: bytes) -> None:
        """Write a copy, encrypted with the same key; all of it is in that one file.

        Raises
        ------
        StoreError
            The disk of the copy is full, or fails; or the database is damaged.
        """
        with self._alone():
            self._words = self._kind.reading_words
            self._kind.copy_to(path, key)

    def close(self) -> None:
        """Let go of it; closing twice does no harm."""
        with self._lock:
            self._is_closed = True
            self._kind.engine.dispose()

    def _begin(self, connection: Connection) -> None:
        for word in self._words:
            connection.exec_driver_sql(word)

    @contextmanager
    def _transaction(self, words: tuple[str, ...]) -> Iterator[Transaction]:
        with self._alone():
            self._words = words
            with self._kind.engine.connect() as transaction, transaction.begin():
                self._kind.check_in_place()  # now nobody moves them before the end
                yield transaction
                self._is_saving = words == self._kind.changing_words

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
                raise self._kind.explained(error.orig, is_saving=self._is_saving) from error
            except UnicodeEncodeError:
                raise _no_text() from None  # the error holds the text, which may be a name
            except StatementError as error:
                if isinstance(error.orig, UnicodeEncodeError):
                    raise _no_text() from None
                raise
            finally:
                self._is_inside = self._is_saving = False


def _no_text() -> StoreError:
    return StoreError(
        "A text holds half a character, which nothing can keep, and nothing of this was saved. "
        "Type the text again."
    )
