"""`adibas body`: recordings of standing views in, one surface and the measures of the back out."""

import argparse
from pathlib import Path

from adibas.cli.console import Console
from adibas.cli.options import add_json
from adibas.cli.recording_options import add_calibration, add_frames
from adibas.cli.report_options import add_language, add_patient, check_report, check_surface
from adibas.data.posture import VIEWS
from adibas.texts import SpokenNumber, message, translate_plural
from adibas.texts import translate as _

SUMMARY = message("join standing views of a patient into one surface, and measure the back")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument(
        "views",
        nargs="+",
        type=_view_of,
        metavar=_("VIEW=RECORDING"),
        help=_(
            "anterior, posterior, right_lateral or left_lateral, and the recording that shows it"
        ),
    )
    add_calibration(parser)
    add_frames(parser, _("frames of each burst, B not included; all of them if not given"))
    parser.add_argument(
        "--markers",
        default="",
        metavar="colours.json|led",
        help=_("learned colours, or led for LED markers; without, none are looked for"),
    )
    parser.add_argument(
        "--labels",
        action="append",
        default=[],
        type=_view_of,
        metavar=_("VIEW=FILE"),
        help=_("names of a view's markers: a table with marker,label or u,v,label (pixels)"),
    )
    add_patient(parser)
    add_language(parser)
    parser.add_argument(
        "--out", type=Path, required=True, metavar="body.ply", help=_("surface to write")
    )
    parser.add_argument(
        "--report",
        type=Path,
        metavar="report.xlsx|.pdf",
        help=_("report on the back to write, with pictures"),
    )
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Measure and write the files."""
    from adibas.pipeline.body import BodyRequest, measure_body
    from adibas.pipeline.body_views import ViewRequest
    from adibas.reports.body import BODY_KINDS, write_body
    from adibas.reports.body_files import body_to_json, write_body_ply

    check_surface(arguments.out)
    if arguments.report is not None:
        check_report(arguments.report, BODY_KINDS)
    request = BodyRequest(
        tuple(
            ViewRequest(view, path, arguments.calibration, arguments.frames)
            for view, path in arguments.views
        ),
        arguments.markers,
        dict(arguments.labels),
        arguments.patient,
    )
    with console.progress(_("Analysing")) as progress:
        body = measure_body(request, progress)
    write_body_ply(body.whole.surface, arguments.out)
    if arguments.report is not None:
        write_body(body, arguments.report, arguments.language)
    for notice in body.notices:
        console.warn(notice.text)
    n_points = len(body.whole.surface.points_m)
    console.say(
        _("{file}: {points} from {views}.").format(
            file=arguments.out,
            points=translate_plural("{n} point", "{n} points", n_points).format(n=n_points),
            views=translate_plural("{n} view", "{n} views", len(body.n_frames)).format(
                n=len(body.n_frames)
            ),
        )
    )
    for mark in body.landmarks:
        if mark.apart_m is not None:
            console.say(
                _("{name}: seen in {n} views, {mm:.1f} mm from their mean.").format(
                    name=mark.name, n=len(mark.places_m), mm=SpokenNumber(1e3 * mark.apart_m)
                )
            )
    console.give(body_to_json(body))
    return 0


def _view_of(text: str) -> tuple[str, Path]:
    """Read ``VIEW=PATH``."""
    view, equals, path = text.partition("=")
    if not equals or not path or view not in VIEWS:
        raise argparse.ArgumentTypeError(
            _("{text} names no view: give one of {views}, = and a file").format(
                text=text, views=", ".join(VIEWS)
            )
        )
    return view, Path(path)
