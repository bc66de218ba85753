"""The form of a patient: name, birth date, record number, sex, notes, and a first consent."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QGroupBox,
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
from ui.patients.content import ConsentEntry, PatientEntry
from ui.patients.form_footer import lay_out_footer
from ui.patients.patient_panel import SEX_NAMES
from ui.patients.patients_model import age_text
from ui.widgets.flow import in_a_flow

NOTES_LINES = 4


class PatientForm(QWidget):
    """Enter in a line saves, Escape cancels."""

    saved = Signal(object, object)
    """A `PatientEntry`, and a `ConsentEntry` or None."""
    cancelled = Signal()
    birth_date_typed = Signal(str)
    work_list_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._is_new = True
        self._age_years: int | None = None
        self._title, self._problem, self._age = (QLabel(self) for _number in range(3))
        self._name, self._birth_date, self._record_number = (QLineEdit(self) for _n in range(3))
        self._sex, self._notes = QComboBox(self), QPlainTextEdit(self)
        self._labels: dict[QWidget, QLabel] = {
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
        self.footer = QWidget(self)
        self._save, self._cancel = QPushButton(self.footer), QPushButton(self.footer)
        self._work_list = QPushButton(self)
        self._has_work_list = False
        for _sex in SEXES:
            self._sex.addItem("")
        self._lay_out()
        self._connect()

    def _lay_out(self) -> None:
        self._title.setProperty("kind", "title")
        self._age.setProperty("kind", "quiet")
        self._notes.setTabChangesFocus(True)
        self._notes.setFixedHeight(NOTES_LINES * self._notes.fontMetrics().lineSpacing())
        self._consents.setCheckable(True)
        inner = QVBoxLayout(self._consents)
        inner.addWidget(self._consent)
        column = QVBoxLayout(self)
        column.setSpacing(8)
        column.addWidget(self._title)
        column.addLayout(in_a_flow(self._work_list))
        pairs = QGridLayout()
        pairs.setSpacing(8)
        self._place(pairs, self._name, 0, 0, 2)
        self._place(pairs, self._birth_date, 2, 0, 1)
        pairs.addWidget(self._age, 3, 1)
        self._place(pairs, self._record_number, 4, 0, 1)
        self._place(pairs, self._sex, 4, 1, 1)
        self._place(pairs, self._notes, 6, 0, 2)
        column.addLayout(pairs)
        column.addSpacing(8)
        column.addWidget(self._consents)
        column.addStretch(1)
        lay_out_footer(self.footer, self._problem, self._cancel, self._save)

    def _place(self, pairs: QGridLayout, field: QWidget, row: int, column: int, n: int) -> None:
        """Put a field below its label."""
        label = self._labels[field]
        label.setBuddy(field)
        label.setWordWrap(True)
        pairs.addWidget(label, row, column, 1, n)
        pairs.addWidget(field, row + 1, column, 1, n)

    def _connect(self) -> None:
        for line in (self._name, self._birth_date, self._record_number, self._consent.guardian):
            line.returnPressed.connect(self.save)
        self._birth_date.textChanged.connect(self.birth_date_typed)
        self._consents.toggled.connect(self._consent.setVisible)
        self._work_list.clicked.connect(self.work_list_asked)
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
        self._work_list.setText(_("From the work list..."))
        self._work_list.setToolTip(_("Take a patient over from the orders of the clinic"))
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
        self._work_list.setVisible(is_new and self._has_work_list)
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

    def offer_work_list(self, *, has_work_list: bool) -> None:
        """Offer new patients from a work list from now on, or no longer."""
        self._has_work_list = has_work_list

    def show_consent(self, entry: ConsentEntry) -> None:
        """Show the consent that was entered before."""
        self._consents.setChecked(True)
        self._consent.show_entry(entry)

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
        self.saved.emit(*self.typed())

    def typed(self) -> tuple[PatientEntry, ConsentEntry | None]:
        """Return what is entered; the consent where one was given."""
        entry = PatientEntry(
            self._name.text(),
            self._birth_date.text(),
            self._record_number.text(),
            SEXES[self._sex.currentIndex()],
            self._notes.toPlainText(),
        )
        has_consent = self._is_new and self._consents.isChecked()
        return entry, self._consent.entry() if has_consent else None
