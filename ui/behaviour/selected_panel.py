"""The event that is looked at: its times, modifiers and comment."""

from dataclasses import replace

from PySide6.QtCore import QLocale, QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QGroupBox,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.data.coding import MS_PER_S, Occurrence
from adibas.data.ethogram import BETWEEN_VALUES, NO_VALUE, Modifier
from adibas.reports.behaviour_texts import behaviour_text, subject_text
from adibas.texts import translate as _
from ui.behaviour.content import Selected
from ui.widgets.flow import in_a_flow
from ui.widgets.number_fields import DecimalField

LONGEST_S = 1e6
FRAME_S = 0.033


class SelectedPanel(QGroupBox):
    """Shows an event and lets it be changed."""

    changed = Signal(object, object)
    """The `Occurrence` as it was, and as it shall be."""
    accepted = Signal()
    removed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._selected: Selected | None = None
        self._what = QLabel(self)
        self._what.setWordWrap(True)
        self._begin, self._end = (self._time_field() for _edge in range(2))
        self._comment = QLineEdit(self)
        self._comment.setObjectName("comment")
        self._accept, self._remove = QPushButton(self), QPushButton(self)
        self._labels = {name: QLabel(self) for name in ("begin", "end", "comment")}
        self._form = QFormLayout()
        self._form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        for name, field in (
            ("begin", self._begin),
            ("end", self._end),
            ("comment", self._comment),
        ):
            self._labels[name].setBuddy(field)
            self._form.addRow(self._labels[name], field)
        self._modifiers: list[tuple[QLabel, QComboBox]] = []
        self._offered: tuple[tuple[Modifier, ...], tuple[str, ...]] = ((), ())
        column = QVBoxLayout(self)
        column.addWidget(self._what)
        column.addLayout(self._form)
        column.addLayout(in_a_flow(self._accept, self._remove))
        self._begin.editingFinished.connect(self._on_edited)
        self._end.editingFinished.connect(self._on_edited)
        self._comment.editingFinished.connect(self._on_edited)
        self._accept.clicked.connect(self.accepted)
        self._remove.clicked.connect(self.removed)
        for button in (self._accept, self._remove):
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.hide()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setTitle(_("Chosen event"))
        self._labels["begin"].setText(_("Begins &at [s]"))
        self._labels["end"].setText(_("Ends a&t [s]"))
        self._labels["comment"].setText(_("Co&mment"))
        self._begin.setToolTip(_("Ctrl+B: at the frame that is seen"))
        self._end.setToolTip(_("Ctrl+E: at the frame that is seen"))
        self._accept.setText(_("Accept"))
        self._accept.setToolTip(_("Enter"))
        self.show_selected(self._selected)

    def show_selected(self, selected: Selected | None) -> None:
        """Show an event; nothing where none is chosen."""
        self._selected = selected
        self.setVisible(selected is not None)
        if selected is None:
            return
        one = selected.occurrence
        is_proposed = selected.layer == "proposed"
        text = f"{behaviour_text(one.behaviour)} ({subject_text(one.subject)})"
        self._what.setText(
            _("{event}, seen by the program").format(event=text) if is_proposed else text
        )
        for field, time_ms in ((self._begin, one.begin_ms), (self._end, one.end_ms)):
            with QSignalBlocker(field):
                field.setLocale(QLocale())
                field.setValue((time_ms - selected.since_ms) / MS_PER_S)
        told = selected.behaviour
        is_point = told.kind == "point" if told is not None else not one.duration_ms
        self._end.setEnabled(selected.layer != "begun" and not is_point)
        with QSignalBlocker(self._comment):
            self._comment.setText(one.comment)
        self._show_modifiers(selected)
        self._accept.setVisible(is_proposed)
        self._remove.setText(_("Re&ject") if is_proposed else _("De&lete"))
        self._remove.setToolTip(_("Delete key"))

    def _time_field(self) -> QDoubleSpinBox:
        field = DecimalField(self)
        field.setDecimals(3)
        field.setRange(-LONGEST_S, LONGEST_S)
        field.setSingleStep(FRAME_S)
        field.setKeyboardTracking(False)
        return field

    def _show_modifiers(self, selected: Selected) -> None:
        wanted = () if selected.behaviour is None else selected.behaviour.modifiers
        told = selected.occurrence.modifiers
        values = tuple(told[n] if n < len(told) else NO_VALUE for n in range(len(wanted)))
        if (wanted, values) == self._offered:
            return
        self._offered = (wanted, values)
        for label, field in self._modifiers:
            self._form.takeRow(field)
            for part in (label, field):
                part.hide()
                part.deleteLater()  # perhaps it is telling us of the change right now
        self._modifiers = [
            self._modifier_row(number, *pair)
            for number, pair in enumerate(zip(wanted, values, strict=True))
        ]

    def _modifier_row(
        self, number: int, modifier: Modifier, value: str
    ) -> tuple[QLabel, QComboBox]:
        field, label = QComboBox(self), QLabel(modifier.name.replace("&", "&&"), self)
        _fill(field, modifier, value)
        field.setAccessibleName(modifier.name)
        field.activated.connect(lambda _index: self._on_edited())
        line = field.lineEdit()
        if line is not None:
            line.editingFinished.connect(self._on_edited)
        self._form.insertRow(2 + number, label, field)
        return label, field

    def _on_edited(self) -> None:
        selected = self._selected
        if selected is None:
            return
        new = self._typed(selected)
        if new != selected.occurrence:
            self.changed.emit(selected.occurrence, new)

    def _typed(self, selected: Selected) -> Occurrence:
        begin_ms, end_ms = (
            round(field.value() * MS_PER_S) + selected.since_ms
            for field in (self._begin, self._end)
        )
        if not self._end.isEnabled():
            end_ms = begin_ms
        return replace(
            selected.occurrence,
            begin_ms=begin_ms,
            end_ms=end_ms,
            comment=self._comment.text(),
            modifiers=tuple(_value(field) for _label, field in self._modifiers),
        )


def _fill(field: QComboBox, modifier: Modifier, value: str) -> None:
    """Offer the values of a modifier; where several may be told, one more with what is told."""
    field.addItem("\N{EN DASH}", NO_VALUE)
    for one in modifier.values:
        field.addItem(one, one)
        if modifier.selection == "several" and value and one not in value.split(BETWEEN_VALUES):
            more = f"{value}{BETWEEN_VALUES}{one}"
            field.addItem(f"+ {one}", more)
    if modifier.selection == "number":
        field.setEditable(True)
        field.setEditText(value)
    if field.findData(value) < 0:
        field.addItem(value.replace(BETWEEN_VALUES, ", "), value)
    if not field.isEditable():
        field.setCurrentIndex(field.findData(value))


def _value(field: QComboBox) -> str:
    if field.isEditable():
        return field.currentText().strip("\N{EN DASH} ")
    return str(field.currentData())
