"""The sessions of the chosen patient: started, continued, opened, hidden. Knows nothing of Qt."""

from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

from adibas.clock import day_here
from adibas.errors import AdibasError, ConsentError
from adibas.texts import describe
from adibas.texts import translate as _
from ui.patients.content import (
    History,
    PurgeQuestion,
    Thumbnail,
    UndoOffer,
)
from ui.patients.undo import Undo
from ui.ports import JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:  # patients are listed before anything is known of their sessions
    from adibas.data.protocols import Wording
    from adibas.data.sessions import Session, SessionSetup
    from adibas.sessions import SessionStore
    from adibas.sessions.conflicts import Decision

Thumbnails = dict[str, tuple[Thumbnail, ...]]
"""By the session's id."""


class HistoryView(Protocol):
    """Buttons that begin a session, and the list of sessions, as this presenter needs them."""

    def show_history(self, history: History) -> None:
        """Show these sessions, and what can be done."""

    def show_protocols(self, protocols: "tuple[tuple[str, Wording], ...]", chosen: str) -> None:
        """Offer protocols for new sessions; an empty name is none."""

    def show_current(self, session_id: str | None) -> None:
        """Mark the session that the other screens look at."""

    def show_thumbnails(self, thumbnails: Thumbnails) -> None:
        """Show the pictures of some sessions."""

    def ask_purge(self, question: PurgeQuestion) -> None:
        """Ask for the word that confirms a removal for good."""


class HistoryPresenter:
    """Follows the workspace's patient and session."""

    def __init__(self, view: HistoryView, workspace: Workspace, undo: Undo) -> None:
        self._view = view
        self._workspace = workspace
        self._undo = undo
        self._has_deleted = False
        self._sessions: tuple[Session, ...] = ()
        self._is_seen = False
        self._has_read_protocols = False
        self._ends = (
            workspace.patient_changed.subscribe(self._follow),
            workspace.session_changed.subscribe(self._follow),
            undo.hidden_changed.subscribe(self._follow),
        )

    def close(self) -> None:
        """Listen no more."""
        for end in self._ends:
            end()

    def enter(self) -> None:
        """Show the store as it is now, and follow what other screens do."""
        self._is_seen = True
        self._has_read_protocols = False  # others may have been made or deleted meanwhile
        self.refresh()

    def leave(self) -> None:
        """Wait until the screen is seen again."""
        self._is_seen = False

    def refresh(self) -> None:
        """Show the history as it is in the store now."""
        if not self._workspace.attempt(self._read):
            self._sessions = ()
        patient, is_read_only = self._workspace.patient, self._workspace.store.is_read_only
        can_change = patient is not None and not patient.is_deleted and not is_read_only
        if can_change and not self._has_read_protocols:
            self._read_protocols()
        self._view.show_history(
            History(
                self._sessions,
                can_start=can_change,
                can_continue=can_change and self._last() is not None,
                can_change=not is_read_only,
                is_read_only=is_read_only,
                can_repeat=can_repeat(self._sessions),
            )
        )
        session = self._workspace.session
        self._view.show_current(None if session is None else session.session_id)

    def show_deleted(self, *, is_wanted: bool) -> None:
        """List hidden sessions, too, or no longer."""
        self._has_deleted = is_wanted
        self.refresh()

    def start(self) -> None:
        """Begin a session with the usual set-up."""
        from adibas.data.sessions import SessionSetup

        self._start(SessionSetup(protocol=self._workspace.preferences.now.protocol))

    def choose_protocol(self, name: str) -> None:
        """Follow this protocol in sessions that begin from now on."""
        self._workspace.preferences.change(protocol=name)

    def start_like_last(self) -> None:
        """Begin a session that is set up as the last one was."""
        last = self._last()
        if last is not None:
            self._start(last.setup)

    def continue_last(self) -> None:
        """Go on with the last session."""
        last = self._last()
        if last is not None:
            self._workspace.choose_session(last)
            self._workspace.show_screen("capture")

    def open(self, session_id: str, capture_id: str | None = None) -> None:
        """Review a session, from one of its captures or from the first one."""
        session = self._listed(session_id)
        if session is None:
            return
        if session.is_deleted:
            self._workspace.tell(
                "warning", _("This session was deleted. Restore it, then it can be opened.")
            )
            return
        self._workspace.choose_session(session)
        if capture_id is None and session.capture_ids:
            capture_id = session.capture_ids[0]
        self._workspace.choose_capture(capture_id)
        self._workspace.show_screen("review")

    def compare(self, session_id: str) -> None:
        """See what changed until a session; until the last one where none is told."""
        session = self._listed(session_id)
        if session is not None and not session.is_deleted:
            self._workspace.choose_session(session)
        self._workspace.show_screen("comparison")

    def call_repeat(self, session_id: str, *, is_repeat: bool) -> None:
        """Note whether a session repeats the one before it, with the markers placed anew."""
        session = self._listed(session_id)
        if session is None or self._workspace.store.is_read_only:
            return
        setup = replace(session.setup, is_repeat=is_repeat)
        sessions, renew = self._workspace.store.sessions, self._workspace.renew_session

        def change(decisions: "tuple[Decision, ...]") -> None:
            renew(sessions.change(session_id, setup=setup, seen=session, decisions=decisions))

        self._workspace.save_shared(change, self.refresh)

    def delete(self, session_id: str) -> None:
        """Hide a session; it can be undone."""
        session = self._listed(session_id)
        if session is None or session.is_deleted or self._workspace.store.is_read_only:
            return
        sessions = self._workspace.store.sessions
        if self._workspace.attempt(lambda: sessions.delete(session_id)):
            self._leave(session_id)
            offer = UndoOffer("session", "", session.started_utc)
            self._undo.offer(offer, lambda: sessions.restore(session_id))

    def restore(self, session_id: str) -> None:
        """Show a hidden session again."""
        sessions = self._workspace.store.sessions
        if self._workspace.attempt(lambda: sessions.restore(session_id)):
            self._undo.forget()

    def ask_purge(self, session_id: str) -> None:
        """Ask whether a hidden session is to be removed for good."""
        session, patient = self._listed(session_id), self._workspace.patient
        if session is None or patient is None or not session.is_deleted:
            return
        name, word = patient.identity.name, patient.pseudonym
        self._view.ask_purge(PurgeQuestion("session", name, 1, session.started_utc, word))

    def purge(self, session_id: str) -> None:
        """Remove a session for good; the user typed the patient's pseudonym."""
        sessions = self._workspace.store.sessions

        def gone(_nothing: None) -> None:
            self._leave(session_id)
            self._undo.forget()
            self._workspace.tell("good", _("The session was removed for good."))

        self._workspace.jobs.start(
            _("Removing a session for good"),
            lambda _control: sessions.purge(session_id),
            gone,
            stop="never",
        )

    def load_thumbnails(self, session_ids: tuple[str, ...]) -> None:
        """Read the pictures of some sessions beside the window, then show them."""
        store = self._workspace.store
        wanted = [one for one in self._sessions if one.session_id in session_ids]

        def work(control: JobControl) -> Thumbnails:
            found: Thumbnails = {}
            for number, session in enumerate(wanted):
                control.progress(number, len(wanted))
                found[session.session_id] = read_thumbnails(store, session)
            return found

        self._workspace.jobs.start(_("Reading pictures"), work, self._view.show_thumbnails)

    def _read_protocols(self) -> None:
        """Offer the protocols that there are; one that is gone is not followed any more."""
        self._has_read_protocols = True
        preferences = self._workspace.preferences

        def work(_control: JobControl) -> "tuple[tuple[str, Wording], ...]":
            from adibas.measures.protocol_store import protocol_titles

            return protocol_titles()

        def done(found: "tuple[tuple[str, Wording], ...]") -> None:
            if preferences.now.protocol not in ("", *dict(found)):
                preferences.change(protocol="")
            self._view.show_protocols(found, preferences.now.protocol)

        self._workspace.jobs.start(_("Reading the protocols"), work, done)

    def _start(self, setup: "SessionSetup") -> None:
        patient = self._workspace.patient
        if patient is None:
            return
        try:
            session = self._workspace.store.sessions.start(patient.pseudonym, setup)
        except ConsentError as error:
            self._workspace.tell("warning", describe(error))
            self._workspace.ask_consent()
        except AdibasError as error:
            self._workspace.report_problem(error)
        else:
            self._workspace.choose_session(session)
            self._workspace.show_screen("capture")

    def _follow(self) -> None:
        if self._is_seen:
            self.refresh()

    def _leave(self, session_id: str) -> None:
        """Look at no session where it is this one."""
        current = self._workspace.session
        if current is not None and current.session_id == session_id:
            self._workspace.choose_session(None)

    def _read(self) -> None:
        patient = self._workspace.patient
        if patient is None:
            self._sessions = ()
            return
        of_patient = self._workspace.store.sessions.of_patient
        self._sessions = of_patient(patient.pseudonym, with_deleted=self._has_deleted)

    def _last(self) -> "Session | None":
        return next((one for one in self._sessions if not one.is_deleted), None)

    def _listed(self, session_id: str) -> "Session | None":
        return next((one for one in self._sessions if one.session_id == session_id), None)


def can_repeat(sessions: "tuple[Session, ...]") -> frozenset[str]:
    """Return the ids of sessions before which there was another on their day by their operator."""
    first: dict[tuple[object, str], str] = {}
    found = set()
    for session in sorted(sessions, key=lambda one: one.started_utc):
        if session.is_deleted:
            continue
        of_day = (day_here(session.started_utc), session.operator)
        if first.setdefault(of_day, session.session_id) != session.session_id:
            found.add(session.session_id)
    return frozenset(found)


def read_thumbnails(store: "SessionStore", session: "Session") -> tuple[Thumbnail, ...]:
    """Return a session's captures in small; nothing where the session cannot be read."""
    import numpy as np

    try:
        captures = store.captures.of_session(session.session_id)
    except AdibasError:
        return ()
    n_turns = -session.setup.rotation_deg // 90  # numpy turns the other way
    thumbnails = []
    for capture in captures:
        try:
            small = store.captures.thumbnail(capture.capture_id)
        except AdibasError:
            thumbnails.append(Thumbnail(capture.capture_id, capture.view, None))
            continue
        upright = np.ascontiguousarray(np.rot90(small, n_turns))
        thumbnails.append(Thumbnail(capture.capture_id, capture.view, upright))
    return tuple(thumbnails)
