"""The list of patients as a table."""

from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QObject, QPersistentModelIndex, Qt
from PySide6.QtGui import QFont

from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.patients.content import PatientLine
from ui.widgets.dates import day_text
from ui.widgets.line_table import NUMBERS, title_data

Index = QModelIndex | QPersistentModelIndex
Role = Qt.ItemDataRole
NAME, BORN, RECORD_NUMBER, N_SESSIONS, LAST_SESSION = range(5)
N_COLUMNS = 5
NO_PARENT = QModelIndex()


class PatientsModel(QAbstractTableModel):
    """One line a patient; texts are made when they are seen."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._lines: tuple[PatientLine, ...] = ()
        self._headings: tuple[str, ...] = ("",) * N_COLUMNS
        self._struck = QFont()
        self._struck.setStrikeOut(True)

    def retranslate(self) -> None:
        """Set the headings in the language in use."""
        self._headings = (
            _("Name"),
            _("Birth date (age)"),
            _("Record number"),
            _("Sessions"),
            _("Last session"),
        )
        self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, N_COLUMNS - 1)
        self.show_lines(self._lines)

    def show_lines(self, lines: tuple[PatientLine, ...]) -> None:
        """Show these patients."""
        self.beginResetModel()
        self._lines = lines
        self.endResetModel()

    def pseudonym(self, row: int) -> str:
        """Return who stands in a row."""
        return self._lines[row].row.pseudonym

    def row_of(self, pseudonym: str | None) -> int | None:
        """Return the row of a patient; None where it is not listed."""
        rows = (row for row in range(len(self._lines)) if self.pseudonym(row) == pseudonym)
        return next(rows, None)

    def rowCount(self, parent: Index = NO_PARENT) -> int:  # noqa: N802  (Qt's name)
        return 0 if parent.isValid() else len(self._lines)

    def columnCount(self, parent: Index = NO_PARENT) -> int:  # noqa: N802  (Qt's name)
        return 0 if parent.isValid() else N_COLUMNS

    def headerData(  # noqa: N802  (Qt's name)
        self, section: int, orientation: Qt.Orientation, role: int = Role.DisplayRole
    ) -> Any:
        if orientation is not Qt.Orientation.Horizontal:
            return None
        found = title_data(self._headings[section], role, is_number=section == N_SESSIONS)
        return int(found | Qt.TextFlag.TextWordWrap) if found is NUMBERS else found

    def data(self, index: Index, role: int = Role.DisplayRole) -> Any:
        line = self._lines[index.row()]
        if role == Role.DisplayRole:
            return _text(line, index.column())
        if role == Role.ToolTipRole and line.row.is_deleted:
            return _("Deleted. It can be restored.")
        if role == Role.ToolTipRole and index.column() == NAME:
            return line.row.identity.name
        if role == Role.FontRole and line.row.is_deleted:
            return self._struck
        if role == Role.TextAlignmentRole and index.column() == N_SESSIONS:
            return int(NUMBERS)
        return None


def _text(line: PatientLine, column: int) -> str:
    row = line.row
    if column == NAME:
        return row.identity.name
    if column == BORN:
        return born_text(line)
    if column == RECORD_NUMBER:
        return row.identity.record_number
    if column == N_SESSIONS:
        return str(row.n_sessions or "")
    last_utc = row.last_session_utc
    return "" if last_utc is None else day_text(last_utc.astimezone().date())


def born_text(line: PatientLine) -> str:
    """Return birth date and age in years."""
    if line.age_years is None:
        return ""
    day = day_text(line.row.identity.birth_date)
    return f"{day}  ({line.age_years})"


def age_text(age_years: int | None) -> str:
    """Return the age in words; empty for None."""
    if age_years is None:
        return ""
    return translate_plural("{age} year", "{age} years", age_years).format(age=age_years)
