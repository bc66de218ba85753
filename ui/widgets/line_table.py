"""Tables: one line is chosen, Enter and Delete do something with it."""

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView, QWidget

ENTER_KEYS = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
TEXTS = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
NUMBERS = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
"""How columns stand, and their titles above them."""


def title_data(title: str, role: int, *, is_number: bool) -> object:
    """Return what a model's `headerData` gives for the title of a column."""
    if role == Qt.ItemDataRole.DisplayRole:
        return title
    is_placed = role == Qt.ItemDataRole.TextAlignmentRole and is_number
    return NUMBERS if is_placed else None


class LineTable(QTableView):
    """A table of whole lines; Tab leaves it."""

    entered_line = Signal(int)
    """Enter, or a double click, on a line."""
    deleted_line = Signal(int)
    """Delete on a line."""
    resized = Signal()
    """There is more or less room for columns than before."""
    letters_changed = Signal()
    """Lines and titles have letters of another size or kind."""
    _has_other_letters = Signal()

    def __init__(self, parent: QWidget | None = None, *, takes_delete: bool = False) -> None:
        super().__init__(parent)
        self._takes_delete = takes_delete
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setTabKeyNavigation(False)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.verticalHeader().hide()
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self.horizontalHeader().setHighlightSections(False)
        self.horizontalHeader().setDefaultAlignment(TEXTS)
        self.horizontalHeader().setStretchLastSection(True)
        # The titles get their letters after the lines.
        self._has_other_letters.connect(
            self.letters_changed.emit, Qt.ConnectionType.QueuedConnection
        )
        self.doubleClicked.connect(lambda index: self.entered_line.emit(index.row()))

    def fit_lines(self) -> None:
        """Make lines and columns as large as the letters in use need."""
        self.verticalHeader().setDefaultSectionSize(round(self.fontMetrics().height() * 1.7))

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802  (Qt's name)
        super().resizeEvent(event)
        if event.size().width() != event.oldSize().width():
            self.resized.emit()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self.fit_lines()
            self._has_other_letters.emit()

    def event(self, event: QEvent) -> bool:
        """Keep Delete from the shortcut of the screen where the table has a use for it."""
        is_override = event.type() == QEvent.Type.ShortcutOverride
        if is_override and isinstance(event, QKeyEvent) and self._is_delete(event):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802  (Qt's name)
        row = self.currentIndex().row()
        if row >= 0 and self._is_delete(event):
            self.deleted_line.emit(row)
        elif (
            row >= 0
            and event.key() in ENTER_KEYS
            and self.state() != QAbstractItemView.State.EditingState
        ):
            self.entered_line.emit(row)
        else:
            super().keyPressEvent(event)

    def _is_delete(self, event: QKeyEvent) -> bool:
        return self._takes_delete and event.key() == Qt.Key.Key_Delete
