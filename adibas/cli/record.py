"""`adibas record`: live frames into a recording."""

import argparse

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_out, positive
from adibas.errors import RecordingError
from adibas.texts import translate as _

SUMMARY = "record a sensor, the simulator or a replayed recording"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument(
        "source",
        metavar="SOURCE",
        help=_("openni2[:FILE.oni], realsense[:FILE], simulator[:SCENE] or a recording"),
    )
    parser.add_argument(
        "--seconds", type=positive, metavar="N", help=_("how long; until Ctrl-C if not given")
    )
    add_out(parser, "FILE.mcap")
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Record until the time is over, the source ends, or Ctrl-C."""
    from adibas.pipeline.recording import record
    from adibas.sensors import open_source

    if arguments.out.suffix.lower() != ".mcap":
        raise RecordingError(
            "{file} is no name for a new recording. Give --out a name that ends in .mcap; "
            "`adibas convert` makes the other formats of it.",
            file=arguments.out.name,
        )
    with open_source(arguments.source) as camera, console.progress(_("Recording")) as progress:
        summary = record(camera, arguments.out, seconds=arguments.seconds, progress=progress)
    console.say(
        _("{file}: {n_frames} frames in {seconds:.1f} s, {n_dropped} dropped.").format(
            file=summary.path,
            n_frames=summary.n_frames,
            seconds=summary.seconds,
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
    return 0
