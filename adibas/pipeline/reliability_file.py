"""The file of how often joints are where they are said to be."""

import json
from functools import cache

from adibas.errors import FileError
from adibas.files import DAMAGED_JSON, written_whole
from adibas.resources import resource_path
from adibas.skeleton.reliability import Reliability, reliability_from_json, reliability_to_json

FILE = ("models", "reliability.json")


@cache
def shipped_reliability() -> Reliability:
    """Return what comes with the program.

    Raises
    ------
    FileError
        The file is missing or damaged.
    """
    path = resource_path(*FILE)
    try:
        return reliability_from_json(json.loads(path.read_text("utf-8")))
    except (OSError, KeyError, TypeError, *DAMAGED_JSON) as error:
        raise FileError(
            "{file} is broken or missing. Install the program again.", file=path.name
        ) from error


def write_reliability(reliability: Reliability) -> None:
    """Write the resource.

    Raises
    ------
    FileError
        It cannot be written.
    """
    with written_whole(resource_path(*FILE)) as unfinished:
        unfinished.write_text(json.dumps(reliability_to_json(reliability), indent=1), "utf-8")
