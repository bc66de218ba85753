"""`adibas behaviour`: joints over time in, a timeline with all its counts out."""

import argparse
from pathlib import Path

from adibas.cli.console import Console
from adibas.cli.options import add_json, positive, seconds_range
from adibas.cli.recording_options import add_rotation, add_shown_view
from adibas.cli.report_options import add_language, add_patient, check_report
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

SUMMARY = message("turn joints over time into a timeline of activity and behaviour")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument(
        "sources",
        type=Path,
        nargs="+",
        metavar=_("RECORDING"),
        help=_(
            "a recording, in which joints are found without markers, or several of one camera in "
            "the order of time; or a JOINTS.csv"
        ),
    )
    parser.add_argument(
        "--model",
        type=Path,
        action="append",
        default=[],
        metavar="model.json",
        help=_("find the gestures of this model, too; may be given several times"),
    )
    parser.add_argument(
        "--ethogram", type=Path, metavar=_("FILE"), help=_("what behaviours are called (JSON)")
    )
    parser.add_argument(
        "--coding",
        type=Path,
        metavar=_("FILE"),
        help=_("what a human observer coded: .csv, .tsv, .xlsx, .boris or .eaf"),
    )
    add_rotation(parser)
    add_shown_view(parser)
    parser.set_defaults(refuse=parser.error)
    _add_measuring(parser)
    add_patient(parser)
    add_language(parser)
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        action="append",
        metavar="report.xlsx|.csv|DIR",
        help=_(
            "report, or what was found as a coding; may be given several times. In a folder the "
            "report is named after the recordings, and none that stands there is replaced"
        ),
    )
    add_json(parser)


def _add_measuring(parser: argparse.ArgumentParser) -> None:
    """Say how activity is measured and counted."""
    parser.add_argument(
        "--section",
        type=named_section,
        action="append",
        default=[],
        metavar=_("NAME=A:B"),
        help=_("a condition from A to B seconds, compared with others; may be given several times"),
    )
    parser.add_argument(
        "--bin",
        type=positive,
        default=60.0,
        metavar="S",
        help=_("length of a time bin, seconds; 60 if not given"),
    )
    parser.add_argument(
        "--still",
        type=seconds_range,
        metavar="A:B",
        help=_(
            "seconds in which nobody moved, on the recording's clock (timestamp_s of a table): its "
            "steps are the noise"
        ),
    )


def named_section(text: str) -> tuple[str, float, float]:
    """Read ``NAME=A:B``."""
    name, _equals, span = text.rpartition("=")
    if not name.strip():
        raise argparse.ArgumentTypeError(
            _("{text} is no section: give NAME=A:B such as game=10:70").format(text=text)
        )
    return name.strip(), *seconds_range(span)


def _file(path: Path, called: str) -> Path:
    """Return a file as it is given; in a folder one that is named after what was watched.

    There nothing that stands already is written over.
    """
    if not path.is_dir():
        return path
    from adibas.reports.batch import free_path

    return free_path(path, f"{called}-behaviour", ".xlsx")


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Measure, write the reports, and say what was found."""
    from adibas.behaviour.activity import ActivityParams
    from adibas.pipeline.behaviour import BehaviourRequest, analyse_behaviour
    from adibas.pipeline.joined_access import access_to, joined_name
    from adibas.recordings.joints_csv import is_joint_table, recording_name
    from adibas.reports.behaviour import BEHAVIOUR_KINDS, write_behaviour
    from adibas.reports.behaviour_json import behaviour_to_json

    if arguments.view and is_joint_table(arguments.sources[0]):
        arguments.refuse(_("--view is of a recording: a table of joints tells left and right"))
    names = [recording_name(path) for path in arguments.sources]
    called = joined_name(names)
    out = [_file(path, called) for path in arguments.out]
    for path in out:
        check_report(path, BEHAVIOUR_KINDS)
    request = BehaviourRequest(
        arguments.sources[0],
        tuple(arguments.model),
        arguments.ethogram,
        arguments.coding,
        tuple(arguments.section),
        arguments.bin,
        arguments.patient,
        ActivityParams(still_s=arguments.still),
        access=access_to(arguments.sources),
        name=called,
        parts=tuple(names) if len(names) > 1 else (),
        rotation_deg=arguments.rotation,
        view=arguments.view,
    )
    with console.progress(_("Analysing")) as advance:
        analysis = analyse_behaviour(request, advance)
    for path in out:
        write_behaviour(analysis, path, arguments.language)
    for notice in analysis.notices:
        console.warn(notice.text)
    n_people, n_events = len(analysis.people), len(analysis.detected.occurrences)
    for path in out:
        console.say(
            _("{file}: {people}, {events}.").format(
                file=path,
                people=translate_plural("{n} person", "{n} people", n_people).format(n=n_people),
                events=translate_plural("{n} event found", "{n} events found", n_events).format(
                    n=n_events
                ),
            )
        )
    console.give({**behaviour_to_json(analysis), "out": [str(path) for path in out]})
    return 0
