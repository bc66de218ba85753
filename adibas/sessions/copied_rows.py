"""All rows of a store from one database into another one, whatever keeps the two."""

from itertools import zip_longest
from pathlib import Path

from sqlalchemy import insert, select, text

from adibas.errors import StoreError
from adibas.sessions.database import Database
from adibas.sessions.migrating import bring_up_to_date
from adibas.sessions.rows import Transaction, values_of
from adibas.sessions.schema import METADATA
from adibas.sessions.sqlite_file import SqliteFile

ROWS_AT_A_TIME = 500


def copy_rows(source: Transaction, target: Transaction) -> None:
    """Copy every row into empty tables, and compare what stands there then.

    Raises
    ------
    StoreError
        The copy is not as the original.
    """
    for table in METADATA.sorted_tables:
        rows = source.execute(select(table).execution_options(yield_per=ROWS_AT_A_TIME))
        for part in rows.partitions():
            target.execute(insert(table), [values_of(row) for row in part])
    for table in METADATA.sorted_tables:
        in_order = select(table).order_by(*table.primary_key)
        pairs = zip_longest(source.execute(in_order), target.execute(in_order))
        if any(one is None or other is None or tuple(one) != tuple(other) for one, other in pairs):
            raise StoreError("The copy of the database is not as the original. Try again.")
    if target.dialect.name == "postgresql":
        _go_on_counting(target)


def write_file_of(source: Transaction, path: Path, key: bytes) -> None:
    """Write all rows into one new encrypted file with the tables of a store.

    Raises
    ------
    StoreError
        The disk is full, or fails.
    """
    target = Database(SqliteFile(path.parent, key, path.name), is_read_only=False)
    try:
        bring_up_to_date(target, key)
        with target.changing() as transaction:
            copy_rows(source, transaction)
        target.empty_journal()
    finally:
        target.close()


def _go_on_counting(target: Transaction) -> None:
    """Let a server give the next numbers where the copied ones end."""
    for table in METADATA.sorted_tables:
        key = table.autoincrement_column
        if key is None:
            continue
        target.execute(
            text(
                f"SELECT setval(pg_get_serial_sequence('{table.name}', '{key.name}'), "  # noqa: S608
                f"(SELECT coalesce(max({key.name}), 0) + 1 FROM {table.name}), false)"
            )
        )
