"""Differences, trends and repeats of one protocol's measures. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol, TypeVar

from adibas.errors import AdibasError
from adibas.pipeline.clinic_repeats import ClinicReliability, reliability_in_clinic
from adibas.pipeline.protocol_measuring import ProtocolWish
from adibas.pipeline.session_comparison import (
    PatientTrends,
    compare_by_protocol,
    patient_trends,
)
from adibas.texts import describe, message, translate_plural
from adibas.texts import translate as _
from ui.comparison.content import Choices, Differences, Repeats, Trends
from ui.ports import Job, JobControl
from ui.workspace import Workspace

LOOKING = message("The repeats of this clinic are being looked through.")
STOPPED = message("The repeats of this clinic were not looked through. Choose the operator again.")
NO_REPEATS = message("No session of this operator has a measure of this protocol.")

Clinic = tuple[str, str, str]
"""Protocol, its revision, and operator."""
Result = TypeVar("Result")


class NumbersView(Protocol):
    """The pages with numbers, as this presenter needs it."""

    def show_differences(self, differences: Differences) -> None:
        """Show the table of changes, or why there is none."""

    def show_trends(self, trends: Trends) -> None:
        """Show the measures over time."""

    def show_repeats(self, repeats: Repeats) -> None:
        """Show how well measures repeat."""


class NumbersPresenter:
    """Measures both sessions, then all of the patient, then the repeats of the clinic.

    The repeats of a whole clinic take a while: changes are shown before, and marked when they are
    known. What was looked through is kept until a session changes.
    """

    def __init__(self, view: NumbersView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._choices = Choices()
        self._wish: ProtocolWish | None = None
        self._known: dict[Clinic, ClinicReliability] = {}
        self._looking: set[Clinic] = set()
        self._jobs: dict[str, Job] = {}

    def show(self, choices: Choices, wish: ProtocolWish) -> None:
        """Show these sessions by this protocol."""
        self._choices, self._wish = choices, wish
        later = choices.later
        if later is not None:
            self._look_through(wish, later.operator)
        self._measure(wish)
        self.choose_operator(choices.operator)

    def choose_operator(self, operator: str) -> None:
        """Show the repeats of an operator."""
        wish = self._wish
        if wish is None:
            return
        self._choices = replace(self._choices, operator=operator)
        self._look_through(wish, operator)
        self._show_repeats(wish, operator)

    def forget_repeats(self) -> None:
        """Look through them anew the next time: a session has changed."""
        self._known.clear()

    def _measure(self, wish: ProtocolWish) -> None:
        """Compare and follow, with what is known of repeats."""
        later, earlier, store = self._choices.later, self._choices.earlier, self._workspace.store
        if later is None:
            self._view.show_differences(Differences(wish.protocol))
            self._view.show_trends(Trends())
            return
        clinic = _clinic(wish, later.operator)
        mdc95 = self._known[clinic].mdc95() if clinic in self._known else {}
        is_looking = clinic in self._looking

        def work(control: JobControl) -> tuple[Differences, PatientTrends]:
            differences = Differences(wish.protocol, is_looking=is_looking)
            if earlier is not None:
                try:
                    found = compare_by_protocol(store, earlier, later, wish, mdc95)
                    differences = Differences(wish.protocol, found, is_looking=is_looking)
                except AdibasError as error:
                    differences = Differences(wish.protocol, refusal=describe(error))
            return differences, patient_trends(store, later, wish, mdc95, control.progress)

        def done(found: tuple[Differences, PatientTrends]) -> None:
            differences, trends = found
            self._view.show_differences(differences)
            self._view.show_trends(Trends(trends.trends, _notes(trends)))

        self._start("measure", _("Measuring both sessions"), work, done)

    def _look_through(self, wish: ProtocolWish, operator: str) -> None:
        """Find out how well measures repeat, unless that is known."""
        clinic, store = _clinic(wish, operator), self._workspace.store
        if clinic in self._known or clinic in self._looking:
            return
        outcome: list[ClinicReliability] = []

        def work(control: JobControl) -> None:
            outcome.append(reliability_in_clinic(store, wish, operator, control.progress))

        def ended() -> None:
            self._looking.discard(clinic)
            if outcome:
                self._known[clinic] = outcome[0]
            self._on_looked_through(wish, operator)

        self._looking.add(clinic)
        label = _("Looking through the clinic's repeats")
        self._start(f"repeats of {operator}", label, work, _nothing_more, ended)

    def _on_looked_through(self, wish: ProtocolWish, operator: str) -> None:
        now, clinic, choices = self._wish, _clinic(wish, operator), self._choices
        if now is None or _clinic(now, operator) != clinic:
            return
        if choices.later is not None and choices.later.operator == operator:
            self._measure(now)
        if choices.operator == operator:
            self._show_repeats(wish, operator)

    def _show_repeats(self, wish: ProtocolWish, operator: str) -> None:
        clinic = _clinic(wish, operator)
        if clinic in self._known:
            self._view.show_repeats(_repeats(self._known[clinic]))
        else:
            sentence = _(LOOKING) if clinic in self._looking else _(STOPPED)
            self._view.show_repeats(Repeats(wish.protocol, (), sentence))

    def _start(
        self,
        name: str,
        label: str,
        work: Callable[[JobControl], Result],
        done: Callable[[Result], None],
        ended: Callable[[], None] | None = None,
    ) -> None:
        """Start a job in place of one of the same name that still runs."""
        before = self._jobs.get(name)
        if before is not None and before.is_running:
            before.cancel()
        self._jobs[name] = self._workspace.jobs.start(label, work, done, None, ended)


def _clinic(wish: ProtocolWish, operator: str) -> Clinic:
    return wish.protocol.protocol_id, wish.protocol.revision, operator


def _nothing_more(_nothing: None) -> None:
    """Do nothing: all is told when the job has ended."""


def _repeats(found: ClinicReliability) -> Repeats:
    rows = tuple(found.by_measure.items())
    return Repeats(found.wish.protocol, rows, "" if rows else _(NO_REPEATS))


def _notes(found: PatientTrends) -> tuple[str, ...]:
    notes = []
    if found.n_other_protocol:
        notes.append(
            translate_plural(
                "{n} session follows another protocol and is left out.",
                "{n} sessions follow another protocol and are left out.",
                found.n_other_protocol,
            ).format(n=found.n_other_protocol)
        )
    if found.n_without:
        notes.append(
            translate_plural(
                "{n} session has no measure of this protocol.",
                "{n} sessions have no measure of this protocol.",
                found.n_without,
            ).format(n=found.n_without)
        )
    return tuple(notes)
