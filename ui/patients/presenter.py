"""Which patients are listed, who is chosen, hidden and shown again. Knows nothing of Qt."""

from collections.abc import Callable
from datetime import date
from typing import Protocol

from adibas.data.patients import Patient
from adibas.errors import AdibasError
from adibas.sessions.roles import Permission
from adibas.texts import translate as _
from ui.patients.content import (
    PatientLine,
    PurgeQuestion,
    ShownPatient,
    UndoOffer,
    consent_state,
)
from ui.patients.undo import Undo
from ui.workspace import Workspace

MOST_LISTED = 200


class PatientListView(Protocol):
    """The list at the left, as this presenter needs it."""

    def show_patients(self, lines: tuple[PatientLine, ...], *, is_cut: bool) -> None:
        """List what the search found; `is_cut` where there are more."""

    def show_chosen(self, pseudonym: str | None) -> None:
        """Mark a patient in the list, if it is there."""

    def show_rights(self, *, is_read_only: bool, sees_all_names: bool) -> None:
        """Say whether patients can be added and changed, and by how little they are found."""


class PatientView(Protocol):
    """The chosen patient at the right, as this presenter needs it."""

    def show_patient(self, shown: ShownPatient | None) -> None:
        """Show a patient, or that none is chosen."""

    def ask_purge(self, question: PurgeQuestion) -> None:
        """Ask for the word that confirms a removal for good."""


class PatientsPresenter:
    """Searches with every key; what is chosen becomes the workspace's patient."""

    def __init__(
        self,
        views: tuple[PatientListView, PatientView],
        workspace: Workspace,
        undo: Undo,
        today: Callable[[], date] = date.today,
    ) -> None:
        self._list, self._details = views
        self._workspace = workspace
        self._undo = undo
        self._today = today
        self._text = ""
        self._has_deleted = False
        self._is_seen = False
        self._ends = (
            workspace.patient_changed.subscribe(self._on_patient),
            workspace.session_changed.subscribe(self._on_session),
            undo.hidden_changed.subscribe(self.refresh),
        )
        self._list.show_rights(
            is_read_only=workspace.store.is_read_only,
            sees_all_names=workspace.store.may(Permission.SEE_ALL_NAMES),
        )
        self._details.show_patient(None)

    def close(self) -> None:
        """Listen no more."""
        for end in self._ends:
            end()

    def enter(self) -> None:
        """Show the store as it is now, and follow what other screens do."""
        self._is_seen = True
        self.refresh()

    def leave(self) -> None:
        """Wait until the screen is seen again."""
        self._is_seen = False

    def refresh(self) -> None:
        """List anew and show the chosen patient as it is in the store now."""
        self._search()
        self._reload()
        self._show_chosen()

    def search(self, text: str) -> None:
        """List the patients in whom every word of `text` is found."""
        self._text = text
        self._search()
        self._list.show_chosen(self._pseudonym())

    def show_deleted(self, *, is_wanted: bool) -> None:
        """List hidden patients, too, or no longer."""
        self._has_deleted = is_wanted
        self.search(self._text)

    def choose(self, pseudonym: str) -> None:
        """Look at a patient."""
        if pseudonym != self._pseudonym():
            store, choose = self._workspace.store, self._workspace.choose_patient
            self._workspace.attempt(lambda: choose(store.patients.get(pseudonym)))

    def delete(self) -> None:
        """Hide the chosen patient; it can be undone."""
        patient = self._workspace.patient
        if patient is None or patient.is_deleted or self._workspace.store.is_read_only:
            return
        patients, pseudonym = self._workspace.store.patients, patient.pseudonym
        if self._workspace.attempt(lambda: patients.delete(pseudonym)):
            if not self._has_deleted:
                self._workspace.choose_patient(None)
            offer = UndoOffer("patient", patient.identity.name)
            self._undo.offer(offer, lambda: self._show_again(pseudonym))

    def restore(self) -> None:
        """Show the chosen, hidden patient again."""
        pseudonym = self._pseudonym()
        if pseudonym is not None and self._workspace.attempt(lambda: self._show_again(pseudonym)):
            self._undo.forget()

    def ask_purge(self) -> None:
        """Ask whether the chosen, hidden patient is to be removed for good."""
        patient = self._workspace.patient
        if patient is not None and patient.is_deleted:
            self._ask_purge(patient)

    def ask_removal(self) -> None:
        """Ask whether the chosen patient, hidden or not, is to be removed for good."""
        if self._workspace.patient is not None:
            self._ask_purge(self._workspace.patient)

    def _ask_purge(self, patient: Patient) -> None:
        of_patient = self._workspace.store.sessions.of_patient
        n_sessions = len(of_patient(patient.pseudonym, with_deleted=True))
        self._details.ask_purge(
            PurgeQuestion(
                "patient", patient.identity.name, n_sessions, None, word=patient.pseudonym
            )
        )

    def purge(self, pseudonym: str) -> None:
        """Remove a patient for good; the user typed its pseudonym."""
        patients = self._workspace.store.patients

        def gone(_nothing: None) -> None:
            if self._pseudonym() == pseudonym:
                self._workspace.choose_patient(None)
            self._undo.forget()
            self._workspace.tell("good", _("The patient was removed for good."))

        self._workspace.jobs.start(
            _("Removing a patient for good"),
            lambda _control: patients.purge(pseudonym),
            gone,
            stop="never",
        )

    def _show_again(self, pseudonym: str) -> None:
        patients = self._workspace.store.patients
        patients.restore(pseudonym)
        self._workspace.choose_patient(patients.get(pseudonym))

    def _pseudonym(self) -> str | None:
        patient = self._workspace.patient
        return None if patient is None else patient.pseudonym

    def _on_patient(self) -> None:
        if self._is_seen:
            self._show_chosen()

    def _on_session(self) -> None:
        if self._is_seen:
            self.search(self._text)  # the number of sessions may be another one

    def _search(self) -> None:
        self._workspace.attempt(self._list_found)

    def _list_found(self) -> None:
        found = self._workspace.store.patients.search(
            self._text, limit=MOST_LISTED + 1, with_deleted=self._has_deleted
        )
        today = self._today()
        lines = [PatientLine(row, row.identity.age_years(today)) for row in found[:MOST_LISTED]]
        self._list.show_patients(tuple(lines), is_cut=len(found) > MOST_LISTED)

    def _reload(self) -> None:
        """Let the workspace have the chosen patient's new content; one that is gone is left."""
        pseudonym = self._pseudonym()
        if pseudonym is None:
            return
        try:
            patient = self._workspace.store.patients.get(pseudonym)
        except AdibasError as error:
            self._workspace.report_problem(error)
            self._workspace.choose_patient(None)
            return
        if patient != self._workspace.patient:
            self._workspace.choose_patient(patient)

    def _show_chosen(self) -> None:
        patient = self._workspace.patient
        self._list.show_chosen(self._pseudonym())
        if patient is None:
            self._details.show_patient(None)
            return
        self._details.show_patient(
            ShownPatient(
                patient,
                patient.age_years(self._today()),
                consent_state(patient),
                can_change=not self._workspace.store.is_read_only,
            )
        )
