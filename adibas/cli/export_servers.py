"""The parts of `adibas export` that speak to a DICOM server: name one, ask it, send to it."""

import argparse
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adibas.cli.console import Console
from adibas.cli.options import add_json, positive_count
from adibas.errors import ExchangeError
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.exchange.orders import Order
    from adibas.exchange.servers import DicomServer

AddAction = Callable[[str, str], argparse.ArgumentParser]


def add_server_arguments(add: AddAction) -> None:
    """Offer `server` and `worklist`."""
    naming = add("server", _("DICOM servers of the clinic: name one, test it, or list them."))
    naming.set_defaults(alone=_server)
    naming.add_argument("name", nargs="?", metavar=_("NAME"), help=_("what you call it"))
    naming.add_argument("--host", metavar=_("HOST"), help=_("its name or address in the network"))
    naming.add_argument("--port", type=positive_count, metavar="N", help=_("such as 104 or 11112"))
    naming.add_argument("--title", metavar=_("TITLE"), help=_("its application entity title"))
    naming.add_argument(
        "--own-title", metavar=_("TITLE"), help=_("this program's title; ADIBAS if not given")
    )
    naming.add_argument(
        "--encrypted", action="store_true", help=_("the server is reached with TLS")
    )
    naming.add_argument(
        "--certificates",
        type=Path,
        metavar=_("FILE"),
        help=_("certificates to trust (PEM); those of the system if not given"),
    )
    naming.add_argument("--test", action="store_true", help=_("see whether it answers"))
    naming.add_argument("--remove", action="store_true", help=_("forget it"))
    listing = add("worklist", _("What is ordered, as a server's work list tells it."))
    listing.set_defaults(alone=_worklist)
    listing.add_argument("name", metavar=_("NAME"), help=_("a server that `server` lists"))
    listing.add_argument(
        "--date", type=_day, metavar=_("YYYY-MM-DD"), help=_("of that day alone; all if not given")
    )
    listing.add_argument(
        "--names", action="store_true", help=_("names too, which are left out if not given")
    )
    for parser in (naming, listing):
        add_json(parser)


def add_order(parser: argparse.ArgumentParser) -> None:
    """Offer `--order` and `--work-list`."""
    parser.add_argument(
        "--order",
        metavar="N",
        help=_(
            "accession number of the order: the files get its study, and its patient with name "
            "and birth date"
        ),
    )
    parser.add_argument(
        "--work-list", metavar=_("NAME"), help=_("server whose work list has the order")
    )


def wished_order(arguments: argparse.Namespace) -> "Order | None":
    """Return the order that the options name.

    Raises
    ------
    ExchangeError
        There is no such order or several, no work list is named, or its server fails.
    """
    if arguments.order is None:
        return None
    if arguments.work_list is None:
        raise ExchangeError(
            "An order is looked for in a work list. Name its server with --work-list NAME."
        )
    from adibas.exchange.dicom_network import orders

    name = arguments.work_list
    found = orders(named_server(name), name, accession_number=arguments.order)
    fitting = [one for one in found if one.accession_number == arguments.order]
    if len(fitting) != 1:
        raise ExchangeError(
            "The work list of {server} has {n} orders {order}, and one is needed. Look with: "
            "adibas export worklist {server}",
            server=name,
            n=len(fitting),
            order=arguments.order,
        )
    return fitting[0]


def named_server(name: str) -> "DicomServer":
    """Return a server that this user named.

    Raises
    ------
    ExchangeError
        There is none of that name, or the list is damaged.
    FileError
        The list cannot be read.
    """
    from adibas.exchange.servers import find_server, servers_file

    return find_server(servers_file(), name)


def warn_of_listeners(server: "DicomServer", name: str, console: Console) -> None:
    """Say so where others in the network can read what is sent."""
    if server.is_open_to_listeners:
        console.warn(
            _(
                "What goes to {server} is not encrypted: whoever listens in the network can read "
                "it. Ask those who run it for TLS, and name it with --encrypted."
            ).format(server=name)
        )


def _server(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.exchange.servers import read_servers, servers_file, write_servers

    path = servers_file()
    servers = read_servers(path)
    name = arguments.name
    if name is not None and arguments.remove:
        named_server(name)
        del servers[name]
        write_servers(path, servers)
    elif name is not None and (arguments.host, arguments.port, arguments.title) != (None,) * 3:
        servers[name] = _described(arguments)
        write_servers(path, servers)
    if name is not None and arguments.test:
        _test(name, console)
    for one, server in sorted(servers.items()):
        console.say(f"{one}  {server.title}  {server.host}:{server.port}")
    if not servers:
        console.say(_("No DICOM server is named yet."))
    console.give({"servers": {one: _document(server) for one, server in servers.items()}})
    return 0


def _test(name: str, console: Console) -> None:
    from adibas.exchange.dicom_network import verify

    server = named_server(name)
    verify(server, name)
    console.say(_("{server} answers.").format(server=name))
    warn_of_listeners(server, name, console)


def _described(arguments: argparse.Namespace) -> "DicomServer":
    """Return the server that the options describe."""
    from adibas.exchange.servers import LAST_PORT, OWN_TITLE, DicomServer, can_be_server

    own_title = arguments.own_title or OWN_TITLE
    host, port = arguments.host or "", arguments.port or 0
    if not can_be_server(host, port, arguments.title or "", own_title):
        raise ExchangeError(
            "A DICOM server needs --host, --port from 1 to {last}, and --title with 1 to 16 "
            "letters without accents. Those who run it know them.",
            last=LAST_PORT,
        )
    certificates = "" if arguments.certificates is None else str(arguments.certificates.absolute())
    return DicomServer(
        host=host,
        port=port,
        title=arguments.title,
        own_title=own_title,
        is_encrypted=arguments.encrypted,
        certificates=certificates,
    )


def _worklist(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.exchange.dicom_network import orders

    name = arguments.name
    server = named_server(name)
    found = orders(server, name, arguments.date)
    for order in found:
        who = [order.patient_name] if arguments.names else []
        parts = (order.start, order.accession_number, order.procedure, *who)
        console.say("  ".join(_on_one_line(part) for part in parts if part))
    if not found:
        console.say(_("Nothing is ordered."))
    warn_of_listeners(server, name, console)
    console.give({"orders": [_order_document(one, with_name=arguments.names) for one in found]})
    return 0


def _on_one_line(text: str) -> str:
    """Return what a server told without what would steer the terminal."""
    return "".join(one if one.isprintable() else "\N{WHITE SQUARE}" for one in text)


def _order_document(order: "Order", *, with_name: bool) -> dict[str, Any]:
    name = (
        {
            "patient_id": order.patient_id,
            "patient_name": order.patient_name,
            "birth_date": order.birth_date,
        }
        if with_name
        else {}
    )
    return {
        "accession_number": order.accession_number,
        "start": order.start,
        "procedure": order.procedure,
        **name,
    }


def _document(server: "DicomServer") -> dict[str, Any]:
    return {
        "host": server.host,
        "port": server.port,
        "title": server.title,
        "own_title": server.own_title,
        "is_encrypted": server.is_encrypted,
    }


def _day(text: str) -> date:
    """Read ``YYYY-MM-DD``."""
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            _("{text} is no day: give YYYY-MM-DD such as 2026-03-27").format(text=text)
        ) from None
