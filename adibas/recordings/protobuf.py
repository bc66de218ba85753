"""The little of the protobuf wire format that the messages of a recording need.

Source: Protocol Buffers documentation, "Encoding" and ``descriptor.proto``.
"""

import struct
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from adibas.clock import NS_PER_S

VARINT, FIXED64, BYTES, FIXED32 = 0, 1, 2, 5
_MAX_VARINT_BITS = 63

Kind = Literal["double", "fixed32", "uint64", "string", "bytes", "timestamp", "doubles"]
# Numbers of FieldDescriptorProto.Type; "doubles" is a repeated double.
_TYPE_NUMBERS = {
    "double": 1,
    "fixed32": 7,
    "uint64": 4,
    "string": 9,
    "bytes": 12,
    "timestamp": 11,
    "doubles": 1,
}


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message type."""

    number: int
    name: str
    kind: Kind


@dataclass(frozen=True, slots=True)
class MessageType:
    """A message type by its full name, ``package.Name``."""

    full_name: str
    fields: tuple[Field, ...]


def varint(value: int) -> bytes:
    """Return `value` (not negative) as a base-128 number."""
    pieces = bytearray()
    while value > 0x7F:  # noqa: PLR2004
        pieces.append(value & 0x7F | 0x80)
        value >>= 7
    pieces.append(value)
    return bytes(pieces)


def tagged_varint(number: int, value: int) -> bytes:
    """Return an integer field."""
    return varint(number << 3 | VARINT) + varint(value)


def tagged_bytes(number: int, value: bytes) -> bytes:
    """Return a field of bytes, text or a nested message."""
    return varint(number << 3 | BYTES) + varint(len(value)) + value


def encode_message(kind: MessageType, values: dict[str, object]) -> bytes:
    """Return the message with `values` by field name, in the order of the type's fields."""
    return b"".join(_encode_field(field, values[field.name]) for field in kind.fields)


def _encode_field(field: Field, value: object) -> bytes:
    match value:
        case float():
            return varint(field.number << 3 | FIXED64) + struct.pack("<d", value)
        case int() if field.kind == "timestamp":
            return tagged_bytes(field.number, _timestamp(value))
        case int() if field.kind == "fixed32":
            return varint(field.number << 3 | FIXED32) + struct.pack("<I", value)
        case int():
            return tagged_varint(field.number, value)
        case str() | bytes():
            content = value.encode() if isinstance(value, str) else value
            return tagged_bytes(field.number, content)
        case tuple():
            return tagged_bytes(field.number, struct.pack(f"<{len(value)}d", *value))
    raise ValueError(f"{field.name} cannot be {value!r}")


def _timestamp(time_ns: int) -> bytes:
    """Return a google.protobuf.Timestamp."""
    seconds, nanoseconds = divmod(time_ns, NS_PER_S)
    return tagged_varint(1, seconds) + tagged_varint(2, nanoseconds)


def decode_message(kind: MessageType, data: bytes) -> dict[str, object]:
    """Return the fields of `data` by name; unknown fields are skipped, missing ones are zero.

    Raises
    ------
    ValueError
        `data` is no such message.
    """
    by_number = {field.number: field for field in kind.fields}
    zeros = {"string": "", "bytes": b"", "double": 0.0, "doubles": ()}
    values: dict[str, object] = {field.name: zeros.get(field.kind, 0) for field in kind.fields}
    for number, value in _split(data):
        field = by_number.get(number)
        if field is not None:
            values[field.name] = _decode_field(field, value)
    return values


def _decode_field(field: Field, value: int | bytes) -> object:
    if field.kind in ("fixed32", "uint64") and isinstance(value, int):
        return value
    if not isinstance(value, bytes):
        raise ValueError(f"{field.name} has the wrong wire type")  # noqa: TRY004  (bad input)
    match field.kind:
        case "string":
            return value.decode()
        case "timestamp":
            parts = dict(_split(value))
            seconds, nanoseconds = parts.get(1, 0), parts.get(2, 0)
            if isinstance(seconds, bytes) or isinstance(nanoseconds, bytes):
                raise ValueError(f"{field.name} is no time")  # noqa: TRY004
            return seconds * NS_PER_S + nanoseconds
        case "double" if len(value) == struct.calcsize("d"):
            return struct.unpack("<d", value)[0]
        case "bytes":
            return value
    raise ValueError(f"{field.name} has the wrong wire type")


def _split(data: bytes) -> Iterable[tuple[int, int | bytes]]:
    """Give (field number, value) of every field; fixed 64-bit values as their bytes."""
    position = 0
    while position < len(data):
        tag, position = _read_varint(data, position)
        number, wire_type = tag >> 3, tag & 7
        if wire_type == VARINT:
            value, position = _read_varint(data, position)
            yield number, value
            continue
        if wire_type == BYTES:
            length, position = _read_varint(data, position)
        elif wire_type in (FIXED64, FIXED32):
            length = 8 if wire_type == FIXED64 else 4
        else:
            raise ValueError(f"unknown wire type {wire_type}")
        if length > len(data) - position:
            raise ValueError("the message is cut")
        piece = data[position : position + length]
        position += length
        yield number, int.from_bytes(piece, "little") if wire_type == FIXED32 else piece


def _read_varint(data: bytes, position: int) -> tuple[int, int]:
    value = 0
    for shift in range(0, _MAX_VARINT_BITS + 7, 7):
        if position >= len(data):
            raise ValueError("the message is cut")
        byte = data[position]
        position += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:  # noqa: PLR2004
            return value, position
    raise ValueError("a number of the message is too long")


def file_descriptor_set(kind: MessageType) -> bytes:
    """Return the FileDescriptorSet of `kind` (with Timestamp), as MCAP keeps protobuf schemas."""
    timestamp = MessageType(
        "google.protobuf.Timestamp", (Field(1, "seconds", "uint64"), Field(2, "nanos", "uint64"))
    )
    first = _file_descriptor(timestamp, (3, 5))  # really int64 and int32
    return tagged_bytes(1, first) + tagged_bytes(1, _file_descriptor(kind, None))


def _file_descriptor(kind: MessageType, type_numbers: tuple[int, ...] | None) -> bytes:
    package, name = kind.full_name.rsplit(".", 1)
    numbers = type_numbers or tuple(_TYPE_NUMBERS[field.kind] for field in kind.fields)
    fields = b"".join(
        tagged_bytes(2, _field_descriptor(field, number))
        for field, number in zip(kind.fields, numbers, strict=True)
    )
    dependency = b"" if type_numbers else tagged_bytes(3, b"google/protobuf/timestamp.proto")
    file_name = name.lower() if type_numbers else name
    return (
        tagged_bytes(1, f"{package.replace('.', '/')}/{file_name}.proto".encode())
        + tagged_bytes(2, package.encode())
        + dependency
        + tagged_bytes(4, tagged_bytes(1, name.encode()) + fields)
        + tagged_bytes(12, b"proto3")
    )


def _field_descriptor(field: Field, type_number: int) -> bytes:
    label = 3 if field.kind == "doubles" else 1
    described = tagged_bytes(1, field.name.encode())
    described += tagged_varint(3, field.number) + tagged_varint(4, label)
    described += tagged_varint(5, type_number)
    if field.kind == "timestamp":
        described += tagged_bytes(6, b".google.protobuf.Timestamp")
    return described
