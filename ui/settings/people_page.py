"""Who may open the store: a chooser, what a person is, and a passphrase typed twice."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QGroupBox,
    QLabel,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from adibas.sessions.roles import TITLES, WORDS, Role, allowed
from adibas.texts import translate as _
from ui.settings.people_presenter import PersonEntry
from ui.widgets.flow import in_a_flow
from ui.widgets.question import ask


class PeoplePage(QWidget):
    """One group; seen by administrators alone."""

    chosen = Signal(str)
    """A name; empty: a new person is described."""
    saved = Signal(object)
    """A `PersonEntry`."""
    removed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._group, self._told, self._may = QGroupBox(self), QLabel(self), QLabel(self)
        for label in (self._told, self._may):
            label.setWordWrap(True)
        self._may.setProperty("kind", "quiet")
        self._people, self._role = QComboBox(self), QComboBox(self)
        self._name, self._passphrase, self._again = (QLineEdit(self) for _field in range(3))
        for field in (self._passphrase, self._again):
            field.setEchoMode(QLineEdit.EchoMode.Password)
        self._save, self._remove = QPushButton(self), QPushButton(self)
        self._remove.setProperty("danger", "true")
        self._has_people = False
        fields = (self._people, self._name, self._role, self._passphrase, self._again)
        self._labels = {field: QLabel(self) for field in fields}
        for part in (self, self._group):  # the page is scrolled before anything is squeezed
            part.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        self._lay_out()
        self._people.activated.connect(lambda _index: self.chosen.emit(self._people.currentData()))
        self._role.currentIndexChanged.connect(self._show_what_it_may)
        self._save.clicked.connect(lambda: self.saved.emit(self._entry()))
        self._remove.clicked.connect(self._ask)
        for role in Role:
            self._role.addItem("", role)
        self.retranslate()

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        for field, label in self._labels.items():
            label.setBuddy(field)
            form.addRow(label, field)
        inner = QVBoxLayout(self._group)  # a form gives sentences of several lines too little room
        inner.addWidget(self._told)
        inner.addLayout(form)
        inner.addWidget(self._may)
        inner.addLayout(in_a_flow(self._save, self._remove))
        column = QVBoxLayout(self)
        column.setContentsMargins(9, 4, 9, 4)
        column.addWidget(self._group)

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._group.setTitle(_("Who may open the store"))
        self._told.setText(_told(has_people=self._has_people))
        for field, text in (
            (self._people, _("Person")),
            (self._name, _("Name, as the audit log tells it")),
            (self._role, _("Role")),
            (self._passphrase, _("Passphrase of this person")),
            (self._again, _("The same passphrase again")),
        ):
            self._labels[field].setText(text)
        for index, role in enumerate(Role):
            self._role.setItemText(index, _(TITLES[role]))
        self._show_what_it_may()
        self._save.setText(_("Save the person"))
        self._remove.setText(_("Remove the person..."))
        index = self._people.findData("")
        if index >= 0:
            self._people.setItemText(index, _("A new person"))

    def show_people(self, names: tuple[str, ...], chosen: str) -> None:
        self._has_people = bool(names)
        self._people.clear()
        for name in names:
            self._people.addItem(name, name)
        self._people.addItem(_("A new person"), "")
        self._people.setCurrentIndex(self._people.findData(chosen))
        self._told.setText(_told(has_people=self._has_people))

    def show_person(self, entry: PersonEntry, *, is_new: bool, can_choose_role: bool) -> None:
        self._name.setText(entry.name)
        self._name.setReadOnly(not is_new)
        self._role.setCurrentIndex(tuple(Role).index(entry.role))
        self._role.setEnabled(can_choose_role)
        for field in (self._passphrase, self._again):
            field.clear()
            field.setPlaceholderText("" if is_new else _("as it is"))
        self._remove.setEnabled(not is_new)

    def show_rights(self, *, is_seen: bool, can_change: bool) -> None:
        self.setVisible(is_seen)
        self._group.setEnabled(can_change)

    def _entry(self) -> PersonEntry:
        return PersonEntry(
            self._name.text(),
            self._role.currentData(),
            self._passphrase.text(),
            self._again.text(),
        )

    def _show_what_it_may(self) -> None:
        role = self._role.currentData()
        if role is None:
            return
        before = tuple(Role)[: tuple(Role).index(role)]
        known = set(allowed(before[-1])) if before else set()
        own = [_(WORDS[one]) for one in allowed(role) if one not in known]
        lines = [_("All that the role before it may, and:"), *own] if before else own
        self._may.setText("\n".join(lines))

    def _ask(self) -> None:
        name = self._people.currentData()
        question = _(
            "{name} will open the store no more. Backups of before still open with that "
            "passphrase. Whoever kept a copy of the store keeps what is in it."
        ).format(name=name)
        ask(self, question, _("Remove the person"), self.removed.emit)


def _told(*, has_people: bool) -> str:
    if has_people:
        return _(
            "Each opens the store with a passphrase of their own, and the audit log tells who it "
            "was. A role holds from the next time the store is opened."
        )
    return _(
        "The store has one passphrase, and whoever knows it may do everything. Add yourself first: "
        "you become the administrator, and from then on only people whom you add open the store."
    )
