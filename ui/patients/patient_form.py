"""The form of a patient: name, birth date, record number, sex, notes, and a first consent."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QComboBox,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.data.patients import SEXES
from adibas.texts import translate as _
from ui.patients.consent_fields import ConsentFields
from ui.patients.content import PatientEntry
from ui.patients.patient_panel import SEX_NAMES
from ui.patients.patients_model import age_text


class PatientForm(QWidget):
    """Enter in a line saves, Escape cancels."""

    saved = Signal(object, object)
    """A `PatientEntry`, and a `ConsentEntry` or None."""
    cancelled = Signal()
    birth_date_typed = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._is_new = True
        self._age_years: int | None = None
        self._title, self._problem, self._age = (QLabel(self) for _number in range(3))
        self._name, self._birth_date, self._record_number = (QLineEdit(self) for _n in range(3))
        self._sex, self._notes = QComboBox(self), QPlainTextEdit(self)
        self._labels = {
            field: QLabel(self)
            for field in (
                self._name,
                self._birth_date,
                self._record_number,
                self._sex,
                self._notes,
            )
        }
        self._consents = QGroupBox(self)
        self._consent = ConsentFields(self._consents)
        self._save, self._cancel = QPushButton(self), QPushButton(self)
        for _sex in SEXES:
            self._sex.addItem("")
        self._lay_out()
        self._connect()

    def _lay_out(self) -> None:
        self._title.setProperty("kind", "title")
        self._problem.setProperty("kind", "bad")
        self._age.setProperty("kind", "quiet")
        self._problem.setWordWrap(True)
        self._save.setProperty("main", "true")
        self._notes.setTabChangesFocus(True)
        self._notes.setMinimumHeight(64)
        self._consents.setCheckable(True)
        inner = QVBoxLayout(self._consents)
        inner.addWidget(self._consent)
        column, buttons = QVBoxLayout(self), QHBoxLayout()
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(6)
        column.addWidget(self._title)
        for field, label in self._labels.items():
            label.setBuddy(field)
            column.addSpacing(4)
            column.addWidget(label)
            column.addWidget(field)
            if field is self._birth_date:
                column.addWidget(self._age)
        column.addSpacing(8)
        column.addWidget(self._consents)
        column.addStretch(1)
        column.addWidget(self._problem)
        buttons.addStretch(1)
        buttons.addWidget(self._cancel)
        buttons.addWidget(self._save)
        column.addLayout(buttons)

    def _connect(self) -> None:
        for line in (self._name, self._birth_date, self._record_number, self._consent.guardian):
            line.returnPressed.connect(self.save)
        for button in (self._save, self._cancel):
            button.setAutoDefault(True)
        self._birth_date.textChanged.connect(self.birth_date_typed)
        self._consents.toggled.connect(self._consent.setVisible)
        self._save.clicked.connect(self.save)
        self._cancel.clicked.connect(self.cancelled)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._title.setText(_("New patient") if self._is_new else _("Change the patient"))
        for field, text in (
            (self._name, _("N&ame")),
            (self._birth_date, _("&Birth date (may stay empty)")),
            (self._record_number, _("&Record number")),
            (self._sex, _("Se&x")),
            (self._notes, _("No&tes")),
        ):
            self._labels[field].setText(text)
        self._birth_date.setPlaceholderText(_("day/month/year"))
        for index, sex in enumerate(SEXES):
            self._sex.setItemText(index, _(SEX_NAMES[sex]))
        self._consents.setTitle(_("A &consent was given"))
        self._consent.retranslate()
        self._save.setText(_("&Save"))
        self._save.setToolTip(_("Save the patient (Enter)"))
        self._cancel.setText(_("Cancel"))
        self._cancel.setToolTip(_("Forget what was typed (Esc)"))
        self.show_age(self._age_years)

    def show_entry(self, entry: PatientEntry, *, is_new: bool) -> None:
        """Show what is known; a new patient is asked for consent, too."""
        self._is_new = is_new
        self._problem.hide()
        self._consent.clear()
        self._consents.setVisible(is_new)
        self._consents.setChecked(False)
        self._consent.hide()
        self.show_age(None)
        self._name.setText(entry.name)
        self._birth_date.setText(entry.birth_date)
        self._record_number.setText(entry.record_number)
        self._sex.setCurrentIndex(SEXES.index(entry.sex))
        self._notes.setPlainText(entry.notes)
        self.retranslate()
        self._name.setFocus()

    def show_age(self, age_years: int | None) -> None:
        """Show how old the patient is."""
        self._age_years = age_years
        self._age.setText(age_text(age_years))
        self._age.setVisible(age_years is not None)

    def propose_guardian(self, *, is_guardian: bool) -> None:
        """Ask for a guardian's consent, or for the patient's own."""
        self._consent.propose_guardian(is_guardian=is_guardian)

    def show_problem(self, field: str, sentence: str) -> None:
        """Say what is wrong, and lead to where."""
        self._problem.setText(sentence)
        self._problem.show()
        lines = {"name": self._name, "birth_date": self._birth_date}
        widget = lines.get(field) or self._consent.field(field)
        if widget is not None:
            widget.setFocus()

    def cancel(self) -> None:
        """Press the button that forgets what was typed."""
        self._cancel.click()

    def save(self) -> None:
        """Send what is entered."""
        self._problem.hide()
        entry = PatientEntry(
            self._name.text(),
            self._birth_date.text(),
            self._record_number.text(),
            SEXES[self._sex.currentIndex()],
            self._notes.toPlainText(),
        )
        has_consent = self._is_new and self._consents.isChecked()
        self.saved.emit(entry, self._consent.entry() if has_consent else None)
