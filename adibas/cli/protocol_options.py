"""The options that say what to measure, and in whose plane."""

import argparse
from typing import TYPE_CHECKING

from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.pipeline.protocol_measuring import ProtocolWish

PLANES = ("sensor", "template", "acromia", "asis")
"""The values of `PlaneChoice`, which costs an import."""


def add_protocol(parser: argparse.ArgumentParser) -> None:
    """Offer `--protocol` and `--plane`."""
    parser.add_argument(
        "--protocol",
        metavar=_("NAME"),
        help=_("what to measure: a name that `adibas protocols list` shows, or a .json file"),
    )
    parser.add_argument(
        "--plane",
        choices=PLANES,
        default=PLANES[0],
        help=_(
            "vertical plane of the projected values: the sensor's if not given, the foot "
            "template's, or the patient's own"
        ),
    )


def wished_protocol(arguments: argparse.Namespace) -> "ProtocolWish | None":
    """Return what `--protocol` and `--plane` ask for.

    Raises
    ------
    ProtocolError
        There is no such protocol, or its file has a mistake.
    """
    if arguments.protocol is None:
        return None
    from adibas.data.protocol_measures import PlaneChoice
    from adibas.measures.protocol_store import find_protocol
    from adibas.pipeline.protocol_measuring import ProtocolWish

    return ProtocolWish(find_protocol(arguments.protocol), PlaneChoice(arguments.plane))
