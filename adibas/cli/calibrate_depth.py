"""`adibas calibrate RECORDING`: the colour camera of a recording, and with `--depth` the depth."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.recording_options import add_rotation
from adibas.recordings import is_named_like_recording
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.data.board import Board
    from adibas.data.calibration import RgbdCalibration
    from adibas.pipeline.calibrating import CalibratingParams, CameraOutcome
    from adibas.pipeline.calibrating_depth import DepthOutcome

REPEAT = 1
WRONG_USAGE = 2


def add_depth_arguments(parser: argparse.ArgumentParser) -> None:
    """Offer what the depth camera needs."""
    group = parser.add_argument_group(_("depth camera, from recordings of a board or a wall"))
    group.add_argument(
        "--depth",
        action="store_true",
        help=_("calibrate the depth camera of the recordings as well"),
    )
    group.add_argument(
        "--wall",
        action="store_true",
        help=_("a flat wall that fills the image is in the recordings, with or without a board"),
    )
    group.add_argument(
        "--calibration",
        type=Path,
        metavar=_("FILE"),
        help=_("of the colour camera; it is calibrated by the recordings if not given"),
    )
    add_rotation(parser)


def are_recordings(paths: Sequence[Path]) -> bool:
    """Say whether the files are recordings and not images."""
    return bool(paths) and all(is_named_like_recording(path) or path.is_dir() for path in paths)


def board_of(arguments: argparse.Namespace) -> "Board | None":
    """Return the board that was said; None where its size or that of its squares was not."""
    from adibas.data.board import Board

    if arguments.board is None or arguments.square_mm is None:
        return None
    columns, rows = arguments.board
    return Board(columns, rows, arguments.square_mm / 1000.0)


def missing(arguments: argparse.Namespace) -> str | None:
    """Return what is lacking of the command line; None where nothing is."""
    board = board_of(arguments)
    if not are_recordings(arguments.images):
        return _(
            "To calibrate the depth camera, give recordings, such as: adibas calibrate B.mcap "
            "--depth --board 9x6 --square-mm 25 --out C.json"
        )
    if board is None and (arguments.calibration is None or not arguments.wall):
        return _(
            "Give the board's inner corners and the side of its squares, such as --board 9x6 "
            "--square-mm 25. A wall alone needs --wall and the --calibration of the sensor."
        )
    return None


def run_depth(arguments: argparse.Namespace, console: Console, params: "CalibratingParams") -> int:
    """Calibrate the depth camera, and the colour camera where that is not done."""
    from adibas.calibration.files import write_calibration
    from adibas.cli.calibrate_depth_texts import depth_document, describe_depth
    from adibas.cli.calibrate_texts import describe_camera, document
    from adibas.data.calibration_verdict import Grade
    from adibas.pipeline.calibrating_pictures import joined

    problem = missing(arguments)
    if problem is not None:
        console.warn(problem)
        return WRONG_USAGE
    color, calibration = _color(arguments, console, params)
    if calibration is None:
        return REPEAT
    outcome = _depth(arguments, console, calibration, params)
    verdict = outcome.verdict if color is None else joined(color.verdict, outcome.verdict)
    is_bad = verdict.grade is Grade.REPEAT
    is_written = arguments.keep_bad or not is_bad
    if is_written:
        write_calibration(arguments.out, outcome.calibration)
    for line in describe_camera(color) if color is not None else ():
        console.say(line)
    for line in (*describe_depth(outcome), *verdict.sentences()):
        console.say(line)
    say_where(arguments, console, is_written=is_written)
    _write_reports(arguments, console, outcome, color, calibration if color is None else None)
    found = depth_document(outcome, verdict, arguments.out if is_written else None)
    console.give(found if color is None else found | {"color": document(color, None)})
    return REPEAT if is_bad else 0


def say_where(arguments: argparse.Namespace, console: Console, *, is_written: bool) -> None:
    """Say whether the calibration is written."""
    if is_written:
        console.say(_("{file} is written.").format(file=arguments.out))
    else:
        console.warn(
            _("{file} is not written; add --keep-bad to write it all the same.").format(
                file=arguments.out
            )
        )


def color_of_recordings(
    arguments: argparse.Namespace, console: Console, params: "CalibratingParams"
) -> "CameraOutcome":
    """Calibrate the colour camera of the recordings."""
    from adibas.pipeline.calibrating_recording import calibrate_color_of

    board = board_of(arguments)
    if board is None:
        raise ValueError("a board is needed")
    with console.progress(_("Looking for the board")) as progress:
        outcome = calibrate_color_of(arguments.images, board, params, progress=progress)
    if outcome is None:
        raise ValueError("nothing can stop this calibration")
    return outcome


def _color(
    arguments: argparse.Namespace, console: Console, params: "CalibratingParams"
) -> "tuple[CameraOutcome | None, RgbdCalibration | None]":
    """Return the colour camera as it was given, or by the recordings; None where it is bad."""
    from adibas.calibration.files import read_calibration
    from adibas.cli.calibrate_texts import describe_outcome, document
    from adibas.data.calibration_verdict import Grade
    from adibas.pipeline.calibrating import color_calibration
    from adibas.pipeline.calibrating_recording import serial_of

    if arguments.calibration is not None:
        return None, read_calibration(arguments.calibration)
    outcome = color_of_recordings(arguments, console, params)
    fit = outcome.fit
    is_fitted = fit is not None and fit.is_settled
    is_bad = outcome.verdict.grade is Grade.REPEAT
    if fit is None or not is_fitted or (is_bad and not arguments.keep_bad):
        for line in describe_outcome(outcome):
            console.say(line)
        console.warn(_("{file} is not written.").format(file=arguments.out))
        console.give({"out": None, "color": document(outcome, None)})
        return outcome, None
    serial = serial_of(arguments.images)
    return outcome, color_calibration(fit, serial, method=outcome.method)


def _depth(
    arguments: argparse.Namespace,
    console: Console,
    calibration: "RgbdCalibration",
    params: "CalibratingParams",
) -> "DepthOutcome":
    from adibas.pipeline.calibrating_depth import (
        DepthCalibratingParams,
        DepthRequest,
        calibrate_depth,
    )

    first, *more = arguments.images
    request = DepthRequest(
        first,
        calibration,
        board_of(arguments),
        has_wall=arguments.wall,
        more_recordings=tuple(more),
        rotation_deg=arguments.rotation,
    )
    with console.progress(_("Calibrating the depth camera")) as progress:
        outcome = calibrate_depth(request, progress, DepthCalibratingParams(finder=params.finder))
    if outcome is None:
        raise ValueError("nothing can stop this calibration")
    return outcome


def _write_reports(
    arguments: argparse.Namespace,
    console: Console,
    outcome: "DepthOutcome",
    color: "CameraOutcome | None",
    previous: "RgbdCalibration | None",
) -> None:
    from adibas.pipeline.calibration_report import report_of_sensor
    from adibas.reports.calibration import write_calibration_report

    for path in arguments.report:
        report = report_of_sensor(
            outcome, color, board_of(arguments), arguments.language, previous=previous
        )
        write_calibration_report(report, path)
        console.say(_("{file} is written.").format(file=path))
