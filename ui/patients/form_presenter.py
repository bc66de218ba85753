"""What is typed of a patient and of a consent: checked, then saved. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime
from functools import partial
from typing import TYPE_CHECKING, Protocol

from adibas.data.patients import Consent, Identity, Patient, allow_capture
from adibas.sessions.search_text import simplified
from adibas.texts import translate as _
from ui.orders.presenter import has_work_list
from ui.patients.content import (
    CHILD_BELOW_YEARS,
    ConsentEntry,
    Draft,
    EntryError,
    PatientEntry,
    read_birth_date,
)
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.exchange.orders import Order
    from adibas.sessions.conflicts import Decision


class FormView(Protocol):
    """The form in the place of the chosen patient, as this presenter needs it."""

    def show_entry(self, entry: PatientEntry, *, is_new: bool) -> None:
        """Open the form with a patient; a new one is asked for consent, too."""

    def offer_work_list(self, *, has_work_list: bool) -> None:
        """Offer to take new patients from a work list, or not."""

    def show_consents(self, patient: Patient) -> None:
        """Open the form of a patient's consents."""

    def show_consent(self, entry: ConsentEntry) -> None:
        """Fill in the consent of the open form."""

    def typed(self) -> tuple[PatientEntry | None, ConsentEntry | None] | None:
        """Return what stands in the open form, or None where no form is open."""

    def show_age(self, age_years: int | None) -> None:
        """Show the age that goes with the birth date that is typed."""

    def propose_guardian(self, *, is_guardian: bool) -> None:
        """Ask for a guardian's consent, or for the patient's own."""

    def show_problem(self, field: str, sentence: str) -> None:
        """Say at a field what is wrong with it; nothing was saved."""

    def close_form(self) -> None:
        """Show the chosen patient again."""


_Typed = tuple[PatientEntry | None, ConsentEntry | None]


@dataclass(eq=False)
class _Form:
    """A form from its opening until it is saved or cancelled.

    Attributes
    ----------
    edited : Patient or None
        Whom it changes, as she was seen; None while a new patient is not saved.
    warned_of : Identity or None
        Whose likeness to somebody the user was warned of.
    back_to : str
        The screen that waits for a consent; empty where none does.
    opened : tuple or None
        What stood in it before anything was typed; None where that is unknown.
    """

    edited: Patient | None
    is_new: bool
    warned_of: Identity | None = None
    back_to: str = ""
    opened: _Typed | None = None


class FormPresenter:
    """Adds and changes patients, gives and withdraws consents.

    Parameters
    ----------
    saved : callable
        Told of each change.
    withdrawn : callable
        Told, after that, of each consent that was withdrawn.
    """

    def __init__(
        self,
        view: FormView,
        workspace: Workspace,
        saved: Callable[[], None],
        now: Callable[[], datetime] = lambda: datetime.now(UTC),
        withdrawn: Callable[[], None] = lambda: None,
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._saved = saved
        self._now = now
        self._withdrawn = withdrawn
        self._form: _Form | None = None
        self._end = workspace.consent_wanted.subscribe(self._want_consent)

    def close(self) -> None:
        """Listen no more."""
        self._end()

    def add(self) -> None:
        """Open the form for a new patient."""
        if not self._workspace.store.is_read_only:
            self._view.offer_work_list(has_work_list=has_work_list())
            self._open(None, PatientEntry(), is_new=True)

    def edit(self) -> None:
        """Open the form with the chosen patient."""
        patient = self._workspace.patient
        if patient is None or self._workspace.store.is_read_only:
            return
        self._open(patient, _entry_of(patient))
        self._view.show_age(patient.age_years(self._today()))

    def edit_consents(self) -> None:
        """Open the form of the chosen patient's consents."""
        self._open_consents("")

    def _want_consent(self, back_to: str) -> None:
        """Open the form of consents for a screen that waits; what is being typed stays open."""
        if self._form is not None:
            self._workspace.tell(
                "warning", _("Save or cancel what is being typed, then record the consent.")
            )
            return
        self._open_consents(back_to)

    def _open_consents(self, back_to: str) -> None:
        patient = self._workspace.patient
        if patient is not None and not self._workspace.store.is_read_only:
            self._open(patient, None, back_to=back_to)

    def take_over(self, order: "Order") -> None:
        """Fill the form of a new patient with whom an order is of; it is saved as typed."""
        form = self._form
        if form is not None and form.edited is None:
            entry = _ordered_entry(order)
            self._open(None, entry, is_new=True, is_saved=False)
            self.note_birth_date(entry.birth_date)

    @property
    def is_unsaved(self) -> bool:
        """Whether anything was typed into the open form."""
        return self._form is not None and self._view.typed() != self._form.opened

    def draft(self) -> str:
        """Return the open form as it stands; nothing where none is open."""
        typed, form = self._view.typed(), self._form
        if typed is None or form is None:
            return ""
        edited = None if form.edited is None else form.edited.pseudonym
        seen = None if form.edited is None else _entry_of(form.edited)
        return Draft(edited, *typed, is_new=form.is_new, seen=seen).to_text()

    def take_back(self, text: str) -> None:
        """Open a form as it stood; that a patient is gone meanwhile is told."""
        draft = Draft.from_text(text)
        self._workspace.attempt(lambda: self._open_again(draft))

    def cancel(self) -> None:
        """Forget what was typed, also where it was to be tried again."""
        self._form = None
        self._workspace.withdraw_retry()
        self._view.close_form()

    def note_birth_date(self, text: str) -> None:
        """Follow the birth date while it is typed: the age, and who has to consent."""
        try:
            born = read_birth_date(text, self._today())
        except EntryError:
            self._view.show_age(None)
            return
        identity = Identity("-", born)
        self._view.show_age(identity.age_years(self._today()))
        self._view.propose_guardian(is_guardian=self._is_child(identity))

    def save(self, entry: PatientEntry, consent: ConsentEntry | None = None) -> None:
        """Save the patient, with a consent where one is given; what is wrong is said first."""
        form = self._form
        if form is None:
            return
        try:
            identity = self._identity(entry)
            given = None if consent is None else self._consent(consent, identity.name)
            self._warn_of_likeness(form, identity)
        except EntryError as error:
            self._view.show_problem(error.field, error.sentence)
            return
        self._workspace.save_shared(partial(self._write, form, identity, entry, given))

    def give(self, entry: ConsentEntry) -> None:
        """Save a consent of the chosen patient."""
        form = self._form
        if form is None or form.edited is None:
            return
        patient = form.edited
        try:
            consent = self._consent(entry, patient.identity.name)
        except EntryError as error:
            self._view.show_problem(error.field, error.sentence)
            return
        patients = self._workspace.store.patients
        self._workspace.attempt(
            lambda: self._finish(form, patients.give_consent(patient.pseudonym, consent))
        )

    def withdraw(self, index: int) -> None:
        """Note that a consent of the chosen patient stands no more."""
        form, patients = self._form, self._workspace.store.patients
        if form is None or form.edited is None:
            return
        pseudonym = form.edited.pseudonym
        if self._workspace.attempt(
            lambda: self._finish(form, patients.withdraw_consent(pseudonym, index))
        ):
            self._withdrawn()

    def _open(
        self,
        patient: Patient | None,
        entry: PatientEntry | None,
        *,
        is_new: bool = False,
        back_to: str = "",
        is_saved: bool = True,
    ) -> None:
        """Open the form of a patient, or of her consents; what is not saved yet counts as typed."""
        form = self._form = _Form(patient, is_new, back_to=back_to)
        if entry is not None:
            self._view.show_entry(entry, is_new=is_new)
        elif patient is not None:
            self._view.show_consents(patient)
            self._view.propose_guardian(is_guardian=self._is_child(patient.identity))
        form.opened = self._view.typed() if is_saved else None

    def _open_again(self, draft: Draft) -> None:
        edited = draft.edited
        patient = None if edited is None else self._workspace.store.patients.get(edited)
        if patient is not None and draft.seen is not None:  # others may have changed her meanwhile
            seen = draft.seen
            identity = self._identity(seen)
            patient = replace(patient, identity=identity, sex=seen.sex, notes=seen.notes)
        self._open(patient, draft.entry, is_new=draft.is_new, is_saved=False)
        if draft.entry is not None:
            self.note_birth_date(draft.entry.birth_date)
        if draft.consent is not None:
            self._view.show_consent(draft.consent)

    def _write(
        self,
        form: _Form,
        identity: Identity,
        entry: PatientEntry,
        consent: Consent | None,
        decisions: "tuple[Decision, ...]",
    ) -> None:
        patients = self._workspace.store.patients
        if form.edited is None:
            patient = patients.add(identity, sex=entry.sex, notes=entry.notes.strip())
            form.edited = patient  # a second attempt after a failed consent adds nobody
        else:
            patient = patients.change(
                form.edited.pseudonym,
                identity=identity,
                sex=entry.sex,
                notes=entry.notes.strip(),
                seen=form.edited,
                decisions=decisions,
            )
        if consent is not None:
            patient = patients.give_consent(patient.pseudonym, consent)
        self._finish(form, patient)

    def _finish(self, form: _Form, patient: Patient) -> None:
        """Show who was saved, unless the form was left meanwhile: another one may be open."""
        if form is self._form:
            self._form = None
            self._workspace.choose_patient(patient)
            self._view.close_form()
            self._go_back(form, patient)
        self._saved()

    def _go_back(self, form: _Form, patient: Patient) -> None:
        """Show the screen that waited for a consent, once there is the one that it needs."""
        if form.back_to and allow_capture(patient.consents):
            self._workspace.tell("good", _("The consent is recorded: a capture can be made."))
            self._workspace.show_screen(form.back_to)

    def _identity(self, entry: PatientEntry) -> Identity:
        if not entry.name.strip():
            raise EntryError("name", _("Type the patient's name."))
        born = read_birth_date(entry.birth_date, self._today())
        return Identity(entry.name.strip(), born, entry.record_number.strip())

    def _consent(self, entry: ConsentEntry, name: str) -> Consent:
        if not entry.purposes:
            raise EntryError("purposes", _("Choose what the consent is for."))
        if entry.is_guardian and not entry.guardian.strip():
            raise EntryError("guardian", _("Type the name of the guardian who consents."))
        given_by = entry.guardian.strip() if entry.is_guardian else name
        return Consent(entry.purposes, given_by, entry.is_guardian, self._now())

    def _warn_of_likeness(self, form: _Form, identity: Identity) -> None:
        """Refuse once what looks like a patient who is there already."""
        if identity == form.warned_of or not self._is_alike_another(form.edited, identity):
            return
        form.warned_of = identity
        raise EntryError(
            "name",
            _(
                "A patient with this record number, or with this name and birth date, is there "
                "already. Save again if this is somebody else."
            ),
        )

    def _is_alike_another(self, patient: Patient | None, identity: Identity) -> bool:
        from adibas.sessions.patients import ALL_OF_THEM

        own = None if patient is None else patient.pseudonym
        search = self._workspace.store.patients.search
        for text in filter(None, (identity.record_number, identity.name)):
            for row in search(text, limit=ALL_OF_THEM):
                if row.pseudonym != own and _is_alike(row.identity, identity):
                    return True
        return False

    def _is_child(self, identity: Identity) -> bool:
        age_years = identity.age_years(self._today())
        return age_years is not None and age_years < CHILD_BELOW_YEARS

    def _today(self) -> date:
        return self._now().astimezone().date()


def _entry_of(patient: Patient) -> PatientEntry:
    """Return a patient as the form shows her."""
    identity, born = patient.identity, patient.identity.birth_date
    return PatientEntry(
        identity.name,
        "" if born is None else f"{born:%d/%m/%Y}",
        identity.record_number,
        patient.sex,
        patient.notes,
    )


def _ordered_entry(order: "Order") -> PatientEntry:
    """Return whom an order is of, as the form shows her."""
    from adibas.exchange.orders import ordered_person

    person = ordered_person(order)
    born = "" if person.birth_date is None else f"{person.birth_date:%d/%m/%Y}"
    return PatientEntry(person.name, born, person.record_number, person.sex)


def _is_alike(one: Identity, other: Identity) -> bool:
    has_number = bool(one.record_number) and one.record_number == other.record_number
    names = (simplified(one.name), simplified(other.name))
    return has_number or (names[0] == names[1] and one.birth_date == other.birth_date)
