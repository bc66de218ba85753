"""`adibas record`: live frames into a recording."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.options import (
    add_json,
    add_out,
    add_overwrite,
    image_size,
    positive,
    refuse_to_replace,
)
from adibas.errors import RecordingError, SensorError
from adibas.files import check_place
from adibas.texts import SpokenNumber, message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.pipeline.recording import RecordingSummary
    from adibas.sensors import DepthCamera

SUMMARY = message("record a sensor, the simulator or a replayed recording")

INTERRUPTED = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument(
        "source",
        metavar=_("SOURCE"),
        help=_(
            "openni2[:FILE.oni|:SENSOR], realsense[:FILE|:SENSOR], simulator[:SCENE] or a recording"
        ),
    )
    parser.add_argument(
        "--seconds", type=positive, metavar="N", help=_("how long; until Ctrl-C if not given")
    )
    parser.add_argument(
        "--jpeg",
        action="store_true",
        help=_("colour as JPEG of quality 95, for long recordings; without loss if not given"),
    )
    add_overwrite(parser, _("replace a recording of that name"))
    live = parser.add_argument_group(_("live sensors only"))
    live.add_argument(
        "--color-size",
        type=image_size,
        metavar="WxH",
        help=_("size of the colour image in pixels; 1280x1024 if not given"),
    )
    live.add_argument(
        "--registered",
        action="store_true",
        help=_("let the sensor move the depth into the colour image; not for measuring"),
    )
    live.add_argument(
        "--infrared",
        action="store_true",
        help=_("what the depth camera sees in place of colour, for calibration"),
    )
    add_out(parser, _("FILE.mcap"), _("recording to write"))
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Record until the time is over, the source ends, or Ctrl-C."""
    from adibas.cli.interrupts import stop_by_signals
    from adibas.pipeline.recording import record
    from adibas.recordings import RecordingOptions

    _check_out(arguments)
    options = RecordingOptions(color="jpeg" if arguments.jpeg else "png")
    with (
        stop_by_signals() as stop,
        _open(arguments) as camera,
        console.progress(_("Recording")) as progress,
    ):
        summary = record(
            camera,
            arguments.out,
            seconds=arguments.seconds,
            progress=progress,
            stop=stop,
            options=options,
        )
        n_missing_before = camera.info.n_dropped
    is_cut_short = stop.is_set() and arguments.seconds is not None
    if summary.n_dropped > n_missing_before:
        console.warn(_dropped(summary, camera))
    if is_cut_short:
        console.warn(
            _("Stopped before the {seconds:g} s were over; what came until then is kept.").format(
                seconds=arguments.seconds
            )
        )
    _tell(summary, console)
    return INTERRUPTED if is_cut_short else 0


def _check_out(arguments: argparse.Namespace) -> None:
    """Refuse, before the sensor starts, names that would lose a recording or cannot be written."""
    out: Path = arguments.out
    if out.suffix.lower() != ".mcap":
        raise RecordingError(
            "{file} is no name for a new recording. Give --out a name that ends in .mcap; "
            "`adibas convert` makes the other formats of it.",
            file=out.name or str(out),
        )
    check_place(out)
    refuse_to_replace(out, is_allowed=arguments.overwrite)
    source = Path(arguments.source)
    if out.exists() and source.exists() and source.samefile(out):
        raise RecordingError(
            "{file} cannot be recorded into itself. Choose another name.", file=out.name
        )


def _open(arguments: argparse.Namespace) -> "DepthCamera":
    from adibas.calibration.kept import KeptCalibrations
    from adibas.sensors import SensorOptions
    from adibas.sensors.calibrated import CalibratedOpener

    default = SensorOptions()
    options = SensorOptions(
        color_size=arguments.color_size or default.color_size,
        is_depth_registered=arguments.registered,
        is_infrared=arguments.infrared,
    )
    camera = CalibratedOpener(KeptCalibrations())(arguments.source, options)
    is_for_live = arguments.color_size or arguments.registered or arguments.infrared
    if is_for_live and not camera.is_live:
        camera.close()
        raise SensorError(
            "{source} is no live sensor and gives its images as they are. Leave out --color-size, "
            "--registered and --infrared.",
            source=arguments.source,
        )
    return camera


def _dropped(summary: "RecordingSummary", camera: "DepthCamera") -> str:
    if camera.is_live:
        text = translate_plural(
            "{n_dropped} frame was lost, because the computer, the disk or the cable was too "
            "slow. Record with --jpeg or a smaller --color-size, and put the sensor into a USB "
            "port of its own.",
            "{n_dropped} frames were lost, because the computer, the disk or the cable was too "
            "slow. Record with --jpeg or a smaller --color-size, and put the sensor into a USB "
            "port of its own.",
            summary.n_dropped,
        )
    else:
        text = translate_plural(
            "{n_dropped} frame that the sensor had counted is missing in the source.",
            "{n_dropped} frames that the sensor had counted are missing in the source.",
            summary.n_dropped,
        )
    return text.format(n_dropped=summary.n_dropped)


def _tell(summary: "RecordingSummary", console: Console) -> None:
    console.say(
        translate_plural(
            "{file}: {n_frames} frame in {seconds:.1f} s, {n_dropped} dropped.",
            "{file}: {n_frames} frames in {seconds:.1f} s, {n_dropped} dropped.",
            summary.n_frames,
        ).format(
            file=summary.path,
            n_frames=summary.n_frames,
            seconds=SpokenNumber(summary.seconds),
            n_dropped=summary.n_dropped,
        )
    )
    console.give(
        {
            "out": str(summary.path),
            "n_frames": summary.n_frames,
            "n_dropped": summary.n_dropped,
            "seconds": summary.seconds,
        }
    )
