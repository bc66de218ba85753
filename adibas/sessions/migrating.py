"""Brings the tables to the present revision, or refuses those of a later program."""

import threading
from pathlib import Path

from sqlalchemy import inspect

from adibas.errors import StoreError
from adibas.files import written_whole
from adibas.sessions.database import DATABASE_FILE, Database
from adibas.sessions.rows import Transaction

HEAD = "0001"
"""The last revision under `migrations/versions` (a test compares), to start without Alembic."""

KNOWN = ("0001",)

REVISIONS = Path(__file__).parent / "migrations"

_ONE_AT_A_TIME = threading.Lock()
"""Alembic keeps the connection in a global: two threads would migrate each other's stores."""


def bring_up_to_date(database: Database, key: bytes) -> None:
    """Make the tables of a new database, or migrate an old one after keeping a copy of it.

    Raises
    ------
    StoreError
        The database is of a later version, or an old one that this opener may not change.
    FileError
        The copy cannot be written.
    """
    with database.reading() as transaction:
        revision = _revision(transaction)
    if revision == HEAD:
        return
    if revision is not None and revision not in KNOWN:
        raise StoreError(
            "The patient store was used with a later version of ADiBAS (its tables are {found}, "
            "this version knows {known}). Nothing was changed. Update the program.",
            found=revision,
            known=HEAD,
        )
    if revision is not None:
        _keep_copy(database, key, revision)
    with database.changing() as transaction:
        _upgrade(transaction)


def copies(folder: Path) -> list[Path]:
    """Return the copies that were kept before migrations."""
    return sorted(folder.glob(f"{DATABASE_FILE}.before-*"))


def _revision(transaction: Transaction) -> str | None:
    """Return the revision of the tables; None of an empty database."""
    tables = inspect(transaction).get_table_names()
    if not tables:
        return None
    if "alembic_version" not in tables:
        raise StoreError(
            "{file} is no database of ADiBAS. Nothing was changed. Restore the store's folder "
            "from a backup.",
            file=DATABASE_FILE,
        )
    found = transaction.exec_driver_sql("SELECT version_num FROM alembic_version").scalar_one()
    return str(found)


def _keep_copy(database: Database, key: bytes, revision: str) -> None:
    if database.is_read_only:
        raise StoreError(
            "The patient store is of an older version and is open in another window. Close that "
            "window, then open the store again."
        )
    kept = database.folder / f"{DATABASE_FILE}.before-{HEAD}-from-{revision}"
    with written_whole(kept) as path:
        database.copy_to(path, key)


def _upgrade(transaction: Transaction) -> None:
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(REVISIONS))
    config.attributes["connection"] = transaction
    with _ONE_AT_A_TIME:
        command.upgrade(config, "head")
