"""`adibas sessions people`: who may open the store, each with a passphrase and a role."""

import argparse
import getpass
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.store_options import add_store, read_passphrase
from adibas.errors import PassphraseError, StoreError
from adibas.sessions.roles import TITLES, WORDS, Permission, Role, may
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.sessions import SessionStore

NEW_PASSPHRASE_VARIABLE = "ADIBAS_NEW_PASSPHRASE"  # noqa: S105  (its name, not its content)

Add = Callable[[str, str], argparse.ArgumentParser]


def add_people_arguments(add: Add) -> None:
    """Say what the action takes; `add` makes its parser."""
    parser = add("people", _("Who may open the store, each with a passphrase and a role."))
    actions = parser.add_subparsers(metavar=_("ACTION"), required=True)

    def add_action(name: str, summary: str, work: object) -> argparse.ArgumentParser:
        action = actions.add_parser(name, help=summary, description=summary)
        action.set_defaults(work=work)
        add_store(action)
        return action

    add_action("list", _("The people, their roles, and what each role may."), _list)
    adding = add_action("add", _("Let somebody open the store; the first one is you."), _add)
    removing = add_action("remove", _("Let somebody open the store no more."), _remove)
    changing = add_action("role", _("Give somebody another role."), _set_role)
    anew = add_action("passphrase", _("Change your passphrase, or give somebody a new one."), _anew)
    for action in (adding, removing, changing):
        action.add_argument("name", metavar=_("NAME"), help=_("as the audit log tells it"))
    anew.add_argument(
        "name", nargs="?", metavar=_("NAME"), help=_("somebody else's; your own if not given")
    )
    _add_role(changing, "role", metavar=_("ROLE"))
    _add_role(adding, "--role", default=None)
    removing.add_argument("--yes", action="store_true", help=_("yes, that person is meant"))
    for action in (adding, anew):
        add_new_passphrase(action)


def add_new_passphrase(parser: argparse.ArgumentParser) -> None:
    """Offer `--new-passphrase-file`."""
    parser.add_argument(
        "--new-passphrase-file",
        type=Path,
        metavar=_("FILE"),
        help=_(
            "file whose first line is the new passphrase; without it the environment variable "
            "{variable}, or it is asked for"
        ).format(variable=NEW_PASSPHRASE_VARIABLE),
    )


def _add_role(parser: argparse.ArgumentParser, name: str, **more: object) -> None:
    parser.add_argument(
        name,
        choices=[role.value for role in Role],
        help=_("what that person may: see `adibas sessions people list`"),
        **more,  # type: ignore[arg-type]
    )


def _list(store: "SessionStore", _arguments: argparse.Namespace, console: Console) -> int:
    people = store.people.all()
    for one in people:
        console.say(f"{one.name}  {_(TITLES[one.role])}")
    if not people:
        console.say(_("The store has no people: whoever has its passphrase may do everything."))
    for role in Role:
        console.say(_("{role} may:").format(role=_(TITLES[role])))
        for permission in Permission:
            if may(role, permission):
                console.say(f"    {_(WORDS[permission])}")
    console.give(
        {
            "people": [{"name": one.name, "role": one.role.value} for one in people],
            "you": None if store.person is None else store.person.name,
            "may": {
                role.value: [one.value for one in Permission if may(role, one)] for role in Role
            },
        }
    )
    return 0


def _add(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    store.require(Permission.MANAGE_PEOPLE, "people")
    is_first = store.person is None
    # The first one has no choice; of the others the least is taken where nothing is said.
    usual = Role.ADMINISTRATOR if is_first else Role.OPERATOR
    role = usual if arguments.role is None else Role(arguments.role)
    person = store.people.add(arguments.name, role, read_new_passphrase(arguments))
    told = _("{name} may open the store as {role}.").format(
        name=person.name, role=_(TITLES[role]).lower()
    )
    console.say(told)
    if is_first:
        console.say(
            _(
                "From now on only people open it: the passphrase of before, or the keyring, does "
                "no more. Add a second administrator, for the day the first one is forgetful."
            )
        )
    console.give({"name": person.name, "role": role.value})
    return 0


def _remove(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    store.require(Permission.MANAGE_PEOPLE, "people")
    if not arguments.yes:
        raise StoreError(
            "{name} will not open the patient store any more. Add --yes if you mean it.",
            name=arguments.name,
        )
    store.people.remove(arguments.name)
    console.say(
        _(
            "{name} opens the store no more. Backups of before still open with that passphrase: "
            "make a new one and remove them."
        ).format(name=arguments.name)
    )
    console.give({"removed": arguments.name})
    return 0


def _set_role(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    role = Role(arguments.role)
    store.people.change(arguments.name, role=role)
    console.say(
        _("{name} is {role} from the next time they open the store.").format(
            name=arguments.name, role=_(TITLES[role]).lower()
        )
    )
    console.give({"name": arguments.name, "role": role.value})
    return 0


def _anew(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    if arguments.name is None:
        store.people.change_passphrase(arguments.passphrase, read_new_passphrase(arguments))
    else:
        store.require(Permission.MANAGE_PEOPLE, "people")
        store.people.change(arguments.name, passphrase=read_new_passphrase(arguments))
    console.say(_("From now on the new passphrase opens the patient store."))
    console.give({"name": arguments.name})
    return 0


def read_new_passphrase(arguments: argparse.Namespace) -> str:
    """Return a new passphrase as it is given; in a terminal it is asked for twice.

    Raises
    ------
    PassphraseError
        None is given where nobody can be asked, or the two differ.
    FileError
        The file cannot be read.
    """
    given = read_passphrase(arguments.new_passphrase_file)
    given = os.environ.get(NEW_PASSPHRASE_VARIABLE) if given is None else given
    if given is not None:
        return given
    if sys.stdin is None or not sys.stdin.isatty():
        raise PassphraseError(
            "A new passphrase is needed. Give a file with --new-passphrase-file FILE, or set "
            "{variable}.",
            variable=NEW_PASSPHRASE_VARIABLE,
        )
    first, second = (
        getpass.getpass(question) for question in (_("New passphrase: "), _("Once more: "))
    )
    if first != second:
        raise PassphraseError("The two passphrases differ. Type the same one twice.")
    return first
