"""The patients of the store: identity, consents, and what hides or restores them."""

import secrets
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date, datetime

from sqlalchemy import Select, func, select
from sqlalchemy.orm import Session as Transaction

from adibas.clock import to_text
from adibas.data.patients import Consent, Identity, Patient
from adibas.errors import StoreError
from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.documents import from_json, to_json
from adibas.sessions.schema import (
    ConsentRecord,
    IdentityRecord,
    PatientRecord,
    SessionRecord,
    SignerRecord,
)
from adibas.sessions.search_text import ESCAPE, patterns, searchable, simplified

LETTERS = "23456789ABCDEFGHJKMNPQRSTUVWXYZ"
"""Without those that look alike: 0 O, 1 I L."""
PREFIX, PSEUDONYM_LENGTH = "P-", 6
LIST_OF_PATIENTS = "patients"
"""The audit log's word for a look at the list of names."""


@dataclass(frozen=True, slots=True)
class PatientRow:
    """One line of a search."""

    pseudonym: str
    identity: Identity
    n_sessions: int
    last_session_utc: datetime | None
    is_deleted: bool


class Patients:
    """The patients of a store."""

    def __init__(self, database: Database, audit: AuditLog, purge: Callable[[str], None]) -> None:
        self._database = database
        self._audit = audit
        self._purge = purge

    def add(self, identity: Identity, *, sex: str = "", notes: str = "") -> Patient:
        """Save a new patient under a random pseudonym.

        Raises
        ------
        StoreError
            The store is read-only, or the disk is full.
        """
        with self._database.changing() as transaction:
            pseudonym = _new_pseudonym(transaction)
            created_utc = self._audit.now()
            patient = Patient(pseudonym, identity, sex, notes, datetime.fromisoformat(created_utc))
            transaction.add(
                PatientRecord(
                    pseudonym=pseudonym,
                    sex=sex,
                    notes=notes,
                    created_utc=created_utc,
                    is_deleted=False,
                )
            )
            transaction.flush()
            transaction.add(_identity_record(pseudonym, identity))
            self._audit.write(transaction, "create", pseudonym)
        return patient

    def change(
        self,
        pseudonym: str,
        *,
        identity: Identity | None = None,
        sex: str | None = None,
        notes: str | None = None,
    ) -> Patient:
        """Change what is given; None leaves it as it is.

        Raises
        ------
        StoreError
            There is no such patient, the store is read-only, or the disk is full.
        """
        given = {"identity": identity, "sex": sex, "notes": notes}
        fields = [name for name, value in given.items() if value is not None]
        with self._database.changing() as transaction:
            record = found_patient(transaction, pseudonym)
            if identity is not None:
                transaction.merge(_identity_record(pseudonym, identity))
            if sex is not None:
                record.sex = sex
            if notes is not None:
                record.notes = notes
            patient = _patient(transaction, record)
            if fields:
                self._audit.write(transaction, "change", pseudonym, fields=fields)
        return patient

    def get(self, pseudonym: str) -> Patient:
        """Return a patient, a hidden one too.

        Raises
        ------
        StoreError
            There is no such patient.
        """
        with self._database.reading() as transaction:
            patient = _patient(transaction, found_patient(transaction, pseudonym))
        self._audit.saw(pseudonym)
        return patient

    def search(
        self, text: str, *, limit: int = 200, with_deleted: bool = False
    ) -> tuple[PatientRow, ...]:
        """Return the patients in whom every word of `text` is found, by name.

        A word may be part of the name (capitals and accents do not matter), of the record number,
        the pseudonym, or the birth date (2014-03-27, 27/03/2014 or 27.03.2014).
        """
        with self._database.reading() as transaction:
            found = transaction.execute(_search(text, limit, with_deleted=with_deleted))
            rows = tuple(_row(*line) for line in found)
        if rows:
            self._audit.saw(LIST_OF_PATIENTS)
        return rows

    def give_consent(self, pseudonym: str, consent: Consent) -> Patient:
        """Save that the patient, or a guardian, agreed.

        Raises
        ------
        StoreError
            There is no such patient, the store is read-only, or the disk is full.
        """
        with self._database.changing() as transaction:
            patient = found_patient(transaction, pseudonym)
            record = ConsentRecord(
                pseudonym=pseudonym,
                purposes=to_json(list(consent.purposes)),
                is_guardian=consent.is_guardian,
                given_utc=to_text(consent.given_utc),
                withdrawn_utc=_time_text(consent.withdrawn_utc),
            )
            transaction.add(record)
            transaction.flush()
            transaction.add(SignerRecord(consent_id=record.consent_id, name=consent.given_by))
            self._audit.write(
                transaction, "change", pseudonym, consent="given", purposes=list(consent.purposes)
            )
            return _patient(transaction, patient)

    def withdraw_consent(self, pseudonym: str, index: int) -> Patient:
        """Save that consent `index` of `Patient.consents` stands no more.

        Raises
        ------
        StoreError
            There is no such patient, the store is read-only, or the disk is full.
        """
        with self._database.changing() as transaction:
            patient = found_patient(transaction, pseudonym)
            records = _consent_records(transaction, pseudonym)
            if not 0 <= index < len(records):
                raise ValueError(f"consent {index} of {len(records)}")
            if records[index].withdrawn_utc is None:
                records[index].withdrawn_utc = self._audit.now()
                self._audit.write(
                    transaction, "change", pseudonym, consent="withdrawn", index=index
                )
            return _patient(transaction, patient)

    def delete(self, pseudonym: str) -> None:
        """Hide a patient with all sessions, until `restore` or a purge.

        Raises
        ------
        StoreError
            There is no such patient, the store is read-only, or the disk is full.
        """
        self._hide(pseudonym, is_deleted=True)

    def restore(self, pseudonym: str) -> None:
        """Show a hidden patient again.

        Raises
        ------
        StoreError
            There is no such patient, the store is read-only, or the disk is full.
        """
        self._hide(pseudonym, is_deleted=False)

    def purge(self, pseudonym: str) -> None:
        """Remove a patient for good, with pictures, recordings and their keys.

        Raises
        ------
        StoreError
            There is no such patient, a recording is being made, or the store is read-only.
        """
        self._purge(pseudonym)

    def _hide(self, pseudonym: str, *, is_deleted: bool) -> None:
        with self._database.changing() as transaction:
            record = found_patient(transaction, pseudonym)
            if record.is_deleted != is_deleted:
                record.is_deleted = is_deleted
                self._audit.write(transaction, "delete" if is_deleted else "restore", pseudonym)


def found_patient(transaction: Transaction, pseudonym: str) -> PatientRecord:
    """Return the record, or raise StoreError."""
    record = transaction.get(PatientRecord, pseudonym)
    if record is None:
        raise StoreError(
            "There is no patient {pseudonym} in this store; perhaps the patient was purged. Choose "
            "another one.",
            pseudonym=pseudonym,
        )
    return record


def _search(
    text: str, limit: int, *, with_deleted: bool
) -> "Select[IdentityRecord, bool, int, str | None]":
    theirs = select(func.count()).where(
        SessionRecord.pseudonym == PatientRecord.pseudonym, SessionRecord.is_deleted.is_(False)
    )
    last = theirs.with_only_columns(func.max(SessionRecord.started_utc))
    found = (
        select(
            IdentityRecord,
            PatientRecord.is_deleted,
            theirs.scalar_subquery(),
            last.scalar_subquery(),
        )
        .join(PatientRecord, PatientRecord.pseudonym == IdentityRecord.pseudonym)
        .where(*(IdentityRecord.search_text.like(p, escape=ESCAPE) for p in patterns(text)))
        .order_by(IdentityRecord.sort_name, IdentityRecord.pseudonym)
        .limit(limit)
    )
    return found if with_deleted else found.where(PatientRecord.is_deleted.is_(False))


def _row(
    identity: IdentityRecord, is_deleted: bool, n_sessions: int, last: str | None
) -> PatientRow:
    return PatientRow(
        pseudonym=identity.pseudonym,
        identity=_identity(identity),
        n_sessions=n_sessions,
        last_session_utc=None if last is None else datetime.fromisoformat(last),
        is_deleted=is_deleted,
    )


def _new_pseudonym(transaction: Transaction) -> str:
    while True:
        letters = "".join(secrets.choice(LETTERS) for _ in range(PSEUDONYM_LENGTH))
        if transaction.get(PatientRecord, PREFIX + letters) is None:
            return PREFIX + letters


def _identity_record(pseudonym: str, identity: Identity) -> IdentityRecord:
    born = identity.birth_date
    return IdentityRecord(
        pseudonym=pseudonym,
        name=identity.name,
        birth_date=None if born is None else born.isoformat(),
        record_number=identity.record_number,
        search_text=searchable(identity, pseudonym),
        sort_name=simplified(identity.name),
    )


def _identity(record: IdentityRecord) -> Identity:
    born = None if record.birth_date is None else date.fromisoformat(record.birth_date)
    return Identity(record.name, born, record.record_number)


def _patient(transaction: Transaction, record: PatientRecord) -> Patient:
    identity = transaction.get_one(IdentityRecord, record.pseudonym)
    signers = {
        signer.consent_id: signer.name
        for signer in transaction.scalars(
            select(SignerRecord)
            .join(ConsentRecord, ConsentRecord.consent_id == SignerRecord.consent_id)
            .where(ConsentRecord.pseudonym == record.pseudonym)
        )
    }
    return Patient(
        pseudonym=record.pseudonym,
        identity=_identity(identity),
        sex=record.sex,
        notes=record.notes,
        created_utc=datetime.fromisoformat(record.created_utc),
        consents=tuple(
            _consent(consent, signers[consent.consent_id])
            for consent in _consent_records(transaction, record.pseudonym)
        ),
        is_deleted=record.is_deleted,
    )


def _consent_records(transaction: Transaction, pseudonym: str) -> list[ConsentRecord]:
    in_order = (
        select(ConsentRecord)
        .where(ConsentRecord.pseudonym == pseudonym)
        .order_by(ConsentRecord.consent_id)
    )
    return list(transaction.scalars(in_order))


def _consent(record: ConsentRecord, signer: str) -> Consent:
    withdrawn = record.withdrawn_utc
    return Consent(
        purposes=tuple(from_json(record.purposes)),
        given_by=signer,
        is_guardian=record.is_guardian,
        given_utc=datetime.fromisoformat(record.given_utc),
        withdrawn_utc=None if withdrawn is None else datetime.fromisoformat(withdrawn),
    )


def _time_text(time_utc: datetime | None) -> str | None:
    return None if time_utc is None else to_text(time_utc)
