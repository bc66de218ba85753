"""`adibas posture`: a recording in, the report out."""

import argparse
from pathlib import Path

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_out, add_report_options, frame_range
from adibas.data.posture import VIEWS
from adibas.data.report import PictureChoice
from adibas.errors import FileError
from adibas.files import check_place
from adibas.reports import KINDS, write_report
from adibas.texts import message, translate_plural
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
    add_report_options(parser)
    endings = "|".join(f"report{kind}" for kind in KINDS)
    add_out(parser, endings, _("report to write; an older one is replaced"))
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Analyse the burst and write the report."""
    from adibas.pipeline.session import PostureRequest, analyse_recording
    from adibas.pipeline.session_report import report_of_analysis
    from adibas.reports.json_report import posture_to_json

    if arguments.out.suffix.lower() not in KINDS:
        raise FileError(
            "{file} is no report. Give --out a name that ends in one of: {endings}.",
            file=arguments.out.name or str(arguments.out),
            endings=", ".join(KINDS),
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
    pictures = PictureChoice(arguments.pictures)
    write_report(report_of_analysis(analysis, arguments.language, pictures), arguments.out)
    for notice in analysis.notices:
        console.warn(_(notice))
    n_markers, n_distances, n_angles = (
        len(found) for found in (analysis.markers, analysis.distances, analysis.angles)
    )
    console.say(
        _("{file}: {markers}, {distances}, {angles}.").format(
            file=arguments.out,
            markers=translate_plural("{n} marker", "{n} markers", n_markers).format(n=n_markers),
            distances=translate_plural("{n} distance", "{n} distances", n_distances).format(
                n=n_distances
            ),
            angles=translate_plural("{n} angle", "{n} angles", n_angles).format(n=n_angles),
        )
    )
    console.give(posture_to_json(analysis))
    return 0
