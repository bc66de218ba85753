"""`adibas export`: a session for the other systems of a clinic, without saying who it is."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.options import add_out
from adibas.cli.protocol_options import add_protocol, wished_protocol
from adibas.cli.report_options import add_language, check_report
from adibas.cli.store_options import add_store, open_existing
from adibas.data.report import PictureChoice
from adibas.files import check_place
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.exchange.content import Handover
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


def _add_session(parser: argparse.ArgumentParser) -> None:
    """Ask which session, and how much of the patient may be known."""
    parser.add_argument("session", metavar=_("SESSION"), help=_("its id, as `list` shows it"))
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
    """Open the store and do what was asked."""
    work: Work = arguments.work
    with open_existing(arguments) as store:
        return work(store, arguments, console)


def _fhir(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    from adibas.exchange.fhir_bundle import write_fhir

    out: Path = arguments.out
    check_report(out, (".json",))
    handover = _handed_over(store, arguments)
    n_observations = write_fhir(handover, out)
    _note(store, "fhir", handover)
    text = translate_plural("{file}: {n} observation.", "{file}: {n} observations.", n_observations)
    console.say(text.format(file=out, n=n_observations))
    console.give({"out": [str(out)], "n_observations": n_observations})
    return 0


def _dicom(store: "SessionStore", arguments: argparse.Namespace, console: Console) -> int:
    from adibas.exchange.dicom_files import dicom_paths, write_dicom

    folder: Path = arguments.out
    handover = _handed_over(store, arguments)
    for path in dicom_paths(handover, folder):
        check_place(path)
    written = write_dicom(handover, folder)
    _note(store, "dicom", handover)
    for path in written:
        console.say(str(path))
    console.give({"out": [str(path) for path in written]})
    return 0


def _handed_over(store: "SessionStore", arguments: argparse.Namespace) -> "Handover":
    """Return the session that the options name, with as much of the patient as they allow."""
    from adibas.exchange.content import hand_over
    from adibas.pipeline.stored_report import ReportWish, stored_report

    session = store.sessions.get(arguments.session)
    by_default = PictureChoice.AS_IS if arguments.with_identity else PictureChoice.BLURRED
    pictures = by_default if arguments.pictures is None else PictureChoice(arguments.pictures)
    wish = ReportWish(arguments.language, pictures, wished_protocol(arguments))
    report = stored_report(store, session.session_id, wish)
    person = store.patients.get(session.patient) if arguments.with_identity else None
    return hand_over(session.session_id, report, person)


def _note(store: "SessionStore", kind: str, handover: "Handover") -> None:
    """Write into the audit log what left the clinic, and whether it says who it is."""
    is_known = handover.subject.identity is not None
    store.note_export(f"{kind}, with identity" if is_known else kind, handover.session_id)
