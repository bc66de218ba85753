"""Lossless depth compression: runs of zeros, and differences of neighbours in 3-bit pieces.

Source: A. D. Wilson, Fast Lossless Depth Image Compression, ISS 2017. Words are 32 bits, little
endian, the first piece in the highest bits, as in the paper's code.
"""

import numpy as np

from adibas.arrays import UInt16Array
from adibas.errors import RecordingError

MAX_PIXELS = 1 << 24
"""Largest image that is decoded: a few damaged bytes must not ask for gigabytes."""


def encode_rvl(depth: UInt16Array) -> bytes:
    """Return the (H, W) `depth` compressed without loss."""
    from adibas.recordings.rvl_kernels import encode

    return encode(np.ascontiguousarray(depth).ravel()).tobytes()


def decode_rvl(data: bytes, shape: tuple[int, int]) -> UInt16Array:
    """Return the (H, W) image that `encode_rvl` compressed.

    Raises
    ------
    RecordingError
        `data` is no image of `shape`: too short, too long, or out of range.
    """
    from adibas.recordings.rvl_kernels import decode

    n_pixels = shape[0] * shape[1]
    depth = np.zeros(n_pixels if 0 < n_pixels <= MAX_PIXELS else 0, np.uint16)
    is_whole_words = len(data) % 4 == 0
    if not (len(depth) and is_whole_words and decode(np.frombuffer(data, np.uint32), depth)):
        raise RecordingError("The compressed depth image is damaged. Use another frame.")
    return depth.reshape(shape)
