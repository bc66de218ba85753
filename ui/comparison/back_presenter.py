"""The back in two sessions: its asymmetry, the spine, and the measures. Knows nothing of Qt."""

from typing import Protocol

from adibas.data.sessions import Session
from adibas.errors import AdibasError
from adibas.pipeline.stored_body import stored_back
from adibas.sessions import SessionStore
from adibas.texts import describe, message
from adibas.texts import translate as _
from ui.comparison.back_content import Backs, SeenBack, seen_back
from ui.ports import Job, JobControl
from ui.workspace import Workspace

LOOKING = message("The backs are being measured.")
BEFORE, NOW = message("Before: {why}"), message("Now: {why}")


class BackView(Protocol):
    """The page with the backs, as this presenter needs it."""

    def show_backs(self, backs: Backs) -> None:
        """Show what was found in both sessions."""


class BackPresenter:
    """Measures both backs beside the window, once somebody looks at the page."""

    def __init__(self, view: BackView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._sessions: tuple[Session | None, Session | None] = (None, None)
        self._shown: tuple[Session | None, Session | None] | None = None
        self._is_seen = False
        self._job: Job | None = None

    def show(self, earlier: Session | None, later: Session | None) -> None:
        """Show these two as soon as the page is seen."""
        self._sessions, self._shown = (earlier, later), None
        self._measure()

    def look(self, is_seen: bool) -> None:
        """Note whether the page is seen."""
        self._is_seen = is_seen
        self._measure()

    def _measure(self) -> None:
        if not self._is_seen or self._shown == self._sessions:
            return
        if self._job is not None and self._job.is_running:
            self._job.cancel()
        self._shown = self._sessions
        if self._sessions == (None, None):
            self._view.show_backs(Backs())
            return
        self._view.show_backs(Backs(sentences=(_(LOOKING),)))
        store, sessions = self._workspace.store, self._sessions

        def work(_control: JobControl) -> Backs:
            return read_backs(store, sessions)

        self._job = self._workspace.jobs.start(_(LOOKING), work, self._view.show_backs)


def read_backs(store: SessionStore, sessions: tuple[Session | None, Session | None]) -> Backs:
    """Measure the backs of two sessions; what cannot be measured is told."""
    found: list[SeenBack | None] = []
    sentences: list[str] = []
    for session, told in zip(sessions, (BEFORE, NOW), strict=True):
        back, why = (None, []) if session is None else _read(store, session)
        found.append(back)
        sentences += [_(told).format(why=one) for one in why]
    return Backs(found[0], found[1], tuple(sentences))


def _read(store: SessionStore, session: Session) -> tuple[SeenBack | None, list[str]]:
    try:
        back = stored_back(store, session)
    except AdibasError as error:
        return None, [describe(error)]
    return seen_back(back), [notice.text for notice in back.notices]
