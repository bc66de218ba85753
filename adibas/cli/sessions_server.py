"""`adibas sessions to-server`: the database of a store to a server, for several workstations."""

import argparse
from collections.abc import Callable

from adibas.cli.console import Console
from adibas.cli.store_options import (
    SERVER_PASSWORD_VARIABLE,
    add_store,
    passphrase_of,
    read_server_password,
    store_folder,
)
from adibas.texts import translate as _

Add = Callable[[str, str], argparse.ArgumentParser]


def add_server_arguments(add: Add) -> None:
    """Say what the action takes; `add` makes its parser."""
    parser = add(
        "to-server", _("The database to a server, so that several workstations can work with it.")
    )
    parser.set_defaults(alone=_move)
    add_store(parser)
    parser.add_argument(
        "address",
        metavar=_("ADDRESS"),
        help=_(
            "of an empty PostgreSQL database, as postgresql://USER@SERVER/DATABASE; its password "
            "is in the environment variable {variable}, or asked for"
        ).format(variable=SERVER_PASSWORD_VARIABLE),
    )


def _move(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.sessions.moving import move_to_server
    from adibas.sessions.server_address import parse_address

    address, folder = parse_address(arguments.address), store_folder(arguments)
    passphrase, password = passphrase_of(arguments, folder), read_server_password(address)
    move_to_server(folder, passphrase, address, password)
    console.say(
        _(
            "The database of {folder} is on {server} now. Let every workstation open this folder; "
            "its passphrase is the same."
        ).format(folder=folder, server=address.host)
    )
    console.give({"folder": str(folder), "server": str(address)})
    return 0
