"""`adibas movement`: a moving recording in, joint angles and ranges of movement out."""

import argparse
from pathlib import Path

from adibas.cli.console import Console
from adibas.cli.options import add_json
from adibas.cli.recording_options import (
    add_calibration,
    add_oldest_calibration,
    add_person,
    add_rotation,
)
from adibas.cli.report_options import add_language, add_patient, check_report
from adibas.data.posture import VIEWS
from adibas.errors import MarkerError, RecordingError
from adibas.texts import SpokenNumber, message, translate_plural
from adibas.texts import translate as _

SUMMARY = message("measure joint angles over time and how far each joint moves")

_TABLE_UNUSED = ("markers", "markerless", "model", "calibration", "view")
_MARKERS_UNUSED = ("model", "person")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument(
        "source",
        type=Path,
        metavar=_("RECORDING"),
        help=_(".mcap, .oni or a TUM RGB-D folder with markers on the joints, or a JOINTS.csv"),
    )
    parser.add_argument(
        "--markers",
        default="",
        metavar="colours.json|led",
        help=_("learned colours, or led for LED markers; not for a JOINTS.csv"),
    )
    parser.add_argument(
        "--markerless",
        action="store_true",
        help=_("find the joints in the depth alone, without markers"),
    )
    parser.add_argument(
        "--model",
        type=Path,
        metavar="model.npz",
        help=_("of limbs, with --markerless; the program's own if not given"),
    )
    add_calibration(parser)
    add_rotation(parser)
    add_oldest_calibration(parser)
    parser.add_argument(
        "--view",
        choices=VIEWS,
        default="",
        help=_("which side is seen in the first frame; found out where that can be if not given"),
    )
    add_person(
        parser, _("where there are several people; the one who was seen longest if not given")
    )
    add_patient(parser)
    add_language(parser)
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        action="append",
        metavar="report.xlsx|.pdf|.csv|.c3d|.trc",
        help=_("report to write, or joints as C3D or TRC; may be given several times"),
    )
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Measure the movement and write the reports."""
    from adibas.pipeline.movement import MovementRequest, measure_moving
    from adibas.pipeline.posture import PostureParams
    from adibas.recordings.joints_csv import is_joint_table
    from adibas.reports.movement import MOVEMENT_KINDS, write_movement
    from adibas.reports.movement_json import movement_to_json

    for path in arguments.out:
        check_report(path, MOVEMENT_KINDS)
    _check_markers(arguments, is_table=is_joint_table(arguments.source))
    request = MovementRequest(
        arguments.source,
        arguments.markers,
        arguments.markerless,
        arguments.model,
        arguments.calibration,
        arguments.view,
        arguments.patient,
        arguments.person,
        arguments.oldest_calibration,
        PostureParams(rotation_deg=arguments.rotation),
    )
    with console.progress(_("Analysing")) as progress:
        movement = measure_moving(request, progress)
    for path in arguments.out:
        write_movement(movement, path, arguments.language)
    for notice in movement.notices:
        console.warn(notice.text)
    n_angles = len(movement.ranges)
    for path in arguments.out:
        console.say(
            _("{file}: {angles} over {seconds:.1f} s.").format(
                file=path,
                angles=translate_plural("{n} angle", "{n} angles", n_angles).format(n=n_angles),
                seconds=SpokenNumber(movement.times_s[-1]),
            )
        )
    console.give(movement_to_json(movement))
    return 0


def _check_markers(arguments: argparse.Namespace, *, is_table: bool) -> None:
    """See that it is told how joints are found, and nothing that would not be listened to."""
    if is_table:
        if options := _given(arguments, _TABLE_UNUSED):
            raise RecordingError(
                "{file} is a table of joints that were found already, and has no use for "
                "{options}. Leave that out, or give the recording.",
                file=arguments.source.name,
                options=options,
            )
        return
    if arguments.markers and arguments.markerless:
        raise MarkerError("Give --markers or --markerless, not both.")
    if not (arguments.markers or arguments.markerless):
        raise MarkerError(
            "How are the joints found? Give --markers led, --markers and a file of colours from "
            "adibas markers learn, or --markerless."
        )
    if arguments.markers and (options := _given(arguments, _MARKERS_UNUSED)):
        raise MarkerError(
            "With --markers there is no use for {options}: the markers of the largest person are "
            "measured. Leave that out, or give --markerless.",
            options=options,
        )


def _given(arguments: argparse.Namespace, names: tuple[str, ...]) -> str:
    """Return those options that were given, as they are typed."""
    given = [name for name in names if getattr(arguments, name) not in {None, False, ""}]
    return ", ".join(f"--{name}" for name in given)
