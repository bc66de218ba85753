"""A backup into a store in use: what is missing is added, what differs is kept on both sides.

Purged patients and sessions do not come back, hidden ones stay hidden. Where the store has gone on
from the backup, it is right in everything that differs. Where both went on, the newer one of each
field is right, and what the other says is kept beside it.
"""

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import Table, select, update

from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.merged_rows import (
    ALL_FIELDS,
    Side,
    merge_corrections,
    merge_patient,
    merge_session,
)
from adibas.sessions.rows import (
    Row,
    Transaction,
    add_numbered_row,
    add_row,
    change_row,
    row_of,
    values_of,
)
from adibas.sessions.schema import (
    AUDIT,
    AUDIT_HEAD,
    CAPTURES,
    CONSENTS,
    CORRECTIONS,
    FILES,
    IDENTITIES,
    PATIENTS,
    RECORDINGS,
    SESSIONS,
    SIGNERS,
)


@dataclass(slots=True)
class MergeSummary:
    """What came of a backup.

    Attributes
    ----------
    n_patients, n_sessions, n_captures, n_recordings : int
        Added.
    n_purged : int
        Patients and sessions that were purged here, and do not come back.
    newer_here : list of str
        Ids of what was changed here after the backup, and stays as it is here.
    both_kept : list of str
        Ids of what was changed in both: the newer one is in force, the other one is kept.
    not_added : list of str
        Pseudonyms that stand for somebody else here; they are in the backup alone.
    other_codings : list of str
        Recordings of which something else was coded here; what was coded here stays.
    """

    n_patients: int = 0
    n_sessions: int = 0
    n_captures: int = 0
    n_recordings: int = 0
    n_purged: int = 0
    newer_here: list[str] = field(default_factory=list)
    both_kept: list[str] = field(default_factory=list)
    not_added: list[str] = field(default_factory=list)
    other_codings: list[str] = field(default_factory=list)


def merge(source: Database, target: Database, audit: AuditLog, making: set[str]) -> MergeSummary:
    """Add to `target` what `source` has and it has not, in one transaction.

    Parameters
    ----------
    making : set of str
        Recordings that are being made now.

    Raises
    ------
    StoreError
        The store is read-only, the disk is full, or the server went away since `one_restore`
        began; nothing was changed.
    """
    with source.reading() as theirs, target.changing() as ours:
        target.check_one_restore(ours)
        work = _Merge(theirs, ours, audit, making)
        summary = work.run()
        audit.write(
            ours,
            "merge",
            "store",
            patients=summary.n_patients,
            sessions=summary.n_sessions,
            captures=summary.n_captures,
            recordings=summary.n_recordings,
            both_kept=len(summary.both_kept),
        )
    return summary


class _Merge:
    """One table after the other, those first that others refer to."""

    def __init__(
        self, theirs: Transaction, ours: Transaction, audit: AuditLog, making: set[str]
    ) -> None:
        self._theirs, self._ours = theirs, ours
        self._audit = audit
        self._making = making
        self._summary = MergeSummary()
        self._sides = (
            Side(ours, _last_changes(ours), is_right=_went_on_from(ours, theirs)),
            Side(theirs, _last_changes(theirs)),
        )
        purged = select(AUDIT.c.subject).where(AUDIT.c.action == "purge")
        self._purged = set(ours.scalars(purged))

    def run(self) -> MergeSummary:
        self._patients()
        self._sessions()
        self._recordings()
        self._captures()
        return self._summary

    def _patients(self) -> None:
        for row in self._theirs.execute(select(PATIENTS)).all():
            pseudonym = row.pseudonym
            here = row_of(self._ours, PATIENTS, pseudonym)
            if pseudonym in self._purged:
                self._summary.n_purged += 1
            elif here is None:
                self._add(PATIENTS, row)
                self._add(IDENTITIES, row_of(self._theirs, IDENTITIES, pseudonym))
                self._consents(pseudonym)
                self._summary.n_patients += 1
                self._audit.write(self._ours, "merge", pseudonym, patient=pseudonym)
            elif here.created_utc != row.created_utc:
                self._summary.not_added.append(pseudonym)
            else:
                if self._consents(pseudonym):
                    self._log_change(pseudonym, ["consents"])
                self._settle(pseudonym, merge_patient(*self._sides, pseudonym))

    def _consents(self, pseudonym: str) -> bool:
        """Add consents that are missing; one that was withdrawn on either side is withdrawn.

        Returns
        -------
        is_changed : bool
        """
        whose = select(CONSENTS).where(CONSENTS.c.pseudonym == pseudonym)
        here = {_same_consent(row): row for row in self._ours.execute(whose)}
        is_changed = False
        for row in self._theirs.execute(whose.order_by(CONSENTS.c.consent_id)).all():
            known = here.get(_same_consent(row))
            if known is None:
                values = values_of(row, "consent_id")
                number = add_numbered_row(self._ours, CONSENTS, **values)
                signer = row_of(self._theirs, SIGNERS, row.consent_id)
                if signer is not None:
                    add_row(self._ours, SIGNERS, consent_id=number, name=signer.name)
                is_changed = True
            elif known.withdrawn_utc is None and row.withdrawn_utc is not None:
                withdrawn = {"withdrawn_utc": row.withdrawn_utc}
                change_row(self._ours, CONSENTS, known.consent_id, **withdrawn)
                is_changed = True
        return is_changed

    def _sessions(self) -> None:
        patients = set(self._ours.scalars(select(PATIENTS.c.pseudonym)))
        not_theirs = set(self._summary.not_added)
        for row in self._theirs.execute(select(SESSIONS)).all():
            session_id = row.session_id
            if session_id in self._purged:
                self._summary.n_purged += 1
            elif row.pseudonym not in patients or row.pseudonym in not_theirs:
                continue
            elif row_of(self._ours, SESSIONS, session_id) is not None:
                self._settle(session_id, merge_session(*self._sides, session_id))
            else:
                self._add(SESSIONS, row)
                self._summary.n_sessions += 1
                self._audit.write(self._ours, "merge", session_id, patient=row.pseudonym)

    def _recordings(self) -> None:
        for row in self._of_known_sessions(RECORDINGS):
            recording_id = row.recording_id
            here = row_of(self._ours, RECORDINGS, recording_id)
            if not row.is_closed or recording_id in self._making:
                continue
            if here is None:
                self._add(RECORDINGS, row)
            elif not here.is_closed:  # a crash cut it off here, and the backup has all of it
                anew = update(RECORDINGS).where(RECORDINGS.c.recording_id == recording_id)
                self._ours.execute(anew.values(values_of(row)))
            else:
                continue
            self._summary.n_recordings += 1
            self._audit.write(self._ours, "merge", recording_id, session=row.session_id)

    def _captures(self) -> None:
        for row in self._of_known_sessions(CAPTURES):
            capture_id = row.capture_id
            if row_of(self._ours, CAPTURES, capture_id) is not None:
                self._settle(capture_id, merge_corrections(*self._sides, capture_id))
                continue
            for file_id in (row.picture_id, row.surface_id):
                if file_id is not None:
                    self._add(FILES, row_of(self._theirs, FILES, file_id))
            recording = row.recording_id and row_of(self._ours, RECORDINGS, row.recording_id)
            without = {} if recording else {"recording_id": None}  # it was never finished
            add_row(self._ours, CAPTURES, **{**values_of(row), **without})
            theirs = select(CORRECTIONS).where(CORRECTIONS.c.capture_id == capture_id)
            for correction in self._theirs.execute(theirs.order_by(CORRECTIONS.c.correction_id)):
                values = values_of(correction, "correction_id")
                add_numbered_row(self._ours, CORRECTIONS, **values)
            self._summary.n_captures += 1
            self._audit.write(self._ours, "merge", capture_id, session=row.session_id)

    def _of_known_sessions(self, table: Table) -> list[Row]:
        """Return their rows of sessions that are here now, and of the same patient."""
        known = set(self._ours.scalars(select(SESSIONS.c.session_id)))
        return [row for row in self._theirs.execute(select(table)) if row.session_id in known]

    def _add(self, table: Table, row: Row | None) -> None:
        if row is not None:
            add_row(self._ours, table, **values_of(row))

    def _settle(self, subject: str, outcome: Collection[str] | None) -> None:
        """Note what came of a thing that is on both sides: None where both say the same."""
        if outcome is None:
            return
        if not outcome:
            self._summary.newer_here.append(subject)
            return
        self._summary.both_kept.append(subject)
        self._log_change(subject, outcome)

    def _log_change(self, subject: str, fields: Collection[str]) -> None:
        self._audit.write(self._ours, "change", subject, fields=sorted(fields), merged=True)


def _went_on_from(ours: Transaction, theirs: Transaction) -> bool:
    """Say whether our audit log begins with the whole of theirs."""
    head = theirs.execute(select(AUDIT_HEAD)).one_or_none()
    if head is None:
        return True
    line = row_of(ours, AUDIT, head.sequence)
    return line is not None and line.hash == head.hash


def _last_changes(transaction: Transaction) -> dict[tuple[str, str], str]:
    """Return when each field of each thing was changed last; see `Side.last_changes`."""
    telling = select(AUDIT.c.subject, AUDIT.c.time_utc, AUDIT.c.detail).where(
        AUDIT.c.action.in_(("create", "change"))
    )
    found: dict[tuple[str, str], str] = {}
    # One look at the log, which can be long, and whose time never goes back.
    for row in transaction.execute(telling.order_by(AUDIT.c.sequence)):
        for group in _changed_groups(json.loads(row.detail)):
            found[row.subject, group] = row.time_utc
    return found


def _changed_groups(detail: Mapping[str, Any]) -> Collection[str]:
    if "consent" in detail:
        return ()
    groups: Collection[str] = detail.get("fields", (ALL_FIELDS,))
    return groups


def _same_consent(row: Row) -> tuple[str, str, bool]:
    return row.given_utc, row.purposes, row.is_guardian
