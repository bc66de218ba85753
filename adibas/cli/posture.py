"""`adibas posture`: a recording in, the report out."""

import argparse
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.options import add_json
from adibas.cli.protocol_options import add_protocol, wished_protocol
from adibas.cli.recording_options import (
    add_calibration,
    add_frames,
    add_markers,
    add_oldest_calibration,
    add_recording,
    add_rotation,
)
from adibas.cli.report_options import add_patient, add_report_options, check_report
from adibas.data.posture import VIEWS
from adibas.data.report import PictureChoice
from adibas.reports import KINDS, write_report
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.data.posture import PostureAnalysis

SUMMARY = message("find the markers of a recording and write every distance and angle")

UNPLACED = message("The depth gives no position of {names}: no distance and no angle has it.")
MOST_REASONS = 10


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    add_recording(parser)
    add_markers(parser)
    add_calibration(parser)
    add_oldest_calibration(parser)
    add_rotation(parser)
    add_protocol(parser)
    parser.add_argument(
        "--labels",
        type=Path,
        metavar=_("FILE"),
        help=_("names of markers: a table with marker,label or u,v,label (pixels)"),
    )
    parser.add_argument("--view", choices=VIEWS, default="", help=_("which side is seen"))
    add_frames(parser, _("frames of the burst, B not included; all of them if not given"))
    add_patient(parser)
    add_report_options(parser)
    endings = "|".join(f"report{kind}" for kind in KINDS)
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        action="append",
        metavar=endings,
        help=_("report to write; an older one is replaced; may be given several times"),
    )
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Analyse the burst and write the report."""
    from adibas.pipeline.posture import PostureParams
    from adibas.pipeline.posture_checks import NOT_COUNTED
    from adibas.pipeline.session import PostureRequest, analyse_recording
    from adibas.pipeline.session_report import report_of_analysis
    from adibas.reports.json_report import posture_to_json

    for path in arguments.out:
        check_report(path, KINDS)
    protocol = wished_protocol(arguments)
    request = PostureRequest(
        recording=arguments.recording,
        markers=arguments.markers,
        calibration=arguments.calibration,
        frames=arguments.frames,
        view=arguments.view,
        patient=arguments.patient,
        params=PostureParams(rotation_deg=arguments.rotation),
        protocol=protocol,
        labels=arguments.labels,
        oldest_calibration_days=arguments.oldest_calibration,
    )
    with console.progress(_("Analysing")) as progress:
        analysis = analyse_recording(request, progress)
    pictures = PictureChoice(arguments.pictures)
    report = report_of_analysis(analysis, arguments.language, pictures, arguments.rotation)
    for path in arguments.out:
        write_report(report, path)
    for notice in analysis.notices:
        console.warn(_(notice))
    for reason, count in Counter(one.reason for one in analysis.rejected).most_common():
        console.warn(_(NOT_COUNTED).format(n=count, reason=_(reason)))
    unplaced = [marker.label for marker in analysis.markers if marker.position_m is None]
    if unplaced:
        console.warn(_(UNPLACED).format(names=", ".join(unplaced)))
    _tell_measures(analysis, console)
    n_markers, n_distances, n_angles = (
        len(found) for found in (analysis.markers, analysis.distances, analysis.angles)
    )
    counts = {
        "markers": translate_plural("{n} marker", "{n} markers", n_markers).format(n=n_markers),
        "distances": translate_plural("{n} distance", "{n} distances", n_distances).format(
            n=n_distances
        ),
        "angles": translate_plural("{n} angle", "{n} angles", n_angles).format(n=n_angles),
    }
    for path in arguments.out:
        console.say(_("{file}: {markers}, {distances}, {angles}.").format(file=path, **counts))
    console.give(posture_to_json(analysis))
    return 0


def _tell_measures(analysis: "PostureAnalysis", console: Console) -> None:
    """Say how many measures of the protocol have a number, and why others have none."""
    measures = analysis.measures
    if measures is None:
        return
    for notice in measures.notices:
        console.warn(notice.text)
    found = [result for result in measures.results if result.main is not None]
    console.say(
        _("{protocol}: {n} of {total} measures of this view have a value.").format(
            protocol=measures.protocol.title.text, n=len(found), total=len(measures.results)
        )
    )
    reasons = Counter(
        result.reason.text for result in measures.results if result.reason is not None
    )
    for reason, count in reasons.most_common(MOST_REASONS):
        console.warn(f"{count} \N{MULTIPLICATION SIGN} {reason}")
