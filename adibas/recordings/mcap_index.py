"""Finds the frames of an MCAP file: by its summary, or by walking through a cut file."""

import os
import struct
import zlib
from dataclasses import dataclass, field
from typing import BinaryIO

from adibas.recordings import mcap_records as mcap
from adibas.recordings.mcap_records import END_NAME, INFO_NAME, Cursor
from adibas.recordings.ports import MAX_TIMESTAMP_NS
from adibas.recordings.reading import DamagedError

SUMMARY_CHUNK = struct.Struct("<BQQQQQ")
PEEK_SIZE = 4096
N_CHECKED_AT_THE_END = 60
"""Chunks whose sums are checked in a cut file: what is not on the disk for sure (two seconds)."""
MAX_SUMMARY = 1 << 29


@dataclass(slots=True)
class McapIndex:
    """Where everything is.

    Attributes
    ----------
    library : str
        The program that wrote the file.
    starts, times_ns : list of int
        Position of each frame's chunk, and its time.
    info_texts, end_texts : dict
        What the writer said at the beginning and at the end; the end is empty in a cut file.
    schemas : dict
        Schema name by channel number.
    sequences : list of int or None
        Numbers of the frames of a cut file.
    n_lost_bytes : int
        Bytes after the last whole frame of a cut file.
    """

    library: str = ""
    starts: list[int] = field(default_factory=list)
    times_ns: list[int] = field(default_factory=list)
    info_texts: dict[str, str] = field(default_factory=dict)
    end_texts: dict[str, str] = field(default_factory=dict)
    schemas: dict[int, str] = field(default_factory=dict)
    sequences: list[int] | None = None
    n_lost_bytes: int = 0


def read_index(file: BinaryIO) -> McapIndex:
    """Return the index of an MCAP file.

    Raises
    ------
    DamagedError
        Not even the beginning can be read.
    """
    size = file.seek(0, os.SEEK_END)
    index, data_start = _read_head(file, size)
    try:
        _read_summary(file, size, index)
    except (DamagedError, struct.error):
        _walk(file, size, data_start, index)
    return index


def read_index_without_summary(file: BinaryIO) -> McapIndex:
    """Return the index of an MCAP file as if it were cut; for an end that is not to be believed.

    Raises
    ------
    DamagedError
        Not even the beginning can be read.
    """
    size = file.seek(0, os.SEEK_END)
    index, data_start = _read_head(file, size)
    _walk(file, size, data_start, index)
    return index


def _read_head(file: BinaryIO, size: int) -> tuple[McapIndex, int]:
    """Return what stands before the first chunk, and where that is."""
    index = McapIndex()
    file.seek(0)
    if file.read(len(mcap.MAGIC)) != mcap.MAGIC:
        raise DamagedError("no MCAP file")
    names: dict[int, str] = {}
    while True:
        start = file.tell()
        prefix = file.read(mcap.PREFIX.size)
        opcode = prefix[0] if prefix else mcap.FOOTER
        if opcode not in (mcap.HEADER, mcap.SCHEMA, mcap.CHANNEL, mcap.METADATA):
            return index, start
        content = Cursor(read_content(file, prefix, size, mcap.MAX_SMALL_RECORD))
        if opcode == mcap.HEADER:
            content.text()
            index.library = content.text()
        elif opcode == mcap.SCHEMA:
            schema = content.number(2)
            names[schema] = content.text()
        elif opcode == mcap.CHANNEL:
            channel = content.number(2)
            index.schemas[channel] = names.get(content.number(2), "")
        elif opcode == mcap.METADATA and content.text() == INFO_NAME:
            index.info_texts = mcap.read_text_map(content)


def read_content(file: BinaryIO, prefix: bytes, size: int, limit: int) -> bytes:
    """Return the content of the record that begins with `prefix`, read just now."""
    length = mcap.check_opcode(prefix, prefix[0] if prefix else 0)
    if length > min(limit, size - file.tell()):
        raise DamagedError("a record is longer than the file")
    return file.read(length)


def _read_summary(file: BinaryIO, size: int, index: McapIndex) -> None:
    tail_size = mcap.FOOTER_SIZE + len(mcap.MAGIC)
    if size < tail_size + len(mcap.MAGIC):
        raise DamagedError("the file is cut")
    file.seek(size - tail_size)
    tail = file.read(tail_size)
    if tail[mcap.FOOTER_SIZE :] != mcap.MAGIC:
        raise DamagedError("the file is cut")
    mcap.check_opcode(tail, mcap.FOOTER)
    start, _, crc = mcap.FOOTER_FIELDS.unpack_from(tail, mcap.PREFIX.size)
    if not len(mcap.MAGIC) <= start <= size - tail_size or size - start > MAX_SUMMARY:
        raise DamagedError("the summary is nowhere")
    file.seek(start)
    summary = file.read(size - tail_size - start)
    if zlib.crc32(tail[: mcap.FOOTER_SIZE - 4], zlib.crc32(summary)) != crc:
        raise DamagedError("the summary's sum is wrong")
    _parse_summary(file, summary, size, index)
    if index.end_texts.get("n_frames") != str(len(index.starts)):
        raise DamagedError("the summary lacks frames")


def _parse_summary(file: BinaryIO, summary: bytes, size: int, index: McapIndex) -> None:
    """Read chunk indexes (the loop must be fast: one round a frame) and the end's metadata."""
    position = 0
    end = len(summary)
    while position + SUMMARY_CHUNK.size <= end:
        opcode, length, first_ns, last_ns, start, _ = SUMMARY_CHUNK.unpack_from(summary, position)
        if opcode == mcap.CHUNK_INDEX:
            if first_ns != last_ns or first_ns > MAX_TIMESTAMP_NS or start >= size:
                raise DamagedError("a chunk holds more than one frame")
            index.starts.append(start)
            index.times_ns.append(first_ns)
        elif opcode == mcap.METADATA_INDEX:
            record = summary[position + mcap.PREFIX.size : position + mcap.PREFIX.size + length]
            _read_end(file, record, size, index)
        position += mcap.PREFIX.size + length


def _read_end(file: BinaryIO, index_record: bytes, size: int, index: McapIndex) -> None:
    cursor = Cursor(index_record)
    start = cursor.number(8)
    cursor.take(8)
    if cursor.text() != END_NAME or start >= size:
        return
    file.seek(start)
    prefix = file.read(mcap.PREFIX.size)
    mcap.check_opcode(prefix, mcap.METADATA)
    content = Cursor(read_content(file, prefix, size, mcap.MAX_SMALL_RECORD))
    content.text()
    index.end_texts = mcap.read_text_map(content)


def _walk(file: BinaryIO, size: int, start: int, index: McapIndex) -> None:
    """Find every whole frame from position `start` on."""
    index.starts, index.times_ns, index.end_texts = [], [], {}
    sequences: list[int] = []
    ends: list[int] = []
    position = start
    while position + mcap.PREFIX.size <= size:
        file.seek(position)
        head = file.read(PEEK_SIZE)
        opcode, length = mcap.PREFIX.unpack_from(head)
        end = position + mcap.PREFIX.size + length
        if opcode not in (mcap.CHUNK, mcap.MESSAGE_INDEX) or end > size:
            break
        if opcode == mcap.CHUNK:
            try:
                sequences.append(mcap.peek_sequence(head[mcap.PREFIX.size :]))
                time_ns = Cursor(head[mcap.PREFIX.size :]).number(8)
            except DamagedError:
                break
            index.starts.append(position)
            index.times_ns.append(min(time_ns, MAX_TIMESTAMP_NS))
            ends.append(end)
        elif ends:
            ends[-1] = end
        position = end
    n_whole = _count_whole(file, size, index.starts)
    del index.starts[n_whole:], index.times_ns[n_whole:], sequences[n_whole:]
    index.sequences = sequences
    index.n_lost_bytes = size - (ends[n_whole - 1] if n_whole else start)


def _count_whole(file: BinaryIO, size: int, starts: list[int]) -> int:
    """Return how many chunks there are before the first damaged one among the last."""
    first = max(0, len(starts) - N_CHECKED_AT_THE_END)
    for number in range(first, len(starts)):
        try:
            read_frame_chunk(file, size, starts[number])
        except DamagedError:
            return number
    return len(starts)


def read_frame_chunk(file: BinaryIO, size: int, start: int) -> list[mcap.Message]:
    """Return the messages of the chunk at position `start`.

    Raises
    ------
    DamagedError
        There is no whole chunk.
    """
    file.seek(start)
    prefix = file.read(mcap.PREFIX.size)
    mcap.check_opcode(prefix, mcap.CHUNK)
    return mcap.messages_of(mcap.unpack_chunk(read_content(file, prefix, size, mcap.MAX_CHUNK)))
