"""The back in both sessions: maps, the line and the curves of the spine, and a table."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QHideEvent, QShowEvent
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QLabel,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import message
from adibas.texts import translate as _
from ui.comparison.back_content import Backs, MeasurePair, measure_pairs
from ui.comparison.back_plots import LARGEST_MM, AsymmetryMap, Curve, SpinePlot
from ui.comparison.empty_or import EmptyOr
from ui.comparison.row_table import RowTable
from ui.comparison.rows import Row, interval_text, number
from ui.theme import Theme
from ui.widgets.scrolled import Scrolled

NO_BACKS = message("Neither session shows a back.")
CURVES: tuple[tuple[Curve, str], ...] = (
    ("profile_mm", message("Profile of the spine")),
    ("aside_mm", message("Line of the spine")),
    ("rotation_deg", message("Surface rotation")),
)
PLOT_LINES, TABLE_LINES = 16, 8
PLOTS_PX, TABLE_PX = 420, 240


class BackPage(QWidget):
    """Two maps and a plot above, the measures below."""

    seen = Signal(bool)
    """Whether the page is the one that is seen."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._backs = Backs()
        self._dates = ("", "")
        self._maps = (AsymmetryMap(theme, self), AsymmetryMap(theme, self))
        self._titles = (QLabel(self), QLabel(self))
        self._plot, self._curve = SpinePlot(theme, self), QComboBox(self)
        for curve, title in CURVES:
            self._curve.addItem(title, curve)
        self._legend, self._notes = QLabel(self), QLabel(self)
        self._table = RowTable(range(1, 5), 0, self, is_plain=True)
        self._lay_out()
        self._curve.currentIndexChanged.connect(lambda _index: self._show_curve())

    def _lay_out(self) -> None:
        for label in (*self._titles, self._legend, self._notes):
            label.setWordWrap(True)
        self._legend.setProperty("kind", "quiet")
        self._notes.setProperty("kind", "warning")
        above = Scrolled(self)
        plots = QWidget(self)
        grid = QGridLayout(plots)
        grid.setContentsMargins(0, 0, 0, 0)
        for column, (title, picture) in enumerate(zip(self._titles, self._maps, strict=True)):
            grid.addWidget(title, 0, column)
            grid.addWidget(picture, 1, column)
        grid.addWidget(self._curve, 0, 2)
        grid.addWidget(self._plot, 1, 2)
        for column in range(3):
            grid.setColumnStretch(column, 1)
        grid.setRowStretch(1, 1)
        above.keep_lines(plots, PLOT_LINES)
        above.column.addWidget(plots, 1)
        above.column.addWidget(self._legend)
        below = Scrolled(self)
        below.keep_lines(self._table, TABLE_LINES)
        below.column.addWidget(self._table)
        content = QSplitter(Qt.Orientation.Vertical, self)
        content.addWidget(above)
        content.addWidget(below)
        content.setChildrenCollapsible(False)
        content.setSizes([PLOTS_PX, TABLE_PX])
        self._empty = EmptyOr(content, self)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(8, 8, 8, 8)
        outer.addWidget(self._notes)
        outer.addWidget(self._empty, 1)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._maps[0].setAccessibleName(_("Asymmetry of the back, earlier session"))
        self._maps[1].setAccessibleName(_("Asymmetry of the back, later session"))
        self._plot.setAccessibleName(_("Plot of the spine in both sessions"))
        self._curve.setAccessibleName(_("What of the spine is drawn"))
        for index, (_curve, title) in enumerate(CURVES):
            self._curve.setItemText(index, _(title))
        self._table.retranslate(_("Measures of the back"))
        self._legend.setText(
            _(
                "Maps, seen from behind: red lies further back than the other side, blue further "
                "forward; the colours end at {mm} mm. Plot: dashed before, solid now."
            ).format(mm=round(LARGEST_MM))
        )
        self._word()
        self.show_backs(self._backs)

    def show_dates(self, earlier: str, later: str) -> None:
        """Say when the two sessions were."""
        self._dates = (earlier, later)
        self._word()

    def show_backs(self, backs: Backs) -> None:
        """Show what was found in both sessions."""
        self._backs = backs
        has_any = backs.earlier is not None or backs.later is not None
        told = " ".join(backs.sentences)
        self._notes.setText(told)
        self._notes.setVisible(bool(told) and has_any)
        self._empty.say("" if has_any else told or _(NO_BACKS))
        for picture, back in zip(self._maps, (backs.earlier, backs.later), strict=True):
            picture.show_back(back)
            picture.setVisible(back is not None)
        self._show_curve()
        headers = _("Measure"), _("Before"), _("Now"), _("95 % interval"), _("Difference")
        self._table.show_rows(headers, tuple(_row(one) for one in measure_pairs(backs)))

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802  (Qt's name)
        """Tell that somebody looks."""
        super().showEvent(event)
        self.seen.emit(True)

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802  (Qt's name)
        """Tell that nobody looks any more."""
        super().hideEvent(event)
        self.seen.emit(False)

    def _show_curve(self) -> None:
        self._plot.show_backs(self._backs, self._curve.currentData())

    def _word(self) -> None:
        told = (_("Before: {when}"), _("Now: {when}"))
        for label, text, when in zip(self._titles, told, self._dates, strict=True):
            label.setText(text.format(when=when))


def _row(pair: MeasurePair) -> Row:
    name = f"{_(pair.definition.name)} [{_(pair.unit)}]"
    before, now, difference = (number(x) for x in (pair.before, pair.now, pair.difference))
    return Row(
        (pair.definition.measure_id, ""),
        (name, before, now, interval_text(pair.interval), difference),
        (name, pair.before, pair.now, None, pair.difference),
    )
