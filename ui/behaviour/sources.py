"""What can be coded: recordings on the disk, and those of a session. Knows nothing of Qt."""

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.pipeline.coding_drafts import BesideRecording
from adibas.pipeline.recording_access import FILES, RecordingAccess
from adibas.recordings.joints_csv import recording_name
from adibas.sessions.coding_drafts import InStore
from ui.behaviour.ports import Source
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions import SessionStore


@dataclass(frozen=True, slots=True)
class StoredChoice:
    """A recording of the session that is looked at."""

    recording_id: str
    session_id: str
    created_utc: datetime
    duration_s: float


def file_source(path: Path) -> Source:
    """Return a recording on the disk; what is coded stands beside it."""
    return Source(
        recording_name(path), path, FILES, lambda observer: BesideRecording(path, observer)
    )


def stored_choices(workspace: Workspace) -> tuple[StoredChoice, ...]:
    """Return the recordings of the session that is looked at.

    Raises
    ------
    StoreError
        The store cannot be read.
    """
    session = workspace.session
    if session is None:
        return ()
    found = workspace.store.recordings.of_session(session.session_id)
    return tuple(
        StoredChoice(one.recording_id, one.session_id, one.created_utc, one.duration_ns / 1e9)
        for one in found
    )


def stored_source(store: "SessionStore", choice: StoredChoice) -> Source:
    """Return a recording of the store; what is coded is sealed beside it."""
    recordings = store.recordings
    access = RecordingAccess(
        lambda path: recordings.open(path.name),
        lambda path: recordings.sealed.sha256(path.name),
    )
    return Source(
        choice.recording_id[:8],
        Path(choice.recording_id),
        access,
        lambda observer: InStore(recordings, choice.recording_id, observer),
        choice.session_id,
    )
