"""`adibas export`: a session for the other systems of a clinic, without saying who it is."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.export_servers import (
    add_order,
    add_server_arguments,
    named_server,
    warn_of_listeners,
    wished_order,
)
from adibas.cli.options import add_out, add_overwrite
from adibas.cli.protocol_options import add_protocol, wished_protocol
from adibas.cli.report_options import add_language, check_report
from adibas.cli.store_options import add_store, open_existing
from adibas.data.report import PictureChoice
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.exchange.handing_over import HandoverWish
    from adibas.sessions import SessionStore

SUMMARY = message("hand a session over to other systems as FHIR or DICOM")

Work = Callable[["SessionStore", argparse.Namespace, Console], int]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    actions = parser.add_subparsers(metavar=_("ACTION"), required=True)

    def add(name: str, summary: str, work: Work) -> argparse.ArgumentParser:
        action = actions.add_parser(name, help=summary, description=summary)
        action.set_defaults(work=work)
        add_store(action)
        _add_session(action)
        return action

    fhir = add("fhir", _("The report of a session as a FHIR R5 bundle."), _fhir)
    add_out(fhir, _("FILE"), _("file to write, NAME.json"))
    dicom = add("dicom", _("Pictures, PDF report and measures of a session as DICOM."), _dicom)
    add_out(dicom, _("DIR"), _("folder to write into"))
    add_overwrite(dicom, _("replace the DICOM files of an earlier export in that folder"))
    sending = add("send", _("The same DICOM files, sent to a server of the clinic."), _send)
    sending.add_argument(
        "--to", required=True, metavar=_("NAME"), help=_("a server that `server` lists")
    )
    for action in (dicom, sending):
        add_order(action)
    add_server_arguments(
        lambda name, summary: actions.add_parser(name, help=summary, description=summary)
    )


def _add_session(parser: argparse.ArgumentParser) -> None:
    """Ask which session, and how much of the patient may be known."""
    parser.add_argument(
        "session", metavar=_("SESSION"), help=_("its id, as `adibas sessions list` shows it")
    )
    parser.add_argument(
        "--with-identity",
        action="store_true",
        help=_(
            "name, birth date, record number, sex and notes, too; a pseudonym alone if not given"
        ),
    )
    add_language(parser)
    parser.add_argument(
        "--pictures",
        choices=tuple(choice.value for choice in PictureChoice),
        help=_(
            "how much of the patient the pictures show; the head is hidden if not given, and with "
            "--with-identity they are as they are"
        ),
    )
    add_protocol(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Open the store, where it is needed, and do what was asked."""
    if "alone" in arguments:
        return int(arguments.alone(arguments, console))
    work: Work = arguments.work
    with open_existing(arguments) as store:
        return work(store, arguments, console)


def _fhir(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    from adibas.exchange.handing_over import export_fhir

    out: Path = arguments.out
    check_report(out, (".json",))
    n_observations = export_fhir(store, _wish(arguments), out)
    text = translate_plural("{file}: {n} observation.", "{file}: {n} observations.", n_observations)
    console.say(text.format(file=out, n=n_observations))
    console.give({"out": [str(out)], "n_observations": n_observations})
    return 0


def _dicom(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    from adibas.exchange.handing_over import export_dicom

    written = export_dicom(store, _wish(arguments), arguments.out, can_replace=arguments.overwrite)
    for path in written:
        console.say(str(path))
    console.give({"out": [str(path) for path in written]})
    return 0


def _send(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    from adibas.exchange.handing_over import export_to_server

    name = arguments.to
    server = named_server(name)
    warn_of_listeners(server, name, console)
    wish = _wish(arguments)
    with console.progress(name) as progress:
        uids = export_to_server(store, wish, server, name, progress)
    text = translate_plural("{server} has {n} file.", "{server} has {n} files.", len(uids))
    console.say(text.format(server=name, n=len(uids)))
    console.give({"server": name, "sop_instance_uids": uids})
    return 0


def _wish(arguments: argparse.Namespace) -> "HandoverWish":
    """Return what the options ask for."""
    from adibas.exchange.handing_over import HandoverWish

    pictures = arguments.pictures
    return HandoverWish(
        session_id=arguments.session,
        language=arguments.language,
        with_identity=arguments.with_identity,
        pictures=None if pictures is None else PictureChoice(pictures),
        protocol=wished_protocol(arguments),
        order=wished_order(arguments) if "order" in arguments else None,
    )
