"""Which images of a TUM RGB-D folder are one frame: as our notes say, the rest by time."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias, cast

import numpy as np

from adibas.arrays import IntArray
from adibas.errors import RecordingError
from adibas.files import is_there
from adibas.recordings.association import NONE, associate
from adibas.recordings.ports import MAX_SEQUENCE, MAX_TIMESTAMP_NS
from adibas.recordings.reading import cannot_read
from adibas.recordings.tum_lists import (
    COLOR_LIST,
    DEPTH_LIST,
    INFRARED_LIST,
    ImageList,
    ListedImage,
    read_list,
)
from adibas.recordings.tum_writer import NOTED, NOTES_FILE

Lists: TypeAlias = tuple[ImageList, ImageList, ImageList]
"""Of the depth, colour and infrared images."""

MAX_NOTES_BYTES = 64 * 1024 * 1024
DEPTH, COLOR, INFRARED = range(3)


@dataclass(frozen=True, slots=True, eq=False)
class TumFrames:
    """The frames of a folder.

    Attributes
    ----------
    sequences, times_ns : (N,) arrays
    places : (N, 3) array
        Of a frame's depth, colour and infrared image in `lists`; -1 for none.
    lists : Lists
    """

    sequences: IntArray
    times_ns: IntArray
    places: IntArray
    lists: Lists

    def images(self, index: int) -> tuple[ListedImage | None, ...]:
        """Return the depth, colour and infrared image of frame `index`."""
        places = self.places[index].tolist()
        pairs = zip(self.lists, places, strict=True)
        return tuple(None if place == NONE else images[place] for images, place in pairs)


@dataclass(frozen=True, slots=True, eq=False)
class _NotedFrames:
    sequences: IntArray
    times_ns: IntArray
    names: list[list[str | None]]


def read_notes(path: Path) -> dict[str, object]:
    """Return what our writer noted; nothing in folders of others.

    Raises
    ------
    RecordingError
        The notes cannot be read, or are damaged.
    """
    if not is_there(path):
        return {}
    try:
        with path.open("rb") as file:
            notes = json.loads(file.read(MAX_NOTES_BYTES))
    except OSError as error:
        raise cannot_read(path.name, error) from error
    except (ValueError, RecursionError) as error:
        raise _bad_notes() from error
    if not isinstance(notes, dict):
        raise _bad_notes()
    return notes


def list_frames(path: Path, notes: dict[str, object]) -> TumFrames:
    """Return the frames of the lists: first as the notes pair them, the rest by time.

    Raises
    ------
    RecordingError
        A list or the notes are damaged.
    """
    depth, color, infrared = (
        read_list(path, name) for name in (DEPTH_LIST, COLOR_LIST, INFRARED_LIST)
    )
    lists = (depth, color, infrared)
    noted = _noted_frames(notes["frames"]) if "frames" in notes else None
    first = _frames_of_notes(noted, lists) if noted else _no_frames(lists)
    rest = _frames_by_time(first)
    return TumFrames(
        np.concatenate([first.sequences, rest.sequences]),
        np.concatenate([first.times_ns, rest.times_ns]),
        np.concatenate([first.places, rest.places]),
        lists,
    )


def _noted_frames(table: object) -> _NotedFrames:
    columns = [_column(table, name) for name in NOTED]
    if len(set(map(len, columns))) != 1:
        raise _bad_notes()
    sequences, times_ns, *names = columns
    return _NotedFrames(
        _whole_numbers(sequences, MAX_SEQUENCE),
        _whole_numbers(times_ns, MAX_TIMESTAMP_NS),
        [_names(column) for column in names],
    )


def _column(table: object, name: str) -> list[object]:
    column = table.get(name) if isinstance(table, dict) else None
    if not isinstance(column, list):
        raise _bad_notes()
    return column


def _names(column: list[object]) -> list[str | None]:
    if set(map(type, column)) - {str, type(None)}:
        raise _bad_notes()
    return cast(list[str | None], column)


def _whole_numbers(column: list[object], most: int) -> IntArray:
    """Return the numbers of a column, 0 ... `most`."""
    if set(map(type, column)) - {int}:
        raise _bad_notes()
    try:
        numbers = np.array(cast(list[int], column), np.int64)
    except OverflowError as error:
        raise _bad_notes() from error
    if ((numbers < 0) | (numbers > most)).any():
        raise _bad_notes()
    return numbers


def _bad_notes() -> RecordingError:
    return RecordingError(
        "{file} is damaged. Restore it from a copy, or remove it: then frames are numbered anew.",
        file=NOTES_FILE,
    )


def _no_frames(lists: Lists) -> TumFrames:
    nothing = np.zeros(0, np.int64)
    return TumFrames(nothing, nothing, nothing.reshape(0, 3), lists)


def _frames_of_notes(noted: _NotedFrames, lists: Lists) -> TumFrames:
    """Return the noted frames of which an image is still listed."""
    pairs = zip(noted.names, lists, strict=True)
    places = np.column_stack([_places(names, images) for names, images in pairs])
    times_ns = noted.times_ns
    for kind in (INFRARED, DEPTH):  # the depth's time counts before the infrared's
        is_there = places[:, kind] != NONE
        times_ns = times_ns.copy()
        times_ns[is_there] = lists[kind].times_ns[places[is_there, kind]]
    is_left = (places != NONE).any(axis=1)
    return TumFrames(noted.sequences[is_left], times_ns[is_left], places[is_left], lists)


def _places(names: list[str | None], images: ImageList) -> IntArray:
    """Return where each name is listed, -1 where it is not; a name is used once."""
    if names == images.names:
        return np.arange(len(names))
    place_of = dict(zip(images.names, range(len(images)), strict=True))
    return np.array([place_of.pop(name or "", NONE) for name in names], np.int64)


def _frames_by_time(noted: TumFrames) -> TumFrames:
    """Return frames of the depth and colour images that are in none of the noted frames."""
    lists = noted.lists
    depth, color = (_unused(lists[kind], noted.places[:, kind]) for kind in (DEPTH, COLOR))
    pairs = associate(lists[DEPTH].times_ns[depth], lists[COLOR].times_ns[color])
    places = np.full((len(pairs), 3), NONE)
    times_ns = np.zeros(len(pairs), np.int64)
    for kind, unused, chosen in ((COLOR, color, pairs[:, 1]), (DEPTH, depth, pairs[:, 0])):
        is_there = chosen != NONE
        places[is_there, kind] = unused[chosen[is_there]]
        times_ns[is_there] = lists[kind].times_ns[places[is_there, kind]]
    sequences = len(noted.sequences) + np.arange(len(pairs))
    return TumFrames(sequences, times_ns, places, lists)


def _unused(images: ImageList, used: IntArray) -> IntArray:
    """Return the places of a list that are not among `used`."""
    is_unused = np.ones(len(images), np.bool_)
    is_unused[used[used != NONE]] = False
    return np.flatnonzero(is_unused)
