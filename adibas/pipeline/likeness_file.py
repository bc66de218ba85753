"""The file of how people's limbs differ from those that are found in things."""

import json
from functools import cache

from adibas.errors import FileError
from adibas.files import DAMAGED_JSON, written_whole
from adibas.limbs.likeness import Likeness, likeness_from_json, likeness_to_json
from adibas.pipeline.person_quantities import QUANTITIES
from adibas.resources import resource_path

FILE = ("models", "likeness.json")


@cache
def shipped_likeness() -> Likeness:
    """Return what comes with the program.

    Raises
    ------
    FileError
        The file is missing or damaged.
    """
    path = resource_path(*FILE)
    try:
        return likeness_from_json(json.loads(path.read_text("utf-8")), QUANTITIES)
    except (OSError, KeyError, TypeError, *DAMAGED_JSON) as error:
        raise FileError(
            "{file} is broken or missing. Install the program again.", file=path.name
        ) from error


def write_likeness(likeness: Likeness) -> None:
    """Write the resource.

    Raises
    ------
    FileError
        It cannot be written.
    """
    with written_whole(resource_path(*FILE)) as unfinished:
        unfinished.write_text(json.dumps(likeness_to_json(likeness), indent=1), "utf-8")
