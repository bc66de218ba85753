"""A table of texts that can be read, and copied line by line."""

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from ui.behaviour.tables import TextTable
from ui.widgets.line_table import NUMBERS, TEXTS

ACROSS, ALIGNMENT = Qt.Orientation.Horizontal, Qt.ItemDataRole.TextAlignmentRole
TABLE_LINES = 8
"""That are seen at least, with the titles."""


class TextTableView(QTableWidget):
    """Shows a table; Tab leaves it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setTabKeyNavigation(False)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.verticalHeader().hide()
        self.horizontalHeader().setHighlightSections(False)
        self.horizontalHeader().setDefaultAlignment(TEXTS)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)

    def minimumSizeHint(self) -> QSize:  # noqa: N802  (Qt's name)
        """Ask for room for some lines."""
        letters = self.fontMetrics()
        return QSize(20 * letters.averageCharWidth(), TABLE_LINES * letters.height())

    def show_table(self, table: TextTable) -> None:
        """Show these lines; the current one stays where it is."""
        current = self.currentRow()
        self.setColumnCount(len(table.titles))
        self.setHorizontalHeaderLabels(table.titles)
        self.setRowCount(len(table.lines))
        for column in table.numbers:
            self.model().setHeaderData(column, ACROSS, NUMBERS, ALIGNMENT)
        for row, line in enumerate(table.lines):
            for column, text in enumerate(line):
                item = QTableWidgetItem(text)
                item.setToolTip(text)
                if column in table.numbers:
                    item.setTextAlignment(NUMBERS)
                self.setItem(row, column, item)
        if 0 <= current < len(table.lines):
            self.selectRow(current)
