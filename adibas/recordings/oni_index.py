"""Finds the frames of an .oni file: by our own table behind its end, or by walking through it."""

import json
import os
from dataclasses import dataclass, field
from typing import BinaryIO

import numpy as np

from adibas.arrays import IntArray
from adibas.recordings import oni_records as oni
from adibas.recordings.association import NONE, associate
from adibas.recordings.oni_writer import NO_IMAGE, NS_PER_US, TRAILER_MAGIC, trailer_rows
from adibas.recordings.ports import MAX_SEQUENCE, MAX_TIMESTAMP_NS
from adibas.recordings.reading import DamagedError

PEEK_SIZE = oni.RECORD_HEADER.size + oni.NEW_DATA_FIELDS.size
TAIL_SIZE = 8 + 8 + 8 + len(TRAILER_MAGIC)
MAX_TRAILER = 1 << 28
STREAM_KINDS = (oni.DEPTH_NODE, oni.COLOR_NODE, oni.INFRARED_NODE)


@dataclass(slots=True)
class OniIndex:
    """Where everything is.

    Attributes
    ----------
    rows : (N, 6) array
        Number, frame time and colour time (ns), positions of depth, colour and infrared (-1 =
        none).
    nodes : dict
        Streams by their node number.
    texts : dict
        What our writer said of the source; empty in files of others.
    has_end : bool
        False where the file is cut.
    n_lost_bytes : int
        Bytes after the last whole record of a cut file.
    """

    rows: IntArray = field(default_factory=lambda: np.empty((0, 6), np.int64))
    nodes: dict[int, oni.Node] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    has_end: bool = False
    n_lost_bytes: int = 0


def read_index(file: BinaryIO) -> OniIndex:
    """Return the index of an .oni file.

    Raises
    ------
    DamagedError
        Not even the beginning can be read.
    """
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    head = file.read(oni.FILE_HEADER.size)
    if not head.startswith(oni.MAGIC) or len(head) < oni.FILE_HEADER.size:
        raise DamagedError("no .oni file")
    if head[4:6] != bytes((1, 0)) or oni.FILE_HEADER.unpack(head)[3] < 1:
        raise DamagedError("an .oni file of a version that is too old")
    index = OniIndex()
    walk = _Walk(file, size, index)
    trailer = _read_trailer(file, size)
    if trailer is not None:
        index.rows, index.texts = trailer
        index.has_end = True
        walk.until_data()
        return index
    walk.through()
    return index


def _read_trailer(file: BinaryIO, size: int) -> tuple[IntArray, dict[str, str]] | None:
    """Return rows and texts of the table that our writer puts behind the end; None if none."""
    if size < TAIL_SIZE:
        return None
    file.seek(size - TAIL_SIZE)
    tail = file.read(TAIL_SIZE)
    n_text, n_rows, start = (int.from_bytes(tail[8 * i : 8 * i + 8], "little") for i in range(3))
    n_bytes = n_text + 48 * n_rows
    if tail[-len(TRAILER_MAGIC) :] != TRAILER_MAGIC or start + n_bytes + TAIL_SIZE != size:
        return None
    if n_bytes > MAX_TRAILER:
        raise DamagedError("the table behind the end is too large")
    file.seek(start)
    content = file.read(n_bytes)
    rows = trailer_rows(content[n_text:])
    is_sane = (rows[:, :2] >= 0).all() and (rows[:, 2:] >= NO_IMAGE).all()
    if not is_sane or (rows[:, 0] > MAX_SEQUENCE).any() or (rows[:, 3:] >= size).any():
        raise DamagedError("the table behind the end is damaged")
    try:
        texts = json.loads(content[:n_text])
    except (ValueError, RecursionError) as error:
        raise DamagedError("the texts behind the end are damaged") from error
    if not (isinstance(texts, dict) and all(isinstance(text, str) for text in texts.values())):
        raise DamagedError("the texts behind the end are damaged")
    return rows, texts


class _Walk:
    """Goes from record to record and notes streams and images."""

    def __init__(self, file: BinaryIO, size: int, index: OniIndex) -> None:
        self._file = file
        self._size = size
        self._index = index
        self._position = oni.FILE_HEADER.size
        # Kind of stream -> (time in us, frame number, position) of every image.
        self._images: dict[int, list[tuple[int, int, int]]] = {kind: [] for kind in STREAM_KINDS}

    def until_data(self) -> None:
        """Read the descriptions of the streams."""
        while (header := self._next()) and header.kind not in (oni.NEW_DATA, oni.END):
            self._note(header)

    def through(self) -> None:
        """Read everything up to the end record, or to where the file is cut."""
        while header := self._next():
            if header.kind == oni.END:
                self._index.has_end = True
                break
            self._note(header)
        self._index.rows = _rows(self._images)
        if not self._index.has_end:
            self._index.n_lost_bytes = self._size - self._position
            self._leave_out_half_a_frame()

    def _leave_out_half_a_frame(self) -> None:
        """Drop the last frame if it lacks an image that the frame before it has."""
        rows = self._index.rows
        if len(rows) > 1 and ((rows[-1, 3:] == NO_IMAGE) & (rows[-2, 3:] != NO_IMAGE)).any():
            self._index.rows = rows[:-1]
            self._index.n_lost_bytes = self._size - int(rows[-1, 3:].max())

    def _next(self) -> oni.RecordHeader | None:
        self._file.seek(self._position)
        self._head = self._file.read(PEEK_SIZE)
        try:
            header = oni.parse_header(self._head, self._position, self._size)
        except DamagedError:
            return None
        self._position = header.end
        return header

    def _note(self, header: oni.RecordHeader) -> None:
        node = self._index.nodes.get(header.node)
        if header.kind == oni.NEW_DATA and len(self._head) == PEEK_SIZE:
            if node is not None and node.kind in STREAM_KINDS:
                time_us, number = oni.NEW_DATA_FIELDS.unpack_from(
                    self._head, oni.RECORD_HEADER.size
                )
                time_us = min(time_us, MAX_TIMESTAMP_NS // NS_PER_US)
                self._images[node.kind].append((time_us, number, header.start))
        elif header.kind == oni.NODE_ADDED or header.kind in oni.OLD_NODE_ADDED:
            self._index.nodes[header.node] = oni.parse_node_added(self._fields(header))
        elif header.kind in (oni.INT_PROPERTY, oni.GENERAL_PROPERTY) and node is not None:
            oni.apply_property(node, *oni.parse_property(self._fields(header)))

    def _fields(self, header: oni.RecordHeader) -> bytes:
        if header.fields_size > oni.MAX_FIELDS:
            raise DamagedError("a record is too large")
        self._file.seek(header.start + oni.RECORD_HEADER.size)
        return self._file.read(header.fields_size - oni.RECORD_HEADER.size)


def _rows(images: dict[int, list[tuple[int, int, int]]]) -> IntArray:
    """Pair the images by their times; infrared belongs to the depth camera."""
    color = np.array(images[oni.COLOR_NODE], np.int64).reshape(-1, 3)
    kind = oni.DEPTH_NODE if images[oni.DEPTH_NODE] else oni.INFRARED_NODE
    depth = np.array(images[kind], np.int64).reshape(-1, 3)
    infrared_at = {time_us: position for time_us, _, position in images[oni.INFRARED_NODE]}
    rows = []
    for i, j in associate(depth[:, 0] * NS_PER_US, color[:, 0] * NS_PER_US).tolist():
        time_us, number, position = (color[j] if i == NONE else depth[i]).tolist()
        color_us, color_position = (NO_IMAGE, NO_IMAGE) if j == NONE else color[j, [0, 2]].tolist()
        color_ns = NO_IMAGE if j == NONE else color_us * NS_PER_US
        is_depth = i != NONE and kind == oni.DEPTH_NODE
        depth_position = position if is_depth else NO_IMAGE
        infrared = NO_IMAGE if i == NONE else infrared_at.get(time_us, NO_IMAGE)
        times_ns = (time_us * NS_PER_US, color_ns)
        rows.append((number, *times_ns, depth_position, color_position, infrared))
    return np.array(rows, np.int64).reshape(-1, 6)
