"""Everything that is held of one patient, and what left the store: what a withdrawal must find."""

from dataclasses import dataclass
from datetime import date, datetime


@dataclass(frozen=True, slots=True)
class HeldFile:
    """A sealed file.

    Attributes
    ----------
    name : str
        Its folder within the store, and its id.
    size_bytes : int or None
        None where it is missing.
    """

    name: str
    size_bytes: int | None


@dataclass(frozen=True, slots=True)
class HeldConsent:
    """A consent, without who signed it."""

    purposes: tuple[str, ...]
    is_guardian: bool
    given_utc: datetime
    withdrawn_utc: datetime | None


@dataclass(frozen=True, slots=True)
class HeldCapture:
    """A capture with its files.

    Attributes
    ----------
    n_corrections : int
        Of its markers, also those that were undone or replaced: names may be learned from them.
    """

    capture_id: str
    view: str
    captured_utc: datetime
    picture: HeldFile
    surface: HeldFile | None
    n_corrections: int
    is_deleted: bool


@dataclass(frozen=True, slots=True)
class HeldRecording:
    """A recording, and what observers coded of it.

    Attributes
    ----------
    is_closed : bool
        False while it is being made, or where a crash left it.
    """

    recording_id: str
    created_utc: datetime
    n_frames: int
    duration_ns: int
    file: HeldFile
    codings: tuple[HeldFile, ...]
    is_closed: bool


@dataclass(frozen=True, slots=True)
class HeldSession:
    """A session, a hidden one too."""

    session_id: str
    started_utc: datetime
    operator: str
    has_notes: bool
    captures: tuple[HeldCapture, ...]
    recordings: tuple[HeldRecording, ...]
    is_deleted: bool


@dataclass(frozen=True, slots=True)
class LeftStore:
    """Something that left the store, as the audit log says.

    Attributes
    ----------
    kind : str
        Of what, such as ``report``.
    subject : str
        The patient, session, capture or recording; ``store`` for what tells of all patients.
    receiver : str
        Who got it, where the log tells.
    """

    time_utc: datetime
    operator: str
    kind: str
    subject: str
    receiver: str


@dataclass(frozen=True, slots=True)
class HeldBackup:
    """A backup that may hold the patient.

    Attributes
    ----------
    until : date or None
        The earliest day on which newer ones take its place; None where no plan says so.
    """

    file: str
    created_utc: datetime
    until: date | None


@dataclass(frozen=True, slots=True)
class Holdings:
    """What is held of a patient, and what is known of what was.

    Attributes
    ----------
    since_utc : datetime
        When the patient was added.
    gone_utc : datetime or None
        When the patient was removed for good: the log and backups are all that is left then.
    is_deleted : bool
        Hidden.
    has_identity, has_notes : bool
        Whether a name, and notes, are kept.
    sessions : tuple of HeldSession
        Oldest first.
    left : tuple of LeftStore or None
        Oldest first; None where whoever asks may not read the audit log.
    n_log_lines : int or None
        Lines on the patient, which stay after a removal; None as above.
    backups : tuple of HeldBackup or None
        In the folder of planned backups, newest first; None where it cannot be read.
    backups_made : tuple of datetime or None
        When any backup was made since the patient was added, oldest first; None as of `left`.
    copies : tuple of str
        Copies of the database that were kept before migrations or a move.
    """

    pseudonym: str
    since_utc: datetime
    gone_utc: datetime | None
    is_deleted: bool = False
    has_identity: bool = False
    has_notes: bool = False
    consents: tuple[HeldConsent, ...] = ()
    sessions: tuple[HeldSession, ...] = ()
    left: tuple[LeftStore, ...] | None = None
    n_log_lines: int | None = None
    backups: tuple[HeldBackup, ...] | None = ()
    backups_made: tuple[datetime, ...] | None = None
    copies: tuple[str, ...] = ()

    @property
    def captures(self) -> tuple[HeldCapture, ...]:
        """All captures, hidden ones too."""
        return tuple(one for session in self.sessions for one in session.captures)

    @property
    def recordings(self) -> tuple[HeldRecording, ...]:
        """All recordings."""
        return tuple(one for session in self.sessions for one in session.recordings)

    @property
    def files(self) -> tuple[HeldFile, ...]:
        """All sealed files."""
        of_captures = (file for one in self.captures for file in (one.picture, one.surface))
        of_recordings = (file for one in self.recordings for file in (one.file, *one.codings))
        return (*(file for file in of_captures if file is not None), *of_recordings)

    @property
    def size_bytes(self) -> int:
        """What the files take on the disk."""
        return sum(one.size_bytes or 0 for one in self.files)
