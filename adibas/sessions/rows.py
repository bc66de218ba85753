"""How rows are found, made and changed, by their keys."""

from typing import Any, TypeAlias

from sqlalchemy import Connection, Table, delete, insert, select, update
from sqlalchemy import Row as AnyRow

Transaction: TypeAlias = Connection
Row: TypeAlias = AnyRow[*tuple[Any, ...]]


def row_of(transaction: Transaction, table: Table, key: object) -> Row | None:
    """Return the row with the primary key `key`; None where there is none."""
    found = select(table).where(_key(table) == key)
    return transaction.execute(found).one_or_none()


def add_row(transaction: Transaction, table: Table, **values: object) -> None:
    """Add one row."""
    transaction.execute(insert(table), values)


def add_numbered_row(transaction: Transaction, table: Table, **values: object) -> int:
    """Add one row whose primary key is a number that the database gives; return it."""
    added = insert(table).returning(_key(table))
    return int(transaction.execute(added, values).scalar_one())


def change_row(transaction: Transaction, table: Table, key: object, **values: object) -> None:
    """Change columns of the row with the primary key `key`."""
    transaction.execute(update(table).where(_key(table) == key).values(values))


def remove_row(transaction: Transaction, table: Table, key: object) -> None:
    """Remove the row with the primary key `key`, and with it what belongs to it."""
    transaction.execute(delete(table).where(_key(table) == key))


def values_of(row: Row, *without: str) -> dict[str, Any]:
    """Return what a row holds, by column."""
    return {name: value for name, value in row._asdict().items() if name not in without}


def _key(table: Table) -> Any:
    (key,) = table.primary_key
    return key
