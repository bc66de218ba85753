"""What can be coded: recordings on the disk, and those of a session. Knows nothing of Qt."""

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.clock import NS_PER_S
from adibas.pipeline.coding_drafts import BesideRecording
from adibas.pipeline.recording_access import FILES, RecordingAccess
from adibas.recordings.joints_csv import recording_name
from adibas.sessions.coding_drafts import InStore
from adibas.texts import translate as _
from ui.behaviour.ports import Source
from ui.view_names import VIEW_NAMES
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions import SessionStore


@dataclass(frozen=True, slots=True)
class StoredChoice:
    """A recording of the session that is looked at; `view` is that of its capture, if any."""

    recording_id: str
    session_id: str
    created_utc: datetime
    duration_s: float
    view: str = ""


def file_source(path: Path) -> Source:
    """Return a recording on the disk; what is coded stands beside it."""
    name = recording_name(path)
    return Source(name, name, path, FILES, lambda observer: BesideRecording(path, observer))


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
    store, session_id = workspace.store, session.session_id
    views = {
        one.recording_id: one.view
        for one in store.captures.of_session(session_id, with_deleted=True)
    }
    return tuple(
        StoredChoice(
            *(one.recording_id, one.session_id, one.created_utc, one.duration_ns / NS_PER_S),
            views.get(one.recording_id, ""),
        )
        for one in store.recordings.of_session(session_id)
    )


def plain_title(choice: StoredChoice) -> str:
    """Return what a stored recording is called: when it was made, and which view it shows."""
    return titled(f"{choice.created_utc:%Y-%m-%d %H:%M}", choice.view)


def titled(moment: str, view: str) -> str:
    """Return a moment and the name of a view."""
    return f"{moment}, {_(VIEW_NAMES[view])}" if view else moment


def stored_source(store: "SessionStore", choice: StoredChoice, title: str) -> Source:
    """Return a recording of the store; what is coded is sealed beside it."""
    recordings = store.recordings
    access = RecordingAccess(
        lambda path: recordings.open(path.name),
        lambda path: recordings.sealed.sha256(path.name),
    )
    return Source(
        title,
        choice.recording_id[:8],
        Path(choice.recording_id),
        access,
        lambda observer: InStore(recordings, choice.recording_id, observer),
        choice.session_id,
    )
