"""The tables of the store. Identity stands in two tables of its own, apart from all measurements.

A change here needs a new revision under `migrations/versions`.
"""

from sqlalchemy import ForeignKey, Index, LargeBinary, MetaData
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

NAMING = {
    "fk": "fk_%(table_name)s_%(column_0_name)s",
    "ix": "ix_%(table_name)s_%(column_0_name)s",
    "pk": "pk_%(table_name)s",
    "uq": "uq_%(table_name)s_%(column_0_name)s",
}


class Record(DeclarativeBase):
    """Base of all tables; times are ISO 8601 texts in UTC, documents are JSON texts."""

    metadata = MetaData(naming_convention=NAMING)


class PatientRecord(Record):
    """A patient without identity."""

    __tablename__ = "patients"

    pseudonym: Mapped[str] = mapped_column(primary_key=True)
    sex: Mapped[str]
    notes: Mapped[str]
    created_utc: Mapped[str]
    is_deleted: Mapped[bool]


class IdentityRecord(Record):
    """Who a patient is; `search_text` and `sort_name` are in small letters without accents."""

    __tablename__ = "identities"

    pseudonym: Mapped[str] = mapped_column(
        ForeignKey("patients.pseudonym", ondelete="CASCADE"), primary_key=True
    )
    name: Mapped[str]
    birth_date: Mapped[str | None]
    record_number: Mapped[str]
    search_text: Mapped[str]
    sort_name: Mapped[str] = mapped_column(index=True)


class ConsentRecord(Record):
    """That somebody agreed, without who."""

    __tablename__ = "consents"

    consent_id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    pseudonym: Mapped[str] = mapped_column(
        ForeignKey("patients.pseudonym", ondelete="CASCADE"), index=True
    )
    purposes: Mapped[str]
    is_guardian: Mapped[bool]
    given_utc: Mapped[str]
    withdrawn_utc: Mapped[str | None]


class SignerRecord(Record):
    """Who signed a consent."""

    __tablename__ = "signers"

    consent_id: Mapped[int] = mapped_column(
        ForeignKey("consents.consent_id", ondelete="CASCADE"), primary_key=True
    )
    name: Mapped[str]


class SessionRecord(Record):
    """One visit."""

    __tablename__ = "sessions"

    session_id: Mapped[str] = mapped_column(primary_key=True)
    pseudonym: Mapped[str] = mapped_column(ForeignKey("patients.pseudonym", ondelete="CASCADE"))
    started_utc: Mapped[str] = mapped_column(index=True)
    operator: Mapped[str]
    setup: Mapped[str]
    notes: Mapped[str]
    is_deleted: Mapped[bool]

    __table_args__ = (Index("ix_sessions_pseudonym", "pseudonym", "started_utc"),)


class RecordingRecord(Record):
    """A sealed recording and its key, which is here before the first frame is written.

    `is_closed` is False while it is being made; a crash leaves it so.
    """

    __tablename__ = "recordings"

    recording_id: Mapped[str] = mapped_column(primary_key=True)
    session_id: Mapped[str] = mapped_column(
        ForeignKey("sessions.session_id", ondelete="CASCADE"), index=True
    )
    is_closed: Mapped[bool]
    key: Mapped[bytes] = mapped_column(LargeBinary)
    created_utc: Mapped[str]
    n_frames: Mapped[int]
    n_dropped: Mapped[int]
    duration_ns: Mapped[int]
    size_bytes: Mapped[int]
    sha256: Mapped[str]
    notice: Mapped[str]


class FileRecord(Record):
    """A sealed picture or surface and its key, which is here before the file is written.

    `sha256` is None until a capture uses the file.
    """

    __tablename__ = "files"

    file_id: Mapped[str] = mapped_column(primary_key=True)
    key: Mapped[bytes] = mapped_column(LargeBinary)
    sha256: Mapped[str | None]


class LeftoverRecord(Record):
    """A purged file that is still to be removed from the disk; its key is gone already."""

    __tablename__ = "leftovers"

    file_id: Mapped[str] = mapped_column(primary_key=True)
    folder: Mapped[str]


class CaptureRecord(Record):
    """One burst; `number` counts within the session."""

    __tablename__ = "captures"

    capture_id: Mapped[str] = mapped_column(primary_key=True)
    session_id: Mapped[str] = mapped_column(ForeignKey("sessions.session_id", ondelete="CASCADE"))
    number: Mapped[int]
    view: Mapped[str]
    captured_utc: Mapped[str]
    recording_id: Mapped[str | None] = mapped_column(
        ForeignKey("recordings.recording_id", ondelete="SET NULL")
    )
    first_frame: Mapped[int]
    n_frames: Mapped[int]
    calibration: Mapped[str]
    detected: Mapped[str]
    rejected: Mapped[str]
    provenance: Mapped[str]
    notices: Mapped[str]
    n_done: Mapped[int]
    picture_id: Mapped[str] = mapped_column(ForeignKey("files.file_id"))
    surface_id: Mapped[str | None] = mapped_column(ForeignKey("files.file_id"))
    thumbnail: Mapped[bytes] = mapped_column(LargeBinary)
    is_deleted: Mapped[bool]

    __table_args__ = (Index("ix_captures_session_id", "session_id", "number"),)


class CorrectionRecord(Record):
    """One correction; `position` in the undo stack, None once another one took its place."""

    __tablename__ = "corrections"

    correction_id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    capture_id: Mapped[str] = mapped_column(
        ForeignKey("captures.capture_id", ondelete="CASCADE"), index=True
    )
    position: Mapped[int | None]
    content: Mapped[str]
    made_utc: Mapped[str]
    operator: Mapped[str]


class AuditRecord(Record):
    """One line of the audit log; the database refuses to change or delete one."""

    __tablename__ = "audit"

    sequence: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    time_utc: Mapped[str]
    operator: Mapped[str]
    action: Mapped[str]
    subject: Mapped[str]
    detail: Mapped[str]
    previous_hash: Mapped[str]
    hash: Mapped[str]


class AuditHead(Record):
    """The last line's number and hash, so that lines missing at the end are noticed."""

    __tablename__ = "audit_head"

    only: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    sequence: Mapped[int]
    hash: Mapped[str]
