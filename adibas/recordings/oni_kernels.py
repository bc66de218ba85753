"""The loops of OpenNI's 16-bit depth codecs; they never leave their arrays."""

import numpy as np

from adibas.arrays import Int32Array, UInt8Array, UInt16Array
from adibas.kernels import compiled

SMALL_STEP = 6
LARGE_STEP = 63
STEP_OFFSET = 192
NO_STEPS = 0x66
ONLY_FIRST = 0x0D
ESCAPE = 0x0F
ESCAPE_ALONE = 0xFF
RUN = 0xE0
MAX_RUN = 15


@compiled
def _put_run(output: UInt8Array, n: int, run: int) -> int:
    """Write `run` pairs without a step, if there are any; return the next position."""
    if run:
        output[n] = RUN + run
        return n + 1
    return n


@compiled
def _put_escaped(output: UInt8Array, n: int, step: int, place: int) -> int:
    """Write a larger step, or the place in the table; return the next position."""
    if abs(step) <= LARGE_STEP:
        output[n] = step + STEP_OFFSET
        return n + 1
    output[n] = place >> 8
    output[n + 1] = place & 255
    return n + 2


@compiled
def encode(places: Int32Array) -> UInt8Array:
    """Return the steps from the first of the (N,) table `places` to the last."""
    output = np.empty(3 * places.size + 2, np.uint8)
    n = 0
    run = 0
    half = -1
    for i in range(1, places.size):
        step = places[i - 1] - places[i]
        if abs(step) > SMALL_STEP:
            n = _put_run(output, n, run)
            run = 0
            output[n] = ESCAPE_ALONE if half < 0 else half * 16 + ESCAPE
            n = _put_escaped(output, n + 1, step, places[i])
            half = -1
        elif half < 0:
            half = step + SMALL_STEP
        else:
            pair = half * 16 + step + SMALL_STEP
            half = -1
            run += pair == NO_STEPS
            if pair != NO_STEPS or run == MAX_RUN:
                n = _put_run(output, n, run)
                run = 0
            if pair != NO_STEPS:
                output[n] = pair
                n += 1
    n = _put_run(output, n, run)
    if half >= 0:
        output[n] = half * 16 + ONLY_FIRST
        n += 1
    return output[:n]


@compiled
def _get_escaped(data: UInt8Array, n: int, place: int) -> tuple[int, int]:
    """Return (place in the table, next position) after a larger step; position -1 at the end."""
    if n < data.size and data[n] & 0x80:
        return place - (int(data[n]) - STEP_OFFSET), n + 1
    if n + 1 < data.size:
        return int(data[n]) * 256 + int(data[n + 1]), n + 2
    return place, -1


@compiled
def _put_pixels(table: UInt16Array, place: int, depth: UInt16Array, i: int, count: int) -> int:
    """Write `count` pixels at `i`; return the next pixel, or -1 where they do not fit."""
    if not 0 <= place < table.size or count > depth.size - i:
        return -1
    depth[i : i + count] = table[place]
    return i + count


@compiled
def decode(data: UInt8Array, table: UInt16Array, depth: UInt16Array) -> bool:
    """Fill the (N,) `depth`; return False where `data` does not fit it exactly."""
    place = int(data[0]) + 256 * int(data[1])
    i = _put_pixels(table, place, depth, 0, 1)
    n = 2
    while i >= 0 and 0 <= n < data.size:
        byte = int(data[n])
        n += 1
        if byte == ESCAPE_ALONE:
            place, n = _get_escaped(data, n, place)
            i = _put_pixels(table, place, depth, i, 1)
        elif byte >= RUN:
            i = _put_pixels(table, place, depth, i, 2 * (byte - RUN))
        else:
            place -= (byte >> 4) - SMALL_STEP
            i = _put_pixels(table, place, depth, i, 1)
            second = byte & 15
            if second == ESCAPE:
                place, n = _get_escaped(data, n, place)
            elif second != ONLY_FIRST:
                place -= second - SMALL_STEP
            if i >= 0 and second != ONLY_FIRST:
                i = _put_pixels(table, place, depth, i, 1)
    return n == data.size and i == depth.size
