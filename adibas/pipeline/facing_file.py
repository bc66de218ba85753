"""The file of what tells front from back."""

from functools import cache

from adibas.limbs.facing import Facing, facing_from_json, facing_to_json
from adibas.pipeline.shipped_json import read_shipped, write_shipped

FILE = ("models", "facing.json")


@cache
def shipped_facing() -> Facing:
    """Return what comes with the program; see `read_shipped`."""
    return read_shipped(FILE, facing_from_json)


def write_facing(facing: Facing) -> None:
    """Write the resource; see `write_shipped`."""
    write_shipped(FILE, facing_to_json(facing))
