"""What the session's protocol measures in the picture that is seen, as it is corrected."""

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from adibas.texts import translate as _
from ui.review.protocol_rows import protocol_headers, protocol_notices, protocol_rows, rests_on
from ui.widgets.notes import Notes
from ui.widgets.row_table import RowTable

if TYPE_CHECKING:
    from adibas.data.protocol_measures import ProtocolMeasures


class ProtocolPanel(QWidget):
    """What must be known first, then the measures, then on what they rest."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._measures: ProtocolMeasures | None = None
        self._notes, self._rests = Notes(self), QLabel(self)
        self._table = RowTable(range(1, 3), 0, self, is_plain=True)
        self._rests.setProperty("kind", "quiet")
        self._rests.setWordWrap(True)
        column = QVBoxLayout(self)
        column.setContentsMargins(8, 8, 8, 8)
        column.addWidget(self._notes)
        column.addWidget(self._table, 1)
        column.addWidget(self._rests)
        self.retranslate()

    def show_protocol(self, measures: "ProtocolMeasures | None") -> None:
        """Show these; None where no protocol measures anything here."""
        self._measures = measures
        self._notes.say(() if measures is None else protocol_notices(measures))
        rows = () if measures is None else protocol_rows(measures)
        self._table.show_rows(protocol_headers(), rows)
        self._table.setVisible(measures is not None)
        self._rests.setText(_("No protocol.") if measures is None else rests_on(measures))

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._table.retranslate(_("Measures of the protocol"))
        self.show_protocol(self._measures)
