"""How well each measure repeats in this clinic: numbers, and Bland and Altman's plot."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from adibas.data.reliability import Reliability
from adibas.texts import translate as _
from ui.comparison.agreement_plot import AgreementPlot, agreement_text
from ui.comparison.content import Repeats, definitions_of
from ui.comparison.empty_or import EmptyOr
from ui.comparison.rows import reliability_text, repeat_headers, repeat_rows
from ui.theme import Theme
from ui.widgets.row_table import RowTable
from ui.widgets.rows import measure_text
from ui.widgets.scrolled import Scrolled

TABLE_WIDTH, PLOT_WIDTH = 660, 460
PLOT_LINES = 12
"""Of letters, so high at least."""


class RepeatsPage(QWidget):
    """The operator above, the table at the left, the plot of one measure at the right."""

    operator_chosen = Signal(str)
    picture_asked = Signal()

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._repeats = Repeats()
        self._operators: tuple[str, ...] = ()
        self._operator, self._operator_label = QComboBox(self), QLabel(self)
        self._operator.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        self._operator_label.setBuddy(self._operator)
        self._rows = RowTable(range(2, 7), 1, self)
        self._plot = AgreementPlot(theme, self)
        self._title, self._numbers, self._words = (QLabel(self) for _number in range(3))
        self._reasons, self._how = QLabel(self), QLabel(self)
        self._save = QPushButton(self)
        self._lay_out()
        self._operator.activated.connect(
            lambda index: self.operator_chosen.emit(self._operators[index])
        )
        self._rows.chosen.connect(lambda _key: self._show_measure())
        self._save.clicked.connect(self.picture_asked)

    def _lay_out(self) -> None:
        for label in (self._title, self._numbers, self._words, self._reasons, self._how):
            label.setWordWrap(True)
        self._title.setProperty("kind", "heading")
        self._how.setProperty("kind", "quiet")
        right = Scrolled(self)
        right.keep_lines(self._plot, PLOT_LINES)
        right.column.addWidget(self._title)
        right.column.addWidget(self._plot, 1)
        for label in (self._numbers, self._words, self._reasons):
            right.column.addWidget(label)
        right.column.addWidget(self._save, 0, Qt.AlignmentFlag.AlignLeft)
        right.column.addStretch()
        across = QSplitter(self)
        across.setObjectName("repeats")
        across.addWidget(self._rows)
        across.addWidget(right)
        across.setChildrenCollapsible(False)
        across.setSizes([TABLE_WIDTH, PLOT_WIDTH])
        self._empty = EmptyOr(across, self)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(8, 8, 8, 8)
        chooser = QHBoxLayout()
        chooser.addWidget(self._operator_label)
        chooser.addWidget(self._operator)
        chooser.addStretch()
        outer.addLayout(chooser)
        outer.addWidget(self._empty, 1)
        outer.addWidget(self._how)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._rows.retranslate(_("Repeats of each measure"))
        self._operator_label.setText(_("Sessions &of"))
        self._plot.setAccessibleName(_("Bland-Altman plot"))
        self._plot.setToolTip(_("Left and Right go from patient to patient."))
        self._save.setText(_("Save the &plot..."))
        self._how.setText(
            _(
                "Repeats with the markers placed anew are the sessions that you count as such "
                "below a patient's list. SEM: standard deviation within a patient. MDC95: smallest "
                "detectable change."
            )
        )
        self.show_operators(self._operators, self._operator.currentText())
        self.show_repeats(self._repeats)

    def show_operators(self, operators: tuple[str, ...], chosen: str) -> None:
        """Offer whose sessions are looked at."""
        self._operators = operators
        self._operator.clear()
        self._operator.addItems([name or _("(without a name)") for name in operators])
        if chosen in operators:
            self._operator.setCurrentIndex(operators.index(chosen))

    def show_repeats(self, repeats: Repeats) -> None:
        """Show how well measures repeat, or why nothing is shown."""
        self._repeats = repeats
        self._empty.say(repeats.sentence)
        self._rows.show_rows(repeat_headers(), repeat_rows(repeats))
        self._show_measure()

    def picture(self) -> tuple[str, bytes] | None:
        """Return what the plot is of, and its picture as PNG; None where there is none."""
        if not self._plot.n_points or self._rows.current is None:
            return None
        png = self._plot.picture_png(self._title.text(), self._words.text())
        return self._rows.current[1], png

    def _show_measure(self) -> None:
        key, protocol = self._rows.current, self._repeats.protocol
        found: Reliability | None = dict(self._repeats.by_measure).get(key) if key else None
        definition = None
        if key is not None and protocol is not None:
            definition = definitions_of(protocol).get(key[1])
        agreement = None if found is None else found.agreement
        self._title.setText("" if definition is None else measure_text(definition))
        self._plot.show_agreement(agreement, definition)
        self._numbers.setText("" if found is None else reliability_text(found))
        self._words.setText(agreement_text(agreement))
        reasons = () if found is None else found.reasons
        self._reasons.setText(" ".join(reason.text for reason in reasons))
        for part, is_seen in (
            (self._plot, agreement is not None),
            (self._words, agreement is not None),
            (self._save, agreement is not None),
            (self._reasons, bool(reasons)),
        ):
            part.setVisible(is_seen)
