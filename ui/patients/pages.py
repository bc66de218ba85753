"""The right half of the patients screen: the chosen patient, or a form in its place."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QStackedWidget, QVBoxLayout, QWidget

from adibas.data.patients import Patient
from adibas.texts import translate as _
from ui.events import Event
from ui.patients.consent_form import ConsentForm
from ui.patients.content import ConsentEntry, PatientEntry, PurgeQuestion, ShownPatient
from ui.patients.history_panel import HistoryPanel
from ui.patients.patient_form import PatientForm
from ui.patients.patient_panel import PatientPanel
from ui.widgets.side_panel import SidePanel

LEAST_WIDTH_PX = 400


class PatientPages(QStackedWidget):
    """Shows one page; each scrolls where letters are large.

    Events
    ------
    form_opened(is_open)
        A form took the place of the patient, or gave it back.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.form_opened: Event[[bool]] = Event()
        self.patient, self.history = PatientPanel(self), HistoryPanel(self)
        self.form, self.consents = PatientForm(self), ConsentForm(self)
        self._nobody, self._chosen = QLabel(self), QWidget(self)
        self._nobody.setProperty("kind", "quiet")
        self._nobody.setWordWrap(True)
        self._nobody.setAlignment(Qt.AlignmentFlag.AlignCenter)
        column = QVBoxLayout(self._chosen)
        column.setSpacing(16)
        column.addWidget(self.patient)
        column.addWidget(self.history, 1)
        self._areas: dict[QWidget, SidePanel] = {}
        self._pages = {
            self._nobody: self._scrolled(self._nobody),
            self._chosen: self._scrolled(self._chosen),
            self.form: self._scrolled(self.form, self.form.footer),
            self.consents: self._scrolled(self.consents, self.consents.footer),
        }
        self._open_form: QWidget | None = None
        self._has_patient = False
        self._nobody.setMinimumWidth(LEAST_WIDTH_PX)  # one set for all pages would narrow others

    def _scrolled(self, widget: QWidget, footer: QWidget | None = None) -> QWidget:
        """Make a page of a widget that may be too long, and a footer that is always seen."""
        page = QWidget(self)
        area = SidePanel(page)
        area.column.setContentsMargins(12, 0, 8, 0)
        layout = widget.layout()
        if layout is not None:
            layout.setContentsMargins(0, 0, 0, 0)
        area.column.addWidget(widget)
        self._areas[widget] = area
        column = QVBoxLayout(page)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(area, 1)
        if footer is not None:
            column.addWidget(footer)
        self.addWidget(page)
        return page

    def retranslate(self) -> None:
        """Set every text in the language in use."""
        for part in (self.patient, self.history, self.form, self.consents):
            part.retranslate()
        self._nobody.setText(_("Choose a patient from the list, or add a new one with Ctrl+N."))

    def page_of(self, form: QWidget) -> QWidget:
        """Return the page that a form stands in with its footer."""
        return self._pages[form]

    def confirm(self) -> None:
        """Press the main button of the page that is seen."""
        if self._open_form is self.form:
            self.form.save()
        elif self._open_form is self.consents:
            self.consents.give()
        else:
            self.history.press_start()

    @property
    def has_form(self) -> bool:
        """Whether something is being typed."""
        return self._open_form is not None

    def focus_form(self) -> None:
        """Give the keys back to the field that had them."""
        if self._open_form is not None:
            (self._open_form.focusWidget() or self._open_form).setFocus()

    def show_patient(self, shown: ShownPatient | None) -> None:
        self._has_patient = shown is not None
        self.patient.show_patient(shown)
        self._show()

    def ask_purge(self, question: PurgeQuestion) -> None:
        self.patient.ask_purge(question)

    def show_entry(self, entry: PatientEntry, *, is_new: bool) -> None:
        self._open(self.form)
        self.form.show_entry(entry, is_new=is_new)

    def offer_work_list(self, *, has_work_list: bool) -> None:
        self.form.offer_work_list(has_work_list=has_work_list)

    def show_consents(self, patient: Patient) -> None:
        self._open(self.consents)
        self.consents.show_patient(patient)

    def show_consent(self, entry: ConsentEntry) -> None:
        if self._open_form is self.form:
            self.form.show_consent(entry)
        else:
            self.consents.fields.show_entry(entry)

    def typed(self) -> tuple[PatientEntry | None, ConsentEntry | None] | None:
        if self._open_form is None:
            return None
        if self._open_form is self.form:
            return self.form.typed()
        return None, self.consents.fields.entry()

    def show_age(self, age_years: int | None) -> None:
        self.form.show_age(age_years)

    def propose_guardian(self, *, is_guardian: bool) -> None:
        for form in (self.form, self.consents.fields):
            form.propose_guardian(is_guardian=is_guardian)

    def show_problem(self, field: str, sentence: str) -> None:
        form = self.form if self._open_form is self.form else self.consents
        form.show_problem(field, sentence)
        self._areas[form].ensureWidgetVisible(form.focusWidget())

    def close_form(self) -> None:
        self._open_form = None
        self._show()
        self.form_opened.emit(False)

    def _open(self, form: QWidget) -> None:
        self._open_form = form
        self._show()
        self.form_opened.emit(True)

    def _show(self) -> None:
        page = self._chosen if self._has_patient else self._nobody
        self.setCurrentWidget(self._pages[self._open_form or page])
