"""The consents of a patient: those given, each with a button that withdraws it, and a new one."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QGroupBox, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from adibas.data.patients import Consent, Patient
from adibas.texts import translate as _
from ui.patients.consent_fields import ConsentFields
from ui.patients.form_footer import lay_out_footer
from ui.patients.patient_panel import consent_text
from ui.widgets.dates import day_text
from ui.widgets.flow import in_a_flow


class ConsentForm(QWidget):
    """Enter in the guardian's name gives the consent, Escape cancels."""

    given = Signal(object)
    """A `ConsentEntry`."""
    withdrawn = Signal(int)
    """Which of the patient's consents."""
    cancelled = Signal()
    holdings_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._patient: Patient | None = None
        self._lines: list[QWidget] = []
        self._title, self._name, self._problem = (QLabel(self) for _number in range(3))
        self._old, self._new = QVBoxLayout(), QGroupBox(self)
        self.fields = ConsentFields(self._new)
        self.footer = QWidget(self)
        self._give, self._cancel = QPushButton(self.footer), QPushButton(self.footer)
        self._held = QPushButton(self)
        self._title.setProperty("kind", "title")
        self._lay_out()
        self.fields.guardian.returnPressed.connect(self.give)
        self._give.clicked.connect(self.give)
        self._cancel.clicked.connect(self.cancelled)
        self._held.clicked.connect(self.holdings_asked)

    def _lay_out(self) -> None:
        self._name.setWordWrap(True)
        inner = QVBoxLayout(self._new)
        inner.addWidget(self.fields)
        column = QVBoxLayout(self)
        column.setSpacing(8)
        column.addWidget(self._title)
        column.addWidget(self._name)
        column.addLayout(self._old)
        column.addLayout(in_a_flow(self._held))
        column.addSpacing(8)
        column.addWidget(self._new)
        column.addStretch(1)
        lay_out_footer(self.footer, self._problem, self._cancel, self._give)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._title.setText(_("Consents"))
        self._new.setTitle(_("A new consent"))
        self._give.setText(_("&Save the consent"))
        self._cancel.setText(_("Cancel"))
        self._held.setText(_("&What is held..."))
        self._held.setToolTip(
            _("List everything that is held of the patient, and what left the store")
        )
        self.fields.retranslate()
        if self._patient is not None:
            self._show_old(self._patient)

    def show_patient(self, patient: Patient) -> None:
        """Show a patient's consents."""
        self._patient = patient
        self._problem.hide()
        self._name.setText(patient.identity.name)
        self.fields.clear()
        self.retranslate()
        self._give.setFocus()

    def show_problem(self, field: str, sentence: str) -> None:
        """Say what is wrong, and lead to where."""
        self._problem.setText(sentence)
        self._problem.show()
        widget = self.fields.field(field)
        if widget is not None:
            widget.setFocus()

    def cancel(self) -> None:
        """Press the button that forgets what was entered."""
        self._cancel.click()

    def give(self) -> None:
        """Send what is entered."""
        self._problem.hide()
        self.given.emit(self.fields.entry())

    def _show_old(self, patient: Patient) -> None:
        for line in self._lines:
            self._old.removeWidget(line)
            line.hide()
            line.deleteLater()
        self._lines = [self._line(number, one) for number, one in enumerate(patient.consents)]
        for line in self._lines:
            self._old.addWidget(line)

    def _line(self, index: int, consent: Consent) -> QWidget:
        line = QWidget(self)
        row, text = QHBoxLayout(line), QLabel(consent_text(consent), line)
        row.setContentsMargins(0, 0, 0, 0)
        text.setWordWrap(True)
        row.addWidget(text, 1)
        if consent.withdrawn_utc is None:
            button = QPushButton(_("Withdraw"), line)
            button.setAutoDefault(True)
            button.clicked.connect(lambda: self.withdrawn.emit(index))
        else:
            day = day_text(consent.withdrawn_utc.astimezone().date())
            button = QPushButton(_("Withdrawn on {day}").format(day=day), line)
            button.setEnabled(False)
        row.addWidget(button)
        return line
