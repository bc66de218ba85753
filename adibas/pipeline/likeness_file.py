"""The file of how people's limbs differ from those that are found in things."""

from functools import cache

from adibas.limbs.likeness import Likeness, likeness_from_json, likeness_to_json
from adibas.pipeline.person_quantities import QUANTITIES
from adibas.pipeline.shipped_json import read_shipped, write_shipped

FILE = ("models", "likeness.json")


@cache
def shipped_likeness() -> Likeness:
    """Return what comes with the program; see `read_shipped`."""
    return read_shipped(FILE, lambda document: likeness_from_json(document, QUANTITIES))


def write_likeness(likeness: Likeness) -> None:
    """Write the resource; see `write_shipped`."""
    write_shipped(FILE, likeness_to_json(likeness))
