"""A table with a field that filters it."""

from collections.abc import Callable

from PySide6.QtCore import QModelIndex, Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QHeaderView, QLineEdit, QVBoxLayout, QWidget

from adibas.texts import translate as _
from ui.widgets.line_table import LineTable
from ui.widgets.rows import Key, Row
from ui.widgets.rows_model import RowsModel

N_ROWS_MEASURED = 60
"""Whose texts decide how wide columns are."""
LEAST_LETTERS = 16
"""Of the column that takes what is left."""


class RowTable(QWidget):
    """Lines of a table; words typed above it leave those that hold them all.

    Parameters
    ----------
    numbers : range
        Which columns are numbers; the others are texts.
    wide_column : int
        Takes the room that is left.
    is_plain : bool
        No field, and no sorting.
    cuts_names : bool
        Whether a plain table, too, cuts names that leave the others no room.
    """

    chosen = Signal(object)
    """The key of the current line."""
    entered = Signal(object)
    """Enter, or a double click, on a line: its key."""

    def __init__(
        self,
        numbers: range,
        wide_column: int,
        parent: QWidget | None = None,
        *,
        is_plain: bool = False,
        cuts_names: bool = False,
    ) -> None:
        super().__init__(parent)
        self._model = RowsModel(numbers, self)
        self._wide_column, self._keeps_names = wide_column, is_plain and not cuts_names
        self._is_wanted: Callable[[Row], bool] | None = None
        self._current: Key | None = None
        self.table, self.words = LineTable(self), QLineEdit(self)
        if cuts_names:  # the ends of names tell them apart
            self.table.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.words.setClearButtonEnabled(True)
        self.words.setVisible(not is_plain)
        self.above = QHBoxLayout()
        self.above.addWidget(self.words, 1)
        self.table.setModel(self._model)
        header = self.table.horizontalHeader()
        header.setStretchLastSection(False)
        header.setResizeContentsPrecision(N_ROWS_MEASURED)
        if not is_plain:
            header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
            header.setSortIndicatorClearable(True)
            self.table.setSortingEnabled(True)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addLayout(self.above)
        column.addWidget(self.table, 1)
        self.words.textChanged.connect(lambda _text: self._filter())
        self.table.selectionModel().currentRowChanged.connect(self._on_current)
        self.table.entered_line.connect(lambda line: self.entered.emit(self._model.row(line).key))
        self.table.letters_changed.connect(self._fit)
        self.table.resized.connect(self._fit)
        self._model.modelReset.connect(self._restore)

    def retranslate(self, name: str) -> None:
        """Set the texts in the language in use; `name` is what the table lists."""
        self.table.setAccessibleName(name)
        self.words.setPlaceholderText(_("Words of the measure"))
        self.words.setAccessibleName(_("Show only measures with these words"))

    def show_rows(self, headers: tuple[str, ...], rows: tuple[Row, ...]) -> None:
        """Show these; the current line stays the current one where it is still there."""
        self._model.show_rows(headers, rows)
        self._fit()

    def want(self, is_wanted: Callable[[Row], bool]) -> None:
        """Show only lines that are wanted."""
        self._is_wanted = is_wanted
        self._filter()

    def choose(self, key: Key | None) -> None:
        """Make the line of a key the current one."""
        line = self._model.line_of(key)
        if line >= 0:
            self.table.selectRow(line)

    @property
    def current(self) -> Key | None:
        """The key of the current line."""
        return self._current

    @property
    def n_seen(self) -> int:
        """How many lines are seen."""
        return self._model.rowCount()

    def _filter(self) -> None:
        self._model.filter(self.words.text(), self._is_wanted)

    def _restore(self) -> None:
        """Choose the line that was chosen before lines went or came, else the first."""
        if not self._model.rowCount():
            return
        self.table.selectRow(max(self._model.line_of(self._current), 0))

    def _on_current(self, current: QModelIndex, _previous: QModelIndex) -> None:
        if current.isValid():
            self._current = self._model.row(current.row()).key
            self.chosen.emit(self._current)

    def _fit(self) -> None:
        """Give each column the room of its texts; one takes what is left."""
        self.table.fit_lines()
        header = self.table.horizontalHeader()
        modes = QHeaderView.ResizeMode
        header.setMinimumSectionSize(3 * self.table.fontMetrics().averageCharWidth())
        for column in range(self._model.columnCount()):
            is_wide = column == self._wide_column
            header.setSectionResizeMode(
                column, modes.Stretch if is_wide else modes.ResizeToContents
            )
        least = self._least_px()
        if self._left_px() < least:  # scroll sideways rather than cut the names
            header.setSectionResizeMode(self._wide_column, modes.Interactive)
            header.resizeSection(self._wide_column, least)

    def _least_px(self) -> int:
        """Return how wide the wide column is at least: long names are cut, a few lines are not."""
        letters_px = LEAST_LETTERS * self.table.fontMetrics().averageCharWidth()
        needed_px = self.table.sizeHintForColumn(self._wide_column)
        return needed_px if self._keeps_names else min(letters_px, needed_px)

    def _left_px(self) -> int:
        """Return what the other columns leave; the titles know their widths a moment later."""
        others = set(range(self._model.columnCount())) - {self._wide_column}
        titles = self.table.horizontalHeader()
        needed = (
            max(self.table.sizeHintForColumn(one), titles.sectionSizeHint(one)) for one in others
        )
        return self.table.viewport().width() - sum(needed)
