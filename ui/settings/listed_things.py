"""What the pages of people and of servers share: a chooser above a form for one of them."""

from abc import abstractmethod
from collections.abc import Sequence

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QGroupBox,
    QLabel,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from ui.widgets.flow import in_a_flow


class ListedThings(QWidget):
    """One group: a sentence, a chooser with a new one at its end, a form, and buttons."""

    chosen = Signal(str)
    """A name; empty: a new one is described."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.group, self.told, self.chooser = QGroupBox(self), QLabel(self), QComboBox(self)
        self.save, self.remove = QPushButton(self), QPushButton(self)
        self.told.setWordWrap(True)
        for part in (self, self.group):  # the page is scrolled before anything is squeezed
            part.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        self.form = QFormLayout()
        self.form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        self._labels: dict[QWidget, QLabel] = {}
        self._shown: object = None
        self.chooser.activated.connect(lambda _index: self.chosen.emit(self.chooser.currentData()))

    @property
    def current(self) -> str:
        """Name of the chosen one; empty for a new one."""
        return self.chooser.currentData() or ""

    @abstractmethod
    def entry(self) -> object:
        """Return what stands in the form."""

    def note_shown(self) -> None:
        """Note that what stands in the form now was not typed."""
        self._shown = self.entry()

    @property
    def is_unsaved(self) -> bool:
        """Whether anything was typed since the form was filled."""
        return self._shown is not None and self.entry() != self._shown

    def add_row(self, field: QWidget) -> None:
        """Add a field with its label to the form; `name_fields` gives the label its text."""
        label = QLabel(self)
        label.setBuddy(field)
        self._labels[field] = label
        self.form.addRow(label, field)

    def lay_out(self, *below: QWidget, buttons: Sequence[QWidget]) -> None:
        """Put the sentence, the form, what is below it, and the buttons into the group."""
        inner = QVBoxLayout(self.group)  # a form gives sentences of several lines too little room
        inner.addWidget(self.told)
        inner.addLayout(self.form)
        for part in below:
            inner.addWidget(part)
        inner.addLayout(in_a_flow(*buttons))
        column = QVBoxLayout(self)
        column.setContentsMargins(9, 4, 9, 4)
        column.addWidget(self.group)

    def name_fields(self, *texts: str, new_one: str) -> None:
        """Name the fields in the order in which they were added, and what is not there yet."""
        for label, text in zip(self._labels.values(), texts, strict=True):
            label.setText(text)
        index = self.chooser.findData("")
        if index >= 0:
            self.chooser.setItemText(index, new_one)

    def list_names(self, names: Sequence[str], chosen: str, new_one: str) -> None:
        """Offer these and a new one; choose one of them."""
        self.chooser.clear()
        for name in names:
            self.chooser.addItem(name, name)
        self.chooser.addItem(new_one, "")
        self.chooser.setCurrentIndex(self.chooser.findData(chosen))
