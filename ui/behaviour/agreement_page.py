"""How far two observers agree: every figure with its method, or why there is none."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QLabel,
    QPushButton,
    QWidget,
)

from adibas.behaviour.agreement import AgreementParams
from adibas.data.coding import MS_PER_S
from adibas.texts import translate as _
from ui.behaviour.file_dialogs import (
    ask_open,
    ask_save,
    coding_filter,
    named_after,
    workbook_filter,
)
from ui.behaviour.tables import TextTable
from ui.behaviour.text_table import TextTableView
from ui.widgets.flow import in_a_flow
from ui.widgets.number_fields import DecimalField
from ui.widgets.side_panel import SidePanel

FIELDS = ("unit", "tolerance", "interval")
LONGEST_S = 3600.0
SHORTEST_S = 0.01


class AgreementPage(SidePanel):
    """Choose the other coding, see how far both agree."""

    other_chosen = Signal(object)
    params_changed = Signal(object)
    file_chosen = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._name = ""
        self._open, self._write = QPushButton(self), QPushButton(self)
        self._fields = {name: DecimalField(self) for name in FIELDS}
        self._labels = {name: QLabel(self) for name in FIELDS}
        usual = AgreementParams()
        for name, ms in zip(
            FIELDS, (usual.unit_ms, usual.tolerance_ms, usual.interval_ms), strict=True
        ):
            field = self._fields[name]
            field.setRange(0.0 if name == "tolerance" else SHORTEST_S, LONGEST_S)
            field.setValue(ms / MS_PER_S)
            field.setKeyboardTracking(False)
            field.valueChanged.connect(self._on_params)
            self._labels[name].setBuddy(field)
        self._told = QLabel(self)
        self._told.setWordWrap(True)
        self._table = TextTableView(self)
        column = self.column
        column.setContentsMargins(8, 8, 8, 8)
        column.addLayout(in_a_flow(self._open, self._write))
        pairs = [part for name in FIELDS for part in (self._labels[name], self._fields[name])]
        column.addLayout(in_a_flow(*pairs))
        column.addWidget(self._told)
        column.addWidget(self._table, 1)
        self._open.clicked.connect(self._ask_other)
        self._write.clicked.connect(self._ask_file)
        self._sentence = ""

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._open.setText(_("Co&mpare with a coding..."))
        self._write.setText(_("&Write..."))
        texts = (_("Uni&t [s]"), _("To&lerance [s]"), _("Interv&al [s]"))
        for name, text in zip(FIELDS, texts, strict=True):
            self._labels[name].setText(text)
        self._table.setAccessibleName(_("Agreement"))
        self._word()

    def show_name(self, name: str) -> None:
        """Show what the recording is called, after which files are named."""
        self._name = name

    def show_agreement(self, table: TextTable, sentence: str) -> None:
        """Show figures, and what is to be said of them."""
        self._sentence = sentence
        self._table.show_table(table)
        self._word()

    def _word(self) -> None:
        nothing = _("Open the coding of another observer, or let a second one code.")
        self._told.setText(self._sentence or nothing)
        self._write.setEnabled(bool(self._sentence))

    def _on_params(self) -> None:
        unit, tolerance, interval = (
            round(self._fields[name].value() * MS_PER_S) for name in FIELDS
        )
        self.params_changed.emit(AgreementParams(unit, tolerance, interval))

    def _ask_other(self) -> None:
        title = _("Coding of another observer")
        ask_open(self, title, coding_filter(), self.other_chosen.emit)

    def _ask_file(self) -> None:
        filters = (workbook_filter(),)
        file = named_after(self._name, "agreement")
        ask_save(self, _("Write the agreement"), filters, file, self.file_chosen.emit)
