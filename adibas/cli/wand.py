"""`adibas wand`: does the sensor still measure a known length rightly."""

import argparse
from pathlib import Path

from adibas.cli.console import Console
from adibas.cli.options import add_json, positive
from adibas.cli.recording_options import add_calibration, add_frames, add_markers
from adibas.texts import message
from adibas.texts import translate as _

SUMMARY = message("measure a wand of known length, before a session: does the calibration hold")

NOT_PASSED = 1
MILLIMETRES = 1000.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument(
        "recording",
        type=Path,
        metavar=_("RECORDING"),
        help=_("a second or two of somebody who holds the wand still; .mcap, .oni or TUM folder"),
    )
    parser.add_argument(
        "--length-mm",
        type=positive,
        required=True,
        metavar="MM",
        help=_("between the middles of its two markers, measured with a ruler"),
    )
    add_markers(parser)
    add_calibration(parser)
    parser.add_argument(
        "--tolerance-mm",
        type=positive,
        default=5.0,
        metavar="MM",
        help=_("how far off is still good; 5 if not given"),
    )
    add_frames(parser, _("frames of the burst, B not included; all of them if not given"))
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Measure the wand, say how far off it is; exit code 0 only where it passes."""
    from adibas.calibration.wand import WandParams, WandResult
    from adibas.pipeline.session import PostureRequest
    from adibas.pipeline.wand_check import measure_wand

    request = PostureRequest(
        recording=arguments.recording,
        markers=arguments.markers,
        calibration=arguments.calibration,
        frames=arguments.frames,
    )
    params = WandParams(tolerance_m=arguments.tolerance_mm / MILLIMETRES)
    with console.progress(_("Analysing")) as progress:
        check = measure_wand(request, arguments.length_mm / MILLIMETRES, progress, params)
    console.say(check.sentence.text)
    console.give(
        {
            "result": check.result.value,
            "length_mm": MILLIMETRES * check.length_m,
            "measured_mm": MILLIMETRES * check.measured_m,
            "error_mm": MILLIMETRES * (check.measured_m - check.length_m),
            "ci95_mm": [MILLIMETRES * value for value in check.interval_m],
            "sentence": check.sentence.text,
        }
    )
    return 0 if check.result is WandResult.PASSED else NOT_PASSED
