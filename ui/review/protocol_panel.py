"""What the session's protocol measures in the picture that is seen, as it is corrected."""

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QLabel, QWidget

from adibas.texts import translate as _
from ui.review.protocol_rows import (
    measure_details,
    protocol_headers,
    protocol_notices,
    protocol_rows,
    rests_on,
)
from ui.widgets.row_table import RowTable
from ui.widgets.scrolled import Scrolled

if TYPE_CHECKING:
    from adibas.data.protocol_measures import ProtocolMeasures

TABLE_LINES = 8


class ProtocolPanel(Scrolled):
    """What must be known first, then the measures, more of one, and on what they rest."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._measures: ProtocolMeasures | None = None
        self._notices, self._details, self._rests = (QLabel(self) for _label in range(3))
        self._table = RowTable(range(1, 3), 0, self, is_plain=True, cuts_names=True)
        self._notices.setProperty("kind", "warning")
        self._rests.setProperty("kind", "quiet")
        for label in (self._notices, self._details, self._rests):
            label.setWordWrap(True)
        self.column.setContentsMargins(8, 8, 8, 8)
        self.column.addWidget(self._notices)
        self.column.addWidget(self._table, 1)
        self.column.addWidget(self._details)
        self.column.addWidget(self._rests)
        self.column.addStretch()
        self.keep_lines(self._table, TABLE_LINES)
        self._table.chosen.connect(lambda _key: self._show_details())
        self.retranslate()

    def show_protocol(self, measures: "ProtocolMeasures | None") -> None:
        """Show these; None where no protocol measures anything here."""
        self._measures = measures
        notices = () if measures is None else protocol_notices(measures)
        self._notices.setText("\n".join(notices))
        self._notices.setVisible(bool(notices))
        rows = () if measures is None else protocol_rows(measures)
        self._table.show_rows(protocol_headers(), rows)
        self._table.setVisible(measures is not None)
        self._show_details()
        self._rests.setText(_("No protocol.") if measures is None else rests_on(measures))

    def _show_details(self) -> None:
        """Tell more of the current line."""
        measures, key = self._measures, self._table.current
        told = "" if measures is None or key is None else measure_details(measures, key[1])
        self._details.setText(told)
        self._details.setVisible(bool(told))

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._table.retranslate(_("Measures of the protocol"))
        self.show_protocol(self._measures)
