"""OpenNI's lossless depth codec ``16zT``: a table of the values that occur, and small steps in it.

A byte below 0xE0 holds two steps of -6 to 6 (plus 6, so 6 is no step); a second half of 0xD means
that there is only the first, of 0xF that a larger step follows. 0xE1-0xEF stand for 1-15 pairs
without a step. 0xFF stands before a larger step alone. A larger step is one byte of 129-255 (192
plus -63 to 63) or two bytes with the value's place in the table, big endian, below 0x8000.
"""

import struct

import numpy as np

from adibas.arrays import UInt16Array
from adibas.recordings.reading import DamagedError
from adibas.recordings.rvl import MAX_PIXELS

MAX_TABLE = 0x8000
"""A place in the table has 15 bits: an image of more different values cannot be held."""


def encode_16zt(depth: UInt16Array) -> bytes | None:
    """Return the (H, W) `depth` compressed without loss; None if it has too many values."""
    from adibas.recordings.oni_kernels import encode

    counts = np.bincount(depth.ravel(), minlength=65536)
    values = np.flatnonzero(counts)
    if len(values) > MAX_TABLE:
        return None
    table = struct.pack("<H", len(values)) + values.astype("<u2").tobytes()
    place_of = np.cumsum(counts > 0, dtype=np.int32) - np.int32(1)
    flat = place_of[depth.ravel()]
    return table + struct.pack("<H", int(flat[0])) + encode(flat).tobytes()


def decode_16zt(data: bytes, shape: tuple[int, int]) -> UInt16Array:
    """Return the (H, W) image that `data` holds.

    Raises
    ------
    DamagedError
        `data` is no image of `shape`.
    """
    if len(data) < 4:  # noqa: PLR2004  (two lengths)
        raise DamagedError("the depth image is too short")
    end = 2 + 2 * int.from_bytes(data[:2], "little")
    table = np.frombuffer(data[2:end], "<u2") if end <= len(data) else np.empty(0, np.uint16)
    return _decode(data[end:], table.astype(np.uint16), shape)


def decode_16z(data: bytes, shape: tuple[int, int]) -> UInt16Array:
    """Return the (H, W) image of the older codec without a table."""
    return _decode(data, np.arange(65536, dtype=np.uint16), shape)


def _decode(data: bytes, table: UInt16Array, shape: tuple[int, int]) -> UInt16Array:
    from adibas.recordings.oni_kernels import decode

    n_pixels = shape[0] * shape[1]
    depth = np.zeros(n_pixels if 0 < n_pixels <= MAX_PIXELS else 0, np.uint16)
    if not (len(depth) and len(data) > 1 and len(table)):
        raise DamagedError("the depth image has no size")
    if not decode(np.frombuffer(data, np.uint8), table, depth):
        raise DamagedError("the depth image is damaged")
    return depth.reshape(shape)
