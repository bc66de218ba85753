"""Measures over the patient's sessions: a list, a plot, and the same in a table."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QLabel,
    QPushButton,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from adibas.data.trends import Trend
from adibas.texts import decimal_text, message
from adibas.texts import translate as _
from ui.comparison.content import Trends
from ui.comparison.empty_or import EmptyOr
from ui.comparison.rows import (
    point_headers,
    point_rows,
    trend_headers,
    trend_rows,
)
from ui.comparison.trend_plot import TrendPlot
from ui.theme import Theme
from ui.widgets.flow import in_a_flow
from ui.widgets.row_table import RowTable
from ui.widgets.rows import Key, measure_text
from ui.widgets.scrolled import Scrolled

NO_TRENDS = message("No session of this patient has a measure of this protocol.")
LIST_WIDTH, PLOT_WIDTH = 460, 660
PLOT_LINES, TABLE_LINES = 11, 6
"""Of letters, so high at least."""


class TrendsPage(QWidget):
    """The list at the left, the plot and its words at the right."""

    picture_asked = Signal()

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._trends = Trends()
        self._title, self._legend, self._notes = QLabel(self), QLabel(self), QLabel(self)
        self._list = RowTable(range(2, 3), 1, self)
        self._points = RowTable(range(1, 4), 0, self, is_plain=True)
        self._plot = TrendPlot(theme, self)
        self._has_reference, self._save = QCheckBox(self), QPushButton(self)
        self._lay_out()
        self._list.chosen.connect(lambda _key: self._show_trend())
        self._points.chosen.connect(self._on_point)
        self._plot.stepped.connect(self._on_step)
        self._has_reference.toggled.connect(lambda _on: self._show_trend())
        self._save.clicked.connect(self.picture_asked)

    def _lay_out(self) -> None:
        for label in (self._title, self._legend, self._notes):
            label.setWordWrap(True)
        self._legend.setProperty("kind", "quiet")
        self._notes.setProperty("kind", "warning")
        self._title.setProperty("kind", "heading")
        right = Scrolled(self)
        right.keep_lines(self._plot, PLOT_LINES)
        right.keep_lines(self._points, TABLE_LINES)
        right.column.addWidget(self._title)
        right.column.addWidget(self._plot, 2)
        right.column.addWidget(self._legend)
        right.column.addLayout(in_a_flow(self._has_reference, self._save))
        right.column.addWidget(self._points, 1)
        across = QSplitter(self)
        across.setObjectName("trends")
        across.addWidget(self._list)
        across.addWidget(right)
        across.setChildrenCollapsible(False)
        across.setSizes([LIST_WIDTH, PLOT_WIDTH])
        content = QWidget(self)
        column = QVBoxLayout(content)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._notes)
        column.addWidget(across, 1)
        self._empty = EmptyOr(content, self)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(8, 8, 8, 8)
        outer.addWidget(self._empty)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._list.retranslate(_("Measures over time"))
        self._points.retranslate(_("Values of each session"))
        self._plot.setAccessibleName(_("Plot of the measure over time"))
        self._plot.setToolTip(_("Left and Right go from session to session."))
        self._has_reference.setText(_("Value of &others, with its source"))
        self._save.setText(_("Save the &plot..."))
        self.show_trends(self._trends)

    def show_trends(self, trends: Trends) -> None:
        """Show these measures; the one that was seen stays where it is still there."""
        self._trends = trends
        self._notes.setText(" ".join(trends.notes))
        self._notes.setVisible(bool(trends.notes))
        self._empty.say("" if trends.trends else _(NO_TRENDS))
        self._list.show_rows(trend_headers(), trend_rows(trends.trends))
        self._show_trend()

    def say(self, sentence: str) -> None:
        """Say what to do first in place of the plots; nothing: show what there is."""
        if sentence:
            self._empty.say(sentence)

    def choose(self, key: Key) -> None:
        """Show another measure."""
        self._list.choose(key)
        self._list.table.setFocus()

    def picture(self) -> tuple[str, bytes] | None:
        """Return what the plot is of, and its picture as PNG; None where there is none."""
        trend = self._trend()
        if trend is None:
            return None
        title = measure_text(trend.definition)
        return trend.definition.measure_id, self._plot.picture_png(title, self._legend.text())

    def _trend(self) -> Trend | None:
        return next((one for one in self._trends.trends if one.key == self._list.current), None)

    def _show_trend(self) -> None:
        trend = self._trend()
        references = () if trend is None else trend.definition.references
        self._has_reference.setVisible(bool(references))
        shown = references[0] if references and self._has_reference.isChecked() else None
        self._title.setText("" if trend is None else measure_text(trend.definition))
        self._plot.show_trend(trend, shown)
        self._points.show_rows(point_headers(), () if trend is None else point_rows(trend))
        self._legend.setText("" if trend is None else self._legend_text(trend))
        if trend is not None:
            self._points.choose((trend.points[-1].session_id, ""))

    def _legend_text(self, trend: Trend) -> str:
        words = [_("Dots and bars: value and 95 % interval of the instrument.")]
        if trend.mdc95 is None:
            words.append(_("The smallest detectable change is not known."))
        else:
            told = _("Band: the first value and the smallest detectable change, {mdc95}.")
            words.append(told.format(mdc95=_with_unit(trend.mdc95, trend.definition.unit)))
        if trend.definition.positive is not None:
            positive = trend.definition.positive.text
            words.append(_("Positive means: {what}.").format(what=positive))
        if self._has_reference.isChecked() and trend.definition.references:
            reference = trend.definition.references[0]
            told = _("Dashed line: {value}, {who} ({source}). {note}")
            words.append(
                told.format(
                    value=_with_unit(reference.mean, trend.definition.unit),
                    who=reference.who,
                    source=reference.source,
                    note=reference.note,
                )
            )
        return " ".join(words)

    def _on_point(self, key: Key) -> None:
        trend = self._trend()
        if trend is not None:
            ids = [point.session_id for point in trend.points]
            if key[0] in ids:
                self._plot.choose(ids.index(key[0]))

    def _on_step(self, index: int) -> None:
        trend = self._trend()
        if trend is not None:
            self._points.choose((trend.points[index].session_id, ""))


def _with_unit(value: float, unit: str) -> str:
    """Write a value with its unit; a degree sign stands close to its number."""
    told = _(unit)
    return f"{decimal_text(value, 1)}{'' if told == '°' else ' '}{told}"
