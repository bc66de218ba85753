"""Changes a coding scheme: behaviours, kinds, keys, exclusions, modifiers, subjects."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from adibas.data.ethogram import Ethogram
from adibas.texts import message
from adibas.texts import translate as _
from ui.behaviour.scheme import (
    SchemeFields,
    TypedScheme,
    fields_of,
    with_new,
    without,
)
from ui.widgets.flow import in_a_flow
from ui.widgets.question import ask
from ui.widgets.scrolled import Scrolled

NAMES_LETTERS, FIELD_LETTERS = 20, 28
USUAL_LETTERS, USUAL_LINES = 100, 36
KINDS = {"state": message("state (it lasts)"), "point": message("point event")}
TEXTS = ("name", "key", "category", "color", "group", "modifiers", "description")


class SchemeDialog(QDialog):
    """Edits a copy; `use` takes it when it makes sense, or says why it does not.

    Parameters
    ----------
    ethogram : Ethogram
    use : callable
        Takes the fields and returns what is wrong; nothing where they were taken.
    typed : TypedScheme or None
        What was typed into it before; goes on if it was this scheme.
    """

    def __init__(
        self,
        ethogram: Ethogram,
        use: Callable[[SchemeFields], str],
        parent: QWidget | None = None,
        typed: TypedScheme | None = None,
    ) -> None:
        super().__init__(parent)
        self._opened = self._fields = fields_of(ethogram)
        if typed is not None and typed.opened == self._opened:
            self._fields = typed.fields
        self._is_given_up = False
        self._use = use
        self._is_showing = False
        self._list = QListWidget(self)
        self._kind = QComboBox(self)
        self._texts = {name: QLineEdit(self) for name in TEXTS}
        self._subjects, self._subjects_label = QLineEdit(self), QLabel(self)
        self._labels = {name: QLabel(self) for name in (*TEXTS, "kind")}
        self._add, self._remove = QPushButton(self), QPushButton(self)
        self._wrong = QLabel(self)
        self._wrong.setWordWrap(True)
        self._wrong.setProperty("kind", "bad")
        self._wrong.hide()
        standard = QDialogButtonBox.StandardButton
        self._box = QDialogButtonBox(standard.Ok | standard.Cancel, self)
        self._lay_out()
        self._connect()
        self._order_focus()
        self.retranslate()
        self._subjects.setText(self._fields.subjects)
        self._show_names(0)
        self._take_room()

    def _take_room(self) -> None:
        """Be as large as reads well, and no larger than the window."""
        metrics, parent = self.fontMetrics(), self.parentWidget()
        wanted = QSize(USUAL_LETTERS * metrics.averageCharWidth(), USUAL_LINES * metrics.height())
        self.resize(wanted if parent is None else wanted.boundedTo(parent.window().size()))

    def _lay_out(self) -> None:
        letter_px = self.fontMetrics().averageCharWidth()
        self._list.setMinimumWidth(NAMES_LETTERS * letter_px)
        form = QFormLayout()
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        rows = [("name", self._texts["name"]), ("kind", self._kind)]
        rows += [(name, self._texts[name]) for name in TEXTS[1:]]
        for name, field in rows:
            field.setMinimumWidth(FIELD_LETTERS * letter_px)
            self._labels[name].setBuddy(field)
            form.addRow(self._labels[name], field)
        left = QVBoxLayout()
        left.addWidget(self._list, 1)
        left.addLayout(in_a_flow(self._add, self._remove))
        right = Scrolled(self)
        right.column.addLayout(form)
        right.column.addStretch()
        right.setMinimumWidth(form.minimumSize().width() + 24)
        across = QHBoxLayout()
        across.setSpacing(16)
        across.addLayout(left)
        across.addWidget(right, 1)
        column = QVBoxLayout(self)
        column.addLayout(across, 1)
        self._subjects_label.setBuddy(self._subjects)
        for part in (self._subjects_label, self._subjects, self._wrong, self._box):
            column.addWidget(part)

    def _connect(self) -> None:
        self._list.currentRowChanged.connect(self._show_behaviour)
        for name, field in self._texts.items():
            field.textEdited.connect(lambda text, name=name: self._change(**{name: text}))
        self._kind.activated.connect(lambda index: self._change(kind=self._kind.itemData(index)))
        self._subjects.textEdited.connect(
            lambda text: self._take(replace(self._fields, subjects=text))
        )
        self._add.clicked.connect(self._on_add)
        self._remove.clicked.connect(self._on_remove)
        self._box.accepted.connect(self._on_accepted)
        self._box.rejected.connect(self.reject)

    def _order_focus(self) -> None:
        """Let Tab go through the fields as they are read."""
        fields = [self._texts["name"], self._kind, *(self._texts[name] for name in TEXTS[1:])]
        order = [self._list, self._add, self._remove, *fields, self._subjects]
        for before, after in pairwise(order):
            self.setTabOrder(before, after)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.setWindowTitle(_("Coding scheme"))
        self._list.setAccessibleName(_("Behaviours"))
        self._kind.clear()
        for kind, told in KINDS.items():
            self._kind.addItem(_(told), kind)
        for name, text in _labels().items():
            self._labels[name].setText(text)
        self._texts["group"].setToolTip(_("Of one group only one can last at a time."))
        self._texts["modifiers"].setToolTip(
            _(
                "name: value, value; another: value. A + before the values: several may be told; "
                "# in their place: a number."
            )
        )
        self._subjects_label.setText(_("Who is &observed (name=key, name=key)"))
        self._add.setText(_("&Add"))
        self._remove.setText(_("&Remove"))
        standard = QDialogButtonBox.StandardButton
        self._box.button(standard.Ok).setText(_("&Use this scheme"))
        self._box.button(standard.Cancel).setText(_("Cancel"))

    def unsaved(self) -> tuple[str, ...]:
        """Name the scheme, once it was changed."""
        return () if self._fields == self._opened else (_("The coding scheme"),)

    def reject(self) -> None:
        """Close; what was changed is lost after a question alone."""
        if self.unsaved():
            question = _("The coding scheme was changed and is not in use yet. Close and lose it?")
            ask(self, question, _("Close"), self._give_up)
        else:
            super().reject()

    @property
    def left_behind(self) -> TypedScheme | None:
        """Return what was typed when the window locked over it; None where its user closed it."""
        was_closed = self._is_given_up or not self.unsaved()
        return None if was_closed else TypedScheme(self._opened, self._fields)

    def _give_up(self) -> None:
        self._is_given_up = True
        super().reject()

    def _show_names(self, row: int) -> None:
        self._is_showing = True
        self._list.clear()
        self._list.addItems([one.name or "\N{EN DASH}" for one in self._fields.behaviours])
        self._is_showing = False
        self._list.setCurrentRow(min(row, self._list.count() - 1))
        self._show_behaviour(self._list.currentRow())

    def _show_behaviour(self, row: int) -> None:
        if self._is_showing:
            return
        is_there = 0 <= row < len(self._fields.behaviours)
        for field in (*self._texts.values(), self._kind, self._remove):
            field.setEnabled(is_there)
        if is_there:
            one = self._fields.behaviours[row]
            for name, field in self._texts.items():
                field.setText(getattr(one, name))
                field.setCursorPosition(0)
            self._kind.setCurrentIndex(self._kind.findData(one.kind))

    def _change(self, **changes: str) -> None:
        row = self._list.currentRow()
        if row < 0:
            return
        some = list(self._fields.behaviours)
        some[row] = replace(some[row], **changes)
        self._take(replace(self._fields, behaviours=tuple(some)))
        self._list.item(row).setText(some[row].name or "\N{EN DASH}")

    def _take(self, fields: SchemeFields) -> None:
        self._fields = fields
        self._wrong.hide()

    def _on_add(self) -> None:
        self._take(with_new(self._fields, _("new behaviour")))
        self._show_names(len(self._fields.behaviours) - 1)
        self._texts["name"].setFocus(Qt.FocusReason.OtherFocusReason)
        self._texts["name"].selectAll()

    def _on_remove(self) -> None:
        row = self._list.currentRow()
        self._take(without(self._fields, row))
        self._show_names(max(row - 1, 0))

    def _on_accepted(self) -> None:
        wrong = self._use(self._fields)
        self._wrong.setText(wrong)
        self._wrong.setVisible(bool(wrong))
        if not wrong:
            self._opened = self._fields
            self.accept()


def _labels() -> dict[str, str]:
    return {
        "name": _("&Name"),
        "kind": _("&Kind"),
        "key": _("Ke&y"),
        "category": _("&Category"),
        "color": _("Co&lour (#RRGGBB)"),
        "group": _("E&xclusive group"),
        "modifiers": _("&Modifiers"),
        "description": _("&Description"),
    }
