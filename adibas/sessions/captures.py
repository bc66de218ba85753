"""The captures of a session, their pictures, and the corrections of their markers."""

import uuid
from collections.abc import Collection
from dataclasses import dataclass, field
from datetime import datetime

from sqlalchemy import func, select

from adibas.arrays import UInt8Array
from adibas.clock import to_text
from adibas.data.calibration import RgbdCalibration
from adibas.data.corrections import CorrectionHistory
from adibas.data.markers import Marker, RejectedBlob
from adibas.data.posture import Provenance
from adibas.data.sessions import Capture
from adibas.data.surface import BurstDisparity
from adibas.errors import StoreError
from adibas.sessions.audit import AuditLog
from adibas.sessions.conflicts import Decision
from adibas.sessions.consents import changing_with_consent, require_consent
from adibas.sessions.correcting import (
    CorrectedCapture,
    HistoryChange,
    bring_together,
    corrected_captures,
    history_of,
    save_history,
)
from adibas.sessions.database import Database
from adibas.sessions.documents import (
    calibration_line,
    calibration_of_line,
    markers_from_json,
    markers_to_json,
    provenance_from_json,
    provenance_to_json,
    rejected_from_json,
    rejected_to_json,
)
from adibas.sessions.images import (
    decode_picture,
    decode_surface,
    encode_picture,
    encode_surface,
    encode_thumbnail,
)
from adibas.sessions.json_line import from_json, to_json
from adibas.sessions.kept_files import KeptFiles
from adibas.sessions.roles import Permission
from adibas.sessions.rows import Row, Transaction, add_row, change_row, row_of
from adibas.sessions.schema import CAPTURES, RECORDINGS
from adibas.sessions.visits import session_in_sight


@dataclass(frozen=True, slots=True, eq=False)
class NewCapture:
    """A capture before it is saved; the fields are those of `Capture`.

    Attributes
    ----------
    recording_id : str
        Of this store; empty where nothing was recorded.
    captured_utc : datetime or None
        None = now.
    """

    view: str
    recording_id: str
    first_frame: int
    n_frames: int
    calibration: RgbdCalibration
    detected: tuple[Marker, ...]
    rejected: tuple[RejectedBlob, ...]
    provenance: Provenance
    captured_utc: datetime | None = None
    history: CorrectionHistory = field(default_factory=CorrectionHistory)
    notices: tuple[str, ...] = ()


class Captures:
    """The captures of a store."""

    def __init__(self, database: Database, audit: AuditLog, files: KeptFiles) -> None:
        self._database = database
        self._audit = audit
        self._files = files

    def add(
        self,
        session_id: str,
        new: NewCapture,
        picture_rgb: UInt8Array,
        surface: BurstDisparity | None = None,
    ) -> Capture:
        """Save a capture with its (H, W, 3) picture; when this returns it is on the disk.

        Raises
        ------
        ConsentError
            No consent of the patient stands that a capture needs; nothing was saved.
        StoreError
            There is no such session, or it is hidden; the store is read-only, or the disk is full.
        """
        self._audit.require(Permission.TAKE_SESSIONS, session_id)
        new.history.markers(new.detected)
        asking = changing_with_consent(self._database, self._audit, session_id)
        with asking as transaction:  # before files are written
            require_consent(transaction, session_in_sight(transaction, session_id).pseudonym)
            _check_recording(transaction, session_id, new.recording_id)
        payloads = [encode_picture(picture_rgb)]
        if surface is not None:
            payloads.append(encode_surface(surface))
        thumbnail = encode_thumbnail(picture_rgb)
        saving = changing_with_consent(self._database, self._audit, session_id)
        with self._files.written(payloads) as files, saving as transaction:
            require_consent(transaction, session_in_sight(transaction, session_id).pseudonym)
            self._files.keep(transaction, files)
            capture_id, at = uuid.uuid4().hex, new.captured_utc
            add_row(
                transaction,
                CAPTURES,
                capture_id=capture_id,
                session_id=session_id,
                number=_next_number(transaction, session_id),
                picture_id=files[0],
                surface_id=files[1] if surface is not None else None,
                thumbnail=thumbnail,
                captured_utc=self._audit.now() if at is None else to_text(at),
                **_columns_of(new),
            )
            self._audit.write(transaction, "create", capture_id, session=session_id)
            row = found_capture(transaction, capture_id)
            save_history(transaction, self._audit, row, new.history)
            return _capture(transaction, found_capture(transaction, capture_id))

    def get(self, capture_id: str) -> Capture:
        """Return a capture, a hidden one too.

        Raises
        ------
        StoreError
            There is no such capture.
        """
        with self._database.reading() as transaction:
            capture = _capture(transaction, found_capture(transaction, capture_id))
        self._audit.saw(capture.session_id)
        return capture

    def of_session(self, session_id: str, *, with_deleted: bool = False) -> tuple[Capture, ...]:
        """Return the captures of a session in the order in which they were taken."""
        theirs = select(CAPTURES).where(CAPTURES.c.session_id == session_id)
        if not with_deleted:
            theirs = theirs.where(CAPTURES.c.is_deleted.is_(False))
        with self._database.reading() as transaction:
            found = transaction.execute(theirs.order_by(CAPTURES.c.number)).all()
            captures = tuple(_capture(transaction, row) for row in found)
        if captures:
            self._audit.saw(session_id)
        return captures

    def latest(self, session_id: str) -> dict[str, Capture]:
        """Return the last capture of each view of a session, by the view."""
        return {one.view: one for one in self.of_session(session_id)}

    def corrected(self) -> tuple[CorrectedCapture, ...]:
        """Return which captures had a marker corrected, oldest first; none of them is looked at."""
        with self._database.reading() as transaction:
            return corrected_captures(transaction)

    def correct(
        self,
        capture_id: str,
        history: CorrectionHistory,
        *,
        seen: CorrectionHistory | None = None,
        decisions: Collection[Decision] = (),
    ) -> Capture:
        """Save the history of corrections as it is now; the log gets a line for each change.

        Parameters
        ----------
        seen : CorrectionHistory, optional
            From which `history` was made: what others corrected since then stays below it. Without
            it the present one is meant, and replaced.
        decisions : collection of Decision
            On the conflicts of an attempt before.

        Raises
        ------
        ConflictError
            Somebody else corrected the same marker since `seen`; nothing was saved.
        ValueError
            The history does not fit the markers.
        StoreError
            There is no such capture, the store is read-only, or the disk is full.
        """
        self._audit.require(Permission.TAKE_SESSIONS, capture_id)
        with self._database.changing() as transaction:
            row = found_capture(transaction, capture_id)
            detected = markers_from_json(row.detected)
            history.markers(detected)
            if seen is None:
                save_history(transaction, self._audit, row, history)
            else:
                change = HistoryChange(detected, seen, history)
                bring_together(transaction, self._audit, row, change, decisions)
            return _capture(transaction, found_capture(transaction, capture_id))

    def delete(self, capture_id: str) -> None:
        """Hide a capture, until `restore` or a purge of its session.

        Raises
        ------
        StoreError
            There is no such capture, the store is read-only, or the disk is full.
        """
        self._hide(capture_id, is_deleted=True)

    def restore(self, capture_id: str) -> None:
        """Show a hidden capture again.

        Raises
        ------
        StoreError
            There is no such capture, the store is read-only, or the disk is full.
        """
        self._hide(capture_id, is_deleted=False)

    def picture(self, capture_id: str) -> UInt8Array:
        """Return the (H, W, 3) RGB picture.

        Raises
        ------
        StoreError
            There is no such capture, or its picture is missing or damaged.
        """
        with self._database.reading() as transaction:
            picture_id = found_capture(transaction, capture_id).picture_id
        return decode_picture(self._files.read(picture_id))

    def thumbnail(self, capture_id: str) -> UInt8Array:
        """Return the (h, w, 3) RGB picture with a longer side of 160 pixels at most.

        Raises
        ------
        StoreError
            There is no such capture.
        """
        with self._database.reading() as transaction:
            return decode_picture(found_capture(transaction, capture_id).thumbnail)

    def surface(self, capture_id: str) -> BurstDisparity | None:
        """Return the depth of the burst; None where it was not kept.

        Raises
        ------
        StoreError
            There is no such capture, or the file is missing or damaged.
        """
        with self._database.reading() as transaction:
            surface_id = found_capture(transaction, capture_id).surface_id
        return None if surface_id is None else decode_surface(self._files.read(surface_id))

    def _hide(self, capture_id: str, *, is_deleted: bool) -> None:
        self._audit.require(Permission.TAKE_SESSIONS, capture_id)
        with self._database.changing() as transaction:
            if found_capture(transaction, capture_id).is_deleted != is_deleted:
                change_row(transaction, CAPTURES, capture_id, is_deleted=is_deleted)
                self._audit.write(transaction, "delete" if is_deleted else "restore", capture_id)


def found_capture(transaction: Transaction, capture_id: str) -> Row:
    """Return the row, or raise StoreError."""
    row = row_of(transaction, CAPTURES, capture_id)
    if row is None:
        raise StoreError(
            "There is no capture {capture_id} in this store; perhaps it was purged. Choose another "
            "one.",
            capture_id=capture_id,
        )
    return row


def _check_recording(transaction: Transaction, session_id: str, recording_id: str) -> None:
    row = row_of(transaction, RECORDINGS, recording_id) if recording_id else None
    if recording_id and (row is None or row.session_id != session_id):
        raise ValueError(f"no recording {recording_id} of session {session_id}")


def _next_number(transaction: Transaction, session_id: str) -> int:
    last = select(func.max(CAPTURES.c.number)).where(CAPTURES.c.session_id == session_id)
    return (transaction.scalar(last) or 0) + 1


def _columns_of(new: NewCapture) -> dict[str, object]:
    """Return what a new capture brings along itself."""
    return {
        "view": new.view,
        "recording_id": new.recording_id or None,
        "first_frame": new.first_frame,
        "n_frames": new.n_frames,
        "calibration": calibration_line(new.calibration),
        "detected": markers_to_json(new.detected),
        "rejected": rejected_to_json(new.rejected),
        "provenance": provenance_to_json(new.provenance),
        "notices": to_json(list(new.notices)),
        "n_done": 0,
        "is_deleted": False,
    }


def _capture(transaction: Transaction, row: Row) -> Capture:
    return Capture(
        capture_id=row.capture_id,
        session_id=row.session_id,
        view=row.view,
        captured_utc=datetime.fromisoformat(row.captured_utc),
        recording_id=row.recording_id or "",
        first_frame=row.first_frame,
        n_frames=row.n_frames,
        calibration=calibration_of_line(row.calibration),
        detected=markers_from_json(row.detected),
        rejected=rejected_from_json(row.rejected),
        provenance=provenance_from_json(row.provenance),
        history=history_of(transaction, row),
        notices=tuple(from_json(row.notices)),
        is_deleted=row.is_deleted,
    )
