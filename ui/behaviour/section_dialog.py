"""Tags a part of the session with a condition, and takes tags away."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.data.coding import MS_PER_S, Section
from adibas.texts import translate as _
from ui.behaviour.content import time_text
from ui.widgets.flow import in_a_flow
from ui.widgets.number_fields import DecimalField


class SectionDialog(QDialog):
    """A name and two times; below, the sections that there are."""

    marked = Signal(object)
    """A `Section` to be marked."""
    removed = Signal(object)

    def __init__(
        self,
        sections: tuple[Section, ...],
        observed_ms: tuple[int, int],
        now_ms: int,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._sections = sections
        self._begin_ms = observed_ms[0]
        self._name = QComboBox(self)
        self._name.setEditable(True)
        self._name.addItems(list(dict.fromkeys(one.name for one in sections)))
        lasts_s = (observed_ms[1] - observed_ms[0]) / MS_PER_S
        self._from, self._to = (DecimalField(self) for _edge in range(2))
        for field, seconds in (
            (self._from, (now_ms - self._begin_ms) / MS_PER_S),
            (self._to, lasts_s),
        ):
            field.setDecimals(3)
            field.setRange(0.0, lasts_s)
            field.setValue(seconds)
        self._there, self._remove = QComboBox(self), QPushButton(self)
        for one in sections:
            begin, end = (time_text(time - self._begin_ms) for time in (one.begin_ms, one.end_ms))
            self._there.addItem(f"{one.name}: {begin} \N{EN DASH} {end}")
        standard = QDialogButtonBox.StandardButton
        self._box = QDialogButtonBox(standard.Ok | standard.Cancel, self)
        form = QFormLayout()
        self._labels = [QLabel(self) for _field in range(3)]
        parts: tuple[QWidget, ...] = (self._name, self._from, self._to)
        for label, part in zip(self._labels, parts, strict=True):
            label.setBuddy(part)
            form.addRow(label, part)
        column = QVBoxLayout(self)
        column.addLayout(form)
        column.addLayout(in_a_flow(self._there, self._remove))
        column.addWidget(self._box)
        for part in (self._there, self._remove):
            part.setVisible(bool(sections))
        self._connect()
        self.retranslate()

    def _connect(self) -> None:
        self._box.accepted.connect(self._on_accepted)
        self._box.rejected.connect(self.reject)
        self._remove.clicked.connect(self._on_removed)
        self._name.editTextChanged.connect(lambda _text: self._allow())
        self._allow()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setWindowTitle(_("Section of the session"))
        texts = (_("&Condition"), _("&From [s]"), _("&To [s]"))
        for label, text in zip(self._labels, texts, strict=True):
            label.setText(text)
        self._there.setAccessibleName(_("Sections that are marked"))
        self._remove.setText(_("&Remove"))
        standard = QDialogButtonBox.StandardButton
        self._box.button(standard.Ok).setText(_("&Mark"))
        self._box.button(standard.Cancel).setText(_("Cancel"))

    def _allow(self) -> None:
        has_name = bool(self._name.currentText().strip())
        self._box.button(QDialogButtonBox.StandardButton.Ok).setEnabled(has_name)

    def _on_accepted(self) -> None:
        begin_ms, end_ms = (
            self._begin_ms + round(field.value() * MS_PER_S) for field in (self._from, self._to)
        )
        self.marked.emit(Section(self._name.currentText().strip(), begin_ms, end_ms))
        self.accept()

    def _on_removed(self) -> None:
        self.removed.emit(self._sections[self._there.currentIndex()])
        self.accept()
