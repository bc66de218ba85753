"""The list of markers beside the picture."""

from PySide6.QtCore import QEvent, QModelIndex, Qt, Signal
from PySide6.QtWidgets import QAbstractItemView, QVBoxLayout, QWidget

from adibas.data.landmark_texts import LANDMARKS, landmark_text
from adibas.texts import translate as _
from ui.review.content import Points
from ui.review.markers_model import NAME, REMARK, MarkersModel
from ui.review.name_delegate import NameDelegate
from ui.theme import Theme
from ui.widgets.line_table import LineTable

LEAST_LETTERS = 30
"""Of the usual width that a line always has room for."""


class MarkersPanel(QWidget):
    """Chooses markers and renames them."""

    chosen = Signal(str)
    entered = Signal(str)
    renamed = Signal(str, str)

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._model = MarkersModel(theme)
        self._model.setParent(self)
        self._table = LineTable(self)
        self._table.setModel(self._model)
        self._table.setEditTriggers(
            QAbstractItemView.EditTrigger.DoubleClicked
            | QAbstractItemView.EditTrigger.EditKeyPressed
        )
        self._delegate = NameDelegate(self)
        self._table.setItemDelegateForColumn(NAME, self._delegate)
        self._names: tuple[str, ...] = ()
        self._is_showing = False
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 8, 8, 8)
        layout.addWidget(self._table)
        self._table.selectionModel().currentRowChanged.connect(self._on_current)
        self._table.entered_line.connect(lambda row: self.entered.emit(self._model.label(row)))
        self._model.renamed.connect(self.renamed)
        self._table.resized.connect(self._fit_columns)
        self._table.letters_changed.connect(self._fit_columns)
        self.retranslate()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._table.setAccessibleName(_("Markers"))
        horizontal = Qt.Orientation.Horizontal
        self._model.headerDataChanged.emit(horizontal, 0, self._model.columnCount() - 1)
        self._table.fit_lines()
        self._fit_columns()
        self.suggest(self._names)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802  (Qt's name)
        """Keep room for a name and three coordinates in letters of another size."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self.setMinimumWidth(LEAST_LETTERS * self.fontMetrics().averageCharWidth())

    def suggest(self, names: tuple[str, ...]) -> None:
        """Suggest names of this patient before the usual ones."""
        self._names = names
        self._delegate.names = tuple(dict.fromkeys(map(landmark_text, (*names, *LANDMARKS))))

    def show_points(self, points: Points) -> None:
        """Show the markers, and which one is chosen."""
        self._is_showing = True
        before = self._model.texts()
        self._model.show_points(points)
        row = self._model.row_of(points.selected)
        if row is None:
            self._table.clearSelection()
            self._table.setCurrentIndex(QModelIndex())
        elif row != self._table.currentIndex().row():
            self._table.setCurrentIndex(self._model.index(row, NAME))
        if before != self._model.texts():
            self._fit_columns()
        self._is_showing = False

    def edit_name(self, label: str | None) -> None:
        """Let the name of a marker be typed."""
        row = self._model.row_of(label)
        if row is not None:
            index = self._model.index(row, NAME)
            self._table.setFocus()
            self._table.setCurrentIndex(index)
            self._table.edit(index)

    def _on_current(self, now: QModelIndex, _before: QModelIndex) -> None:
        if not self._is_showing and now.isValid():
            self.chosen.emit(self._model.label(now.row()))

    def _fit_columns(self) -> None:
        """Show as much of each marker as there is room for: remarks are in icon and tool tip."""
        table, header = self._table, self._table.horizontalHeader()
        header.setStretchLastSection(False)  # a stretched column would keep its width
        for is_brief, has_remark in ((False, True), (False, False), (True, True), (True, False)):
            self._model.set_brief(is_brief=is_brief)
            table.setColumnHidden(REMARK, not has_remark)
            table.resizeColumnsToContents()
            if self._needed_px() <= table.viewport().width():
                break
        header.setStretchLastSection(True)

    def _needed_px(self) -> int:
        """Return how wide all columns are; the last one's own width, not what it was given."""
        table, columns = self._table, range(self._model.columnCount())
        shown = [column for column in columns if not table.isColumnHidden(column)]
        hints = [
            max(table.sizeHintForColumn(column), table.horizontalHeader().sectionSizeHint(column))
            for column in shown
        ]
        return sum(hints)
