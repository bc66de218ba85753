"""The sessions of the patients: one visit each, with how it was taken."""

import uuid
from collections.abc import Callable
from datetime import datetime

from sqlalchemy import select
from sqlalchemy.orm import Session as Transaction

from adibas.data.sessions import Session, SessionSetup
from adibas.errors import StoreError
from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.documents import setup_from_json, setup_to_json
from adibas.sessions.patients import found_patient
from adibas.sessions.schema import CaptureRecord, PatientRecord, SessionRecord


class Sessions:
    """The sessions of a store."""

    def __init__(self, database: Database, audit: AuditLog, purge: Callable[[str], None]) -> None:
        self._database = database
        self._audit = audit
        self._purge = purge

    def start(self, pseudonym: str, setup: SessionSetup) -> Session:
        """Begin a session of a patient now.

        Raises
        ------
        StoreError
            There is no such patient, the store is read-only, or the disk is full.
        """
        with self._database.changing() as transaction:
            found_patient(transaction, pseudonym)
            record = SessionRecord(
                session_id=uuid.uuid4().hex,
                pseudonym=pseudonym,
                started_utc=self._audit.now(),
                operator=self._audit.operator,
                setup=setup_to_json(setup),
                notes="",
                is_deleted=False,
            )
            transaction.add(record)
            self._audit.write(transaction, "create", record.session_id, patient=pseudonym)
            return _session(transaction, record)

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
        theirs = select(SessionRecord).where(SessionRecord.pseudonym == pseudonym)
        if not with_deleted:
            theirs = theirs.where(SessionRecord.is_deleted.is_(False))
        with self._database.reading() as transaction:
            found = transaction.scalars(theirs.order_by(SessionRecord.started_utc.desc()))
            return tuple(_session(transaction, record) for record in found)

    def recent(self, limit: int = 20) -> tuple[Session, ...]:
        """Return the last sessions of all patients, newest first, without hidden ones."""
        newest = (
            select(SessionRecord)
            .join(PatientRecord, PatientRecord.pseudonym == SessionRecord.pseudonym)
            .where(SessionRecord.is_deleted.is_(False), PatientRecord.is_deleted.is_(False))
            .order_by(SessionRecord.started_utc.desc())
            .limit(limit)
        )
        with self._database.reading() as transaction:
            return tuple(_session(transaction, r) for r in transaction.scalars(newest))

    def change(
        self, session_id: str, *, notes: str | None = None, setup: SessionSetup | None = None
    ) -> Session:
        """Change what is given; None leaves it as it is.

        Raises
        ------
        StoreError
            There is no such session, the store is read-only, or the disk is full.
        """
        given = {"notes": notes, "setup": setup}
        fields = [name for name, value in given.items() if value is not None]
        with self._database.changing() as transaction:
            record = found_session(transaction, session_id)
            if notes is not None:
                record.notes = notes
            if setup is not None:
                record.setup = setup_to_json(setup)
            if fields:
                self._audit.write(transaction, "change", session_id, fields=fields)
            return _session(transaction, record)

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
        self._purge(session_id)

    def _hide(self, session_id: str, *, is_deleted: bool) -> None:
        with self._database.changing() as transaction:
            record = found_session(transaction, session_id)
            if record.is_deleted != is_deleted:
                record.is_deleted = is_deleted
                self._audit.write(transaction, "delete" if is_deleted else "restore", session_id)


def found_session(transaction: Transaction, session_id: str) -> SessionRecord:
    """Return the record, or raise StoreError."""
    record = transaction.get(SessionRecord, session_id)
    if record is None:
        raise StoreError(
            "There is no session {session_id} in this store; perhaps it was purged. Choose another "
            "one.",
            session_id=session_id,
        )
    return record


def _session(transaction: Transaction, record: SessionRecord) -> Session:
    captures = (
        select(CaptureRecord.capture_id)
        .where(CaptureRecord.session_id == record.session_id, CaptureRecord.is_deleted.is_(False))
        .order_by(CaptureRecord.number)
    )
    return Session(
        session_id=record.session_id,
        patient=record.pseudonym,
        started_utc=datetime.fromisoformat(record.started_utc),
        operator=record.operator,
        setup=setup_from_json(record.setup),
        notes=record.notes,
        capture_ids=tuple(transaction.scalars(captures)),
        is_deleted=record.is_deleted,
    )
