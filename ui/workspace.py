"""What all screens share: the store, who is being looked at, and what the user was told. No Qt."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Literal

from adibas.data.patients import Patient
from adibas.errors import AdibasError, ServerAwayError
from adibas.texts import describe, message
from adibas.texts import translate as _
from ui.events import Event
from ui.ports import Jobs, LiveSource
from ui.preferences import PreferencesFile

if TYPE_CHECKING:  # compiler and database come later: the window is usable before
    from adibas.data.sessions import Session
    from adibas.pipeline.posture import MarkerTarget
    from adibas.sessions import SessionStore
    from adibas.sessions.conflicts import Decision
    from ui.disputes import Dispute

HIDDEN_MEANWHILE = message(
    "Somebody else deleted this patient or session meanwhile. What you saved is kept in it, but it "
    "is hidden: restore it on Patients to see it again."
)
NoticeKind = Literal["good", "warning", "bad"]
Save = Callable[["tuple[Decision, ...]"], None]
"""Saves something as it was decided; nothing is decided at first."""


@dataclass(frozen=True, slots=True)
class Place:
    """What was being looked at, without anything of the patient: it outlives a lock.

    Attributes
    ----------
    patient, session_id, capture_id : str or None
        Random ids of the store.
    target : MarkerTarget or None
        What markers look like.
    """

    patient: str | None
    session_id: str | None
    capture_id: str | None
    target: "MarkerTarget | None"


class Workspace:
    """The one place that screens meet in: they never know of one another.

    Everything here happens in the window's thread.

    Attributes
    ----------
    store : SessionStore
        Of patients and sessions.
    jobs : Jobs
        Work beside the window.
    preferences : PreferencesFile
        Of this user on this computer.
    live : LiveSource
        The sensor, for whoever shows or captures it.
    patient, session, capture_id
        What is being looked at; None where nothing is chosen.
    target : MarkerTarget or None
        What markers look like; None before it was learned.

    Events
    ------
    patient_changed, session_changed, capture_chosen, target_changed
        Something else was chosen, or what is chosen has new content.
    person_changed
        Who has the store open became somebody by name.
    screen_wanted(name)
        A screen asks for another one to be shown.
    consent_wanted(back_to)
        A consent of the chosen patient lacks; the screen that asks is shown again once it is there.
    noticed(kind, sentence)
        The user is told something.
    notice_withdrawn(sentence)
        It was told of a patient or session that is not looked at any more.
    retry_offered(sentence, again)
        Something failed that can be tried again as it is.
    retry_withdrawn()
        It is not offered any more.
    dispute_found(dispute)
        Somebody else changed the same meanwhile: the user has to choose.
    """

    def __init__(
        self, store: "SessionStore", jobs: Jobs, preferences: PreferencesFile, live: LiveSource
    ) -> None:
        self.store = store
        self.jobs = jobs
        self.preferences = preferences
        self.live = live
        self.patient: Patient | None = None
        self.session: Session | None = None
        self.capture_id: str | None = None
        self.target: MarkerTarget | None = None
        self.patient_changed: Event[[]] = Event()
        self.session_changed: Event[[]] = Event()
        self.capture_chosen: Event[[]] = Event()
        self.target_changed: Event[[]] = Event()
        self.person_changed: Event[[]] = Event()
        self.screen_wanted: Event[[str]] = Event()
        self.consent_wanted: Event[[str]] = Event()
        self.noticed: Event[[NoticeKind, str]] = Event()
        self.notice_withdrawn: Event[[str]] = Event()
        self.retry_offered: Event[[str, Callable[[], object]]] = Event()
        self.retry_withdrawn: Event[[]] = Event()
        self.dispute_found: Event[[Dispute]] = Event()
        self._offered: _Attempt | None = None
        self._told_here = ""
        self._told_hidden = ""

    def choose_patient(self, patient: Patient | None) -> None:
        """Look at a patient; a session of another one is left."""
        self.withdraw_retry()  # before anybody is told: who is told may offer another one
        if _pseudonym(patient) != _pseudonym(self.patient):
            self._withdraw_notice()
        self.patient = patient
        if self.session is not None and (
            patient is None or self.session.patient != patient.pseudonym
        ):
            self.choose_session(None)
        self.patient_changed.emit()

    def choose_session(self, session: "Session | None") -> None:
        """Look at a session (the same one with new content, too)."""
        self.withdraw_retry()
        is_other = (
            session is None or self.session is None or session.session_id != self.session.session_id
        )
        self.session = session
        if is_other:
            self._withdraw_notice()
            self.choose_capture(None)
        self.session_changed.emit()

    def renew_session(self, session: "Session") -> None:
        """Take the new content of a session, where it is the one that is being looked at."""
        if self.session is not None and self.session.session_id == session.session_id:
            self.choose_session(session)

    def choose_capture(self, capture_id: str | None) -> None:
        """Look at one capture of the session."""
        self.capture_id = capture_id
        self.capture_chosen.emit()

    def set_target(self, target: "MarkerTarget | None") -> None:
        """Look for these markers from now on."""
        self.target = target
        self.live.set_target(target)
        self.target_changed.emit()

    @property
    def place(self) -> Place:
        """What is being looked at."""
        return Place(
            patient=self.patient.pseudonym if self.patient is not None else None,
            session_id=self.session.session_id if self.session is not None else None,
            capture_id=self.capture_id,
            target=self.target,
        )

    def return_to(self, place: Place) -> None:
        """Look at the same again; what is gone meanwhile is told."""
        if place.target is not None:
            self.set_target(place.target)
        self.attempt(lambda: self._choose_all(place))

    def _choose_all(self, place: Place) -> None:
        if place.patient is not None:
            self.choose_patient(self.store.patients.get(place.patient))
        if place.session_id is not None:
            self.choose_session(self.store.sessions.get(place.session_id))
            self.choose_capture(place.capture_id)

    def show_screen(self, name: str) -> None:
        """Ask the window to show another screen."""
        self.screen_wanted.emit(name)

    def ask_consent(self, back_to: str = "patients") -> None:
        """Let a consent of the chosen patient be recorded, where consents are."""
        self.show_screen("patients")  # first: it listens from its first showing on
        self.consent_wanted.emit(back_to)

    def tell(self, kind: NoticeKind, sentence: str) -> None:
        """Tell the user something, already in his language."""
        self.noticed.emit(kind, sentence)

    def tell_here(self, kind: NoticeKind, sentence: str) -> None:
        """Tell what holds of the patient and session that are looked at, and goes with them."""
        self._told_here = sentence
        self.tell(kind, sentence)

    def _withdraw_notice(self) -> None:
        sentence, self._told_here = self._told_here, ""
        if sentence:
            self.notice_withdrawn.emit(sentence)

    def report_problem(self, error: AdibasError) -> None:
        """Tell the user what failed and what to do."""
        self.tell("bad", describe(error))

    def attempt(self, action: Callable[[], None]) -> bool:
        """Do something short in the store; a failure is told. Return whether it went well."""
        try:
            action()
        except AdibasError as error:
            self.report_problem(error)
            return False
        return True

    def save_shared(
        self, save: "Save", ended: Callable[[], None] = lambda: None, *, is_kept: bool = True
    ) -> bool:
        """Save what others may change at the same time; return whether that went well at once.

        Where somebody did, the user is asked, and it is saved as he decides. Where the server of
        the store does not answer, he is offered to try again, until he saves something, gives it
        up, or looks at another patient or session.

        Parameters
        ----------
        save : callable
            Takes the decisions of the user, which are none at first. What it saves, and where, is
            bound now: by the time that it succeeds, he may be looking at something else.
        ended : callable
            Told after each attempt.
        is_kept : bool
            Whether what is to be saved stays on the screen. Where it does not and the user does
            not decide, both texts stay, and of markers the other version, with his own set aside.
        """
        return self._attempt_shared(_Attempt(save, ended, is_kept), ())

    @property
    def has_retry(self) -> bool:
        """Whether something waits to be tried again."""
        return self._offered is not None

    def withdraw_retry(self) -> None:
        """Offer no more to try again what failed: it was given up, or is saved otherwise."""
        if self._offered is not None:
            self._offered = None
            self.retry_withdrawn.emit()

    def _try_again(self, attempt: "_Attempt", decisions: "tuple[Decision, ...]") -> None:
        if attempt is self._offered:
            self._attempt_shared(attempt, decisions)

    def _attempt_shared(self, attempt: "_Attempt", decisions: "tuple[Decision, ...]") -> bool:
        self.withdraw_retry()
        try:
            attempt.save(decisions)
        except ServerAwayError as error:
            self._offered = attempt
            self.retry_offered.emit(describe(error), partial(self._try_again, attempt, decisions))
        except AdibasError as error:
            self._tell_or_ask(error, attempt)
        else:
            attempt.ended()
            self._tell_if_hidden()
            return True
        attempt.ended()
        return False

    def _tell_if_hidden(self) -> None:
        """Tell once that somebody hid meanwhile what was just changed: it is saved, and not seen.

        A hidden one is never looked at otherwise.
        """
        if self.session is None or self.session.session_id == self._told_hidden:
            return
        session_id, pseudonym = self.session.session_id, self.session.patient
        with suppress(AdibasError):  # what was saved is saved; the next step tells what fails
            session = self.store.sessions.get(session_id)
            if session.is_deleted or self.store.patients.get(pseudonym).is_deleted:
                self._told_hidden = session_id
                self.tell_here("warning", _(HIDDEN_MEANWHILE))

    def _tell_or_ask(self, error: AdibasError, attempt: "_Attempt") -> None:
        from adibas.sessions.conflicts import ConflictError
        from ui.disputes import Dispute, undecided

        if not isinstance(error, ConflictError):
            self.report_problem(error)
            return
        conflicts = error.conflicts

        def put_off() -> None:
            if not attempt.is_kept:
                self._attempt_shared(attempt, undecided(conflicts))

        def decide(decisions: "tuple[Decision, ...]") -> None:
            self._attempt_shared(attempt, decisions)

        self.dispute_found.emit(Dispute(conflicts, decide, put_off))


def _pseudonym(patient: Patient | None) -> str | None:
    return None if patient is None else patient.pseudonym


@dataclass(frozen=True, slots=True)
class _Attempt:
    """What is saved, who is told after each attempt, whether it stays on the screen."""

    save: Save
    ended: Callable[[], None]
    is_kept: bool
