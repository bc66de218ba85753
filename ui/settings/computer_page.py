"""What this computer has and lacks."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QHeaderView,
    QLabel,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from adibas.sensors.doctor import Finding
from adibas.texts import translate as _
from ui.widgets.line_table import TEXTS


class ComputerPage(QWidget):
    """A table of findings, each with what to do."""

    asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._again = QPushButton(self)
        self._again.clicked.connect(self.asked)
        self._table = QTableWidget(0, 4, self)
        self._table.setEditTriggers(QTableWidget.EditTrigger.NoEditTriggers)
        self._table.setSelectionBehavior(QTableWidget.SelectionBehavior.SelectRows)
        self._table.setWordWrap(True)
        self._table.verticalHeader().hide()
        header = self._table.horizontalHeader()
        header.setDefaultAlignment(TEXTS)
        for column in (0, 1):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.ResizeToContents)
        for column in (2, 3):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.Stretch)
        self._log, self._log_folder = QLabel(self), ""
        self._log.setWordWrap(True)
        self._log.setTextInteractionFlags(
            Qt.TextInteractionFlag.TextSelectableByMouse
            | Qt.TextInteractionFlag.TextSelectableByKeyboard
        )
        layout = QVBoxLayout(self)
        layout.addWidget(self._table)
        layout.addWidget(self._log)
        layout.addWidget(self._again, 0, Qt.AlignmentFlag.AlignLeft)
        self.retranslate()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._table.setHorizontalHeaderLabels([_("What"), _("State"), _("Found"), _("What to do")])
        self._table.setAccessibleName(_("This computer"))
        self._again.setText(_("Look &again"))
        self._log.setText(
            _("The program's log, without any patient, lies in {folder}").format(
                folder=self._log_folder
            )
        )

    def show_log(self, folder: str) -> None:
        """Show where the log lies."""
        self._log_folder = folder
        self.retranslate()

    def show_findings(self, found: tuple[Finding, ...]) -> None:
        """Show what was found."""
        self._table.setRowCount(len(found))
        for row, finding in enumerate(found):
            state = _("ok") if finding.ok else _("lacking")
            for column, text in enumerate((finding.name, state, finding.detail, finding.remedy)):
                self._table.setItem(row, column, QTableWidgetItem(text))
        self._table.resizeRowsToContents()
