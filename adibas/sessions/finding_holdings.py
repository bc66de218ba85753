"""Finds everything that is held of a patient: in tables, sealed files, audit log and backups."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import TYPE_CHECKING

from sqlalchemy import Select, func, select

from adibas.errors import FileError, StoreError
from adibas.sessions.audit import AuditEntry, AuditLog, every_entry
from adibas.sessions.database import Database
from adibas.sessions.holdings import (
    HeldBackup,
    HeldCapture,
    HeldConsent,
    HeldFile,
    HeldRecording,
    HeldSession,
    Holdings,
    LeftStore,
)
from adibas.sessions.json_line import from_json
from adibas.sessions.key_file import read_key_file
from adibas.sessions.migrating import copies
from adibas.sessions.patients import found_patient
from adibas.sessions.places import ID_LENGTH
from adibas.sessions.roles import Permission, may
from adibas.sessions.rows import Row, Transaction, row_of
from adibas.sessions.schema import (
    CAPTURES,
    CONSENTS,
    CORRECTIONS,
    IDENTITIES,
    PATIENTS,
    RECORDINGS,
    SESSIONS,
)
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sealed_folder import SealedFolder
from adibas.sessions.stored_recordings import Recordings

if TYPE_CHECKING:
    from adibas.sessions.backup_schedule import BackupPlan

WHOLE_STORE = "store"
"""The audit log's word for what is of all patients."""


@dataclass(frozen=True, slots=True)
class _Rows:
    """What the tables say, in one state of the database."""

    patient: Row
    has_identity: bool
    consents: Sequence[Row]
    sessions: Sequence[Row]
    captures: Sequence[Row]
    recordings: Sequence[Row]
    n_corrections: dict[str, int]

    @property
    def ids(self) -> set[str]:
        """Every id that a line of the log may name."""
        return {
            self.patient.pseudonym,
            *(row.session_id for row in self.sessions),
            *(row.capture_id for row in self.captures),
            *(row.recording_id for row in self.recordings),
        }


@dataclass(frozen=True, slots=True)
class _Told:
    """What the audit log says of the patient, oldest first; nothing where it may not be read."""

    lines: tuple[AuditEntry, ...] | None
    backups: tuple[datetime, ...] | None
    exports: tuple[AuditEntry, ...] = ()


class FindHoldings:
    """Looks in all places where something of a patient may be."""

    def __init__(
        self, database: Database, audit: AuditLog, pictures: SealedFiles, recordings: Recordings
    ) -> None:
        self._database = database
        self._audit = audit
        self._pictures = pictures
        self._recordings = recordings

    def of(self, pseudonym: str, plan: "BackupPlan | None" = None) -> Holdings:
        """Return everything that is held of a patient, a hidden or removed one too.

        Who may not read the audit log is told what the tables, the files and the folder of backups
        say.

        Parameters
        ----------
        plan : BackupPlan, optional
            Of the backups that are made every few days.

        Raises
        ------
        StoreError
            There is no such patient, and never was; or the store cannot be read.
        """
        self._audit.require(Permission.FIND_PATIENTS, pseudonym)
        with self._database.reading() as transaction:
            is_here = row_of(transaction, PATIENTS, pseudonym) is not None
            rows = _rows_of(transaction, pseudonym) if is_here else None
            ids = {pseudonym} if rows is None else rows.ids
            told = self._told(transaction, pseudonym, ids)
            if rows is None and not told.lines:
                found_patient(transaction, pseudonym)  # says that there is none
        held = _gone(pseudonym, told) if rows is None else self._held(rows)
        self._audit.saw(pseudonym)
        return replace(
            held,
            left=_left(told, held.since_utc),
            n_log_lines=None if told.lines is None else len(told.lines),
            backups=self._backups(plan, held),
            backups_made=_since(told.backups, held),
            copies=tuple(path.name for path in copies(self._database.folder)),
        )

    def _told(self, transaction: Transaction, pseudonym: str, ids: set[str]) -> _Told:
        if not may(self._audit.role, Permission.READ_LOG):
            return _Told(None, None)
        theirs, of_all = [], []
        for entry in reversed(list(every_entry(transaction))):
            if entry.patient == pseudonym or entry.subject in ids:
                theirs.append(entry)
            elif entry.subject == WHOLE_STORE:
                of_all.append(entry)
        made = tuple(one.time_utc for one in of_all if one.action == "backup")
        exports = tuple(one for one in (*theirs, *of_all) if one.action == "export")
        return _Told(tuple(theirs), made, exports)

    def _held(self, rows: _Rows) -> Holdings:
        coded = defaultdict(list)
        for name in sorted(self._recordings.codings.ids()):
            coded[name[:ID_LENGTH]].append(_file(self._recordings.codings, name))
        captures, recordings = defaultdict(list), defaultdict(list)
        for row in rows.captures:
            captures[row.session_id].append(self._capture(row, rows.n_corrections))
        for row in rows.recordings:
            codings = tuple(coded[row.recording_id])
            recordings[row.session_id].append(self._recording(row, codings))
        return Holdings(
            pseudonym=rows.patient.pseudonym,
            since_utc=datetime.fromisoformat(rows.patient.created_utc),
            gone_utc=None,
            is_deleted=rows.patient.is_deleted,
            has_identity=rows.has_identity,
            has_notes=bool(rows.patient.notes),
            consents=tuple(_consent(row) for row in rows.consents),
            sessions=tuple(
                HeldSession(
                    session_id=row.session_id,
                    started_utc=datetime.fromisoformat(row.started_utc),
                    operator=row.operator,
                    has_notes=bool(row.notes),
                    captures=tuple(captures[row.session_id]),
                    recordings=tuple(recordings[row.session_id]),
                    is_deleted=row.is_deleted,
                )
                for row in rows.sessions
            ),
        )

    def _capture(self, row: Row, n_corrections: dict[str, int]) -> HeldCapture:
        surface_id = row.surface_id
        return HeldCapture(
            capture_id=row.capture_id,
            view=row.view,
            captured_utc=datetime.fromisoformat(row.captured_utc),
            picture=_file(self._pictures, row.picture_id),
            surface=None if surface_id is None else _file(self._pictures, surface_id),
            n_corrections=n_corrections.get(row.capture_id, 0),
            is_deleted=row.is_deleted,
        )

    def _recording(self, row: Row, codings: tuple[HeldFile, ...]) -> HeldRecording:
        return HeldRecording(
            recording_id=row.recording_id,
            created_utc=datetime.fromisoformat(row.created_utc),
            n_frames=row.n_frames,
            duration_ns=row.duration_ns,
            file=_file(self._recordings.sealed, row.recording_id),
            codings=codings,
            is_closed=row.is_closed,
        )

    def _backups(self, plan: "BackupPlan | None", held: Holdings) -> tuple[HeldBackup, ...] | None:
        """Return the planned backups from the time in which the patient was here."""
        from adibas.sessions.backup_schedule import backups_in

        file = read_key_file(self._database.folder)
        if plan is None or file is None:
            return ()
        try:
            kept = backups_in(plan.folder, file.store_id, self._audit.now_utc())
        except FileError:
            return None
        step = timedelta(days=plan.every_days)
        return tuple(
            HeldBackup(
                file=one.path.name,
                created_utc=one.created_utc,
                until=(kept[0].created_utc + max(1, plan.keep - place) * step).date(),
            )
            for place, one in enumerate(kept)
            if _was_here(held, one.created_utc)
        )


def _rows_of(transaction: Transaction, pseudonym: str) -> _Rows:
    sessions = select(SESSIONS.c.session_id).where(SESSIONS.c.pseudonym == pseudonym)
    captures = select(CAPTURES.c.capture_id).where(CAPTURES.c.session_id.in_(sessions))
    corrections = (
        select(CORRECTIONS.c.capture_id, func.count())
        .where(CORRECTIONS.c.capture_id.in_(captures))
        .group_by(CORRECTIONS.c.capture_id)
    )

    def all_of(chosen: Select[tuple[object, ...]]) -> Sequence[Row]:
        return transaction.execute(chosen).all()

    return _Rows(
        patient=found_patient(transaction, pseudonym),
        has_identity=row_of(transaction, IDENTITIES, pseudonym) is not None,
        consents=all_of(
            select(CONSENTS)
            .where(CONSENTS.c.pseudonym == pseudonym)
            .order_by(CONSENTS.c.consent_id)
        ),
        sessions=all_of(
            select(SESSIONS)
            .where(SESSIONS.c.pseudonym == pseudonym)
            .order_by(SESSIONS.c.started_utc)
        ),
        captures=all_of(
            select(CAPTURES)
            .where(CAPTURES.c.session_id.in_(sessions))
            .order_by(CAPTURES.c.session_id, CAPTURES.c.number)
        ),
        recordings=all_of(
            select(RECORDINGS)
            .where(RECORDINGS.c.session_id.in_(sessions))
            .order_by(RECORDINGS.c.created_utc)
        ),
        n_corrections={name: int(n) for name, n in transaction.execute(corrections)},
    )


def _gone(pseudonym: str, told: _Told) -> Holdings:
    """Return what is known of a patient who was removed for good."""
    lines = told.lines or ()
    purged = [one.time_utc for one in lines if one.action == "purge" and one.subject == pseudonym]
    return Holdings(
        pseudonym=pseudonym,
        since_utc=lines[0].time_utc,
        gone_utc=purged[-1] if purged else lines[-1].time_utc,
    )


def _left(told: _Told, since_utc: datetime) -> tuple[LeftStore, ...] | None:
    if told.lines is None:
        return None
    left = [
        LeftStore(
            time_utc=one.time_utc,
            operator=one.operator,
            kind=str(one.detail.get("kind", "")),
            subject=one.subject,
            receiver=str(one.detail.get("receiver", "")),
        )
        for one in told.exports
        if one.subject != WHOLE_STORE or one.time_utc >= since_utc
    ]
    return tuple(sorted(left, key=lambda one: one.time_utc))


def _since(made: tuple[datetime, ...] | None, held: Holdings) -> tuple[datetime, ...] | None:
    return None if made is None else tuple(one for one in made if _was_here(held, one))


def _was_here(held: Holdings, time_utc: datetime) -> bool:
    """Say whether the patient may have been in the store at a time."""
    return held.since_utc <= time_utc and (held.gone_utc is None or time_utc <= held.gone_utc)


def _consent(row: Row) -> HeldConsent:
    withdrawn = row.withdrawn_utc
    return HeldConsent(
        purposes=tuple(from_json(row.purposes)),
        is_guardian=row.is_guardian,
        given_utc=datetime.fromisoformat(row.given_utc),
        withdrawn_utc=None if withdrawn is None else datetime.fromisoformat(withdrawn),
    )


def _file(folder: SealedFolder, file_id: str) -> HeldFile:
    try:
        size_bytes = folder.size(file_id)
    except StoreError:
        size_bytes = None
    return HeldFile(f"{folder.folder.name}/{file_id}", size_bytes)
