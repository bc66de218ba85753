"""Lines of a table, filtered and sorted in one go: there may be 1,500."""

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QObject, QPersistentModelIndex, Qt
from PySide6.QtGui import QFont

from adibas.data.reliability import Verdict
from ui.widgets.line_table import NUMBERS, title_data
from ui.widgets.rows import Key, Order, Row

Role = Qt.ItemDataRole
Index = QModelIndex | QPersistentModelIndex


class RowsModel(QAbstractTableModel):
    """Texts in columns; those beyond the smallest detectable change are bold.

    Parameters
    ----------
    numbers : range
        Which columns are numbers; the others are texts.
    """

    def __init__(self, numbers: range, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._numbers = numbers
        self._headers: tuple[str, ...] = ()
        self._rows: tuple[Row, ...] = ()
        self._seen: list[Row] = []
        self._words: tuple[str, ...] = ()
        self._is_wanted: Callable[[Row], bool] = _any
        self._order: tuple[int, bool] | None = None

    def show_rows(self, headers: tuple[str, ...], rows: tuple[Row, ...]) -> None:
        """Show these."""
        self._headers, self._rows = headers, rows
        self._arrange()

    def filter(self, text: str, is_wanted: Callable[[Row], bool] | None = None) -> None:
        """Show only lines whose texts hold all words, and that are wanted."""
        self._words = tuple(text.casefold().split())
        self._is_wanted = is_wanted or _any
        self._arrange()

    def row(self, line: int) -> Row:
        """Return what stands in a line."""
        return self._seen[line]

    def line_of(self, key: Key | None) -> int:
        """Return the line of a key; -1 where it is not seen."""
        return next((i for i, row in enumerate(self._seen) if row.key == key), -1)

    def sort(self, column: int, order: Qt.SortOrder = Qt.SortOrder.AscendingOrder) -> None:
        """Sort by a column; by none (-1): as measured."""
        is_descending = order == Qt.SortOrder.DescendingOrder
        self._order = None if column < 0 else (column, is_descending)
        self._arrange()

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008  (Qt's)
        return 0 if parent.isValid() else len(self._seen)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008  (Qt's)
        return 0 if parent.isValid() else len(self._headers)

    def headerData(  # noqa: N802  (Qt's name)
        self, section: int, orientation: Qt.Orientation, role: int = Role.DisplayRole
    ) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        return title_data(self._headers[section], role, is_number=section in self._numbers)

    def data(self, index: Index, role: int = Role.DisplayRole) -> Any:
        row, column = self._seen[index.row()], index.column()
        if role == Role.TextAlignmentRole and column in self._numbers:
            return NUMBERS
        if role == Role.FontRole and row.verdict is Verdict.BEYOND:
            font = QFont()
            font.setBold(True)
            return font
        return row.cells[column] if role in (Role.DisplayRole, Role.ToolTipRole) else None

    def _arrange(self) -> None:
        self.beginResetModel()
        self._seen = [row for row in self._rows if self._matches(row)]
        if self._order is not None:
            column, is_descending = self._order
            known = [row for row in self._seen if row.order[column] is not None]
            rest = [row for row in self._seen if row.order[column] is None]
            known.sort(key=lambda row: _sortable(row.order[column]), reverse=is_descending)
            self._seen = [*known, *rest]
        self.endResetModel()

    def _matches(self, row: Row) -> bool:
        text = " ".join((*row.cells, *row.key)).casefold() if self._words else ""
        return self._is_wanted(row) and all(word in text for word in self._words)


def _any(_row: Row) -> bool:
    return True


def _sortable(value: Order) -> tuple[str, float]:
    return (value.casefold(), 0.0) if isinstance(value, str) else ("", value or 0.0)
