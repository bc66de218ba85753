"""The patients screen: the list at the left, patient or form at the right, and the keys."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import QHBoxLayout, QSplitter, QWidget

from adibas.texts import translate as _
from ui.patients.form_presenter import FormPresenter
from ui.patients.history_presenter import HistoryPresenter
from ui.patients.list_panel import PatientListPanel
from ui.patients.pages import PatientPages
from ui.patients.presenter import PatientsPresenter
from ui.patients.undo import Undo
from ui.widgets.screen import Screen

USUAL_WIDTHS_PX = (700, 440)


class PatientsScreen(Screen):
    """Two halves; while something is typed at the right, the list waits."""

    name = "patients"

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.list, self.pages = PatientListPanel(self), PatientPages(self)
        halves = QSplitter(Qt.Orientation.Horizontal, self)
        halves.setObjectName("halves")
        halves.addWidget(self.list)
        halves.addWidget(self.pages)
        halves.setChildrenCollapsible(False)
        halves.setStretchFactor(0, 1)
        halves.setStretchFactor(1, 1)
        halves.setSizes(list(USUAL_WIDTHS_PX))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(halves)
        self.pages.form_opened.subscribe(self._on_form_opened)
        self._make_shortcuts()
        self.retranslate()

    def _make_shortcuts(self) -> None:
        """Make keys for all buttons; those of a screen that is not seen do nothing."""
        pages = self.pages
        for keys, action in (
            ("Ctrl+F", self.list.focus_search),
            ("Ctrl+N", self.list.add),
            ("F2", pages.patient.edit),
            ("Ctrl+Return", pages.confirm),
            ("Ctrl+Z", self.list.undo),
        ):
            QShortcut(QKeySequence(keys), self).activated.connect(action)
        here = Qt.ShortcutContext.WidgetWithChildrenShortcut
        for widget, keys, action in (
            (self.list.table, "Del", pages.patient.delete),
            (pages.history.list, "Del", pages.history.delete_chosen),
            (pages.page_of(pages.form), "Esc", pages.form.cancel),
            (pages.page_of(pages.consents), "Esc", pages.consents.cancel),
        ):
            QShortcut(QKeySequence(keys), widget, context=here).activated.connect(action)

    def bind(
        self, presenters: tuple[PatientsPresenter, HistoryPresenter, FormPresenter], undo: Undo
    ) -> None:
        """Send what is done to the presenters, and own them."""
        self._patients, self._history, self._form = presenters
        self._undo = undo
        self._bind_patients()
        self._bind_history()
        self._bind_form()

    def _bind_patients(self) -> None:
        presenter, patient = self._patients, self.pages.patient
        self.list.searched.connect(presenter.search)
        self.list.chosen.connect(presenter.choose)
        self.list.taken.connect(self.pages.history.focus_start)
        self.list.undo_asked.connect(self._undo.take_back)
        self.list.deleted_wanted.connect(self._on_deleted_wanted)
        patient.delete_asked.connect(presenter.delete)
        patient.restore_asked.connect(presenter.restore)
        patient.purge_asked.connect(presenter.ask_purge)
        patient.purge_confirmed.connect(presenter.purge)

    def _bind_history(self) -> None:
        presenter, panel = self._history, self.pages.history
        panel.start_asked.connect(presenter.start)
        panel.continue_asked.connect(presenter.continue_last)
        panel.start_like_last_asked.connect(presenter.start_like_last)
        panel.opened.connect(presenter.open)
        panel.protocol_chosen.connect(presenter.choose_protocol)
        panel.compare_asked.connect(presenter.compare)
        panel.repeat_called.connect(
            lambda session_id, is_repeat: presenter.call_repeat(session_id, is_repeat=is_repeat)
        )
        panel.delete_asked.connect(presenter.delete)
        panel.restore_asked.connect(presenter.restore)
        panel.purge_asked.connect(presenter.ask_purge)
        panel.purge_confirmed.connect(presenter.purge)
        panel.pictures_wanted.connect(presenter.load_thumbnails)

    def _bind_form(self) -> None:
        presenter, pages = self._form, self.pages
        self.list.add_asked.connect(presenter.add)
        pages.patient.edit_asked.connect(presenter.edit)
        pages.patient.consents_asked.connect(presenter.edit_consents)
        pages.form.birth_date_typed.connect(presenter.note_birth_date)
        pages.form.saved.connect(presenter.save)
        pages.form.cancelled.connect(presenter.cancel)
        pages.consents.given.connect(presenter.give)
        pages.consents.withdrawn.connect(presenter.withdraw)
        pages.consents.cancelled.connect(presenter.cancel)

    def retranslate(self) -> None:
        """Set every text in the language in use."""
        self.list.retranslate()
        self.pages.retranslate()

    def entered(self) -> None:
        """Show what the store holds now; the next key is a search, or goes on with a form."""
        self._patients.enter()
        self._history.enter()
        if self.pages.has_form:
            self.pages.focus_form()
        else:
            self.list.focus_search()

    def left(self) -> None:
        """Read nothing of the store while other screens are seen."""
        self._patients.leave()
        self._history.leave()

    def closed(self) -> None:
        """Let go of everything."""
        self._patients.close()
        self._history.close()
        self._form.close()
        self.pages.history.list.shown_model.stop()

    def draft(self) -> str:
        """Return the form that is open."""
        return self._form.draft()

    def take_back(self, draft: str) -> None:
        """Open the form as it was left."""
        self._form.take_back(draft)

    def unsaved(self) -> tuple[str, ...]:
        """Name the open form, once anything was typed into it."""
        return (_("What was typed of a patient"),) if self._form.is_unsaved else ()

    def _on_deleted_wanted(self, is_wanted: bool) -> None:
        self._patients.show_deleted(is_wanted=is_wanted)
        self._history.show_deleted(is_wanted=is_wanted)

    def _on_form_opened(self, is_open: bool) -> None:
        self.list.setEnabled(not is_open)
        if not is_open:
            self.list.table.setFocus()
