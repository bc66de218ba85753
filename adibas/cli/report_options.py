"""Options of commands that write a report on one person."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from adibas.data.report import PictureChoice
from adibas.errors import FileError
from adibas.files import check_place
from adibas.texts import LANGUAGES, spoken_language
from adibas.texts import translate as _


def add_patient(parser: argparse.ArgumentParser) -> None:
    """Offer `--patient`."""
    parser.add_argument(
        "--patient", default="", metavar=_("PSEUDONYM"), help=_("shown on the report; never a name")
    )


def add_language(parser: argparse.ArgumentParser) -> None:
    """Offer `--language`."""
    parser.add_argument(
        "--language",
        choices=tuple(LANGUAGES),
        default=spoken_language(),
        help=_("of the report; the program's own if not given"),
    )


def add_report_options(parser: argparse.ArgumentParser) -> None:
    """Offer `--language` and `--pictures`."""
    add_language(parser)
    parser.add_argument(
        "--pictures",
        choices=tuple(choice.value for choice in PictureChoice),
        default=PictureChoice.AS_IS.value,
        help=_("how much of the patient the report's pictures show; as they are if not given"),
    )


def check_report(path: Path, kinds: Sequence[str]) -> None:
    """See, before long work, that a report of one of these kinds can be written.

    Raises
    ------
    FileError
        The name ends otherwise, or nothing can be written there.
    """
    if path.suffix.lower() not in kinds:
        raise FileError(
            "{file} is no report. Give --out a name that ends in one of: {endings}.",
            file=path.name or str(path),
            endings=", ".join(kinds),
        )
    check_place(path)


def check_surface(path: Path) -> None:
    """See, before long work, that a surface can be written as PLY.

    Raises
    ------
    FileError
        The name ends otherwise, or nothing can be written there.
    """
    if path.suffix.lower() != ".ply":
        raise FileError(
            "{file} is no surface. Give --out a name that ends in .ply.",
            file=path.name or str(path),
        )
    check_place(path)
