"""The editor of a marker's name, with suggestions."""

from PySide6.QtCore import QModelIndex, QObject, QPersistentModelIndex, Qt
from PySide6.QtWidgets import (
    QCompleter,
    QLineEdit,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from adibas.data.corrections import LONGEST_LABEL
from adibas.texts import translate as _


class NameDelegate(QStyledItemDelegate):
    """Types a name of 40 characters at most; suggests those that hold what was typed."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.names: tuple[str, ...] = ()

    def createEditor(  # noqa: N802  (Qt's name)
        self,
        parent: QWidget,
        option: QStyleOptionViewItem,  # noqa: ARG002  (Qt's signature)
        index: QModelIndex | QPersistentModelIndex,  # noqa: ARG002  (Qt's signature)
    ) -> QWidget:
        editor = QLineEdit(parent)
        editor.setMaxLength(LONGEST_LABEL)
        editor.setAccessibleName(_("Name of the marker"))
        completer = QCompleter(list(self.names), editor)
        completer.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        completer.setFilterMode(Qt.MatchFlag.MatchContains)
        editor.setCompleter(completer)
        return editor
