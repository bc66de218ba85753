"""`adibas posture`: a recording in, the report out."""

import argparse
from pathlib import Path

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_out, frame_range
from adibas.data.posture import VIEWS
from adibas.errors import FileError
from adibas.files import check_place
from adibas.texts import message
from adibas.texts import translate as _

SUMMARY = message("find the markers of a recording and write every distance and angle")

LED = "led"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument(
        "recording", type=Path, metavar=_("RECORDING"), help=_(".mcap, .oni or a TUM RGB-D folder")
    )
    parser.add_argument(
        "--markers",
        required=True,
        metavar="colours.json|led",
        help=_("learned colours, or led for LED markers"),
    )
    parser.add_argument(
        "--calibration",
        type=Path,
        metavar=_("FILE"),
        help=_("in place of the recording's own calibration"),
    )
    parser.add_argument("--view", choices=VIEWS, default="", help=_("which side is seen"))
    parser.add_argument(
        "--frames",
        type=frame_range,
        default=(0, None),
        metavar="A:B",
        help=_("frames of the burst, B not included; all of them if not given"),
    )
    parser.add_argument(
        "--patient", default="", metavar=_("PSEUDONYM"), help=_("shown on the report; never a name")
    )
    add_out(parser, "report.xlsx|report.csv", _("report to write; an older one is replaced"))
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Analyse the burst and write the report."""
    from adibas.pipeline.session import PostureRequest, analyse_recording
    from adibas.reports import write_posture_report
    from adibas.reports.json_report import posture_to_json

    if arguments.out.suffix.lower() not in (".xlsx", ".csv"):
        raise FileError(
            "{file} is no report. Give --out a name that ends in .xlsx or .csv.",
            file=arguments.out.name or str(arguments.out),
        )
    check_place(arguments.out)
    request = PostureRequest(
        recording=arguments.recording,
        markers=arguments.markers,
        calibration=arguments.calibration,
        frames=arguments.frames,
        view=arguments.view,
        patient=arguments.patient,
    )
    with console.progress(_("Analysing")) as progress:
        analysis = analyse_recording(request, progress)
    write_posture_report(analysis, arguments.out)
    for notice in analysis.notices:
        console.warn(notice)
    console.say(
        _("{file}: {n_markers} markers, {n_distances} distances, {n_angles} angles.").format(
            file=arguments.out,
            n_markers=len(analysis.markers),
            n_distances=len(analysis.distances),
            n_angles=len(analysis.angles),
        )
    )
    console.give(posture_to_json(analysis))
    return 0
