"""The patients of the store: identity, consents, and what hides or restores them."""

import secrets
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from datetime import datetime

from sqlalchemy import select

from adibas.clock import to_text
from adibas.data.patients import Consent, Identity, Patient
from adibas.errors import StoreError
from adibas.sessions.audit import AuditLog
from adibas.sessions.conflicts import Decision
from adibas.sessions.database import Database
from adibas.sessions.json_line import from_json, to_json
from adibas.sessions.patient_search import (
    PatientRow,
    as_looked_for,
    find_patients,
    identity_of,
)
from adibas.sessions.roles import Permission, may
from adibas.sessions.rows import (
    Row,
    Transaction,
    add_numbered_row,
    add_row,
    change_row,
    row_of,
)
from adibas.sessions.schema import CONSENTS, IDENTITIES, PATIENTS, SIGNERS
from adibas.sessions.search_text import searchable, simplified
from adibas.sessions.shared_fields import (
    Change,
    identity_of_fields,
    patient_fields,
    settle_fields,
)

LETTERS = "23456789ABCDEFGHJKMNPQRSTUVWXYZ"
"""Without those that look alike: 0 O, 1 I L."""
PREFIX, PSEUDONYM_LENGTH = "P-", 6
ALL_OF_THEM = 2**31
LIST_OF_PATIENTS = "patients"
"""The audit log's word for a look at the list of names."""


class Patients:
    """The patients of a store.

    Whoever may not do something is refused with `NotAllowedError`, a StoreError; who may not read
    notes is given patients without them, see `docs/session-store.md`.
    """

    def __init__(self, database: Database, audit: AuditLog, purge: Callable[[str], object]) -> None:
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
        self._audit.require(Permission.REGISTER_PATIENTS, LIST_OF_PATIENTS)
        with self._database.changing() as transaction:
            pseudonym = _new_pseudonym(transaction)
            created_utc = self._audit.now()
            patient = Patient(pseudonym, identity, sex, notes, datetime.fromisoformat(created_utc))
            add_row(
                transaction,
                PATIENTS,
                pseudonym=pseudonym,
                sex=sex,
                notes=notes,
                created_utc=created_utc,
                is_deleted=False,
            )
            add_row(transaction, IDENTITIES, **identity_columns(pseudonym, identity))
            self._audit.write(transaction, "create", pseudonym)
        return patient

    def change(
        self,
        pseudonym: str,
        *,
        identity: Identity | None = None,
        sex: str | None = None,
        notes: str | None = None,
        seen: Patient | None = None,
        decisions: Collection[Decision] = (),
    ) -> Patient:
        """Change what is given; None leaves it as it is.

        Parameters
        ----------
        seen : Patient, optional
            From what it is changed: what others changed since then stays. Without it the present
            state is meant.
        decisions : collection of Decision
            On the conflicts of an attempt before.

        Raises
        ------
        ConflictError
            Somebody else changed the same field since `seen`; nothing was saved.
        StoreError
            There is no such patient, the store is read-only, or the disk is full.
        """
        self._audit.require(Permission.CHANGE_PATIENTS, pseudonym)
        named = (("identity", identity), ("sex", sex), ("notes", notes))
        given = [name for name, value in named if value is not None]
        with self._database.changing() as transaction:
            now = _patient(transaction, pseudonym)
            base = now if seen is None else seen
            mine = patient_fields(
                identity or base.identity,
                base.sex if sex is None else sex,
                base.notes if notes is None else notes,
            )
            change = Change(_fields_of(base), _fields_of(now), mine)
            settled = settle_fields(transaction, pseudonym, change, decisions)
            groups = settled.groups if seen is not None else tuple(given)
            if groups:
                _keep_fields(transaction, pseudonym, settled.values)
            if groups or settled.detail:
                self._audit.write(
                    transaction, "change", pseudonym, fields=list(groups), **settled.detail
                )
            return _patient(transaction, pseudonym)

    def get(self, pseudonym: str) -> Patient:
        """Return a patient, a hidden one too.

        Raises
        ------
        StoreError
            There is no such patient.
        """
        self._audit.require(Permission.FIND_PATIENTS, pseudonym)
        with self._database.reading() as transaction:
            patient = _patient(transaction, pseudonym)
        self._audit.saw(pseudonym)
        return self._as_shown(patient)

    def search(
        self, text: str, *, limit: int = 200, with_deleted: bool = False
    ) -> tuple[PatientRow, ...]:
        """Return the patients in whom every word of `text` is found, by name.

        A word may be part of the name (capitals and accents do not matter), of the record number,
        the pseudonym, or the birth date (2014-03-27, 27/03/2014 or 27.03.2014).

        Who may not see all names is told those for whom he looks: by three letters of the name at
        least, or by the whole birth date, record number or pseudonym. The others he finds by their
        pseudonym, which they have in place of the name.
        """
        self._audit.require(Permission.FIND_PATIENTS, LIST_OF_PATIENTS)
        sees_all = may(self._audit.role, Permission.SEE_ALL_NAMES)
        with self._database.reading() as transaction:
            rows = find_patients(
                transaction,
                text,
                limit if sees_all else ALL_OF_THEM,
                with_deleted=with_deleted,
                is_sealed=self._database.seals_columns,
            )
        if not sees_all:
            rows = as_looked_for(rows, text)[:limit]
        if any(row.identity.name != row.pseudonym for row in rows):
            self._audit.saw(LIST_OF_PATIENTS)
        return rows

    def names(self) -> dict[str, str]:
        """Return the name of every patient, the hidden ones included, by pseudonym."""
        self._audit.require(Permission.SEE_ALL_NAMES, LIST_OF_PATIENTS)
        columns = IDENTITIES.c
        with self._database.reading() as transaction:
            found = transaction.execute(select(columns.pseudonym, columns.name))
            names = {row.pseudonym: row.name for row in found}
        if names:
            self._audit.saw(LIST_OF_PATIENTS)
        return names

    def give_consent(self, pseudonym: str, consent: Consent) -> Patient:
        """Save that the patient, or a guardian, agreed.

        Raises
        ------
        StoreError
            There is no such patient, the store is read-only, or the disk is full.
        """
        self._audit.require(Permission.REGISTER_PATIENTS, pseudonym)
        with self._database.changing() as transaction:
            found_patient(transaction, pseudonym)
            consent_id = add_numbered_row(
                transaction,
                CONSENTS,
                pseudonym=pseudonym,
                purposes=to_json(list(consent.purposes)),
                is_guardian=consent.is_guardian,
                given_utc=to_text(consent.given_utc),
                withdrawn_utc=_time_text(consent.withdrawn_utc),
            )
            add_row(transaction, SIGNERS, consent_id=consent_id, name=consent.given_by)
            self._audit.write(
                transaction, "change", pseudonym, consent="given", purposes=list(consent.purposes)
            )
            return self._as_shown(_patient(transaction, pseudonym))

    def withdraw_consent(self, pseudonym: str, index: int) -> Patient:
        """Save that consent `index` of `Patient.consents` stands no more.

        Raises
        ------
        StoreError
            There is no such patient, the store is read-only, or the disk is full.
        """
        self._audit.require(Permission.REGISTER_PATIENTS, pseudonym)
        with self._database.changing() as transaction:
            found_patient(transaction, pseudonym)
            rows = _consent_rows(transaction, pseudonym)
            if not 0 <= index < len(rows):
                raise ValueError(f"consent {index} of {len(rows)}")
            if rows[index].withdrawn_utc is None:
                consent_id, now = rows[index].consent_id, self._audit.now()
                change_row(transaction, CONSENTS, consent_id, withdrawn_utc=now)
                self._audit.write(
                    transaction, "change", pseudonym, consent="withdrawn", index=index
                )
            return self._as_shown(_patient(transaction, pseudonym))

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
        self._audit.require(Permission.PURGE, pseudonym)
        self._purge(pseudonym)

    def _as_shown(self, patient: Patient) -> Patient:
        """Return a patient without what whoever works may not see."""
        if may(self._audit.role, Permission.SEE_NOTES):
            return patient
        return replace(patient, notes="")

    def _hide(self, pseudonym: str, *, is_deleted: bool) -> None:
        self._audit.require(Permission.CHANGE_PATIENTS, pseudonym)
        with self._database.changing() as transaction:
            if found_patient(transaction, pseudonym).is_deleted != is_deleted:
                change_row(transaction, PATIENTS, pseudonym, is_deleted=is_deleted)
                self._audit.write(transaction, "delete" if is_deleted else "restore", pseudonym)


def found_patient(transaction: Transaction, pseudonym: str) -> Row:
    """Return the row, or raise StoreError."""
    row = row_of(transaction, PATIENTS, pseudonym)
    if row is None:
        raise StoreError(
            "There is no patient {pseudonym} in this store; perhaps the patient was purged. Choose "
            "another one.",
            pseudonym=pseudonym,
        )
    return row


def _new_pseudonym(transaction: Transaction) -> str:
    while True:
        letters = "".join(secrets.choice(LETTERS) for _ in range(PSEUDONYM_LENGTH))
        if row_of(transaction, PATIENTS, PREFIX + letters) is None:
            return PREFIX + letters


def identity_columns(pseudonym: str, identity: Identity) -> dict[str, str | None]:
    """Return the row of `IDENTITIES`."""
    born = identity.birth_date
    return {
        "pseudonym": pseudonym,
        "name": identity.name,
        "birth_date": None if born is None else born.isoformat(),
        "record_number": identity.record_number,
        "search_text": searchable(identity, pseudonym),
        "sort_name": simplified(identity.name),
    }


def _fields_of(patient: Patient) -> dict[str, str]:
    return patient_fields(patient.identity, patient.sex, patient.notes)


def _keep_fields(transaction: Transaction, pseudonym: str, values: Mapping[str, str]) -> None:
    columns = identity_columns(pseudonym, identity_of_fields(values))
    change_row(transaction, IDENTITIES, pseudonym, **columns)
    change_row(transaction, PATIENTS, pseudonym, sex=values["sex"], notes=values["notes"])


def _patient(transaction: Transaction, pseudonym: str) -> Patient:
    row = found_patient(transaction, pseudonym)
    whose = select(IDENTITIES).where(IDENTITIES.c.pseudonym == pseudonym)
    return Patient(
        pseudonym=pseudonym,
        identity=identity_of(transaction.execute(whose).one()),
        sex=row.sex,
        notes=row.notes,
        created_utc=datetime.fromisoformat(row.created_utc),
        consents=tuple(_consent(one) for one in _consent_rows(transaction, pseudonym)),
        is_deleted=row.is_deleted,
    )


def _consent_rows(transaction: Transaction, pseudonym: str) -> list[Row]:
    """Return the consents of a patient in their order, each with the name of who signed."""
    in_order = (
        select(CONSENTS, SIGNERS.c.name)
        .join(SIGNERS, SIGNERS.c.consent_id == CONSENTS.c.consent_id)
        .where(CONSENTS.c.pseudonym == pseudonym)
        .order_by(CONSENTS.c.consent_id)
    )
    return list(transaction.execute(in_order))


def _consent(row: Row) -> Consent:
    withdrawn = row.withdrawn_utc
    return Consent(
        purposes=tuple(from_json(row.purposes)),
        given_by=row.name,
        is_guardian=row.is_guardian,
        given_utc=datetime.fromisoformat(row.given_utc),
        withdrawn_utc=None if withdrawn is None else datetime.fromisoformat(withdrawn),
    )


def _time_text(time_utc: datetime | None) -> str | None:
    return None if time_utc is None else to_text(time_utc)
