"""The chosen patient at the right: who it is, and whether there is a consent."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QLabel, QPushButton, QVBoxLayout, QWidget

from adibas.data.patients import PURPOSE_OF_CAPTURE, Consent
from adibas.sessions.audit_words import PURPOSE_NAMES
from adibas.sessions.roles import Permission
from adibas.texts import message
from adibas.texts import translate as _
from ui.patients.content import PurgeQuestion, ShownPatient
from ui.patients.patients_model import age_text
from ui.patients.purge_dialog import purge_dialog
from ui.widgets.dates import day_text
from ui.widgets.flow import in_a_flow
from ui.widgets.look import show_kind

SEX_NAMES = {"": message("Not told"), "female": message("Female"), "male": message("Male")}
MOST_LETTERS = 240
"""Of the notes; all of them are in the tooltip and in the form."""


class PatientPanel(QWidget):
    """Name and facts, consent, and what can be done with the patient."""

    edit_asked = Signal()
    consents_asked = Signal()
    delete_asked = Signal()
    restore_asked = Signal()
    purge_asked = Signal()
    purge_confirmed = Signal(str)
    """A pseudonym."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shown: ShownPatient | None = None
        self._name, self._facts, self._notes, self._consent, self._deleted = (
            QLabel(self) for _number in range(5)
        )
        self._edit, self._consents, self._delete, self._restore, self._purge = (
            QPushButton(self) for _number in range(5)
        )
        self._name.setProperty("kind", "title")
        self._facts.setProperty("kind", "quiet")
        self._deleted.setProperty("kind", "warning")
        self._purge.setProperty("danger", "true")
        column = QVBoxLayout(self)
        for button, asked in (
            (self._edit, self.edit_asked),
            (self._consents, self.consents_asked),
            (self._delete, self.delete_asked),
            (self._restore, self.restore_asked),
            (self._purge, self.purge_asked),
        ):
            button.clicked.connect(asked)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        for label in (self._name, self._facts, self._notes, self._deleted, self._consent):
            label.setWordWrap(True)
            label.setTextFormat(Qt.TextFormat.PlainText)
            column.addWidget(label)
        buttons = (self._edit, self._consents, self._delete, self._restore, self._purge)
        column.addLayout(in_a_flow(*buttons))

    def for_roles(self) -> tuple[tuple[QWidget, Permission], ...]:
        """Return the buttons that are not for everybody."""
        changing = (self._edit, self._delete, self._restore)
        return (
            *((button, Permission.CHANGE_PATIENTS) for button in changing),
            (self._purge, Permission.PURGE),
        )

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._edit.setText(_("&Edit"))
        self._edit.setToolTip(_("Change name, birth date, notes ... (F2)"))
        self._consents.setText(_("C&onsent"))
        self._consents.setToolTip(_("Give or withdraw a consent"))
        self._delete.setText(_("De&lete"))
        self._delete.setToolTip(_("Hide the patient; it can be undone (Delete, in the list)"))
        self._restore.setText(_("&Restore"))
        self._purge.setText(_("Remove for &good"))
        self._deleted.setText(_("This patient was deleted and is hidden. Restore it to go on."))
        self.show_patient(self._shown)

    def show_patient(self, shown: ShownPatient | None) -> None:
        self._shown = shown
        if shown is None:
            return
        patient = shown.patient
        self._name.setText(patient.identity.name)
        self._facts.setText(_facts(shown))
        self._notes.setText(_shortened(patient.notes))
        self._notes.setToolTip(patient.notes if len(patient.notes) > MOST_LETTERS else "")
        self._notes.setVisible(bool(patient.notes))
        self._consent.setText(_consent_text(shown))
        show_kind(self._consent, "quiet" if shown.consent == "given" else "warning")
        self._deleted.setVisible(patient.is_deleted)
        self._consent.setVisible(not patient.is_deleted)
        for button in (self._edit, self._consents, self._delete):
            button.setVisible(not patient.is_deleted)
        for button in (self._restore, self._purge):
            button.setVisible(patient.is_deleted)
        for button in self.findChildren(QPushButton):
            button.setEnabled(shown.can_change)

    def edit(self) -> None:
        """Press the button that changes the patient, where it is seen."""
        if self._edit.isVisible():
            self._edit.click()

    def delete(self) -> None:
        """Press the button that hides the patient, where it is seen."""
        if self._delete.isVisible():
            self._delete.click()

    def ask_purge(self, question: PurgeQuestion) -> None:
        dialog = purge_dialog(question, self)
        dialog.confirmed.connect(lambda: self.purge_confirmed.emit(question.word))
        dialog.open()


def _facts(shown: ShownPatient) -> str:
    patient = shown.patient
    facts = (
        day_text(patient.identity.birth_date),
        age_text(shown.age_years),
        _(SEX_NAMES[patient.sex]) if patient.sex else "",
        patient.identity.record_number,
        patient.pseudonym,
    )
    return "  ·  ".join(fact for fact in facts if fact)


def _consent_text(shown: ShownPatient) -> str:
    standing = [one for one in shown.patient.consents if one.is_standing]
    if not standing and not shown.can_change:
        return _("No consent stands on record.")
    if shown.consent == "none":
        return _("No consent is on record. Record one for treatment before the first session.")
    if shown.consent == "withdrawn":
        return _("The consent was withdrawn: nothing can be captured without a new one.")
    if shown.consent == "other":
        lack = _("Nothing can be captured without one for treatment.")
        return f"{consent_text(standing[-1])} {lack}"
    return consent_text([one for one in standing if PURPOSE_OF_CAPTURE in one.purposes][-1])


def consent_text(consent: Consent) -> str:
    """Return what was consented to, by whom and when."""
    fields = {
        "purposes": ", ".join(_(PURPOSE_NAMES[one]) for one in consent.purposes),
        "name": consent.given_by,
        "day": day_text(consent.given_utc.astimezone().date()),
    }
    if consent.is_guardian:
        return _("Consent: {purposes}. Given by the guardian {name} on {day}.").format(**fields)
    return _("Consent: {purposes}. Given by the patient on {day}.").format(**fields)


def _shortened(notes: str) -> str:
    return notes if len(notes) <= MOST_LETTERS else notes[:MOST_LETTERS].rstrip() + " ..."
