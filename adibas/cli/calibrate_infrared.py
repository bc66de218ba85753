"""`adibas calibrate IMAGE... --infrared IMAGE...`: both cameras and the pose between them."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from adibas.cli.calibrate_depth import REPEAT, WRONG_USAGE, board_of, say_where
from adibas.cli.console import Console
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.pipeline.calibrating import CalibratingParams
    from adibas.pipeline.calibrating_infrared import InfraredOutcome

SURE = 1.959964
MILLIMETRES = 1000.0


def add_infrared_arguments(parser: argparse.ArgumentParser) -> None:
    """Offer pairs of images."""
    parser.add_argument(
        "--infrared",
        nargs="+",
        type=Path,
        default=[],
        metavar=_("IMAGE"),
        help=_(
            "infrared images, one for each colour image of the board at the same place; paired in "
            "the order of their names. Gives the depth camera and its pose"
        ),
    )


def run_infrared(
    arguments: argparse.Namespace, console: Console, params: "CalibratingParams"
) -> int:
    """Calibrate both cameras, say what that is worth, and write it."""
    from adibas.calibration.files import read_calibration, write_calibration
    from adibas.data.calibration_verdict import Grade
    from adibas.pipeline.calibrating_infrared import calibrate_infrared, in_pairs
    from adibas.pipeline.calibration_report import report_of_infrared
    from adibas.reports.calibration import write_calibration_report

    board = board_of(arguments)
    if board is None or not arguments.images:
        console.warn(
            _(
                "To pair colour and infrared images, give both kinds, the board's inner corners "
                "and the side of its squares, such as: adibas calibrate c*.png --infrared i*.png "
                "--board 9x6 --square-mm 25 --out C.json"
            )
        )
        return WRONG_USAGE
    given = None if arguments.calibration is None else read_calibration(arguments.calibration)
    pairs = in_pairs(arguments.images, arguments.infrared)
    with console.progress(_("Looking for the board")) as progress:
        outcome = calibrate_infrared(pairs, board, given, params, progress=progress)
    is_bad = outcome.verdict.grade is Grade.REPEAT
    is_written = arguments.keep_bad or not is_bad
    if is_written:
        write_calibration(arguments.out, outcome.calibration)
    _tell(outcome, console)
    say_where(arguments, console, is_written=is_written)
    for path in arguments.report:
        report = report_of_infrared(outcome, arguments.language, previous=given)
        write_calibration_report(report, path)
        console.say(_("{file} is written.").format(file=path))
    console.give(_document(outcome, arguments.out if is_written else None))
    return REPEAT if is_bad else 0


def _tell(outcome: "InfraredOutcome", console: Console) -> None:
    fit = outcome.fit
    turn_deg, shift_mm, turn_half, shift_half = _pose(outcome)
    console.say(
        _("{n} pairs of {total} took part.").format(
            n=outcome.n_pairs - len(fit.outliers), total=len(outcome.color.images)
        )
    )
    for axis, value, half in zip("xyz", turn_deg, turn_half, strict=True):
        console.say(_line(f"color_from_depth.r{axis}", value, half, _("deg")))
    for axis, value, half in zip("xyz", shift_mm, shift_half, strict=True):
        console.say(_line(f"color_from_depth.t{axis}", value, half, "mm"))
    for sentence in outcome.verdict.sentences():
        console.say(sentence)


def _line(name: str, value: float, half: float, unit: str) -> str:
    return f"  {name} {value:10.4f} ± {half:.2g} {unit}"


def _pose(
    outcome: "InfraredOutcome",
) -> tuple[list[float], list[float], list[float], list[float]]:
    """Return the turn in degrees and the shift in millimetres, and half of their intervals."""
    from adibas.calibration.extrinsics_model import EXTRINSIC_NAMES
    from adibas.geometry.rigid import rotation_vector

    calibration = outcome.calibration
    if calibration.covariance is None:
        raise ValueError("a covariance is needed")
    at = [calibration.parameter_names.index(name) for name in EXTRINSIC_NAMES]
    half = SURE * np.sqrt(np.diag(calibration.covariance)[at])
    pose = calibration.color_from_depth
    return (
        np.degrees(rotation_vector(pose.rotation)).tolist(),
        (MILLIMETRES * pose.translation_m).tolist(),
        np.degrees(half[:3]).tolist(),
        (MILLIMETRES * half[3:]).tolist(),
    )


def _document(outcome: "InfraredOutcome", out: Path | None) -> dict[str, object]:
    turn_deg, shift_mm, turn_half, shift_half = _pose(outcome)
    verdict, birge = outcome.verdict, outcome.fit.birge_ratio
    return {
        "out": None if out is None else str(out),
        "verdict": {"grade": verdict.grade.value, "sentences": list(verdict.sentences())},
        "n_pairs": outcome.n_pairs,
        "outliers": list(outcome.fit.outliers),
        "birge_ratio": birge if math.isfinite(birge) else None,
        "turn_deg": {"value": turn_deg, "ci95_half": turn_half},
        "shift_mm": {"value": shift_mm, "ci95_half": shift_half},
    }
