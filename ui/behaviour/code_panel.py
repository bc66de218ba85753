"""Behaviours with their keys: pressed by a key or by the mouse."""

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QPushButton, QVBoxLayout, QWidget

from adibas.reports.behaviour_texts import behaviour_text, subject_text
from adibas.texts import translate as _
from adibas.texts import translate_plural
from ui.behaviour.content import CodeKey, Desk
from ui.behaviour.rows import COLORS
from ui.widgets.flow import FlowLayout
from ui.widgets.swatch import swatch, true_icon

SWATCH_PX, SWATCH_GAP_PX = 16, 4


class CodePanel(QWidget):
    """Who is observed, and what he may do."""

    pressed = Signal(str)
    released = Signal(str)
    subject_chosen = Signal(str)
    holding_changed = Signal(bool)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._desk = Desk()
        self._subject, self._subject_label = QComboBox(self), QLabel(self)
        self._subject_label.setBuddy(self._subject)
        self._told, self._hold = QLabel(self), QCheckBox(self)
        for label in (self._told,):
            label.setWordWrap(True)
            label.setProperty("kind", "quiet")
        self._buttons: list[QPushButton] = []
        self._flow = FlowLayout()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        for widget in (self._subject_label, self._subject):
            column.addWidget(widget)
        column.addLayout(self._flow)
        column.addWidget(self._hold)
        column.addWidget(self._told)
        self._hold.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self._hold.toggled.connect(self.holding_changed)
        self._subject.activated.connect(
            lambda index: self.subject_chosen.emit(self._subject.itemData(index))
        )

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._subject_label.setText(_("&Who is observed"))
        self._hold.setText(_("&Hold keys down"))
        self._hold.setToolTip(_("A state lasts while its key is held."))
        self.show_desk(self._desk)

    def show_desk(self, desk: Desk) -> None:
        """Show what can be coded."""
        self._desk = desk
        self._show_subjects(desk)
        while len(self._buttons) < len(desk.keys):
            self._add_button()
        for number, button in enumerate(self._buttons):
            button.setVisible(number < len(desk.keys))
            if number < len(desk.keys):
                _dress(button, desk.keys[number], number)
        self._told.setText(_summary(desk))

    def _show_subjects(self, desk: Desk) -> None:
        names = ["", *(name for name, _key in desk.subjects)]
        keys = dict(desk.subjects)
        self._subject.clear()
        for name in names:
            key = f"  [{keys[name]}]" if keys.get(name) else ""
            self._subject.addItem(f"{subject_text(name)}{key}", name)
        self._subject.setCurrentIndex(max(self._subject.findData(desk.subject), 0))

    def _add_button(self) -> None:
        button = QPushButton(self)
        button.setCheckable(True)
        button.setAutoRepeat(False)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        number = len(self._buttons)
        button.pressed.connect(lambda: self.pressed.emit(self._name(number)))
        button.released.connect(lambda: self._on_released(number))
        self._buttons.append(button)
        self._flow.addWidget(button)

    def _name(self, number: int) -> str:
        return self._desk.keys[number].behaviour.name

    def _on_released(self, number: int) -> None:
        self.released.emit(self._name(number))
        self.show_desk(self._desk)  # a click ticks the button: what lasts is known by the core


def _dress(button: QPushButton, key: CodeKey, number: int) -> None:
    one = key.behaviour
    told = f"  [{one.key}]" if one.key else ""
    name = behaviour_text(one.name)
    button.setText(f"{name}{told}".replace("&", "&&"))
    button.setAccessibleName(name)
    kind = _("state") if one.kind == "state" else _("point event")
    button.setToolTip(f"{name} ({kind})\n{one.description}".strip())
    color = QColor(one.color or COLORS[number % len(COLORS)])
    button.setIconSize(QSize(SWATCH_PX + SWATCH_GAP_PX, SWATCH_PX))
    button.setIcon(true_icon(swatch(color if color.isValid() else QColor(COLORS[-1]), SWATCH_PX)))
    button.setChecked(key.is_lasting)


def _summary(desk: Desk) -> str:
    n, m = desk.n_coded, desk.n_proposed
    parts = [translate_plural("{n} event coded.", "{n} events coded.", n).format(n=n)]
    if m:
        text = translate_plural(
            "{n} event of the program to decide: Enter takes it, Delete rejects it.",
            "{n} events of the program to decide: Enter takes one, Delete rejects it.",
            m,
        )
        parts.append(text.format(n=m))
    if desk.observer:
        told = _("{observer} codes blind: what others saw is hidden, and the scheme is locked.")
        parts.append(told.format(observer=desk.observer))
    elif desk.is_locked:
        parts.append(_("The scheme is locked."))
    return " ".join(parts)
