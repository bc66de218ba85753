"""Options that several commands share, and how their words are read."""

import argparse
import math
from pathlib import Path

from adibas.errors import FileError
from adibas.texts import translate as _

LARGEST_SIDE_PX = 65_535
MOST_CLUSTERS = 64


def add_json(parser: argparse.ArgumentParser) -> None:
    """Offer `--json`."""
    parser.add_argument(
        "--json", action="store_true", help=_("print one JSON document and nothing else on stdout")
    )


def add_out(parser: argparse.ArgumentParser, metavar: str, help_text: str) -> None:
    """Ask for `--out`."""
    parser.add_argument("--out", type=Path, required=True, metavar=metavar, help=help_text)


def sentence(summary: str) -> str:
    """Return the summary of a command as it stands alone."""
    return f"{summary[:1].upper()}{summary[1:]}."


def pixel(text: str) -> tuple[float, float]:
    """Read ``U,V``."""
    try:
        u, v = (float(part) for part in text.split(","))
    except ValueError:
        u = v = math.nan
    if not (math.isfinite(u) and math.isfinite(v)):
        raise argparse.ArgumentTypeError(
            _("{text} is no pixel: give U,V such as 320,240").format(text=text)
        )
    return u, v


def image_size(text: str) -> tuple[int, int]:
    """Read ``WxH``."""
    width, cross, height = text.lower().partition("x")
    sides = [int(side) if side.isdecimal() else 0 for side in (width, height)]
    if not cross or not all(0 < side <= LARGEST_SIDE_PX for side in sides):
        raise argparse.ArgumentTypeError(
            _("{text} is no size of an image: give WxH such as 1280x1024").format(text=text)
        )
    return sides[0], sides[1]


def cluster_count(text: str) -> int:
    """Read a whole number of centroids."""
    count = positive_count(text)
    if count > MOST_CLUSTERS:
        raise argparse.ArgumentTypeError(
            _("{text} is no use: a marker has few colours, give {most} at most").format(
                text=text, most=MOST_CLUSTERS
            )
        )
    return count


def frame_range(text: str) -> tuple[int, int | None]:
    """Read ``A:B`` (B not included; either may be missing)."""
    first, colon, last = text.partition(":")
    try:
        begin, end = int(first or 0), int(last) if last else None
    except ValueError:
        colon = ""
        begin, end = 0, None
    if not colon or begin < 0 or (end is not None and end <= begin):
        raise argparse.ArgumentTypeError(
            _("{text} is no range of frames: give A:B such as 0:30").format(text=text)
        )
    return begin, end


def seconds_range(text: str) -> tuple[float, float]:
    """Read ``A:B`` in seconds."""
    first, _colon, last = text.partition(":")
    try:
        begin, end = float(first), float(last)
    except ValueError:
        begin, end = 0.0, 0.0
    if not 0.0 <= begin < end < float("inf"):
        raise argparse.ArgumentTypeError(
            _("{text} is no time: give A:B in seconds such as 10:25.5").format(text=text)
        )
    return begin, end


def positive(text: str) -> float:
    """Read a number above zero."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(_("{text} is no number above zero").format(text=text))
    return value


def positive_count(text: str) -> int:
    """Read a whole number above zero."""
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(_("{text} is no whole number above 0").format(text=text))
    return int(text)


def add_overwrite(parser: argparse.ArgumentParser, help_text: str) -> None:
    """Offer `--overwrite`; see `refuse_to_replace`."""
    parser.add_argument("--overwrite", action="store_true", help=help_text)


def refuse_to_replace(path: Path, *, is_allowed: bool) -> None:
    """Raise FileError where a file stands already and may not be replaced."""
    if path.is_file() and not is_allowed:
        raise FileError(
            "{file} exists already, and nothing is replaced by mistake. Choose another place, or "
            "add --overwrite.",
            file=path.name,
        )
