"""The records of an OpenNI file.

Source: OpenNI2 (Apache-2.0), ``FileRecorder`` and ``OniFile/DataRecords``: the layout, not the
code. All numbers are little endian and packed.
"""

import struct
from dataclasses import dataclass

from adibas.recordings.reading import DamagedError

MAGIC = b"NI10"
FILE_HEADER = struct.Struct("<4sBBHIQI")
VERSION = (1, 0, 1, 0)
RECORD_MAGIC = 0x0052494E
RECORD_HEADER = struct.Struct("<IIIIIQ")
INT_PROPERTY, GENERAL_PROPERTY, NODE_REMOVED, DATA_BEGIN = 3, 6, 7, 8
STATE_READY, NEW_DATA, END, NODE_ADDED = 9, 10, 11, 13
OLD_NODE_ADDED = (2, 12)
NEW_DATA_FIELDS = struct.Struct("<QI")
DEPTH_NODE, COLOR_NODE, INFRARED_NODE = 2, 3, 5
CODEC_NONE, CODEC_JPEG, CODEC_16ZT, CODEC_16Z = b"NONE", b"JPEG", b"16zT", b"16z "
DEPTH_1_MM, DEPTH_100_UM = 100, 101
RGB888, YUV422, GRAY8, GRAY16, JPEG, YUYV = 200, 201, 202, 203, 204, 205
GRAY16_BEFORE_OPENNI2, RGB24_BEFORE_OPENNI2 = 4, 1
FORMATS_BEFORE_OPENNI2 = {1: RGB888, 2: YUV422, 3: GRAY8, 4: GRAY16, 5: JPEG}
UNITS_M = {DEPTH_1_MM: 0.001, DEPTH_100_UM: 0.0001}
MAX_FIELDS = 1 << 20
UNKNOWN_COUNT = 2**32 - 1
UNKNOWN_TIME = 2**64 - 1


@dataclass(slots=True)
class Node:
    """One stream of the file, as far as its records were read."""

    kind: int
    codec: bytes
    width: int = 0
    height: int = 0
    frame_rate_hz: int = 0
    pixel_format: int = 0
    is_mirrored: bool = False


@dataclass(frozen=True, slots=True)
class RecordHeader:
    """Where a record is and what it says of itself."""

    start: int
    kind: int
    node: int
    fields_size: int
    payload_size: int

    @property
    def payload_start(self) -> int:
        """Position of the payload."""
        return self.start + self.fields_size

    @property
    def end(self) -> int:
        """Position after the record."""
        return self.payload_start + self.payload_size


def file_header(max_time_us: int, max_node: int) -> bytes:
    """Return the first bytes of a file."""
    return FILE_HEADER.pack(MAGIC, *VERSION, max_time_us, max_node)


def record(kind: int, node: int, fields: bytes = b"", payload: bytes = b"") -> bytes:
    """Return a record."""
    size = RECORD_HEADER.size + len(fields)
    return RECORD_HEADER.pack(RECORD_MAGIC, kind, node, size, len(payload), 0) + fields + payload


def text(value: str) -> bytes:
    """Return a string with its length before it and a zero after it."""
    content = value.encode() + b"\0"
    return struct.pack("<I", len(content)) + content


def int_property(node: int, name: str, value: int) -> bytes:
    """Return a property record with a number."""
    return record(INT_PROPERTY, node, text(name) + struct.pack("<IQ", 8, value))


def general_property(node: int, name: str, value: bytes) -> bytes:
    """Return a property record with bytes."""
    return record(GENERAL_PROPERTY, node, text(name) + struct.pack("<I", len(value)) + value)


def parse_header(head: bytes, start: int, size: int) -> RecordHeader:
    """Return the record header `head` at position `start` of a file of `size` bytes.

    Raises
    ------
    DamagedError
        There is no whole record.
    """
    if len(head) < RECORD_HEADER.size:
        raise DamagedError("the file is cut")
    magic, kind, node, fields_size, payload_size, _ = RECORD_HEADER.unpack_from(head)
    header = RecordHeader(start, kind, node, fields_size, payload_size)
    if magic != RECORD_MAGIC or fields_size < RECORD_HEADER.size or header.end > size:
        raise DamagedError("no whole record")
    return header


def parse_node_added(fields: bytes) -> Node:
    """Return the stream that a record of kind NODE_ADDED (or its older forms) announces."""
    _, rest = _split_text(fields)
    if len(rest) < 8:  # noqa: PLR2004  (two numbers)
        raise DamagedError("a stream's description is cut")
    return Node(kind=int.from_bytes(rest[:4], "little"), codec=rest[4:8])


def parse_property(fields: bytes) -> tuple[str, bytes]:
    """Return (name, value) of a property record."""
    name, rest = _split_text(fields)
    length = int.from_bytes(rest[:4], "little")
    if len(rest) < 4 + length:
        raise DamagedError("a property is cut")
    return name, rest[4 : 4 + length]


def apply_property(node: Node, name: str, value: bytes) -> None:
    """Note what a property says of `node`; later ones win, unknown ones are skipped."""
    number = int.from_bytes(value[:8], "little")
    if name == "xnMapOutputMode" and len(value) == struct.calcsize("<III"):
        node.width, node.height, node.frame_rate_hz = struct.unpack("<III", value)
    elif name == "xnPixelFormat" and node.kind != DEPTH_NODE:
        node.pixel_format = FORMATS_BEFORE_OPENNI2.get(number, 0)
    elif name == "oniPixelFormat":
        node.pixel_format = number
    elif name == "xnMirror":
        node.is_mirrored = number != 0


def _split_text(fields: bytes) -> tuple[str, bytes]:
    length = int.from_bytes(fields[:4], "little")
    if len(fields) < 4 + length:
        raise DamagedError("a text is cut")
    return fields[4 : 4 + length].rstrip(b"\0").decode("latin-1"), fields[4 + length :]
