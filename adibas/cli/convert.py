"""`adibas convert`: a recording into another format."""

import argparse
from pathlib import Path

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_overwrite, refuse_to_replace
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

SUMMARY = message("convert a recording: MCAP (.mcap), OpenNI2 (.oni) or a TUM RGB-D folder")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument("source", type=Path, metavar=_("IN"), help=_("recording to read"))
    parser.add_argument(
        "target",
        type=Path,
        metavar=_("OUT"),
        help=_("recording to write: .mcap, .oni, or a new folder's name without an ending"),
    )
    parser.add_argument(
        "--plain",
        action="store_true",
        help=_("MCAP with depth as plain 16-bit images, which any Foxglove reader shows"),
    )
    add_overwrite(parser, _("replace a recording of that name"))
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Convert and say what was done."""
    from adibas.recordings.convert import convert

    refuse_to_replace(arguments.target, is_allowed=arguments.overwrite)
    with console.progress(_("Converting")) as progress:
        summary = convert(
            arguments.source, arguments.target, plain=arguments.plain, progress=progress
        )
    if summary.notice:
        console.warn(summary.notice)
    console.say(
        translate_plural(
            "{file}: {n_frames} frame.", "{file}: {n_frames} frames.", summary.n_frames
        ).format(file=arguments.target, n_frames=summary.n_frames)
    )
    console.give(
        {
            "out": str(arguments.target),
            "n_frames": summary.n_frames,
            "n_dropped": summary.n_dropped,
            "notice": summary.notice,
        }
    )
    return 0
