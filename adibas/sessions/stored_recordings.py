"""The recordings of the sessions: sealed files whose keys and facts are in the database."""

import logging
import secrets
import uuid
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from sqlalchemy import delete, select

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import AdibasError, StoreError
from adibas.progress import Progress
from adibas.recordings.convert import ConversionSummary
from adibas.recordings.ports import RecordingOptions, RecordingReader, RecordingWriter
from adibas.sessions.audit import AuditLog
from adibas.sessions.consents import changing_with_consent, require_consent
from adibas.sessions.database import Database
from adibas.sessions.left_files import SECONDS_AT_REST, Left
from adibas.sessions.roles import Permission
from adibas.sessions.rows import Row, Transaction, add_row, change_row, row_of
from adibas.sessions.schema import RECORDINGS
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sealed_recordings import SealedRecordings, SealedRecordingWriter
from adibas.sessions.sealing import KEY_SIZE
from adibas.sessions.visits import session_in_sight

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RecordingFacts:
    """What is known of a recording without opening it.

    Attributes
    ----------
    duration_ns : int
        From the first frame to the last.
    size_bytes : int
        On the disk.
    sha256 : str
        Of the sealed file.
    notice : str
        What a crash took of it; empty where nothing is missing.
    """

    recording_id: str
    session_id: str
    created_utc: datetime
    n_frames: int
    n_dropped: int
    duration_ns: int
    size_bytes: int
    sha256: str
    notice: str


class StoredRecordingWriter(RecordingWriter):
    """A recording of the store in the making; it is listed when it is closed.

    Attributes
    ----------
    recording_id : str
        Its name in the store.
    """

    def __init__(self, sealed: SealedRecordingWriter, recordings: "Recordings") -> None:
        self.recording_id = sealed.recording_id
        self.path = sealed.path
        self.options = sealed.options
        self._sealed = sealed
        self._recordings = recordings
        self._is_open = True
        self._span_ns: tuple[int, int] | None = None

    @property
    def n_frames(self) -> int:  # type: ignore[override]
        """Frames written up to now."""
        return self._sealed.n_frames

    @property
    def n_dropped(self) -> int:
        """Frames that the sensor counted and that are not in the file, up to now."""
        return self._sealed.n_dropped

    @property
    def duration_ns(self) -> int:
        """From the first frame to the last."""
        return 0 if self._span_ns is None else self._span_ns[1] - self._span_ns[0]

    def write(self, frame: SensorFrame) -> None:
        """Append `frame`.

        Raises
        ------
        StoreError
            The disk is full; the frames until now are kept.
        RecordingError
            No recording can hold the frame's number or time.
        """
        self._sealed.write(frame)
        time_ns = frame.timestamp_ns
        first, last = self._span_ns or (time_ns, time_ns)
        self._span_ns = min(first, time_ns), max(last, time_ns)

    def count_dropped(self, n_frames: int) -> None:
        """Note frames that were lost without a gap in the sensor's count."""
        self._sealed.count_dropped(n_frames)

    def close(self) -> None:
        """Finish the recording and list it; a second call does nothing.

        Raises
        ------
        StoreError
            The disk is full; what was recorded is listed at the next opening of the store.
        """
        if self._is_open:
            self._sealed.close()
            self._recordings.register(self)
            self._is_open = False

    def abandon(self) -> None:
        """Remove everything that was written."""
        self._sealed.abandon()
        if self._is_open:
            self._recordings.forget(self.recording_id)
            self._is_open = False


class Recordings:
    """The recordings of a store.

    Attributes
    ----------
    sealed : SealedRecordings
        Their files.
    codings : SealedFiles
        What observers code of them, each file under the key of its recording.
    """

    def __init__(
        self, database: Database, audit: AuditLog, sealed: SealedRecordings, codings: SealedFiles
    ) -> None:
        self._database = database
        self._audit = audit
        self.sealed = sealed
        self.codings = codings
        self.in_the_making: set[str] = set()

    def create(
        self, session_id: str, info: SourceInfo, options: RecordingOptions | None = None
    ) -> StoredRecordingWriter:
        """Begin a recording of a session.

        Raises
        ------
        ConsentError
            No consent of the patient stands that a capture needs; nothing was begun.
        StoreError
            There is no such session, or it is hidden; the store is read-only, or the disk is full.
        """
        self._audit.require(Permission.TAKE_SESSIONS, session_id)
        recording_id, key = uuid.uuid4().hex, secrets.token_bytes(KEY_SIZE)
        with changing_with_consent(self._database, self._audit, session_id) as transaction:
            require_consent(transaction, session_in_sight(transaction, session_id).pseudonym)
            add_row(
                transaction,
                RECORDINGS,
                recording_id=recording_id,
                session_id=session_id,
                is_closed=False,
                key=key,
                created_utc=self._audit.now(),
                n_frames=0,
                n_dropped=0,
                duration_ns=0,
                size_bytes=0,
                sha256="",
                notice="",
            )
            self.in_the_making.add(recording_id)
        with ExitStack() as if_that_fails:
            if_that_fails.callback(self.forget, recording_id)
            sealed = self.sealed.create(recording_id, key, info, options or RecordingOptions())
            if_that_fails.pop_all()
        return StoredRecordingWriter(sealed, self)

    def open(self, recording_id: str) -> RecordingReader:
        """Open a recording.

        Raises
        ------
        StoreError
            There is no such recording, it is still being made, or its file is missing or damaged.
        RecordingError
            It cannot be read.
        """
        with self._database.reading() as transaction:
            row = _found(transaction, recording_id)
        self._audit.saw(row.session_id)
        return self.sealed.open(recording_id, row.key)

    @property
    def is_read_only(self) -> bool:
        """Whether another process or window may change the store, and this one may not."""
        return self._database.is_read_only

    @property
    def is_shared(self) -> bool:
        """Whether others may change the store at the same time."""
        return self._database.is_shared

    @contextmanager
    def one_at_a_time(self) -> Iterator[None]:
        """Let nobody who shares the store change anything meanwhile."""
        if not self.is_shared:
            yield
            return
        with self._database.changing():
            yield

    def key(self, recording_id: str) -> bytes:
        """Return the key of a recording, under which what belongs to it is sealed.

        Raises
        ------
        StoreError
            There is no such recording, or it is still being made.
        """
        with self._database.reading() as transaction:
            key: bytes = _found(transaction, recording_id).key
        return key

    def facts(self, recording_id: str) -> RecordingFacts:
        """Return what is known of a recording.

        Raises
        ------
        StoreError
            There is no such recording, or it is still being made.
        """
        with self._database.reading() as transaction:
            return _facts(_found(transaction, recording_id))

    def of_session(self, session_id: str) -> tuple[RecordingFacts, ...]:
        """Return the finished recordings of a session, oldest first."""
        theirs = (
            select(RECORDINGS)
            .where(RECORDINGS.c.session_id == session_id, RECORDINGS.c.is_closed)
            .order_by(RECORDINGS.c.created_utc)
        )
        with self._database.reading() as transaction:
            return tuple(_facts(row) for row in transaction.execute(theirs))

    def export(
        self,
        recording_id: str,
        path: Path,
        progress: Progress | None = None,
        *,
        depth_only: bool = False,
    ) -> ConversionSummary:
        """Write a recording without seal as `path`; as .mcap any Foxglove reader shows it.

        The log gets its line before anything is written.

        Parameters
        ----------
        depth_only : bool
            Leave colour and infrared out, in which a face is seen.

        Returns
        -------
        summary : ConversionSummary
            Of a file that was cut the frames that are whole are written; `notice` says so.

        Raises
        ------
        StoreError
            There is no such recording, or its file is missing or damaged.
        RecordingError
            A frame is damaged, or `path` cannot be written. Nothing is left there.
        """
        self._audit.require(Permission.EXPORT, recording_id)
        with self._database.logging() as transaction:
            row = _found(transaction, recording_id)
            told = {"pictures": "depth"} if depth_only else {}
            self._audit.write(
                transaction,
                "export",
                recording_id,
                kind="recording",
                session=row.session_id,
                **told,
            )
        return self.sealed.export(recording_id, row.key, path, progress, depth_only=depth_only)

    def register(self, writer: StoredRecordingWriter) -> None:
        """List a recording whose file is whole."""
        recording_id = writer.recording_id
        facts = {
            "n_frames": writer.n_frames,
            "n_dropped": writer.n_dropped,
            "duration_ns": writer.duration_ns,
            **self._on_disk(recording_id),
        }
        with self._database.changing() as transaction:
            session_id = _finish(transaction, recording_id, facts)
            self._audit.write(transaction, "create", recording_id, session=session_id)
        self.in_the_making.discard(recording_id)

    def forget(self, recording_id: str) -> None:
        """Take a recording without a file off the list; one that somebody recovered stays."""
        its_row = delete(RECORDINGS).where(RECORDINGS.c.recording_id == recording_id)
        with self._database.changing() as transaction:
            transaction.execute(its_row.where(RECORDINGS.c.is_closed.is_(False)))
        self.in_the_making.discard(recording_id)

    def recover(self, left: Left = set) -> None:
        """List what a crash left unfinished, with the frames that are whole.

        Parameters
        ----------
        left : callable
            Tells files that a crash left from those that somebody is writing.
        """
        with self._database.reading() as transaction:
            unfinished = select(RECORDINGS).where(RECORDINGS.c.is_closed.is_(False))
            rows = transaction.execute(unfinished).all()
        written = {row.recording_id: self.sealed.written(row.recording_id) for row in rows}
        are_left = left([path for path in written.values() if path is not None])
        for row in rows:
            path = written[row.recording_id]
            is_made = path not in are_left if path else self._is_beginning(row)
            if is_made:
                continue
            try:
                self._recover(row)
            except AdibasError as error:
                # The other recordings and the store are well; `verify` tells the user of this one.
                logger.warning("recording %s is not recovered: %s", row.recording_id, error)

    def _is_beginning(self, row: Row) -> bool:
        """Say whether another workstation may be about to write the first byte of a recording."""
        age = self._audit.now_utc() - datetime.fromisoformat(row.created_utc)
        return self.is_shared and age.total_seconds() < SECONDS_AT_REST

    def _recover(self, row: Row) -> None:
        recording_id = row.recording_id
        self.sealed.recover(recording_id, row.key)
        if recording_id not in self.sealed.ids():
            self.forget(recording_id)
            return
        with self.sealed.open(recording_id, row.key) as reader:
            times_ns = reader.timestamps_ns
            facts = {
                "n_frames": len(times_ns),
                "n_dropped": reader.info.n_dropped,
                "duration_ns": int(times_ns.max() - times_ns.min()) if len(times_ns) else 0,
                "notice": reader.notice or "",
            }
        facts |= self._on_disk(recording_id)
        with self._database.changing() as transaction:
            session_id = _finish(transaction, recording_id, facts)
            self._audit.write(
                transaction, "recover", recording_id, session=session_id, frames=len(times_ns)
            )

    def _on_disk(self, recording_id: str) -> dict[str, object]:
        return {
            "sha256": self.sealed.sha256(recording_id),
            "size_bytes": self.sealed.size(recording_id),
        }


def _finish(transaction: Transaction, recording_id: str, facts: Mapping[str, object]) -> str:
    """List a recording with what is known of it; return its session."""
    change_row(transaction, RECORDINGS, recording_id, is_closed=True, **facts)
    whose = select(RECORDINGS.c.session_id).where(RECORDINGS.c.recording_id == recording_id)
    return str(transaction.scalars(whose).one())


def _found(transaction: Transaction, recording_id: str) -> Row:
    row = row_of(transaction, RECORDINGS, recording_id)
    if row is None:
        raise StoreError(
            "There is no recording {recording_id} in this store; perhaps it was purged. Choose "
            "another one.",
            recording_id=recording_id,
        )
    if not row.is_closed:
        raise StoreError(
            "The recording {recording_id} is not finished. Stop it; after a crash, close the store "
            "and open it again.",
            recording_id=recording_id,
        )
    return row


def _facts(row: Row) -> RecordingFacts:
    return RecordingFacts(
        recording_id=row.recording_id,
        session_id=row.session_id,
        created_utc=datetime.fromisoformat(row.created_utc),
        n_frames=row.n_frames,
        n_dropped=row.n_dropped,
        duration_ns=row.duration_ns,
        size_bytes=row.size_bytes,
        sha256=row.sha256,
        notice=row.notice,
    )
