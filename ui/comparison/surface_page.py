"""What the pages of the back and of the body have in common: pictures of two sessions, a table."""

from collections.abc import Iterable

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QHideEvent, QShowEvent
from PySide6.QtWidgets import QLabel, QSplitter, QVBoxLayout, QWidget

from adibas.data.body_measures import BodyMeasure
from adibas.texts import translate as _
from ui.comparison.empty_or import EmptyOr
from ui.comparison.measure_pairs import measure_pairs, pair_headers, pair_row
from ui.widgets.notes import Notes
from ui.widgets.row_table import RowTable
from ui.widgets.scrolled import Scrolled

PICTURE_LINES, TABLE_LINES = 16, 6
PICTURES_PX, TABLE_PX = 440, 220


class SurfacePage(QWidget):
    """Notes, pictures and words on them, and measures; derived classes fill in the pictures."""

    seen = Signal(bool)
    """Whether the page is the one that is seen."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._dates = ("", "")
        self.titles = (QLabel(self), QLabel(self))
        self._notes = Notes(self)
        self.table = RowTable(range(1, 5), 0, self, is_plain=True)
        for label in self.titles:
            label.setWordWrap(True)

    def lay_out(self, pictures: QWidget) -> None:
        """Put the pictures above the table; each part scrolls where it must."""
        above, below = Scrolled(self), Scrolled(self)
        above.keep_lines(pictures, PICTURE_LINES)
        above.column.addWidget(pictures, 1)
        below.keep_lines(self.table, TABLE_LINES)
        below.column.addWidget(self.table)
        content = QSplitter(Qt.Orientation.Vertical, self)
        content.setObjectName(type(self).__name__)
        content.addWidget(above)
        content.addWidget(below)
        content.setChildrenCollapsible(False)
        content.setSizes([PICTURES_PX, TABLE_PX])
        self._empty = EmptyOr(content, self)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(8, 8, 8, 8)
        outer.addWidget(self._notes)
        outer.addWidget(self._empty, 1)

    def show_dates(self, earlier: str, later: str) -> None:
        """Say when the two sessions were."""
        self._dates = (earlier, later)
        told = (_("Before: {when}"), _("Now: {when}"))
        for label, text, when in zip(self.titles, told, self._dates, strict=True):
            label.setText(text.format(when=when))

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.show_dates(*self._dates)

    def show_sentences(self, sentences: tuple[str, ...], nothing: str = "") -> None:
        """Say these above the pictures, or in their place where there is `nothing` to show."""
        self._notes.say(() if nothing else sentences)
        self._empty.say(" ".join(sentences) or nothing if nothing else "")

    def show_measures(self, earlier: Iterable[BodyMeasure], later: Iterable[BodyMeasure]) -> None:
        """Show these in the table."""
        pairs = measure_pairs(earlier, later)
        self.table.show_rows(pair_headers(), tuple(map(pair_row, pairs)))

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802  (Qt's name)
        """Tell that somebody looks."""
        super().showEvent(event)
        self.seen.emit(True)

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802  (Qt's name)
        """Tell that nobody looks any more."""
        super().hideEvent(event)
        self.seen.emit(False)
