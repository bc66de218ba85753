"""Documents in JSON that come with the program, and are made again by training."""

import json
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from adibas.errors import FileError
from adibas.files import DAMAGED_JSON, written_whole
from adibas.resources import resource_path

T = TypeVar("T")


def read_shipped(place: tuple[str, ...], parse: Callable[[Any], T]) -> T:
    """Return what a document of the resources says.

    Parameters
    ----------
    place : tuple of str
        Folders and name among the resources.
    parse : callable
        Takes the document; raises KeyError, TypeError or ValueError where it cannot be one.

    Raises
    ------
    FileError
        The file is missing or damaged.
    """
    path = resource_path(*place)
    try:
        return parse(json.loads(path.read_text("utf-8")))
    except (OSError, KeyError, TypeError, *DAMAGED_JSON) as error:
        raise FileError(
            "{file} is broken or missing. Install the program again.", file=path.name
        ) from error


def write_shipped(place: tuple[str, ...], document: Mapping[str, Any]) -> None:
    """Write a document among the resources, whole or not at all.

    Raises
    ------
    FileError
        It cannot be written.
    """
    with written_whole(resource_path(*place)) as unfinished:
        unfinished.write_text(json.dumps(document, indent=1), "utf-8")
