"""What can be coded: recordings on the disk, and those of a session. Knows nothing of Qt."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.clock import NS_PER_S
from adibas.pipeline.coding_drafts import BesideRecording
from adibas.pipeline.joined_access import joined_access, joined_key, joined_name
from adibas.pipeline.recording_access import FILES, RecordingAccess
from adibas.recordings.joints_csv import recording_name
from adibas.sessions.coding_drafts import InStore
from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.behaviour.ports import Source
from ui.view_names import TURN, VIEW_NAMES
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions import SessionStore


ALL = "all"
"""Every recording of the session, one after another."""


@dataclass(frozen=True, slots=True)
class StoredChoice:
    """A recording of the session that is looked at; `view` is that of its capture, if any.

    `rotation_deg` is how far the pictures of the session are turned clockwise to be upright.
    """

    recording_id: str
    session_id: str
    created_utc: datetime
    duration_s: float
    view: str = ""
    rotation_deg: int = 0


def file_source(path: Path) -> Source:
    """Return a recording on the disk; what is coded stands beside it."""
    name = recording_name(path)
    return Source(name, name, path, FILES, lambda observer: BesideRecording(path, observer))


def files_source(paths: Sequence[Path]) -> Source:
    """Return recordings on the disk as one, in the order of their names.

    What is coded stands beside the first one, under a name that is the same for the same files.
    """
    ordered = sorted(paths, key=_as_counted)
    if len(ordered) == 1:
        return file_source(ordered[0])
    names = tuple(recording_name(path) for path in ordered)
    name = joined_name(names)
    whole = ordered[0].with_name(f"{name}.mcap")
    return Source(
        joined_title(names[0], len(names)),
        *(name, ordered[0], joined_access(ordered, FILES)),
        lambda observer: BesideRecording(whole, observer),
        parts=names,
    )


def joined_title(first: str, n_parts: int) -> str:
    """Return what recordings are called that are watched as one."""
    more = translate_plural("{first} and {n} more", "{first} and {n} more", n_parts - 1)
    return more.format(first=first, n=n_parts - 1)


def _as_counted(path: Path) -> list[tuple[int, str]]:
    """Sort 2 before 10."""
    parts = re.split(r"(\d+)", path.name.lower())
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


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
    } | {session.setup.turn: TURN}
    return tuple(
        StoredChoice(
            *(one.recording_id, one.session_id, one.created_utc, one.duration_ns / NS_PER_S),
            views.get(one.recording_id, ""),
            session.setup.rotation_deg,
        )
        for one in store.recordings.of_session(session_id)
    )


def plain_title(choice: StoredChoice) -> str:
    """Return what a stored recording is called: when it was made, and which view it shows."""
    return titled(f"{choice.created_utc:%Y-%m-%d %H:%M}", choice.view)


def titled(moment: str, view: str) -> str:
    """Return a moment and the name of a view."""
    return f"{moment}, {_(VIEW_NAMES[view])}" if view else moment


def stored_sources(store: "SessionStore", choices: Sequence[StoredChoice], title: str) -> Source:
    """Return recordings of the store as one; what is coded is sealed beside the first."""
    first, ids = choices[0], tuple(one.recording_id for one in choices)
    if len(ids) == 1:
        return stored_source(store, first, title)
    paths, key = [Path(one) for one in ids], joined_key(ids)
    return Source(
        joined_title(title, len(ids)),
        f"{first.recording_id[:8]}+{len(ids) - 1}-{key}",
        *(paths[0], joined_access(paths, _sealed_access(store))),
        lambda observer: InStore(store.recordings, first.recording_id, observer, key),
        first.session_id,
        tuple(one[:8] for one in ids),
        first.rotation_deg,
    )


def _sealed_access(store: "SessionStore") -> RecordingAccess:
    recordings = store.recordings
    return RecordingAccess(
        lambda path: recordings.open(path.name),
        lambda path: recordings.sealed.sha256(path.name),
    )


def stored_source(store: "SessionStore", choice: StoredChoice, title: str) -> Source:
    """Return a recording of the store; what is coded is sealed beside it."""
    recordings = store.recordings
    return Source(
        title,
        choice.recording_id[:8],
        Path(choice.recording_id),
        _sealed_access(store),
        lambda observer: InStore(recordings, choice.recording_id, observer),
        choice.session_id,
        rotation_deg=choice.rotation_deg,
    )
