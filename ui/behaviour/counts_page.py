"""How often and how long: a table of the coding, and where it is written."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QComboBox,
    QLabel,
    QPushButton,
    QStackedWidget,
    QWidget,
)

from adibas.texts import translate as _
from ui.behaviour.counts_presenter import EVERYBODY, IN_INTERVALS, TABLES, USUAL_BIN_S
from ui.behaviour.file_dialogs import ask_save, named_after, workbook_filter
from ui.behaviour.measured import HeatMap, People, Raster
from ui.behaviour.tables import TextTable
from ui.behaviour.text_table import TextTableView
from ui.behaviour.time_plot import TimePlot
from ui.theme import Theme
from ui.widgets.flow import in_a_flow
from ui.widgets.number_fields import DecimalField
from ui.widgets.side_panel import SidePanel

LONGEST_BIN_S = 36_000.0


class CountsPage(SidePanel):
    """One table at a time."""

    table_chosen = Signal(str)
    bin_changed = Signal(float)
    person_chosen = Signal(int)
    file_chosen = Signal(object)

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._name = ""
        self._kind, self._bin, self._bin_label = QComboBox(self), DecimalField(self), QLabel(self)
        self._bin_label.setBuddy(self._bin)
        self._person = QComboBox(self)
        self._person.hide()
        self._write = QPushButton(self)
        self._table, self._plot = TextTableView(self), TimePlot(theme, self)
        self._unmeasured = QLabel(self)
        self._unmeasured.setWordWrap(True)
        self._unmeasured.hide()
        self._shown = QStackedWidget(self)
        for part in (self._table, self._plot):
            self._shown.addWidget(part)
        for kind in TABLES:
            self._kind.addItem("", kind)
        self._bin.setRange(0.1, LONGEST_BIN_S)
        self._bin.setValue(USUAL_BIN_S)
        self._bin.setKeyboardTracking(False)
        self._bin.setEnabled(False)
        controls = (self._kind, self._person, self._bin_label, self._bin, self._write)
        column = self.column
        column.setContentsMargins(8, 8, 8, 8)
        column.addLayout(in_a_flow(*controls))
        column.addWidget(self._unmeasured)
        column.addWidget(self._shown, 1)
        self._kind.activated.connect(self._on_kind)
        self._person.activated.connect(
            lambda index: self.person_chosen.emit(self._person.itemData(index))
        )
        self._bin.valueChanged.connect(self.bin_changed)
        self._write.clicked.connect(self._ask_file)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        titles = (
            *(_("Totals and conditions"), _("Time bins"), _("Transitions"), _("Events")),
            *(_("Partial-interval sampling"), _("Whole-interval sampling")),
            _("Momentary sampling"),
            *(_("Activity of joints"), _("Paths in time bins"), _("Band power")),
            *(_("What the program saw"), _("Plot: events"), _("Plot: activity")),
        )
        for index, title in enumerate(titles):
            self._kind.setItemText(index, title)
        self._kind.setAccessibleName(_("What is counted"))
        self._person.setAccessibleName(_("Whose activity is shown"))
        self._bin_label.setText(_("In&terval [s]"))
        self._write.setText(_("&Write..."))
        self._table.setAccessibleName(_("Counts"))
        self._plot.setAccessibleName(_("Plot over time"))
        self._unmeasured.setText(
            _("The program has not looked at this recording yet. Let it find events first.")
        )
        self._plot.redraw()

    def show_name(self, name: str) -> None:
        """Show what the recording is called, after which files are named."""
        self._name = name

    def show_counts(self, table: TextTable) -> None:
        """Show a table."""
        self._table.show_table(table)
        self._shown.setCurrentWidget(self._table)

    def show_plot(self, content: Raster | HeatMap | None) -> None:
        """Show what happened over time."""
        self._plot.show_content(content)
        self._shown.setCurrentWidget(self._plot)

    def show_people(self, people: People, chosen: int) -> None:
        """Offer one person's activity, or everybody's."""
        self._person.clear()
        for number, name in ((EVERYBODY, _("Everybody")), *people):
            self._person.addItem(name, number)
        self._person.setCurrentIndex(max(self._person.findData(chosen), 0))
        self._person.setVisible(bool(people))

    def show_unmeasured(self, *, is_unmeasured: bool) -> None:
        """Say that the program has not looked yet."""
        self._unmeasured.setVisible(is_unmeasured)

    def _on_kind(self, index: int) -> None:
        kind = self._kind.itemData(index)
        self._bin.setEnabled(kind in IN_INTERVALS)
        self.table_chosen.emit(kind)

    def _ask_file(self) -> None:
        filters = (workbook_filter(), "CSV (*.csv)")
        title = _("Write what is counted")
        file = named_after(self._name, "behaviour")
        ask_save(self, title, filters, file, self.file_chosen.emit)
