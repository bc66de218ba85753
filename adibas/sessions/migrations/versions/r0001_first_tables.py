"""The first tables: patients, identities, consents, sessions, recordings, captures, audit."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None

AUDIT_TRIGGERS = """
CREATE TRIGGER audit_{verb} BEFORE {verb} ON audit
BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END
"""


def upgrade() -> None:
    """Make the tables of an empty database."""
    for make in (_patients, _consents, _sessions, _recordings, _captures, _corrections, _audit):
        make()


def _text(name: str) -> "sa.Column[str]":
    return sa.Column(name, sa.String(), nullable=False)


def _whole(name: str) -> "sa.Column[int]":
    return sa.Column(name, sa.Integer(), nullable=False)


def _flag(name: str) -> "sa.Column[bool]":
    return sa.Column(name, sa.Boolean(), nullable=False)


def _bytes(name: str) -> "sa.Column[bytes]":
    return sa.Column(name, sa.LargeBinary(), nullable=False)


def _reference(column: str, target: str, table: str) -> sa.ForeignKeyConstraint:
    """Rows of `table` go with the row that they belong to."""
    name = f"fk_{table}_{column}"
    return sa.ForeignKeyConstraint([column], [target], name=name, ondelete="CASCADE")


def _plain_reference(column: str, target: str) -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint([column], [target], name=f"fk_captures_{column}")


def _patients() -> None:
    op.create_table(
        "patients",
        _text("pseudonym"),
        _text("sex"),
        _text("notes"),
        _text("created_utc"),
        _flag("is_deleted"),
        sa.PrimaryKeyConstraint("pseudonym", name="pk_patients"),
    )
    op.create_table(
        "identities",
        _text("pseudonym"),
        _text("name"),
        sa.Column("birth_date", sa.String(), nullable=True),
        _text("record_number"),
        _text("search_text"),
        _text("sort_name"),
        _reference("pseudonym", "patients.pseudonym", "identities"),
        sa.PrimaryKeyConstraint("pseudonym", name="pk_identities"),
    )
    op.create_index("ix_identities_sort_name", "identities", ["sort_name"])


def _consents() -> None:
    op.create_table(
        "consents",
        _whole("consent_id"),
        _text("pseudonym"),
        _text("purposes"),
        _flag("is_guardian"),
        _text("given_utc"),
        sa.Column("withdrawn_utc", sa.String(), nullable=True),
        _reference("pseudonym", "patients.pseudonym", "consents"),
        sa.PrimaryKeyConstraint("consent_id", name="pk_consents"),
    )
    op.create_index("ix_consents_pseudonym", "consents", ["pseudonym"])
    op.create_table(
        "signers",
        _whole("consent_id"),
        _text("name"),
        _reference("consent_id", "consents.consent_id", "signers"),
        sa.PrimaryKeyConstraint("consent_id", name="pk_signers"),
    )


def _sessions() -> None:
    op.create_table(
        "sessions",
        *(_text(name) for name in ("session_id", "pseudonym", "started_utc", "operator")),
        _text("setup"),
        _text("notes"),
        _flag("is_deleted"),
        _reference("pseudonym", "patients.pseudonym", "sessions"),
        sa.PrimaryKeyConstraint("session_id", name="pk_sessions"),
    )
    op.create_index("ix_sessions_pseudonym", "sessions", ["pseudonym", "started_utc"])
    op.create_index("ix_sessions_started_utc", "sessions", ["started_utc"])


def _recordings() -> None:
    op.create_table(
        "recordings",
        _text("recording_id"),
        _text("session_id"),
        _flag("is_closed"),
        _bytes("key"),
        _text("created_utc"),
        *(_whole(name) for name in ("n_frames", "n_dropped", "duration_ns", "size_bytes")),
        _text("sha256"),
        _text("notice"),
        _reference("session_id", "sessions.session_id", "recordings"),
        sa.PrimaryKeyConstraint("recording_id", name="pk_recordings"),
    )
    op.create_index("ix_recordings_session_id", "recordings", ["session_id"])
    op.create_table(
        "files",
        _text("file_id"),
        _bytes("key"),
        sa.Column("sha256", sa.String(), nullable=True),
        sa.PrimaryKeyConstraint("file_id", name="pk_files"),
    )
    op.create_table(
        "leftovers",
        _text("file_id"),
        _text("folder"),
        sa.PrimaryKeyConstraint("file_id", name="pk_leftovers"),
    )


def _captures() -> None:
    documents = ("calibration", "detected", "rejected", "provenance", "notices")
    op.create_table(
        "captures",
        _text("capture_id"),
        _text("session_id"),
        _whole("number"),
        _text("view"),
        _text("captured_utc"),
        sa.Column("recording_id", sa.String(), nullable=True),
        _whole("first_frame"),
        _whole("n_frames"),
        *(_text(name) for name in documents),
        _whole("n_done"),
        _text("picture_id"),
        sa.Column("surface_id", sa.String(), nullable=True),
        _bytes("thumbnail"),
        _flag("is_deleted"),
        _reference("session_id", "sessions.session_id", "captures"),
        sa.ForeignKeyConstraint(
            ["recording_id"],
            ["recordings.recording_id"],
            name="fk_captures_recording_id",
            ondelete="SET NULL",
        ),
        _plain_reference("picture_id", "files.file_id"),
        _plain_reference("surface_id", "files.file_id"),
        sa.PrimaryKeyConstraint("capture_id", name="pk_captures"),
    )
    op.create_index("ix_captures_session_id", "captures", ["session_id", "number"])


def _corrections() -> None:
    op.create_table(
        "corrections",
        _whole("correction_id"),
        _text("capture_id"),
        sa.Column("position", sa.Integer(), nullable=True),
        _text("content"),
        _text("made_utc"),
        _text("operator"),
        _reference("capture_id", "captures.capture_id", "corrections"),
        sa.PrimaryKeyConstraint("correction_id", name="pk_corrections"),
    )
    op.create_index("ix_corrections_capture_id", "corrections", ["capture_id"])


def _audit() -> None:
    texts = ("time_utc", "operator", "action", "subject", "detail", "previous_hash", "hash")
    op.create_table(
        "audit",
        sa.Column("sequence", sa.Integer(), nullable=False, autoincrement=False),
        *(_text(name) for name in texts),
        sa.PrimaryKeyConstraint("sequence", name="pk_audit"),
    )
    op.create_table(
        "audit_head",
        sa.Column("only", sa.Integer(), nullable=False, autoincrement=False),
        _whole("sequence"),
        _text("hash"),
        sa.PrimaryKeyConstraint("only", name="pk_audit_head"),
    )
    for verb in ("UPDATE", "DELETE"):
        op.execute(AUDIT_TRIGGERS.format(verb=verb))
