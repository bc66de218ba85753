"""The list of markers as a table; names can be typed into it."""

import math
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtGui import QIcon

from adibas.data.landmark_texts import landmark_label, landmark_text
from adibas.data.markers import Marker
from adibas.texts import translate as _
from ui.review.content import Points
from ui.review.wording import NOTHING, number
from ui.theme import Theme
from ui.widgets.line_table import NUMBERS, title_data

Role = Qt.ItemDataRole
Index = QModelIndex | QPersistentModelIndex
NAME, X, Z, REMARK = 0, 1, 3, 4
MM_PER_M = 1000.0
SURE = 0.9
"""Of an automatic name that nobody needs to look at: of less sure ones a third is wrong."""


class MarkersModel(QAbstractTableModel):
    """Name, x, y, z with standard deviations, and what must be known of each marker."""

    renamed = Signal(str, str)
    """A marker's name, and the one that was typed."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._points = Points()
        self._is_brief = False

    def set_brief(self, *, is_brief: bool) -> None:
        """Leave standard deviations to the tool tips, where there is no room for them."""
        self._is_brief = is_brief
        self.headerDataChanged.emit(Qt.Orientation.Horizontal, X, Z)

    def show_points(self, points: Points) -> None:
        """Show these markers; where only values changed the selection stays."""
        before = [one.label for one in self._points.markers]
        if before == [one.label for one in points.markers]:
            self._points = points
            if before:
                self.dataChanged.emit(self.index(0, 0), self.index(len(before) - 1, REMARK))
        else:
            self.beginResetModel()
            self._points = points
            self.endResetModel()

    def label(self, row: int) -> str:
        """Return the name in a row."""
        return self._points.markers[row].label

    def texts(self) -> list[tuple[str, str]]:
        """Return names and remarks: what columns are fitted to."""
        return [(landmark_text(one.label), self._remark(one)) for one in self._points.markers]

    def row_of(self, label: str | None) -> int | None:
        """Return where a marker stands."""
        labels = [one.label for one in self._points.markers]
        return labels.index(label) if label in labels else None

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008  (Qt's)
        return 0 if parent.isValid() else len(self._points.markers)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008  (Qt's)
        return 0 if parent.isValid() else REMARK + 1

    def headerData(  # noqa: N802  (Qt's name)
        self, section: int, orientation: Qt.Orientation, role: int = Role.DisplayRole
    ) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        titles = (_("Marker"), "x [mm]", "y [mm]", "z [mm]", _("Remark"))
        return title_data(titles[section], role, is_number=X <= section <= Z)

    def data(self, index: Index, role: int = Role.DisplayRole) -> Any:
        marker, column = self._points.markers[index.row()], index.column()
        if role == Role.DisplayRole:
            return self._text(marker, column, is_brief=self._is_brief)
        if role == Role.ToolTipRole:
            is_remarkable = column == NAME and self._remark(marker)
            return self._text(marker, REMARK if is_remarkable else column)
        if role == Role.TextAlignmentRole and X <= column <= Z:
            return NUMBERS
        if column == NAME and role in (Role.EditRole, Role.DecorationRole):
            return self._text(marker, NAME) if role == Role.EditRole else self._icon(marker)
        return None

    def flags(self, index: Index) -> Qt.ItemFlag:
        flags = super().flags(index)
        if index.column() == NAME and self._points.can_edit:
            flags |= Qt.ItemFlag.ItemIsEditable
        return flags

    def setData(  # noqa: N802  (Qt's name)
        self, index: Index, value: Any, role: int = Role.EditRole
    ) -> bool:
        if role != Role.EditRole or index.column() != NAME:
            return False
        self.renamed.emit(self.label(index.row()), landmark_label(str(value)))
        return True

    def _text(self, marker: Marker, column: int, *, is_brief: bool = False) -> str:
        if column == NAME:
            return landmark_text(marker.label)
        if column == REMARK:
            return self._remark(marker)
        return _coordinate(marker, column - X, is_brief=is_brief)

    def _icon(self, marker: Marker) -> QIcon | None:
        """Return what is seen of the remark where there is no room for it."""
        if marker.position_m is None:
            return self._theme.icon("refused")
        if marker.label in self._points.by_hand:
            return self._theme.icon("rename")
        return self._theme.icon("help") if _is_unsure(marker) else None

    def _remark(self, marker: Marker) -> str:
        is_placed = marker.label in self._points.by_hand
        if marker.position_m is None:
            return _("corrected by hand; no depth here") if is_placed else _("no depth here")
        named = marker.named_by
        percent = 0 if named is None else math.floor(100.0 * named.confidence)
        text = _("named automatically, {percent} %")
        if _is_unsure(marker):
            text = _("named automatically, {percent} %: please check")
        sure = text.format(percent=percent) if named else ""
        remarks = (_("corrected by hand") if is_placed else "", sure)
        return "; ".join(remark for remark in remarks if remark)


def _is_unsure(marker: Marker) -> bool:
    return marker.named_by is not None and marker.named_by.confidence < SURE


def _coordinate(marker: Marker, axis: int, *, is_brief: bool) -> str:
    if marker.position_m is None or marker.covariance_m2 is None:
        return NOTHING
    coordinate = number(MM_PER_M * marker.position_m[axis])
    deviation_mm = MM_PER_M * math.sqrt(marker.covariance_m2[axis, axis])
    return coordinate if is_brief else f"{coordinate} \u00b1 {number(deviation_mm)}"
