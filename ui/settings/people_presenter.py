"""Who may open the store, for administrators: added, given a role, removed. Knows nothing of Qt."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from adibas.errors import AdibasError
from adibas.sessions.roles import Permission, Role
from adibas.texts import translate as _
from ui.ports import JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:
    from adibas.sessions.person_keys import Person


@dataclass(frozen=True, slots=True)
class PersonEntry:
    """A person as typed; without a passphrase the present one stays."""

    name: str = ""
    role: Role = Role.OPERATOR
    passphrase: str = ""
    repeated: str = ""


class PeopleView(Protocol):
    """The page, as this presenter needs it."""

    def show_people(self, names: tuple[str, ...], chosen: str) -> None:
        """Offer people; none chosen: a new one is described."""

    def show_person(self, entry: PersonEntry, *, is_new: bool, can_choose_role: bool) -> None:
        """Show what a person is; what was typed of a passphrase is gone."""

    def show_rights(self, *, is_seen: bool, can_change: bool) -> None:
        """Say whether the page is for whoever has the store open."""


class PeoplePresenter:
    """Changes one person at a time, in a job: a passphrase is costly by design."""

    def __init__(self, view: PeopleView, workspace: Workspace) -> None:
        self._view = view
        self._workspace = workspace
        self._people: tuple[Person, ...] = ()
        self._chosen = ""

    def enter(self) -> None:
        """Show the people as they are now, to those who may see them."""
        store = self._workspace.store
        is_seen = store.may(Permission.MANAGE_PEOPLE)
        self._view.show_rights(is_seen=is_seen, can_change=not store.is_read_only)
        if is_seen:
            self._read(self._chosen)

    def choose(self, name: str) -> None:
        """Show another person; without a name a new one is described."""
        self._chosen = name
        self._show()

    def save(self, entry: PersonEntry) -> None:
        """Add the new person, or give the chosen one the role and the passphrase."""
        if entry.passphrase != entry.repeated:
            self._workspace.tell("bad", _("The two passphrases differ. Type the same one twice."))
            return
        people, chosen = self._workspace.store.people, self._person()
        if chosen is None:
            self._change(
                lambda: people.add(entry.name, entry.role, entry.passphrase),
                _("{name} may open the store from now on.").format(name=entry.name.strip()),
                "",
            )
            return

        told = _("{name} is saved. It holds from the next time the store is opened.")
        self._change(
            lambda: people.change(
                chosen.name,
                role=None if entry.role is chosen.role else entry.role,
                passphrase=entry.passphrase or None,
            ),
            told.format(name=chosen.name),
            chosen.name,
        )

    def remove(self) -> None:
        """Let the chosen person open the store no more; the user was asked."""
        chosen = self._person()
        if chosen is None:
            return
        people = self._workspace.store.people
        told = _("{name} opens the store no more.").format(name=chosen.name)
        self._change(lambda: people.remove(chosen.name), told, "")

    def _change(self, change: Callable[[], object], told: str, chosen: str) -> None:
        def work(_control: JobControl) -> None:
            change()

        def done(_nothing: None) -> None:
            self._workspace.tell("good", told)
            self._workspace.person_changed.emit()
            self._read(chosen)

        def failed(error: AdibasError) -> None:
            self._workspace.report_problem(error)
            if self._chosen:  # what was typed of a new person stays, to be mended
                self._read(self._chosen)

        self._workspace.jobs.start(
            _("Changing who may open the store"), work, done, failed, stop="never"
        )

    def _read(self, chosen: str) -> None:
        def work(_control: JobControl) -> "tuple[Person, ...]":
            return self._workspace.store.people.all()

        def done(people: "tuple[Person, ...]") -> None:
            self._people, self._chosen = people, chosen
            self._view.show_people(tuple(one.name for one in people), chosen)
            self._show()

        self._workspace.jobs.start(_("Looking who may open the store"), work, done)

    def _person(self) -> "Person | None":
        return next((one for one in self._people if one.name == self._chosen), None)

    def _show(self) -> None:
        chosen = self._person()
        if chosen is not None:
            entry = PersonEntry(chosen.name, chosen.role)
            self._view.show_person(entry, is_new=False, can_choose_role=True)
            return
        is_first = not self._people
        entry = PersonEntry(role=Role.ADMINISTRATOR if is_first else Role.OPERATOR)
        self._view.show_person(entry, is_new=True, can_choose_role=not is_first)
