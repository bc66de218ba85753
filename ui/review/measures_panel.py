"""Measures beside the picture: those that were chosen first, then all, then the protocol's."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QLineEdit,
    QPushButton,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.review.content import MeasureRow
from ui.review.measures_model import INTERVAL, KIND, NAME, VALUE, MeasuresModel
from ui.review.protocol_panel import ProtocolPanel
from ui.review.wording import interval_text, value_text
from ui.widgets.line_table import LineTable
from ui.widgets.scrolled import Scrolled

WIDEST_MM = 2888.8
KINDS: tuple[bool | None, ...] = (None, False, True)


class MeasuresPanel(QTabWidget):
    """Three tables; a line of the second can be taken into the first.

    Attributes
    ----------
    protocol : ProtocolPanel
    """

    kept = Signal(tuple)
    removed = Signal(tuple)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._chosen, self._all = MeasuresModel(), MeasuresModel()
        self.protocol = ProtocolPanel(self)
        self._chosen_table = LineTable(self, takes_delete=True)
        self._all_table = LineTable(self)
        self._remove, self._keep = QPushButton(self), QPushButton(self)
        self._hint_area, self._hint = Scrolled(self), QLabel(self)
        self._hint_area.hold_words()
        self._hint_area.column.addWidget(self._hint)
        self._hint_area.column.addStretch()
        self._hint.setProperty("kind", "quiet")
        self._hint.setWordWrap(True)
        self._text, self._kind = QLineEdit(self), QComboBox(self)
        self._text.setClearButtonEnabled(True)
        for _kind in KINDS:
            self._kind.addItem("")
        self._can_edit = False
        for model, table in ((self._chosen, self._chosen_table), (self._all, self._all_table)):
            model.setParent(self)
            table.setModel(model)
            header = table.horizontalHeader()
            header.setSectionResizeMode(NAME, QHeaderView.ResizeMode.Stretch)
            header.setStretchLastSection(False)
        self._all_table.horizontalHeader().setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
        self._all_table.setSortingEnabled(True)
        self._lay_out()
        self._connect()
        self.retranslate()

    def _lay_out(self) -> None:
        chosen, everything = QWidget(self), QWidget(self)
        first = QVBoxLayout(chosen)
        first.addWidget(self._chosen_table, 1)
        first.addWidget(self._hint_area, 1)
        first.addWidget(self._remove, 0, Qt.AlignmentFlag.AlignLeft)
        search = QHBoxLayout()
        search.addWidget(self._text, 1)
        search.addWidget(self._kind)
        second = QVBoxLayout(everything)
        second.addLayout(search)
        second.addWidget(self._all_table)
        second.addWidget(self._keep, 0, Qt.AlignmentFlag.AlignLeft)
        for layout in (first, second):
            layout.setContentsMargins(8, 8, 8, 8)
        self.addTab(chosen, "")
        self.addTab(everything, "")
        self.addTab(self.protocol, "")
        self.tabBar().setUsesScrollButtons(False)  # all names are read, in large letters too

    def _connect(self) -> None:
        self._text.textChanged.connect(self._on_filter)
        self._kind.currentIndexChanged.connect(self._on_filter)
        self._keep.clicked.connect(self._on_keep)
        self._remove.clicked.connect(self._on_remove)
        self._all_table.entered_line.connect(self._on_keep)
        self._chosen_table.deleted_line.connect(self._on_remove)
        for table in (self._all_table, self._chosen_table):
            table.selectionModel().currentRowChanged.connect(self._enable)
            table.model().modelReset.connect(self._enable)
            table.letters_changed.connect(self._fit_columns)
            table.resized.connect(lambda table=table: self._fit_kind(table))

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setTabText(0, _("Chosen"))
        self.setTabText(1, _("All of them"))
        self.setTabText(2, _("Protocol"))
        self.protocol.retranslate()
        self._chosen_table.setAccessibleName(_("Chosen measures"))
        self._all_table.setAccessibleName(_("All measures"))
        self._hint.setText(
            _("None yet. Press Distance or Angle and click markers, or keep one of all measures.")
        )
        self._hint_area.setAccessibleName(self._hint.text())
        self._remove.setText(_("Remove"))
        self._remove.setToolTip(_("Take the measure away (Delete)"))
        self._keep.setText(_("Keep"))
        self._keep.setToolTip(_("Put it among the chosen measures (Enter)"))
        self._text.setPlaceholderText(_("Names of markers"))
        self._text.setAccessibleName(_("Show only measures of these markers"))
        self._kind.setAccessibleName(_("Kind"))
        for index, kind in enumerate((_("Both"), _("Distances"), _("Angles"))):
            self._kind.setItemText(index, kind)
        for table in (self._chosen_table, self._all_table):
            table.fit_lines()
            table.viewport().update()
            table.horizontalHeader().viewport().update()
        self._fit_columns()

    def show_chosen(self, rows: tuple[MeasureRow, ...], *, can_edit: bool) -> None:
        """Show the measures that were asked for."""
        self._can_edit = can_edit
        self._chosen.show_rows(rows)
        self._hint_area.setVisible(not rows)
        for part in (self._chosen_table, self._remove):
            part.setVisible(bool(rows))
        self._enable()

    def show_all(self, rows: tuple[MeasureRow, ...]) -> None:
        """Show every pair and triplet."""
        self._all.show_rows(rows)
        self._enable()

    def _fit_columns(self) -> None:
        """Give each column the room of its widest text; markers take what is left."""
        widest = MeasureRow(("", ""), WIDEST_MM, (WIDEST_MM, WIDEST_MM))
        texts = (max(_("Distance"), _("Angle"), key=len), value_text(widest), interval_text(widest))
        for table in (self._chosen_table, self._all_table):
            metrics = table.fontMetrics()
            least = metrics.horizontalAdvance(_("Markers")) + 24
            table.horizontalHeader().setMinimumSectionSize(least)
            for column, text in zip((KIND, VALUE, INTERVAL), texts, strict=True):
                header = table.horizontalHeader().sectionSizeHint(column)
                table.setColumnWidth(column, max(header, metrics.horizontalAdvance(text) + 12))
            self._fit_kind(table)

    def _fit_kind(self, table: LineTable) -> None:
        """Hide the kind where there is no room for it: the unit says it too."""
        header = table.horizontalHeader()
        table.setColumnHidden(KIND, False)
        widths = [table.columnWidth(column) for column in (KIND, VALUE, INTERVAL)]
        has_room = sum(widths) + header.minimumSectionSize() <= table.viewport().width()
        table.setColumnHidden(KIND, not has_room)

    def _on_filter(self) -> None:
        self._all.filter(self._text.text(), is_angle=KINDS[self._kind.currentIndex()])

    def _on_keep(self) -> None:
        row = self._all_table.currentIndex().row()
        if row >= 0 and self._can_edit:
            self.kept.emit(self._all.measure(row).labels)

    def _on_remove(self) -> None:
        row = self._chosen_table.currentIndex().row()
        if row >= 0 and self._can_edit:
            self.removed.emit(self._chosen.measure(row).labels)

    def _enable(self) -> None:
        self._keep.setEnabled(self._can_edit and self._all_table.currentIndex().isValid())
        self._remove.setEnabled(self._can_edit and self._chosen_table.currentIndex().isValid())
