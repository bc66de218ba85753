"""The change of every measure between two sessions."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QVBoxLayout, QWidget

from adibas.data.protocol_measures import INSTRUMENT_ONLY
from adibas.data.reliability import Verdict
from adibas.reports.facts import chance_text, verdict_text
from adibas.texts import message
from adibas.texts import translate as _
from ui.comparison.content import Differences, clinical_ids
from ui.comparison.empty_or import EmptyOr
from ui.comparison.rows import change_headers, change_rows
from ui.widgets.row_table import RowTable
from ui.widgets.rows import Row

NO_CHANGES = message("Choose two sessions above.")
LOOKING = message("Changes are marked as soon as the clinic's repeats are looked through.")
VERDICTS = (None, Verdict.BEYOND, Verdict.INSIDE, Verdict.UNKNOWN)


class DifferencesPage(QWidget):
    """The table, what is left of it, and what chance alone would mark."""

    trend_asked = Signal(object)
    """View and measure of a line."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._differences = Differences()
        self._ids: frozenset[str] = frozenset()
        self._rows = RowTable(range(2, 7), 1, self)
        self._verdict, self._all = QComboBox(self), QCheckBox(self)
        self._verdict.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        self._chance, self._note = QLabel(self), QLabel(self)
        for _verdict in VERDICTS:
            self._verdict.addItem("")
        for label in (self._chance, self._note):
            label.setWordWrap(True)
        self._note.setProperty("kind", "quiet")
        self._rows.above.addWidget(self._verdict)
        content = QWidget(self)
        column = QVBoxLayout(content)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._all)
        column.addWidget(self._rows, 1)
        column.addWidget(self._chance)
        column.addWidget(self._note)
        self._empty = EmptyOr(content, self)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(8, 8, 8, 8)
        outer.addWidget(self._empty)
        self._verdict.currentIndexChanged.connect(lambda _index: self._filter())
        self._all.toggled.connect(lambda _on: self._filter())
        self._rows.entered.connect(self.trend_asked)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._rows.retranslate(_("Differences"))
        self._all.setText(_("&Every pair and triplet of landmarks, too"))
        self._verdict.setAccessibleName(_("Show only changes that are"))
        texts = [_("All changes"), *(verdict_text(one) for one in VERDICTS if one is not None)]
        for index, text in enumerate(texts):
            self._verdict.setItemText(index, text)
        self._note.setText(_(INSTRUMENT_ONLY))
        self.show_differences(self._differences)

    def show_differences(self, differences: Differences) -> None:
        """Show the changes, or why there are none."""
        self._differences = differences
        found, protocol = differences.comparison, differences.protocol
        self._empty.say(differences.refusal or ("" if found is not None else _(NO_CHANGES)))
        if protocol is not None:
            self._ids = clinical_ids(protocol)
            self._all.setVisible(len(self._ids) < len(protocol.measures))
        self._filter()
        self._rows.show_rows(change_headers(), change_rows(differences))
        if found is not None:
            waiting = differences.is_looking and not found.n_judged
            self._chance.setText(_(LOOKING) if waiting else chance_text(found))

    def say(self, sentence: str) -> None:
        """Say what to do first in place of the table; nothing: show what there is."""
        if sentence:
            self._empty.say(sentence)

    def _filter(self) -> None:
        wanted = VERDICTS[self._verdict.currentIndex()]
        shows_all = self._all.isChecked()

        def is_wanted(row: Row) -> bool:
            is_clinical = shows_all or row.key[1] in self._ids
            return is_clinical and wanted in (None, row.verdict)

        self._rows.want(is_wanted)
