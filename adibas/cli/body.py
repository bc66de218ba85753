"""`adibas body`: standing views or a slow turn in, one surface and the measures of the back out."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.options import add_json
from adibas.cli.protocol_options import add_protocol, wished_protocol
from adibas.cli.recording_options import add_calibration, add_frames, add_rotation
from adibas.cli.report_options import add_language, add_patient, check_report, check_surface
from adibas.data.posture import VIEWS
from adibas.errors import BodyError
from adibas.texts import SpokenNumber, message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.pipeline.body import MeasuredBody
    from adibas.pipeline.body_views import ViewRequest

SUMMARY = message(
    "join standing views, or a slow turn, of a patient into one surface, and measure the back"
)
TURN = "turn"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument(
        "views",
        nargs="+",
        type=_source_of,
        metavar=_("VIEW=RECORDING"),
        help=_(
            "anterior, posterior, right_lateral or left_lateral, and the recording that shows it; "
            "or turn, and one of a patient who turns around slowly"
        ),
    )
    parser.add_argument(
        "--begins",
        choices=VIEWS,
        default="posterior",
        help=_("the view with which a turn begins; posterior if not given"),
    )
    add_calibration(parser)
    add_rotation(parser)
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
    add_protocol(parser)
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
    views = [
        ViewRequest(view, path, arguments.calibration, arguments.frames, arguments.rotation)
        for view, path in arguments.views
    ]
    turn = _only_turn([one for one in views if one.view == TURN])
    request = BodyRequest(
        tuple(one for one in views if one.view != TURN),
        arguments.markers,
        dict(arguments.labels),
        arguments.patient,
        None if turn is None else replace(turn, view=arguments.begins),
        wished_protocol(arguments),
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
    _tell_measures(body, console)
    console.give(body_to_json(body))
    return 0


def _tell_measures(body: "MeasuredBody", console: Console) -> None:
    """Say how many measures of the protocol all views give, and how many a view alone does."""
    if not body.protocol:
        return
    pairs = [pair for side in body.protocol for pair in side.pairs()]
    console.say(
        _(
            "{protocol}: of {total} measures {n} have a value from all views together, {own} from "
            "their own view."
        ).format(
            protocol=body.protocol[0].fused.protocol.title.text,
            total=len(pairs),
            n=sum(fused.main is not None for _seen, fused in pairs),
            own=sum(seen is not None and seen.main is not None for seen, _fused in pairs),
        )
    )


def _only_turn(turns: "Sequence[ViewRequest]") -> "ViewRequest | None":
    if len(turns) > 1:
        raise BodyError("Two turns are given. Give one.")
    return turns[0] if turns else None


def _source_of(text: str) -> tuple[str, Path]:
    """Read ``VIEW=PATH`` or ``turn=PATH``."""
    return _pair_of(text, (*VIEWS, TURN))


def _view_of(text: str) -> tuple[str, Path]:
    """Read ``VIEW=PATH``."""
    return _pair_of(text, VIEWS)


def _pair_of(text: str, names: tuple[str, ...]) -> tuple[str, Path]:
    name, equals, path = text.partition("=")
    if not equals or not path or name not in names:
        raise argparse.ArgumentTypeError(
            _("{text} names no view: give one of {views}, = and a file").format(
                text=text, views=", ".join(names)
            )
        )
    return name, Path(path)
