"""The loops of RVL; they never leave their arrays, whatever the bytes say."""

import numpy as np
import numpy.typing as npt

from adibas.arrays import UInt16Array
from adibas.kernels import compiled

UInt32Array = npt.NDArray[np.uint32]

PIECE_BITS = 3
MORE_FOLLOWS = 8
MAX_SHIFT = 30
MAX_DEPTH = 65535


@compiled
def _put(words: UInt32Array, position: int, value: int) -> int:
    """Write `value` as 3-bit pieces from piece `position` on; return the next position."""
    while True:
        piece = value & 7
        value >>= PIECE_BITS
        if value:
            piece |= MORE_FOLLOWS
        words[position >> 3] |= np.uint32(piece << (28 - 4 * (position & 7)))
        position += 1
        if not value:
            return position


@compiled
def encode(depth: UInt16Array) -> UInt32Array:
    """Return the (N,) `depth` as words."""
    # Six pieces hold any difference (17 bits); a run's length takes less than the pixels of the
    # run have to spare, but for one piece in runs over 32,767 pixels.
    n_pieces = depth.size * 6 + depth.size // 16 + 64
    words = np.zeros(n_pieces // 8 + 1, np.uint32)
    position = 0
    previous = 0
    i = 0
    while i < depth.size:
        start = i
        while i < depth.size and depth[i] == 0:
            i += 1
        position = _put(words, position, i - start)
        start = i
        while i < depth.size and depth[i] != 0:
            i += 1
        position = _put(words, position, i - start)
        for j in range(start, i):
            difference = int(depth[j]) - previous
            position = _put(words, position, (difference << 1) ^ (difference >> 63))
            previous = int(depth[j])
    return words[: (position + 7) >> 3]


@compiled
def _get(words: UInt32Array, position: int) -> tuple[int, int]:
    """Return (value, next position); the position is -1 where the words end or make no sense."""
    value = 0
    shift = 0
    while position >> 3 < words.size and shift <= MAX_SHIFT:
        piece = (int(words[position >> 3]) >> (28 - 4 * (position & 7))) & 15
        position += 1
        value |= (piece & 7) << shift
        if piece < MORE_FOLLOWS:
            return value, position
        shift += PIECE_BITS
    return value, -1


@compiled
def _get_run(
    words: UInt32Array, position: int, depth: UInt16Array, start: int, previous: int
) -> tuple[int, int]:
    """Fill `depth` from `start` to its end; return (last value, next position or -1)."""
    for j in range(start, depth.size):
        value, position = _get(words, position)
        previous += (value >> 1) ^ -(value & 1)
        if position < 0 or previous < 0 or previous > MAX_DEPTH:
            return previous, -1
        depth[j] = previous
    return previous, position


@compiled
def decode(words: UInt32Array, depth: UInt16Array) -> bool:
    """Fill the zeroed (N,) `depth`; return False where the words do not fit it exactly."""
    position = 0
    previous = 0
    i = 0
    while i < depth.size:
        n_zeros, position = _get(words, position)
        if position < 0 or n_zeros > depth.size - i:
            return False
        i += n_zeros
        n_values, position = _get(words, position)
        if position < 0 or n_values > depth.size - i or n_zeros + n_values == 0:
            return False
        previous, position = _get_run(words, position, depth[: i + n_values], i, previous)
        if position < 0:
            return False
        i += n_values
    return (position + 7) >> 3 == words.size
