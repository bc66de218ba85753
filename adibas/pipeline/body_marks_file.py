"""The file of where markers of joints are on bodies."""

from functools import cache

from adibas.pipeline.shipped_json import read_shipped, write_shipped
from adibas.skeleton.body_marks import BodyMarks, marks_from_json, marks_to_json

FILE = ("models", "body-marks.json")


@cache
def shipped_marks() -> BodyMarks:
    """Return what comes with the program; see `read_shipped`."""
    return read_shipped(FILE, marks_from_json)


def write_marks(marks: BodyMarks) -> None:
    """Write the resource; see `write_shipped`."""
    write_shipped(FILE, marks_to_json(marks))
