"""Which sessions of the patient are compared, and by which protocol. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from adibas.data.sessions import Session
from adibas.errors import ProtocolError
from adibas.files import written_whole
from adibas.measures.protocol_store import find_protocol, protocol_titles
from adibas.pipeline.protocol_measuring import ProtocolWish
from adibas.pipeline.session_comparison import last_two_alike
from adibas.texts import message
from adibas.texts import translate as _
from ui.comparison.back_presenter import BackView, back_presenter, body_presenter
from ui.comparison.content import Choices
from ui.comparison.numbers_presenter import NumbersPresenter, NumbersView
from ui.comparison.pictures_presenter import PicturesPresenter, PicturesView
from ui.ports import JobControl
from ui.workspace import Workspace

NO_PATIENT = message("No patient is chosen. Choose one first.")
NO_SESSIONS = message("This patient has no session with pictures yet. Take one first.")
ONE_SESSION = message(
    "This patient has one session with pictures. Take another one to see what changed."
)
USUAL_PROTOCOL = "sapo-1"
TWO = 2


class ComparisonView(PicturesView, NumbersView, BackView, Protocol):
    """The screen, as these presenters need it."""

    def show_nothing(self, sentence: str, screen: str) -> None:
        """Say what to do first, not translated yet, and on which screen; nothing: compare."""

    def show_choices(self, choices: Choices) -> None:
        """Offer sessions, protocols and operators."""


class ComparisonPresenter:
    """Follows the workspace's patient while the screen is seen."""

    def __init__(self, view: ComparisonView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self.pictures = PicturesPresenter(view, workspace)
        self.numbers = NumbersPresenter(view, workspace)
        self.back, self.body = back_presenter(view, workspace), body_presenter(view, workspace)
        self._choices = Choices()
        self._patient: str | None = None
        self._opened_id: str | None = None
        self._is_protocol_chosen = self._is_operator_chosen = False
        self._is_seen = False
        self._ends: list[Callable[[], None]] = [
            workspace.patient_changed.subscribe(self._follow),
            workspace.session_changed.subscribe(self._on_session),
        ]

    def close(self) -> None:
        """Listen no more: nobody looks."""
        self._is_seen = False
        for end in self._ends:
            end()

    def enter(self) -> None:
        """Show what the store holds now; what was chosen before stays where it is still there."""
        self._is_seen = True
        sessions = self._sessions()
        patient = self._workspace.patient
        pseudonym = None if patient is None else patient.pseudonym
        if pseudonym != self._patient:
            self._patient = pseudonym
            self._is_protocol_chosen = self._is_operator_chosen = False
            self._choices = Choices()
        self._choices = self._chosen_anew(sessions)
        self._say_what_lacks(sessions)
        self._show()

    def leave(self) -> None:
        """Note that nobody looks."""
        self._is_seen = False

    def refresh(self) -> None:
        """Say everything anew where somebody looks."""
        self._follow()

    def go_to(self, screen: str) -> None:
        """Show another screen."""
        self._workspace.show_screen(screen)

    def choose_sessions(self, earlier_id: str, later_id: str) -> None:
        """Compare these two; where the first is not the earlier one, what was before the second."""
        by_id = {one.session_id: one for one in self._choices.sessions}
        choices = replace(self._choices, later=by_id.get(later_id))
        befores = choices.befores
        earlier = next(
            (x for x in befores if x.session_id == earlier_id), next(iter(befores), None)
        )
        self._choices = replace(choices, earlier=earlier)
        if not self._is_protocol_chosen:
            self._choices = replace(self._choices, protocol=self._protocol_of(self._choices))
        self._show()

    def choose_protocol(self, name: str) -> None:
        """Measure by another protocol."""
        self._is_protocol_chosen = True
        self._choices = replace(self._choices, protocol=name)
        self._show_numbers()

    def choose_operator(self, operator: str) -> None:
        """Look at the repeats of somebody else."""
        self._is_operator_chosen = True
        self._choices = replace(self._choices, operator=operator)
        self.numbers.choose_operator(operator)

    def save_picture(self, path: Path, png: bytes) -> None:
        """Write a plot that the view drew."""
        store, later = self._workspace.store, self._choices.later

        def work(_control: JobControl) -> None:
            if later is not None:
                store.note_export("plot", later.session_id)
            with written_whole(path) as unfinished:
                unfinished.write_bytes(png)

        def done(_nothing: None) -> None:
            self._workspace.tell("good", _("Written: {names}").format(names=path.name))

        self._workspace.jobs.start(_("Writing the picture"), work, done, stop="tells")

    def save_report(self, path: Path) -> None:
        """Write the report on body and back of the later session, as its ending says."""
        store, later = self._workspace.store, self._choices.later
        language = self._workspace.preferences.now.language
        if later is None:
            return

        def work(control: JobControl) -> None:
            from adibas.reports.body import write_stored_body

            write_stored_body(store, later, path, language, control.progress)

        def done(_nothing: None) -> None:
            self._workspace.tell("good", _("Written: {names}").format(names=path.name))

        self._workspace.jobs.start(_("Writing the report"), work, done, stop="tells")

    def _follow(self) -> None:
        if self._is_seen:
            self.enter()

    def _on_session(self) -> None:
        self.numbers.forget_repeats()
        self._follow()

    def _sessions(self) -> tuple[Session, ...]:
        """Return the patient's sessions with pictures or a turn, newest first."""
        found: list[Session] = []
        patient = self._workspace.patient
        if patient is not None:
            of_patient = self._workspace.store.sessions.of_patient
            self._workspace.attempt(lambda: found.extend(of_patient(patient.pseudonym)))
        taken = [one for one in found if one.capture_ids or one.setup.turn]
        return tuple(sorted(taken, key=lambda one: one.started_utc, reverse=True))

    def _say_what_lacks(self, sessions: tuple[Session, ...]) -> None:
        if self._workspace.patient is None:
            self._view.show_nothing(NO_PATIENT, "patients")
        elif not sessions:
            self._view.show_nothing(NO_SESSIONS, "capture")
        elif len(sessions) < TWO:
            self._view.show_nothing(ONE_SESSION, "capture")
        else:
            self._view.show_nothing("", "")

    def _chosen_anew(self, sessions: tuple[Session, ...]) -> Choices:
        """Return the choices before with what is there now, else the last two of one protocol.

        Where another session was opened meanwhile it is the later of the two.
        """
        earlier, later = self._kept(sessions) or self._pair(sessions)
        choices = replace(
            self._choices,
            sessions=sessions,
            earlier=earlier,
            later=later,
            protocols=tuple((name, title.text) for name, title in protocol_titles()),
        )
        if not self._is_protocol_chosen:
            choices = replace(choices, protocol=self._protocol_of(choices))
        return self._with_operators(choices)

    def _kept(self, sessions: tuple[Session, ...]) -> tuple[Session, Session] | None:
        """Return what was compared, as it is now; None where it is gone or another is opened."""
        opened = self._workspace.session
        opened_id = None if opened is None else opened.session_id
        is_other, self._opened_id = opened_id != self._opened_id, opened_id
        by_id = {one.session_id: one for one in sessions}
        before = (self._choices.earlier, self._choices.later)
        kept = [by_id.get(one.session_id) for one in before if one is not None]
        there = [one for one in kept if one is not None]
        return None if is_other or len(there) < TWO else (there[0], there[1])

    def _pair(self, sessions: tuple[Session, ...]) -> tuple[Session | None, Session | None]:
        """Return the last two of one protocol, else the last two, else the only one."""
        opened = self._workspace.session
        opened_id = "" if opened is None else opened.session_id
        until = next((one for one in sessions if one.session_id == opened_id), None)
        found = last_two_alike(sessions, until)
        if found is not None:
            return found
        if len(sessions) < TWO:
            return None, next(iter(sessions), None)
        return sessions[1], sessions[0]

    def _with_operators(self, choices: Choices) -> Choices:
        names = {one.operator for one in choices.sessions} | {self._workspace.store.operator}
        operator = choices.operator
        if not self._is_operator_chosen or operator not in names:
            later = choices.later
            operator = self._workspace.store.operator if later is None else later.operator
        return replace(choices, operators=tuple(sorted(names)), operator=operator)

    def _protocol_of(self, choices: Choices) -> str:
        """Return the protocol that the compared sessions name, else the usual one."""
        named = [one.setup.protocol for one in (choices.later, choices.earlier) if one is not None]
        known = dict(choices.protocols)
        return next((name for name in named if name in known), USUAL_PROTOCOL)

    def _show(self) -> None:
        self._view.show_choices(self._choices)
        for pages in (self.pictures, self.back, self.body):
            pages.show(self._choices.earlier, self._choices.later)
        self._show_numbers()

    def _show_numbers(self) -> None:
        try:
            wish = ProtocolWish(find_protocol(self._choices.protocol))
        except ProtocolError as error:
            self._workspace.report_problem(error)
            return
        self.numbers.show(self._choices, wish)
