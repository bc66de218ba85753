"""`adibas calibrate`: images of a board into a calibration, or the board itself as a PDF."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.calibrate_depth import (
    add_depth_arguments,
    are_recordings,
    color_of_recordings,
    run_depth,
)
from adibas.cli.calibrate_infrared import add_infrared_arguments, run_infrared
from adibas.cli.console import Console
from adibas.cli.options import add_json, positive
from adibas.cli.report_options import add_language
from adibas.errors import CalibrationError, FileError
from adibas.files import check_place
from adibas.texts import message
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.calibration.lens_models import LensModel
    from adibas.data.calibration import RgbdCalibration
    from adibas.pipeline.calibrating import CalibratingParams, CameraOutcome

SUMMARY = message("calibrate a camera from images of a chessboard, or print the chessboard")

REPEAT = 1
WRONG_USAGE = 2
CORNERS = ("edges", "gradient")
"""The values of `adibas.calibration.corners.CornerMethod`, which brings the compiler along."""
SMALLEST_SIDE, LARGEST_SIDE = 3, 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    _add_board(parser)
    _add_results(parser)
    add_depth_arguments(parser)
    add_infrared_arguments(parser)
    add_json(parser)


def _add_board(parser: argparse.ArgumentParser) -> None:
    """Ask for images of a board, and offer what says how they are looked at."""
    parser.add_argument(
        "images",
        nargs="*",
        type=Path,
        metavar=_("IMAGE"),
        help=_(
            "images of the board, ten or more, each from another place and with another tilt; or a "
            "recording in which it is held still at such places"
        ),
    )
    parser.add_argument(
        "--board",
        type=board_size,
        metavar="CxR",
        help=_("inner corners of the board, columns x rows, such as 9x6"),
    )
    parser.add_argument(
        "--square-mm", type=positive, metavar="MM", help=_("side of a square in millimetres")
    )
    parser.add_argument(
        "--model",
        metavar=_("TERMS"),
        help=_("distortion, such as 'k1 k2 p1 p2' or 'none'; chosen by the images if not given"),
    )
    parser.add_argument(
        "--corners",
        choices=CORNERS,
        default=CORNERS[0],
        help=_(
            "what a corner is: 'edges', where the middles of its edges cross, or 'gradient', where "
            "they are steepest, to compare with OpenCV's cornerSubPix and the toolbox for Matlab; "
            "edges if not given"
        ),
    )


def _add_results(parser: argparse.ArgumentParser) -> None:
    """Ask for the files to write."""
    parser.add_argument(
        "--report",
        type=Path,
        action="append",
        default=[],
        metavar=_("REPORT.xlsx|.pdf"),
        help=_("report to write, whatever the verdict; may be given twice, for Excel and PDF"),
    )
    add_language(parser)
    parser.add_argument(
        "--keep-bad",
        action="store_true",
        help=_("write the calibration also where the verdict is to repeat it"),
    )
    parser.add_argument(
        "--print-board",
        metavar=_("SIZE"),
        help=_("write a board to print (A4, A3, A0, 115.5x84cm) instead"),
    )
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar=_("FILE"),
        help=_("calibration.json to write, or the PDF of the board"),
    )


def board_size(text: str) -> tuple[int, int]:
    """Read ``CxR``."""
    columns, cross, rows = text.lower().partition("x")
    sides = [int(side) if side.isdecimal() else 0 for side in (columns, rows)]
    if not cross or not all(SMALLEST_SIDE <= side <= LARGEST_SIDE for side in sides):
        raise argparse.ArgumentTypeError(
            _("{text} is no size of a board: give its inner corners, such as 9x6").format(text=text)
        )
    return sides[0], sides[1]


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Calibrate, say what it is worth, and write it; or write the board."""
    if arguments.print_board is not None:
        return _print_board(arguments, console)
    if arguments.depth or arguments.infrared:
        return _calibrate_sensor(arguments, console)
    if arguments.wall or arguments.calibration is not None:
        console.warn(_("--wall and --calibration go with --depth or --infrared. Add one of them."))
        return WRONG_USAGE
    if not arguments.images or arguments.board is None or arguments.square_mm is None:
        console.warn(
            _(
                "To calibrate, give images of the board, its inner corners and the side of its "
                "squares, such as: adibas calibrate *.png --board 9x6 --square-mm 25 --out C.json"
            )
        )
        return WRONG_USAGE
    check_place(arguments.out)
    _check_reports(arguments.report)
    return _calibrate(arguments, console)


def _calibrate_sensor(arguments: argparse.Namespace, console: Console) -> int:
    check_place(arguments.out)
    _check_reports(arguments.report)
    run_sensor = run_infrared if arguments.infrared else run_depth
    return run_sensor(arguments, console, _params(arguments))


def _check_reports(paths: list[Path]) -> None:
    from adibas.reports.calibration import KINDS

    for path in paths:
        if path.suffix.lower() not in KINDS:
            raise FileError(
                "{file} is no report. Give --report a name that ends in one of: {endings}.",
                file=path.name or str(path),
                endings=", ".join(KINDS),
            )
        check_place(path)


def _print_board(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.reports.board_page import write_board_pdf

    board = write_board_pdf(arguments.out, arguments.print_board)
    side_mm = 1000.0 * board.square_m
    console.say(
        _(
            "{file}: a board of {columns} x {rows} inner corners. Print it without scaling, check "
            "its ruler, and calibrate with --board {columns}x{rows} --square-mm {side:g}."
        ).format(file=arguments.out, columns=board.columns, rows=board.rows, side=side_mm)
    )
    console.give(
        {
            "out": str(arguments.out),
            "columns": board.columns,
            "rows": board.rows,
            "square_mm": side_mm,
        }
    )
    return 0


def _calibrate(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.calibration.files import write_calibration
    from adibas.cli.calibrate_texts import describe_outcome, document
    from adibas.data.calibration_verdict import Grade
    from adibas.pipeline.calibrating import color_calibration
    from adibas.pipeline.calibrating_recording import serial_of

    is_recorded = are_recordings(arguments.images)
    find = color_of_recordings if is_recorded else _color_of_images
    outcome = find(arguments, console, _params(arguments))
    is_bad = outcome.verdict.grade is Grade.REPEAT
    is_fitted = outcome.fit is not None and outcome.fit.is_settled
    is_written = is_fitted and (arguments.keep_bad or not is_bad)
    serial = serial_of(arguments.images) if is_recorded else ""
    calibration = None
    if is_fitted and outcome.fit is not None:
        calibration = color_calibration(outcome.fit, serial, method=outcome.method)
    if is_written and calibration is not None:
        write_calibration(arguments.out, calibration)
    for line in describe_outcome(outcome):
        console.say(line)
    _say_where(arguments, console, outcome, is_written=is_written)
    _write_reports(arguments, console, outcome, calibration)
    console.give(document(outcome, arguments.out if is_written else None))
    return REPEAT if is_bad else 0


def _color_of_images(
    arguments: argparse.Namespace, console: Console, params: "CalibratingParams"
) -> "CameraOutcome":
    from adibas.data.board import Board
    from adibas.pipeline.calibrating import calibrate_camera, read_images

    columns, rows = arguments.board
    board = Board(columns, rows, arguments.square_mm / 1000.0)
    with console.progress(_("Looking for the board")) as progress:
        outcome = calibrate_camera(
            read_images(arguments.images),
            board,
            params,
            n_images=len(arguments.images),
            progress=progress,
        )
    if outcome is None:
        raise ValueError("nothing can stop this calibration")
    return outcome


def _say_where(
    arguments: argparse.Namespace, console: Console, outcome: "CameraOutcome", *, is_written: bool
) -> None:
    if is_written:
        console.say(_("{file} is written.").format(file=arguments.out))
    elif outcome.fit is not None and outcome.fit.is_settled:
        console.warn(
            _("{file} is not written; add --keep-bad to write it all the same.").format(
                file=arguments.out
            )
        )
    else:
        console.warn(_("{file} is not written.").format(file=arguments.out))


def _write_reports(
    arguments: argparse.Namespace,
    console: Console,
    outcome: "CameraOutcome",
    calibration: "RgbdCalibration | None",
) -> None:
    from adibas.pipeline.calibration_report import report_of_calibration
    from adibas.reports.calibration import write_calibration_report

    for path in arguments.report:
        report = report_of_calibration(outcome, calibration, arguments.language)
        write_calibration_report(report, path)
        console.say(_("{file} is written.").format(file=path))


def _params(arguments: argparse.Namespace) -> "CalibratingParams":
    from adibas.calibration.corners import CornerMethod
    from adibas.pipeline.calibrating import params_by

    return params_by(CornerMethod(arguments.corners), _model(arguments.model))


def _model(name: str | None) -> "LensModel | None":
    from adibas.calibration.lens_models import MODELS, model_named

    if name is None:
        return None
    try:
        return model_named(" ".join(name.replace(",", " ").split()))
    except ValueError as error:
        raise CalibrationError(
            "There is no lens model {name}. Choose one of: {names}.",
            name=name,
            names="; ".join(model.name for model in MODELS),
        ) from error
