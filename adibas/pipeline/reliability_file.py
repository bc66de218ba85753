"""The file of how often joints are where they are said to be."""

from functools import cache

from adibas.pipeline.shipped_json import read_shipped, write_shipped
from adibas.skeleton.reliability import Reliability, reliability_from_json, reliability_to_json

FILE = ("models", "reliability.json")


@cache
def shipped_reliability() -> Reliability:
    """Return what comes with the program; see `read_shipped`."""
    return read_shipped(FILE, reliability_from_json)


def write_reliability(reliability: Reliability) -> None:
    """Write the resource; see `write_shipped`."""
    write_shipped(FILE, reliability_to_json(reliability))
