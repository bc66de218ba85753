"""The tables of the store. Identity stands in two tables of its own, apart from all measurements.

Times are ISO 8601 texts in UTC, documents are JSON texts. A change here needs a new revision under
`migrations/versions`. In a file the whole database is encrypted; on a server the contents
(`_content`, `_bytes`) are sealed one by one, and what puts rows in order (ids, pseudonyms, times,
numbers, who did what) is not.
"""

from typing import Any

from sqlalchemy import (
    TEXT,
    BigInteger,
    Boolean,
    Column,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
)
from sqlalchemy.types import TypeEngine

from adibas.sessions.sealed_columns import SealedBytes, SealedText

NAMING = {
    "fk": "fk_%(table_name)s_%(column_0_name)s",
    "ix": "ix_%(table_name)s_%(column_0_name)s",
    "pk": "pk_%(table_name)s",
    "uq": "uq_%(table_name)s_%(column_0_name)s",
}
METADATA = MetaData(naming_convention=NAMING)


ORDERED = String().with_variant(TEXT(collation="C"), "postgresql")
"""Texts that are sorted and compared letter by letter, whatever language a server speaks."""
WHOLE = Integer().with_variant(BigInteger(), "postgresql")
"""Nanoseconds and bytes: more than 32 bits."""


def _text(name: str, **more: Any) -> "Column[str]":
    return Column(name, ORDERED, nullable=False, **more)


def _text_or_none(name: str, *more: Any) -> "Column[str | None]":
    return Column(name, ORDERED, *more, nullable=True)


def _content(name: str) -> "Column[str]":
    return Column(name, SealedText(name), nullable=False)


def _whole(name: str, **more: Any) -> "Column[int]":
    return Column(name, WHOLE, nullable=False, **more)


def _flag(name: str) -> "Column[bool]":
    return Column(name, Boolean, nullable=False)


def _bytes(name: str) -> "Column[bytes]":
    return Column(name, SealedBytes(name), nullable=False)


def _of(target: str, kind: TypeEngine[Any] = ORDERED, **more: Any) -> "Column[Any]":
    """Refer to the row that this one belongs to, and goes with."""
    name = target.rpartition(".")[2]
    return Column(name, kind, ForeignKey(target, ondelete="CASCADE"), nullable=False, **more)


PATIENTS = Table(
    "patients",
    METADATA,
    _text("pseudonym", primary_key=True),
    _content("sex"),
    _content("notes"),
    _text("created_utc"),
    _flag("is_deleted"),
)
"""Patients without identity."""

IDENTITIES = Table(
    "identities",
    METADATA,
    _of("patients.pseudonym", primary_key=True),
    _content("name"),
    Column("birth_date", SealedText("birth_date"), nullable=True),
    _content("record_number"),
    _content("search_text"),
    Column("sort_name", SealedText("sort_name"), nullable=False, index=True),
)
"""Who a patient is; `search_text` and `sort_name` are in small letters without accents."""

CONSENTS = Table(
    "consents",
    METADATA,
    _whole("consent_id", primary_key=True, autoincrement=True),
    _of("patients.pseudonym", index=True),
    _content("purposes"),
    _flag("is_guardian"),
    _text("given_utc"),
    _text_or_none("withdrawn_utc"),
)
"""That somebody agreed, without who."""

SIGNERS = Table(
    "signers",
    METADATA,
    _of("consents.consent_id", WHOLE, primary_key=True),
    _content("name"),
)
"""Who signed a consent."""

SESSIONS = Table(
    "sessions",
    METADATA,
    _text("session_id", primary_key=True),
    _of("patients.pseudonym"),
    _text("started_utc", index=True),
    _text("operator"),
    _content("setup"),
    _content("notes"),
    _flag("is_deleted"),
    Index("ix_sessions_pseudonym", "pseudonym", "started_utc"),
)
"""One visit a row."""

RECORDINGS = Table(
    "recordings",
    METADATA,
    _text("recording_id", primary_key=True),
    _of("sessions.session_id", index=True),
    _flag("is_closed"),
    _bytes("key"),
    _text("created_utc"),
    _whole("n_frames"),
    _whole("n_dropped"),
    _whole("duration_ns"),
    _whole("size_bytes"),
    _text("sha256"),
    _content("notice"),
)
"""Sealed recordings and their keys, which are here before the first frame is written.

`is_closed` is False while one is being made; a crash leaves it so.
"""

FILES = Table(
    "files",
    METADATA,
    _text("file_id", primary_key=True),
    _bytes("key"),
    _text_or_none("sha256"),
)
"""Sealed pictures and surfaces and their keys, which are here before the file is written.

`sha256` is None until a capture uses the file.
"""

LEFTOVERS = Table("leftovers", METADATA, _text("file_id", primary_key=True), _text("folder"))
"""Purged files that are still to be removed from the disk; their keys are gone already."""

CAPTURES = Table(
    "captures",
    METADATA,
    _text("capture_id", primary_key=True),
    _of("sessions.session_id"),
    _whole("number"),
    _text("view"),
    _text("captured_utc"),
    _text_or_none("recording_id", ForeignKey("recordings.recording_id", ondelete="SET NULL")),
    _whole("first_frame"),
    _whole("n_frames"),
    _content("calibration"),
    _content("detected"),
    _content("rejected"),
    _content("provenance"),
    _content("notices"),
    _whole("n_done"),
    Column("picture_id", ORDERED, ForeignKey("files.file_id"), nullable=False),
    _text_or_none("surface_id", ForeignKey("files.file_id")),
    _bytes("thumbnail"),
    _flag("is_deleted"),
    Index("ix_captures_session_id", "session_id", "number"),
)
"""One burst a row; `number` counts within the session."""

CORRECTIONS = Table(
    "corrections",
    METADATA,
    _whole("correction_id", primary_key=True, autoincrement=True),
    _of("captures.capture_id", index=True),
    Column("position", WHOLE, nullable=True),
    _content("content"),
    _text("made_utc"),
    _text("operator"),
)
"""One correction a row; `position` in the undo stack, None once another one took its place."""

AUDIT = Table(
    "audit",
    METADATA,
    _whole("sequence", primary_key=True, autoincrement=False),
    _text("time_utc"),
    _text("operator"),
    _text("action"),
    _text("subject"),
    _text("detail"),
    _text("previous_hash"),
    _text("hash"),
)
"""The audit log; the database refuses to change or delete a line."""

AUDIT_HEAD = Table(
    "audit_head",
    METADATA,
    _whole("only", primary_key=True, autoincrement=False),
    _whole("sequence"),
    _text("hash"),
)
"""The last line's number and hash, so that lines missing at the end are noticed."""
