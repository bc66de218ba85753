"""Who may open the store: a chooser, what a person is, and a passphrase typed twice."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QLabel, QLineEdit, QWidget

from adibas.sessions.roles import TITLES, WORDS, Role, allowed
from adibas.texts import translate as _
from ui.settings.listed_things import ListedThings
from ui.settings.people_presenter import PeoplePresenter, PersonEntry
from ui.widgets.question import ask


class PeoplePage(ListedThings):
    """Seen by administrators alone."""

    saved = Signal(object)
    """A `PersonEntry`."""
    removed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._may, self._role = QLabel(self), QComboBox(self)
        self._may.setWordWrap(True)
        self._may.setProperty("kind", "quiet")
        self._name, self._passphrase, self._again = (QLineEdit(self) for _field in range(3))
        for field in (self._passphrase, self._again):
            field.setEchoMode(QLineEdit.EchoMode.Password)
        self.remove.setProperty("danger", "true")
        self._has_people = False
        for row in (self.chooser, self._name, self._role, self._passphrase, self._again):
            self.add_row(row)
        self.lay_out(self._may, buttons=(self.save, self.remove))
        self._role.currentIndexChanged.connect(self._show_what_it_may)
        self.save.clicked.connect(lambda: self.saved.emit(self.entry()))
        self.remove.clicked.connect(self._ask)
        for role in Role:
            self._role.addItem("", role)
        self.retranslate()

    def bind(self, presenter: PeoplePresenter) -> None:
        """Send what is wanted to the presenter, and own it."""
        self._presenter = presenter
        self.chosen.connect(presenter.choose)
        self.saved.connect(presenter.save)
        self.removed.connect(presenter.remove)

    def entered(self) -> None:
        """Show what is so now."""
        self._presenter.enter()

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self.group.setTitle(_("Who may open the store"))
        self.told.setText(_told(has_people=self._has_people))
        self.name_fields(
            *(_("Person"), _("Name, as the audit log tells it"), _("Role")),
            *(_("Passphrase of this person"), _("The same passphrase again")),
            new_one=_("A new person"),
        )
        for index, role in enumerate(Role):
            self._role.setItemText(index, _(TITLES[role]))
        self._show_what_it_may()
        self.save.setText(_("Save the person"))
        self.remove.setText(_("Remove the person..."))

    def show_people(self, names: tuple[str, ...], chosen: str) -> None:
        self._has_people = bool(names)
        self.list_names(names, chosen, _("A new person"))
        self.told.setText(_told(has_people=self._has_people))

    def show_person(self, entry: PersonEntry, *, is_new: bool, can_choose_role: bool) -> None:
        self._name.setText(entry.name)
        self._name.setReadOnly(not is_new)
        self._role.setCurrentIndex(tuple(Role).index(entry.role))
        self._role.setEnabled(can_choose_role)
        for field in (self._passphrase, self._again):
            field.clear()
            field.setPlaceholderText("" if is_new else _("as it is"))
        self.remove.setEnabled(not is_new)
        self.note_shown()

    def show_rights(self, *, is_seen: bool, can_change: bool) -> None:
        self.setVisible(is_seen)
        self.group.setEnabled(can_change)

    def entry(self) -> PersonEntry:
        """Return what stands in the form."""
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
        name = self.current
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
