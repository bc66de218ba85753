"""Options of commands that read a recording."""

import argparse
from pathlib import Path

from adibas.cli.options import frame_range, positive_count
from adibas.data.sessions import ROTATIONS_DEG
from adibas.texts import translate as _

SHOWN_VIEWS = ("anterior", "posterior")
"""Sides that people may show where they are found without markers."""


def add_recording(parser: argparse.ArgumentParser) -> None:
    """Ask for the recording."""
    parser.add_argument(
        "recording", type=Path, metavar=_("RECORDING"), help=_(".mcap, .oni or a TUM RGB-D folder")
    )


def add_calibration(parser: argparse.ArgumentParser) -> None:
    """Offer `--calibration`."""
    parser.add_argument(
        "--calibration",
        type=Path,
        metavar=_("FILE"),
        help=_("in place of the recording's own calibration"),
    )


def add_oldest_calibration(parser: argparse.ArgumentParser) -> None:
    """Offer `--oldest-calibration`, None if not given."""
    parser.add_argument(
        "--oldest-calibration",
        type=positive_count,
        metavar=_("DAYS"),
        help=_("refuse a calibration that is older; of any age if not given"),
    )


def add_markers(parser: argparse.ArgumentParser) -> None:
    """Ask for `--markers`."""
    parser.add_argument(
        "--markers",
        required=True,
        metavar="colours.json|led",
        help=_("learned colours, or led for LED markers"),
    )


def add_frames(parser: argparse.ArgumentParser, help_text: str) -> None:
    """Offer `--frames`, all of them if not given."""
    parser.add_argument(
        "--frames", type=frame_range, default=(0, None), metavar="A:B", help=help_text
    )


def add_rotation(parser: argparse.ArgumentParser) -> None:
    """Offer `--rotation`, 0 if not given."""
    parser.add_argument(
        "--rotation",
        type=int,
        choices=ROTATIONS_DEG,
        default=0,
        help=_(
            "degrees by which the picture is turned clockwise to be upright, for a sensor on its "
            "side; where gravity or the floor is known, that says where up is; 0 if not given"
        ),
    )


def add_person(parser: argparse.ArgumentParser, help_text: str) -> None:
    """Offer `--person`, None if not given."""
    parser.add_argument("--person", type=positive_count, metavar="N", help=help_text)


def add_shown_view(parser: argparse.ArgumentParser) -> None:
    """Say which side people show, where they are found without markers."""
    parser.add_argument(
        "--view",
        choices=SHOWN_VIEWS,
        default="",
        help=_("which side everybody shows to the camera; found out if not given"),
    )
