"""The records of an MCAP file that we write and read, each checked against the bytes there are.

The file is laid out by hand, because one chunk has to hold exactly one frame and because lengths
in a damaged file must not be believed; the library `mcap` judges the result in the tests.

Source: MCAP file format specification, version 0 (``mcap.dev/spec``).
"""

import struct
import zlib
from dataclasses import dataclass

import zstandard

from adibas.recordings.reading import DamagedError

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 1, 2, 3, 4, 5, 6
MESSAGE_INDEX, CHUNK_INDEX, STATISTICS, METADATA, METADATA_INDEX = 7, 8, 11, 12, 13
SUMMARY_OFFSET, DATA_END = 14, 15
PREFIX = struct.Struct("<BQ")
FOOTER_FIELDS = struct.Struct("<QQI")
FOOTER_SIZE = PREFIX.size + FOOTER_FIELDS.size
CHUNK_FIELDS = struct.Struct("<QQQI")
CHUNK_HEAD_SIZE = CHUNK_FIELDS.size + 4 + len("zstd") + 8
MESSAGE_FIELDS = struct.Struct("<HIQQ")
CHUNK_INDEX_FIELDS = struct.Struct("<QQQQ")

INFO_NAME, END_NAME = "adibas", "adibas.end"
"""Names of our metadata records."""
MAX_CHUNK = 1 << 28
"""Largest chunk that is unpacked, bytes: a frame of 64 million pixels is smaller."""
MAX_SMALL_RECORD = 1 << 24
"""Largest schema, channel or metadata record that is read, bytes."""


@dataclass(frozen=True, slots=True)
class Message:
    """One message; `log_time_ns` is the frame's time, `publish_time_ns` the image's own."""

    channel: int
    sequence: int
    log_time_ns: int
    publish_time_ns: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Registry:
    """All schema and channel records, as they stand before the first chunk and in the summary."""

    schemas: bytes
    channels: bytes
    n_schemas: int
    n_channels: int


def record(opcode: int, content: bytes) -> bytes:
    """Return `content` as a record."""
    return PREFIX.pack(opcode, len(content)) + content


def text(value: str | bytes) -> bytes:
    """Return a string (or bytes) with its length before it."""
    content = value.encode() if isinstance(value, str) else value
    return struct.pack("<I", len(content)) + content


def text_map(values: dict[str, str]) -> bytes:
    """Return a map of strings with its length before it."""
    return text(b"".join(text(key) + text(value) for key, value in values.items()))


def message_record(message: Message) -> bytes:
    """Return a message record."""
    fields = (message.channel, message.sequence, message.log_time_ns, message.publish_time_ns)
    return record(MESSAGE, MESSAGE_FIELDS.pack(*fields) + message.data)


@dataclass(frozen=True, slots=True)
class PackedChunk:
    """A chunk with its message indexes, ready for the file, and what the summary says of it."""

    chunk: bytes
    message_indexes: bytes
    index_offsets: tuple[tuple[int, int], ...]
    time_ns: int
    compression: str
    compressed_size: int
    uncompressed_size: int

    @property
    def content(self) -> bytes:
        """What stands in the chunk record: times, size, sum, compression and the records."""
        return self.chunk[PREFIX.size :]

    def index_record(self, start: int) -> bytes:
        """Return the chunk index record of this chunk at file position `start`."""
        after = start + len(self.chunk)
        offsets = b"".join(struct.pack("<HQ", i, after + place) for i, place in self.index_offsets)
        sizes = struct.pack("<QQ", self.compressed_size, self.uncompressed_size)
        content = (
            CHUNK_INDEX_FIELDS.pack(self.time_ns, self.time_ns, start, len(self.chunk))
            + text(offsets)
            + struct.pack("<Q", len(self.message_indexes))
            + text(self.compression)
            + sizes
        )
        return record(CHUNK_INDEX, content)


def pack_chunk(messages: list[Message], level: int | None) -> PackedChunk:
    """Return the `messages` of one frame, all of one log time, as a chunk.

    `level` is zstd's; None stores the messages as they are.
    """
    records = [message_record(message) for message in messages]
    plain = b"".join(records)
    compression = "" if level is None else "zstd"
    packed = plain if level is None else _pack_zstd(plain, level)
    time_ns = messages[0].log_time_ns
    content = CHUNK_FIELDS.pack(time_ns, time_ns, len(plain), zlib.crc32(plain))
    content += text(compression)
    indexes = b""
    offsets = []
    place = 0
    for message, encoded in zip(messages, records, strict=True):
        offsets.append((message.channel, len(indexes)))
        entry = struct.pack("<QQ", time_ns, place)
        indexes += record(MESSAGE_INDEX, struct.pack("<H", message.channel) + text(entry))
        place += len(encoded)
    return PackedChunk(
        chunk=record(CHUNK, content + struct.pack("<Q", len(packed)) + packed),
        message_indexes=indexes,
        index_offsets=tuple(offsets),
        time_ns=time_ns,
        compression=compression,
        compressed_size=len(packed),
        uncompressed_size=len(plain),
    )


def _pack_zstd(plain: bytes, level: int) -> bytes:
    """Compress message records.

    The head of the first message is a block of its own, so that a search through a cut file learns
    the frame's number without unpacking the frame.
    """
    packer = zstandard.ZstdCompressor(level=level).compressobj(size=len(plain))
    head = PREFIX.size + MESSAGE_FIELDS.size
    packed = packer.compress(plain[:head]) + packer.flush(zstandard.COMPRESSOBJ_FLUSH_BLOCK)
    return packed + packer.compress(plain[head:]) + packer.flush()


class Cursor:
    """Reads fields from the bytes of one record."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._position = 0

    def take(self, n_bytes: int) -> bytes:
        """Return the next `n_bytes`."""
        if n_bytes > self.n_left:
            raise DamagedError("a length is larger than what is left")
        self._position += n_bytes
        return self._data[self._position - n_bytes : self._position]

    def number(self, n_bytes: int) -> int:
        """Return the next unsigned number."""
        return int.from_bytes(self.take(n_bytes), "little")

    def text_bytes(self) -> bytes:
        """Return the next bytes with a length before them."""
        return self.take(self.number(4))

    def text(self) -> str:
        """Return the next string."""
        try:
            return self.text_bytes().decode()
        except UnicodeDecodeError as error:
            raise DamagedError("a text is no UTF-8") from error

    @property
    def n_left(self) -> int:
        """Bytes that are left."""
        return len(self._data) - self._position


def read_text_map(cursor: Cursor) -> dict[str, str]:
    """Return the next map of strings."""
    inner = Cursor(cursor.text_bytes())
    values = {}
    while inner.n_left:
        key = inner.text()
        values[key] = inner.text()
    return values


def check_opcode(prefix: bytes, opcode: int) -> int:
    """Return the length of the record that begins with `prefix`."""
    if len(prefix) < PREFIX.size or prefix[0] != opcode:
        raise DamagedError("another record was expected here")
    return int(PREFIX.unpack(prefix[: PREFIX.size])[1])


def unpack_chunk(content: bytes) -> bytes:
    """Return the records in a chunk, checked by their sum, from the chunk's `content`."""
    cursor = Cursor(content)
    _, _, size, crc = CHUNK_FIELDS.unpack(cursor.take(CHUNK_FIELDS.size))
    compression = cursor.text()
    packed = cursor.take(cursor.number(8))
    if size > MAX_CHUNK:
        raise DamagedError("the chunk is too large")
    if compression == "zstd":
        plain = unpack_zstd(packed, size)
    elif compression == "":
        plain = packed
    else:
        raise DamagedError("the chunk's compression is unknown")
    if len(plain) != size or (crc and zlib.crc32(plain) != crc):
        raise DamagedError("the chunk's sum is wrong")
    return plain


def unpack_zstd(packed: bytes, size: int) -> bytes:
    """Return exactly `size` bytes; never more memory than that, whatever `packed` says."""
    try:
        declared = zstandard.frame_content_size(packed)
        if declared not in (size, -1):
            raise DamagedError("the chunk's sizes differ")
        unpacker = zstandard.ZstdDecompressor(max_window_size=MAX_CHUNK)
        return unpacker.decompress(packed, max_output_size=size)
    except zstandard.ZstdError as error:
        raise DamagedError("the chunk cannot be unpacked") from error


def peek_sequence(head: bytes) -> int:
    """Return the number of the first message in a chunk from the first bytes of its content."""
    cursor = Cursor(head)
    cursor.take(CHUNK_FIELDS.size)
    compression = cursor.text()
    cursor.take(8)
    start = cursor.take(cursor.n_left)
    if compression == "zstd":
        try:
            with zstandard.ZstdDecompressor().stream_reader(start) as reader:
                start = reader.read(PREFIX.size + MESSAGE_FIELDS.size)
        except zstandard.ZstdError as error:
            raise DamagedError("the chunk cannot be unpacked") from error
    if len(start) < PREFIX.size + MESSAGE_FIELDS.size or start[0] != MESSAGE:
        raise DamagedError("the chunk does not begin with a message")
    return int(MESSAGE_FIELDS.unpack_from(start, PREFIX.size)[1])


def messages_of(plain: bytes) -> list[Message]:
    """Return the messages among the records of an unpacked chunk."""
    cursor = Cursor(plain)
    messages = []
    while cursor.n_left:
        opcode, length = PREFIX.unpack(cursor.take(PREFIX.size))
        content = cursor.take(length)
        if opcode == MESSAGE:
            if length < MESSAGE_FIELDS.size:
                raise DamagedError("a message is too short")
            channel, sequence, log_ns, publish_ns = MESSAGE_FIELDS.unpack_from(content)
            data = content[MESSAGE_FIELDS.size :]
            messages.append(Message(channel, sequence, log_ns, publish_ns, data))
    return messages
