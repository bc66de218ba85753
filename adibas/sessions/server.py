"""The database on a PostgreSQL server, for several workstations at a time.

What is written is sealed before it leaves this computer (`sealed_columns`). One change is made
after the other, whoever makes it: its lock is the server's, and ends with the connection.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import Engine, create_engine, event, inspect, select, text
from sqlalchemy.exc import DatabaseError
from sqlalchemy.pool import QueuePool

from adibas.errors import ServerAwayError, ServerPasswordError, StoreError
from adibas.sessions.database import DatabaseKind
from adibas.sessions.key_file import fingerprint_of
from adibas.sessions.rows import Transaction
from adibas.sessions.schema import METADATA
from adibas.sessions.sealed_columns import seal_columns
from adibas.sessions.server_address import ServerAddress

SECONDS_TO_CONNECT = 5
SECONDS_TO_WAIT = 10
SECONDS_WITHOUT_A_SIGN = 15
"""After that a connection counts as lost: a cable was pulled, a server switched off."""

NO_FILE = f"{os.devnull}/none"
"""Passwords are asked for, or in the keyring; of an empty file libpq would complain."""

CHANGING, OPEN, RESTORING = 0x41444942_01, 0x41444942_02, 0x41444942_03
"""Numbers of locks in the database: held during a change, while a store is open, and while a
backup is restored into it. The last two end with the connection, at a restart of the server too."""

SETTINGS = (
    f"-c lock_timeout={SECONDS_TO_WAIT}s -c idle_in_transaction_session_timeout=60s "
    "-c synchronous_commit=on"
)

BESIDE_THE_TABLES = (
    """
CREATE FUNCTION audit_is_append_only() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN RAISE EXCEPTION 'the audit log is append-only' USING ERRCODE = '23000'; END $$
""",
    """
CREATE TRIGGER audit_guard BEFORE UPDATE OR DELETE OR TRUNCATE ON audit
FOR EACH STATEMENT EXECUTE FUNCTION audit_is_append_only()
""",
    "CREATE TABLE store (fingerprint text NOT NULL)",
    "CREATE TABLE alembic_version (version_num varchar(32) PRIMARY KEY)",
)


class ServerDatabase(DatabaseKind):
    """The tables of a store in a database of their own.

    Parameters
    ----------
    folder : Path
        Of the store, with its sealed files.
    key : bytes
        Of the store, from which that of the columns is made.
    address : ServerAddress
        Of the database.
    password : str or None
        Where the server asks for one.
    """

    seals_columns = True
    reading_words = ("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ READ ONLY",)
    changing_words = (f"SELECT pg_advisory_xact_lock({CHANGING})",)

    def __init__(
        self, folder: Path, key: bytes, address: ServerAddress, password: str | None
    ) -> None:
        self.folder = folder
        self.server = address.host
        self._is_here = address.is_here
        self._fingerprint = fingerprint_of(key)
        self.engine = _engine(address, password)
        seal_columns(self.engine.dialect, key)

    def check_readable(self, transaction: Transaction) -> None:
        """See that the tables are there and belong to this store."""
        if "store" not in inspect(transaction).get_table_names():
            raise StoreError(
                "The database on {server} holds no patient store. Nothing was changed. Check the "
                "address in server.json, or restore the database from a backup.",
                server=self.server,
            )
        found = transaction.execute(text("SELECT fingerprint FROM store")).scalar_one()
        if found != self._fingerprint:
            raise StoreError(
                "The database on {server} belongs to another patient store. Nothing was changed. "
                "Check the address in server.json.",
                server=self.server,
            )

    def check_in_place(self) -> None:
        """Do nothing: tables stay on their server."""

    def make_tables(self, transaction: Transaction, revision: str) -> None:
        """Make the tables in an empty database.

        Raises
        ------
        StoreError
            It holds tables already.
        """
        if inspect(transaction).get_table_names():
            raise StoreError(
                "The database on {server} is not empty, and nothing in it is replaced. Give the "
                "address of an empty one.",
                server=self.server,
            )
        METADATA.create_all(transaction)
        for statement in BESIDE_THE_TABLES:
            transaction.execute(text(statement))
        for table, value in (("store", self._fingerprint), ("alembic_version", revision)):
            transaction.execute(text(f"INSERT INTO {table} VALUES (:value)"), {"value": value})  # noqa: S608  (both names are ours)

    def is_sound(self, transaction: Transaction) -> bool:
        """Open every sealed content; the server itself looks after links and pages."""
        try:
            for table in METADATA.sorted_tables:
                for _row in transaction.execute(select(table)):
                    pass
        except StoreError:
            return False
        return True

    def is_alone(self, transaction: Transaction) -> bool:
        """Say whether no other workstation is connected; none can open the store from now on.

        One whose connection broke may be recording all the same: what it writes tells that.
        """
        taken = transaction.execute(text(f"SELECT pg_try_advisory_lock({OPEN})"))
        return bool(taken.scalar_one())

    def let_others_in(self, transaction: Transaction) -> None:
        """Let other workstations open the store."""
        transaction.execute(text(f"SELECT pg_advisory_unlock({OPEN})"))

    def begin_restore(self, transaction: Transaction) -> bool:
        """Keep other workstations from restoring; False where one is just doing that."""
        taken = transaction.execute(text(f"SELECT pg_try_advisory_lock({RESTORING})"))
        return bool(taken.scalar_one())

    def is_restoring(self, transaction: Transaction) -> bool:
        """Say whether the connection is still the one that keeps others from restoring."""
        held = text(
            "SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND granted AND "
            "pid = pg_backend_pid() AND ((classid::bigint << 32) | objid::bigint) = :number"
        )
        return bool(transaction.execute(held, {"number": RESTORING}).scalar_one())

    def end_restore(self, transaction: Transaction) -> None:
        """Let other workstations restore."""
        transaction.execute(text(f"SELECT pg_advisory_unlock({RESTORING})"))

    def forget_removed(self) -> None:
        """Let the server overwrite the places of removed rows."""
        with self.engine.connect() as connection:
            anew = connection.execution_options(isolation_level="AUTOCOMMIT")
            for table in METADATA.sorted_tables:
                anew.execute(text(f"VACUUM {table.name}"))

    def copy_to(self, path: Path, key: bytes) -> None:
        """Write the rows of one moment into one encrypted file, as a store without server has."""
        from adibas.sessions.copied_rows import write_file_of

        with self.engine.connect() as transaction, transaction.begin():
            write_file_of(transaction, path, key)

    def explained(self, error: BaseException | None, *, is_saving: bool) -> StoreError:
        """Say in words what the driver says; its own words may hold what was being written."""
        import psycopg

        if isinstance(error, psycopg.errors.LockNotAvailable):
            return ServerAwayError(
                "Another workstation is just changing the patient store, and nothing of this was "
                "saved. Wait a moment and try again."
            )
        if isinstance(error, psycopg.errors.DiskFull):
            return StoreError(
                "The disk of {server} is full, and nothing of this was saved. Ask whoever looks "
                "after the server for space, and try again.",
                server=self.server,
            )
        if isinstance(error, psycopg.OperationalError | psycopg.InterfaceError):
            return self._away(error, is_saving=is_saving)
        return StoreError(
            "The database on {server} refuses this ({reason}), and nothing of it was saved. Ask "
            "whoever looks after the server.",
            server=self.server,
            reason=type(error).__name__,
        )

    def _away(self, error: Exception, *, is_saving: bool) -> StoreError:
        attempt = getattr(error, "pgconn", None)
        if attempt is not None and (attempt.needs_password or attempt.used_password):
            return ServerPasswordError(
                "The database on {server} needs the password of its user, or another one. Type it "
                "as whoever looks after the server told you.",
                server=self.server,
            )
        if is_saving:
            return StoreError(  # to try it again unseen might save it twice
                "{server} went away while this was being saved, and it is not known whether it "
                "was. When the server is back, look whether it is there, and save it again if not.",
                server=self.server,
            )
        if attempt is not None and not self._is_here:
            return ServerAwayError(
                "{server}, which keeps the patients' database, does not answer, or has no "
                "certificate that this computer trusts, and nothing of this was saved. Check the "
                "network; docs/session-store.md tells what the address can say of certificates.",
                server=self.server,
            )
        return ServerAwayError(
            "{server}, which keeps the patients' database, does not answer, and nothing of this "
            "was saved. Check the network, then try again.",
            server=self.server,
        )


@contextmanager
def told_in_words(kind: DatabaseKind) -> Iterator[None]:
    """Say in words what a driver says outside of `Database`."""
    try:
        yield
    except DatabaseError as error:
        raise kind.explained(error.orig, is_saving=False) from error


def _engine(address: ServerAddress, password: str | None) -> Engine:
    try:
        import psycopg
    except ImportError as error:
        raise StoreError(
            "This patient store is on a server, and the part of the program that talks to servers "
            "is missing. Install it with: pip install 'adibas[server]'."
        ) from error

    told: dict[str, Any] = address.connection()

    def connect() -> Any:
        return psycopg.connect(
            **told,
            password=password,
            passfile=NO_FILE,
            options=SETTINGS,
            application_name="adibas",
            gssencmode="disable",
            connect_timeout=SECONDS_TO_CONNECT,
            keepalives_idle=SECONDS_TO_CONNECT,
            keepalives_interval=SECONDS_TO_CONNECT,
            keepalives_count=2,
            tcp_user_timeout=1000 * SECONDS_WITHOUT_A_SIGN,
        )

    engine = create_engine(
        "postgresql+psycopg://",
        creator=connect,
        poolclass=QueuePool,
        pool_size=1,
        max_overflow=0,
        pool_pre_ping=True,  # a server that was started anew meanwhile is not noticed
        use_native_hstore=False,
        hide_parameters=True,
    )
    event.listen(engine, "connect", _tell_that_open)
    return engine


def _tell_that_open(connection: Any, _record: object) -> None:
    """Hold the lock of those who have the store open, as long as the connection lasts."""
    connection.autocommit = True
    connection.execute(f"SELECT pg_advisory_lock_shared({OPEN})")
    connection.autocommit = False
