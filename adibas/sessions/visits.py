"""The sessions of the patients: one visit each, with how it was taken."""

import uuid
from collections.abc import Callable, Collection
from dataclasses import replace
from datetime import datetime
from typing import Any

from sqlalchemy import Select, select

from adibas.data.sessions import Session, SessionSetup
from adibas.errors import StoreError
from adibas.sessions.audit import AuditLog
from adibas.sessions.conflicts import Decision
from adibas.sessions.consents import changing_with_consent, require_consent
from adibas.sessions.database import Database
from adibas.sessions.documents import setup_from_json, setup_to_json
from adibas.sessions.patients import found_patient
from adibas.sessions.roles import Permission
from adibas.sessions.rows import Row, Transaction, add_row, change_row, row_of
from adibas.sessions.schema import CAPTURES, PATIENTS, SESSIONS
from adibas.sessions.shared_fields import Change, session_fields, settle_fields, setup_of


class Sessions:
    """The sessions of a store."""

    def __init__(self, database: Database, audit: AuditLog, purge: Callable[[str], object]) -> None:
        self._database = database
        self._audit = audit
        self._purge = purge

    def start(self, pseudonym: str, setup: SessionSetup) -> Session:
        """Begin a session of a patient who consented now, set up like this.

        The turn of another session is not its own, and whether it repeats the one before it is
        said later, through `change`.

        Raises
        ------
        ConsentError
            No consent stands that a capture needs.
        StoreError
            There is no such patient, or it is hidden; the store is read-only, or the disk is full.
        """
        self._audit.require(Permission.TAKE_SESSIONS, pseudonym)
        session_id = uuid.uuid4().hex
        with changing_with_consent(self._database, self._audit, pseudonym) as transaction:
            if found_patient(transaction, pseudonym).is_deleted:
                raise _hidden()
            require_consent(transaction, pseudonym)
            add_row(
                transaction,
                SESSIONS,
                session_id=session_id,
                pseudonym=pseudonym,
                started_utc=self._audit.now(),
                operator=self._audit.operator,
                setup=setup_to_json(replace(setup, turn="", is_repeat=False)),
                notes="",
                is_deleted=False,
            )
            self._audit.write(transaction, "create", session_id, patient=pseudonym)
            return _session(transaction, found_session(transaction, session_id))

    def get(self, session_id: str) -> Session:
        """Return a session, a hidden one too.

        Raises
        ------
        StoreError
            There is no such session.
        """
        with self._database.reading() as transaction:
            session = _session(transaction, found_session(transaction, session_id))
        self._audit.saw(session_id)
        return session

    def of_patient(self, pseudonym: str, *, with_deleted: bool = False) -> tuple[Session, ...]:
        """Return a patient's sessions, newest first."""
        theirs = select(SESSIONS).where(SESSIONS.c.pseudonym == pseudonym)
        if not with_deleted:
            theirs = theirs.where(SESSIONS.c.is_deleted.is_(False))
        return self._found(theirs.order_by(SESSIONS.c.started_utc.desc()))

    def recent(self, limit: int = 20) -> tuple[Session, ...]:
        """Return the last sessions of all patients, newest first, without hidden ones."""
        return self._found(_in_sight().order_by(SESSIONS.c.started_utc.desc()).limit(limit))

    def of_operator(self, operator: str) -> tuple[Session, ...]:
        """Return what one operator recorded, without hidden ones: by patient, oldest first."""
        theirs = _in_sight().where(SESSIONS.c.operator == operator)
        return self._found(theirs.order_by(SESSIONS.c.pseudonym, SESSIONS.c.started_utc))

    def n_following(self, protocol: str) -> int:
        """Return how many sessions name a protocol, hidden ones too: they can be restored."""
        with self._database.reading() as transaction:
            setups = transaction.scalars(select(SESSIONS.c.setup))
            return sum(setup_from_json(one).protocol == protocol for one in setups)

    def change(
        self,
        session_id: str,
        *,
        notes: str | None = None,
        setup: SessionSetup | None = None,
        seen: Session | None = None,
        decisions: Collection[Decision] = (),
    ) -> Session:
        """Change what is given; None leaves it as it is.

        Parameters
        ----------
        seen : Session, optional
            From what it is changed: what others changed since then stays. Without it the present
            state is meant.
        decisions : collection of Decision
            On the conflicts of an attempt before.

        Raises
        ------
        ConflictError
            Somebody else changed the same field since `seen`; nothing was saved.
        StoreError
            There is no such session, the store is read-only, or the disk is full.
        """
        self._audit.require(Permission.TAKE_SESSIONS, session_id)
        named = (("notes", notes), ("setup", setup))
        given = [name for name, value in named if value is not None]
        with self._database.changing() as transaction:
            row = found_session(transaction, session_id)
            theirs = session_fields(row.notes, setup_from_json(row.setup))
            base = theirs if seen is None else session_fields(seen.notes, seen.setup)
            mine = dict(base) if setup is None else session_fields(base["notes"], setup)
            if notes is not None:
                mine["notes"] = notes
            settled = settle_fields(transaction, session_id, Change(base, theirs, mine), decisions)
            groups = settled.groups if seen is not None else tuple(given)
            if groups:
                kept = {"notes": settled.values["notes"]}
                kept["setup"] = setup_to_json(setup_of(settled.values))
                change_row(transaction, SESSIONS, session_id, **kept)
            if groups or settled.detail:
                self._audit.write(
                    transaction, "change", session_id, fields=list(groups), **settled.detail
                )
            return _session(transaction, found_session(transaction, session_id))

    def delete(self, session_id: str) -> None:
        """Hide a session, until `restore` or a purge.

        Raises
        ------
        StoreError
            There is no such session, the store is read-only, or the disk is full.
        """
        self._hide(session_id, is_deleted=True)

    def restore(self, session_id: str) -> None:
        """Show a hidden session again.

        Raises
        ------
        StoreError
            There is no such session, the store is read-only, or the disk is full.
        """
        self._hide(session_id, is_deleted=False)

    def purge(self, session_id: str) -> None:
        """Remove a session for good, with pictures, recordings and their keys.

        Raises
        ------
        StoreError
            There is no such session, a recording is being made, or the store is read-only.
        """
        self._audit.require(Permission.PURGE, session_id)
        self._purge(session_id)

    def _found(self, chosen: Select[Any]) -> tuple[Session, ...]:
        with self._database.reading() as transaction:
            rows = transaction.execute(chosen).all()
            return tuple(_session(transaction, row) for row in rows)

    def _hide(self, session_id: str, *, is_deleted: bool) -> None:
        self._audit.require(Permission.CHANGE_PATIENTS, session_id)
        with self._database.changing() as transaction:
            if found_session(transaction, session_id).is_deleted != is_deleted:
                change_row(transaction, SESSIONS, session_id, is_deleted=is_deleted)
                self._audit.write(transaction, "delete" if is_deleted else "restore", session_id)


def _in_sight() -> Select[Any]:
    """Choose the sessions that are not hidden, of patients who are not."""
    joined = select(SESSIONS).join(PATIENTS, PATIENTS.c.pseudonym == SESSIONS.c.pseudonym)
    return joined.where(SESSIONS.c.is_deleted.is_(False), PATIENTS.c.is_deleted.is_(False))


def found_session(transaction: Transaction, session_id: str) -> Row:
    """Return the row, or raise StoreError."""
    row = row_of(transaction, SESSIONS, session_id)
    if row is None:
        raise StoreError(
            "There is no session {session_id} in this store; perhaps it was purged. Choose another "
            "one.",
            session_id=session_id,
        )
    return row


def session_in_sight(transaction: Transaction, session_id: str) -> Row:
    """Return the row of a session that can be recorded in, or raise StoreError.

    What somebody hid meanwhile, at another workstation perhaps, takes nothing new that nobody
    would see.
    """
    row = found_session(transaction, session_id)
    if row.is_deleted or found_patient(transaction, row.pseudonym).is_deleted:
        raise _hidden()
    return row


def _hidden() -> StoreError:
    return StoreError(
        "This patient or session was deleted meanwhile and is hidden, so nothing more is recorded. "
        "Restore it on Patients, or begin another session."
    )


def _session(transaction: Transaction, row: Row) -> Session:
    captures = (
        select(CAPTURES.c.capture_id)
        .where(CAPTURES.c.session_id == row.session_id, CAPTURES.c.is_deleted.is_(False))
        .order_by(CAPTURES.c.number)
    )
    return Session(
        session_id=row.session_id,
        patient=row.pseudonym,
        started_utc=datetime.fromisoformat(row.started_utc),
        operator=row.operator,
        setup=setup_from_json(row.setup),
        notes=row.notes,
        capture_ids=tuple(transaction.scalars(captures)),
        is_deleted=row.is_deleted,
    )
