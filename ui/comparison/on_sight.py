"""Pages that take a while: they are worked out once somebody looks. Knows nothing of Qt."""

from collections.abc import Callable
from typing import Generic, TypeVar

from adibas.data.sessions import Session
from adibas.errors import AdibasError
from adibas.progress import Progress
from adibas.sessions import SessionStore
from adibas.texts import describe, message
from adibas.texts import translate as _
from ui.ports import Job, JobControl
from ui.workspace import Workspace

BEFORE, NOW = message("Before: {why}"), message("Now: {why}")
Sessions = tuple[Session | None, Session | None]
"""The earlier and the later one."""
Found = TypeVar("Found")
One = TypeVar("One")
Read = Callable[[SessionStore, Session], tuple[One, tuple[str, ...]]]
"""Gives what was found in a session, and notes on it."""


class OnSight(Generic[Found]):
    """Works out what a page shows of two sessions, beside the window.

    Parameters
    ----------
    workspace : Workspace
    looking : str
        What is being done, not translated yet.
    read : function
        Does it.
    show : function
        Shows what was found.
    waiting : function
        Gives what is shown meanwhile, of the translated sentence; of an empty one: nothing.
    """

    def __init__(
        self,
        workspace: Workspace,
        looking: str,
        read: Callable[[SessionStore, Sessions, Progress], Found],
        show: Callable[[Found], None],
        waiting: Callable[[str], Found],
    ) -> None:
        self._workspace = workspace
        self._looking = looking
        self._read, self._show, self._waiting = read, show, waiting
        self._sessions: Sessions = (None, None)
        self._shown: Sessions | None = None
        self._is_seen = False
        self._job: Job | None = None

    def show(self, earlier: Session | None, later: Session | None) -> None:
        """Show these two as soon as the page is seen."""
        self._sessions, self._shown = (earlier, later), None
        self._work()

    def look(self, is_seen: bool) -> None:
        """Note whether the page is seen."""
        self._is_seen = is_seen
        self._work()

    def _work(self) -> None:
        if not self._is_seen or self._shown is not None:
            return
        if self._job is not None and self._job.is_running:
            self._job.cancel()
        self._shown = self._sessions
        if self._sessions == (None, None):
            self._show(self._waiting(""))
            return
        self._show(self._waiting(_(self._looking)))
        store, sessions = self._workspace.store, self._sessions

        def work(control: JobControl) -> Found:
            return self._read(store, sessions, control.progress)

        def done(found: Found) -> None:
            if self._shown == sessions:
                self._show(found)

        self._job = self._workspace.jobs.start(_(self._looking), work, done)


def read_both(
    store: SessionStore,
    sessions: Sessions,
    read: Read[One],
) -> tuple[One | None, One | None, tuple[str, ...]]:
    """Return what was found in both, and the sentences on them: also why something is missing."""
    found: list[One | None] = []
    sentences: list[str] = []
    for session, told in zip(sessions, (BEFORE, NOW), strict=True):
        one, notes = (None, ()) if session is None else _attempt(store, session, read)
        found.append(one)
        sentences += [_(told).format(why=note) for note in notes]
    return found[0], found[1], tuple(sentences)


def _attempt(
    store: SessionStore, session: Session, read: Read[One]
) -> tuple[One | None, tuple[str, ...]]:
    try:
        return read(store, session)
    except AdibasError as error:
        return None, (describe(error),)
