"""Distances and angles as a table, filtered and sorted in one go: it may have 30,000 rows."""

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt

from adibas.texts import translate as _
from ui.review.content import MeasureRow
from ui.review.wording import interval_text, kind_text, measure_name, value_text
from ui.widgets.line_table import NUMBERS, title_data

Role = Qt.ItemDataRole
Index = QModelIndex | QPersistentModelIndex
KIND, NAME, VALUE, INTERVAL = range(4)
WRITERS: tuple[Callable[[MeasureRow], str], ...] = (
    kind_text,
    measure_name,
    value_text,
    interval_text,
)


class MeasuresModel(QAbstractTableModel):
    """Kind, markers, value and interval of each measure."""

    def __init__(self) -> None:
        super().__init__()
        self._rows: tuple[MeasureRow, ...] = ()
        self._seen: list[int] = []
        self._words: tuple[str, ...] = ()
        self._kind: bool | None = None
        self._order: tuple[int, bool] | None = None

    def show_rows(self, rows: tuple[MeasureRow, ...]) -> None:
        """Show these; where only values changed, lines and selection stay where they are."""
        is_same = len(rows) == len(self._rows) and all(
            one.labels == other.labels for one, other in zip(rows, self._rows, strict=True)
        )
        if not is_same:
            self._rows = rows
            self._arrange()
            return
        self._rows = rows
        if self._seen:
            last = self.index(len(self._seen) - 1, INTERVAL)
            self.dataChanged.emit(self.index(0, VALUE), last)

    def filter(self, text: str, *, is_angle: bool | None) -> None:
        """Show only measures whose markers hold all words, and of one kind (None: both)."""
        self._words, self._kind = tuple(text.casefold().split()), is_angle
        self._arrange()

    def measure(self, row: int) -> MeasureRow:
        """Return the measure in a line."""
        return self._rows[self._seen[row]]

    def sort(self, column: int, order: Qt.SortOrder = Qt.SortOrder.AscendingOrder) -> None:
        """Sort by a column; by none (-1): as measured."""
        is_descending = order == Qt.SortOrder.DescendingOrder
        self._order = None if column < 0 else (column, is_descending)
        self._arrange()

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008  (Qt's)
        return 0 if parent.isValid() else len(self._seen)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008  (Qt's)
        return 0 if parent.isValid() else len(WRITERS)

    def headerData(  # noqa: N802  (Qt's name)
        self, section: int, orientation: Qt.Orientation, role: int = Role.DisplayRole
    ) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        titles = (_("Kind"), _("Markers"), _("Value"), _("95 % interval"))
        return title_data(titles[section], role, is_number=section >= VALUE)

    def data(self, index: Index, role: int = Role.DisplayRole) -> Any:
        if role == Role.TextAlignmentRole and index.column() >= VALUE:
            return NUMBERS
        if role not in (Role.DisplayRole, Role.ToolTipRole):
            return None
        return WRITERS[index.column()](self.measure(index.row()))

    def _arrange(self) -> None:
        self.beginResetModel()
        self._seen = [i for i, row in enumerate(self._rows) if self._is_wanted(row)]
        if self._order is not None:
            column, is_descending = self._order
            self._seen.sort(key=lambda i: _key(self._rows[i], column), reverse=is_descending)
        self.endResetModel()

    def _is_wanted(self, row: MeasureRow) -> bool:
        if self._kind is not None and row.is_angle != self._kind:
            return False
        name = measure_name(row).casefold() if self._words else ""
        return all(word in name for word in self._words)


def _key(row: MeasureRow, column: int) -> tuple[bool, object]:
    """Return what a column sorts by; distances and angles are never mixed."""
    if column == NAME:
        return row.is_angle, measure_name(row)
    value = -1.0 if row.value is None else row.value
    if column == VALUE:
        return row.is_angle, value
    if column == INTERVAL:
        return row.is_angle, -1.0 if row.interval is None else row.interval[1] - row.interval[0]
    return row.is_angle, 0.0
