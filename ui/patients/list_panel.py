"""Search field and list of patients at the left, with the undo of the last deletion below."""

from datetime import date

from PySide6.QtCore import QEvent, QModelIndex, QPersistentModelIndex, QRect, Qt, Signal
from PySide6.QtGui import QKeyEvent, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QFrame,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QTableView,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.patients.content import PatientLine, UndoOffer
from ui.patients.patients_model import (
    BORN,
    LAST_SESSION,
    N_SESSIONS,
    NAME,
    RECORD_NUMBER,
    PatientsModel,
)
from ui.widgets.dates import day_text, moment_text
from ui.widgets.line_table import TEXTS

Index = QModelIndex | QPersistentModelIndex
SAMPLES = {
    BORN: "{day}  (88)",
    RECORD_NUMBER: "HC-8888888",
    N_SESSIONS: "888",
    LAST_SESSION: "{day}",
}
"""Texts as wide as a column has to be; measuring every line would cost time with every key."""
EXPENDABLE = (BORN, N_SESSIONS)
"""In this order, where there is no room for all."""
SAMPLE_NAME = "Bernadette Vidal"
PADDING_PX = 16


class SearchField(QLineEdit):
    """A line in which Down and Enter go on to the list."""

    left_downwards = Signal()

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        if event.key() in (Qt.Key.Key_Down, Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.left_downwards.emit()
        else:
            super().keyPressEvent(event)


class PatientTable(QTableView):
    """The list; Up in its first line goes back to the search."""

    left_upwards = Signal()
    chosen = Signal(int)
    """A row."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setTabKeyNavigation(False)
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setWordWrap(False)
        self.setCornerButtonEnabled(False)
        self._widths_px: dict[int, int] = {}
        self.verticalHeader().hide()
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setDefaultAlignment(Qt.AlignmentFlag(TEXTS | Qt.TextFlag.TextWordWrap))

    def fit_columns(self) -> None:
        """Make columns and rows as large as the letters in use need; long headings wrap."""
        header, metrics = self.horizontalHeader(), self.fontMetrics()
        self.verticalHeader().setDefaultSectionSize(round(metrics.height() * 1.9))
        height = metrics.height()
        days = (day_text(date(2888, month, 28)) for month in range(1, 13))
        longest_day = max(days, key=metrics.horizontalAdvance)
        for column, pattern in SAMPLES.items():
            sample = pattern.format(day=longest_day)
            heading = str(self.model().headerData(column, Qt.Orientation.Horizontal) or "")
            widest = max((sample, *heading.split()), key=metrics.horizontalAdvance)
            width = metrics.horizontalAdvance(widest) + PADDING_PX
            header.resizeSection(column, width)
            self._widths_px[column] = width
            room = QRect(0, 0, width - PADDING_PX, 0)
            wrapped = metrics.boundingRect(room, Qt.TextFlag.TextWordWrap, heading)
            height = max(height, wrapped.height())
        header.setFixedHeight(height + PADDING_PX)
        self._fit_name()

    def _fit_name(self) -> None:
        """Give the names what is left; what the patient's panel says too is hidden for them."""
        least = self.fontMetrics().horizontalAdvance(SAMPLE_NAME) + PADDING_PX
        left = self.viewport().width() - sum(self._widths_px.values())
        for column in EXPENDABLE:
            is_hidden = left < least
            self.setColumnHidden(column, is_hidden)
            left += is_hidden * self._widths_px.get(column, 0)
        self.horizontalHeader().resizeSection(NAME, max(left, least))

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        """Fit columns and lines to letters of another size."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self.fit_columns()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        super().resizeEvent(event)
        self._fit_name()

    def currentChanged(  # noqa: N802  (Qt's name)
        self, current: Index, previous: Index
    ) -> None:
        super().currentChanged(current, previous)
        if current.isValid() and current.row() != previous.row():
            self.chosen.emit(current.row())

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        if event.key() == Qt.Key.Key_Up and self.currentIndex().row() <= 0:
            self.left_upwards.emit()
        else:
            super().keyPressEvent(event)


class PatientListPanel(QWidget):
    """Everything at the left of the patients screen."""

    searched = Signal(str)
    chosen = Signal(str)
    """A pseudonym."""
    taken = Signal()
    """Enter or a double click: the chosen patient is the one."""
    add_asked = Signal()
    undo_asked = Signal()
    deleted_wanted = Signal(bool)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title, self._count, self._read_only = (QLabel(self) for _ in range(3))
        self.search = SearchField(self)
        self.table, self._model = PatientTable(self), PatientsModel(self)
        self.table.setModel(self._model)
        self._add = QPushButton(self)
        self._show_deleted = QCheckBox(self)
        self._undo_strip = QFrame(self)
        self._undo_text, self._undo = QLabel(self._undo_strip), QPushButton(self._undo_strip)
        self._undo_offer: UndoOffer | None = None
        self._is_cut = False
        self._sees_all_names = True
        self._lay_out()
        self.search.textChanged.connect(self.searched)
        self.search.left_downwards.connect(self._enter_table)
        self.table.left_upwards.connect(self.focus_search)
        self.table.chosen.connect(lambda row: self.chosen.emit(self._model.pseudonym(row)))
        self.table.activated.connect(lambda _index: self.taken.emit())
        self._add.clicked.connect(self.add_asked)
        self._undo.clicked.connect(self.undo_asked)
        self._show_deleted.toggled.connect(self.deleted_wanted)

    def _lay_out(self) -> None:
        self._title.setProperty("kind", "title")
        self._count.setProperty("kind", "quiet")
        self._read_only.setProperty("kind", "warning")
        self._undo_strip.setObjectName("message")
        self.search.setClearButtonEnabled(True)
        for label in (self._count, self._read_only, self._undo_text):
            label.setWordWrap(True)
        head, strip, foot = QHBoxLayout(), QHBoxLayout(self._undo_strip), QHBoxLayout()
        head.addWidget(self._title, 1)
        head.addWidget(self._add)
        strip.addWidget(self._undo_text, 1)
        strip.addWidget(self._undo)
        foot.addWidget(self._count, 1)
        foot.addWidget(self._show_deleted)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 8, 0)
        column.setSpacing(8)
        column.addLayout(head)
        column.addWidget(self._read_only)
        column.addWidget(self.search)
        column.addWidget(self.table, 1)
        column.addWidget(self._undo_strip)
        column.addLayout(foot)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._title.setText(_("Patients"))
        hint = _("Search by name, record number or birth date")
        self.search.setPlaceholderText(hint)
        self.search.setToolTip(f"{hint}\n{_('Search patients (Ctrl+F)')}")  # a narrow field cuts it
        self.search.setAccessibleName(_("Search patients"))
        self.table.setAccessibleName(_("Patients"))
        self._add.setText(_("&New patient"))
        self._add.setToolTip(_("Add a patient (Ctrl+N)"))
        self._show_deleted.setText(_("Show &deleted"))
        self._undo.setText(_("&Undo"))
        self._undo.setToolTip(_("Undo the deletion (Ctrl+Z)"))
        self._read_only.setText(
            _("Another window has these patients open: here you can look, but not change.")
        )
        chosen = self._chosen_pseudonym()
        self._model.retranslate()
        self.show_chosen(chosen)
        self.show_undo(self._undo_offer)
        self._show_count()
        self.table.fit_columns()

    def show_patients(self, lines: tuple[PatientLine, ...], *, is_cut: bool) -> None:
        self._is_cut = is_cut
        self._model.show_lines(lines)
        self._show_count()

    def show_chosen(self, pseudonym: str | None) -> None:
        row = self._model.row_of(pseudonym)
        self.table.blockSignals(True)
        if row is None:
            self.table.clearSelection()
            self.table.setCurrentIndex(QModelIndex())
        else:
            self.table.selectRow(row)
        self.table.blockSignals(False)

    def show_rights(self, *, is_read_only: bool, sees_all_names: bool) -> None:
        self._sees_all_names = sees_all_names
        self._add.setEnabled(not is_read_only)
        self._read_only.setVisible(is_read_only)

    def show_undo(self, offer: UndoOffer | None) -> None:
        self._undo_offer = offer
        if offer is None:
            if self._undo.hasFocus():
                self.table.setFocus(Qt.FocusReason.OtherFocusReason)
            self._undo_strip.hide()
            return
        self._undo_strip.show()
        if offer.kind == "patient":
            text = _("{name} was deleted.").format(name=offer.name)
        else:
            when = moment_text(offer.started_utc)
            text = _("The session of {when} was deleted.").format(when=when)
        self._undo_text.setText(text)

    def add(self) -> None:
        """Press the button of a new patient."""
        self._add.click()

    def undo(self) -> None:
        """Press the button of the strip, where it is seen."""
        if not self._undo_strip.isHidden():
            self._undo.click()

    def focus_search(self) -> None:
        """Let the next key be a search."""
        self.search.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.search.selectAll()

    def _enter_table(self) -> None:
        if self._model.rowCount():
            self.table.setFocus(Qt.FocusReason.TabFocusReason)
            if not self.table.currentIndex().isValid():
                self.table.selectRow(0)

    def _chosen_pseudonym(self) -> str | None:
        index = self.table.currentIndex()
        return self._model.pseudonym(index.row()) if index.isValid() else None

    def _show_count(self) -> None:
        count = self._model.rowCount()
        if self._is_cut:
            text = _("The first {count} are shown. Type more to find the others.")
        elif count:
            text = ""
        elif self.search.text() and not self._sees_all_names:
            text = _(
                "Nobody was found. Type three letters of the name, or the whole birth date or "
                "record number, or add a new patient."
            )
        elif self.search.text():
            text = _("Nobody was found. Try fewer letters, or add a new patient.")
        else:
            text = _("There is no patient yet. Add the first one with “New patient”.")
        self._count.setText(text.format(count=count))
