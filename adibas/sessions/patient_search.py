"""Patients by words: found by the database where it can read them, here where it cannot."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import date, datetime
from typing import Any

from sqlalchemy import Select, func, select

from adibas.data.patients import Identity
from adibas.sessions.rows import Row, Transaction
from adibas.sessions.schema import IDENTITIES, PATIENTS, SESSIONS
from adibas.sessions.search_text import ESCAPE, date_texts, patterns, simplified

LEAST_LETTERS = 3
"""So many letters of a name at least are typed by who looks for one patient."""


@dataclass(frozen=True, slots=True)
class PatientRow:
    """One line of a search."""

    pseudonym: str
    identity: Identity
    n_sessions: int
    last_session_utc: datetime | None
    is_deleted: bool


def find_patients(
    transaction: Transaction, text: str, limit: int, *, with_deleted: bool, is_sealed: bool
) -> tuple[PatientRow, ...]:
    """Return the patients in whom every word of `text` is found, by name.

    Parameters
    ----------
    is_sealed : bool
        Whether the database cannot read what is searched.
    """
    if not is_sealed:
        found = transaction.execute(_search(text, limit, with_deleted=with_deleted))
        return tuple(_row(line) for line in found)
    wanted = _search_opened(transaction, text, limit, with_deleted=with_deleted)
    return tuple(sorted((_row(line) for line in transaction.execute(wanted)), key=_in_order))


def as_looked_for(rows: Iterable[PatientRow], text: str) -> tuple[PatientRow, ...]:
    """Return whom somebody may find by `text` who may not see all names.

    A name is told to who typed letters of it, or the whole birth date, record number or pseudonym:
    part of a number is part of everybody's. The others are found by their pseudonyms alone, and
    come after them in an order in which nothing is told of the names.
    """
    typed = simplified(text)
    words = typed.split()
    named, others = [], []
    for row in rows:
        if _is_meant(row, typed, words):
            named.append(row)
        elif all(word in simplified(row.pseudonym) for word in words):
            others.append(replace(row, identity=Identity(row.pseudonym)))
    return (*named, *sorted(others, key=lambda row: row.pseudonym))


def identity_of(row: Row) -> Identity:
    """Return who a row of `IDENTITIES` tells of."""
    born = None if row.birth_date is None else date.fromisoformat(row.birth_date)
    return Identity(row.name, born, row.record_number)


def _search(text: str, limit: int, *, with_deleted: bool) -> "Select[*tuple[Any, ...]]":
    theirs = (SESSIONS.c.pseudonym == PATIENTS.c.pseudonym) & SESSIONS.c.is_deleted.is_(False)
    n_sessions = select(func.count()).select_from(SESSIONS).where(theirs).scalar_subquery()
    last = select(func.max(SESSIONS.c.started_utc)).where(theirs).scalar_subquery()
    columns = IDENTITIES.c
    found = (
        select(
            IDENTITIES,
            PATIENTS.c.is_deleted,
            n_sessions.label("n_sessions"),
            last.label("last_session_utc"),
        )
        .join(PATIENTS, PATIENTS.c.pseudonym == columns.pseudonym)
        .where(*(columns.search_text.like(p, escape=ESCAPE) for p in patterns(text)))
        .order_by(columns.sort_name, columns.pseudonym)
        .limit(limit)
    )
    return found if with_deleted else found.where(PATIENTS.c.is_deleted.is_(False))


def _search_opened(
    transaction: Transaction, text: str, limit: int, *, with_deleted: bool
) -> "Select[*tuple[Any, ...]]":
    """Search here what the server holds sealed; then ask for the rows that were found."""
    columns = IDENTITIES.c
    everybody = select(columns.pseudonym, columns.search_text, columns.sort_name).join(
        PATIENTS, PATIENTS.c.pseudonym == columns.pseudonym
    )
    if not with_deleted:
        everybody = everybody.where(PATIENTS.c.is_deleted.is_(False))
    words = simplified(text).split()
    found = sorted(
        (row.sort_name, row.pseudonym)
        for row in transaction.execute(everybody)
        if all(word in row.search_text for word in words)
    )
    pseudonyms = [pseudonym for _name, pseudonym in found[:limit]]
    return _search("", limit, with_deleted=with_deleted).where(columns.pseudonym.in_(pseudonyms))


def _is_meant(row: PatientRow, typed: str, words: Sequence[str]) -> bool:
    """Say whether a search tells one patient from the others."""
    identity = row.identity
    name = simplified(identity.name)
    if any(word in name and sum(map(str.isalpha, word)) >= LEAST_LETTERS for word in words):
        return True
    numbers = (identity.record_number, row.pseudonym, *date_texts(identity.birth_date))
    return bool({simplified(one) for one in numbers if one.strip()} & {typed, *words})


def _in_order(row: PatientRow) -> tuple[str, str]:
    return simplified(row.identity.name), row.pseudonym


def _row(found: Row) -> PatientRow:
    last = found.last_session_utc
    return PatientRow(
        pseudonym=found.pseudonym,
        identity=identity_of(found),
        n_sessions=found.n_sessions,
        last_session_utc=None if last is None else datetime.fromisoformat(last),
        is_deleted=found.is_deleted,
    )
