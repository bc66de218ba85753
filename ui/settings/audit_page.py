"""The audit log as a table, with a search for one patient's lines."""

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtWidgets import (
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from adibas.sessions.audit_words import action_text, subject_text
from adibas.texts import translate as _
from ui.settings.audit_presenter import AuditPresenter
from ui.widgets.dates import moment_text
from ui.widgets.line_table import TEXTS

if TYPE_CHECKING:
    from adibas.sessions import AuditEntry

SUBJECT = 4
NAME_OF_FILE = "audit.csv"


class AuditPage(QWidget):
    """When, who, what, on whom; newest first."""

    searched = Signal(str)
    exported = Signal(object)
    """A path."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._entries: tuple[AuditEntry, ...] = ()
        self._is_cut = False
        self._label, self._state = QLabel(self), QLabel(self)
        self._state.setProperty("kind", "quiet")
        self._state.setWordWrap(True)
        self.search, self.export = QLineEdit(self), QPushButton(self)
        self.search.setClearButtonEnabled(True)
        self._label.setBuddy(self.search)
        self._table = QTableWidget(0, SUBJECT + 1, self)
        self._table.setEditTriggers(QTableWidget.EditTrigger.NoEditTriggers)
        self._table.setSelectionBehavior(QTableWidget.SelectionBehavior.SelectRows)
        self._table.setTabKeyNavigation(False)
        self._table.setWordWrap(False)
        self._table.verticalHeader().hide()
        header = self._table.horizontalHeader()
        header.setDefaultAlignment(TEXTS)
        header.setStretchLastSection(True)
        below = QHBoxLayout()
        below.addWidget(self._state, 1)
        below.addWidget(self.export)
        layout = QVBoxLayout(self)
        layout.setSpacing(8)
        for widget in (self._label, self.search, self._table):
            layout.addWidget(widget)
        layout.addLayout(below)
        self.search.textChanged.connect(self.searched)
        self.export.clicked.connect(self._ask_place)
        self.retranslate()

    def bind(self, presenter: AuditPresenter) -> None:
        """Send what is wanted to the presenter, and own it."""
        self._presenter = presenter
        self.searched.connect(presenter.search)
        self.exported.connect(presenter.export)

    def entered(self) -> None:
        """Show what is so now."""
        self._presenter.enter()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._label.setText(_("&Patient"))
        self.search.setPlaceholderText(_("Name, record number or pseudonym; empty for all"))
        self.export.setText(_("&Write as CSV..."))
        self._table.setAccessibleName(_("Audit log"))
        self._table.setHorizontalHeaderLabels(
            [_("When"), _("Who"), _("What was done"), _("Patient"), _("To what")]
        )
        self.show_entries(self._entries, is_cut=self._is_cut)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        """Give the lines the height of the letters."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._fit_lines()
            self._fit_columns()

    def show_entries(self, entries: "tuple[AuditEntry, ...]", *, is_cut: bool) -> None:
        """Show lines, newest first."""
        self._entries, self._is_cut = entries, is_cut
        self._fit_lines()
        self._table.setRowCount(len(entries))
        for row, entry in enumerate(entries):
            for column, text in enumerate(_cells(entry)):
                self._table.setItem(row, column, QTableWidgetItem(text))
        self._fit_columns()
        if is_cut:
            state = _("The {n} newest lines; the file holds all of them.").format(n=len(entries))
        else:
            state = "" if entries else _("Nothing was done to such a patient.")
        self._state.setText(state)

    def _fit_lines(self) -> None:
        height = round(self.fontMetrics().height() * 1.7)
        self._table.verticalHeader().setDefaultSectionSize(height)

    def _fit_columns(self) -> None:
        header = self._table.horizontalHeader()
        header.setStretchLastSection(False)  # a stretched column would keep its width
        self._table.resizeColumnsToContents()
        header.setStretchLastSection(True)

    def _ask_place(self) -> None:
        dialog = QFileDialog(self, _("Where to write the audit log"), NAME_OF_FILE)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilter("CSV (*.csv)")
        dialog.setDefaultSuffix("csv")
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.fileSelected.connect(lambda name: self.exported.emit(Path(name)))
        dialog.open()


def _cells(entry: "AuditEntry") -> tuple[str, ...]:
    is_patient = entry.subject == entry.patient
    return (
        moment_text(entry.time_utc),
        entry.operator,
        action_text(entry.action),
        entry.patient,
        "" if is_patient else subject_text(entry.subject),
    )
