"""Begin-end alignment with limited slope: between half and twice the model's speed.

Steps (model, stream): (1, 1) costs d(i, j); (1, 2) the mean of d(i, j-1) and d(i, j); (2, 1)
d(i-1, j) + d(i, j). Each weighs as many frames of the model as it passes, so that every path to
the last frame weighs m: paths of different lengths compare fairly.

Source: Sakoe & Chiba, Dynamic programming algorithm optimization for spoken word recognition,
1978 (slope constraint P = 1, asymmetric weights).
"""

from typing import TypeAlias

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled
from adibas.timeseries.frame_cost_kernels import local_costs

N_COSTS, N_ROWS = 8, 15
"""Of the memory: costs of the latest frames, sums of three, starts of three, and scratch."""
SUMS, STARTS, SCRATCH = 8, 11, 14
AT_ONCE = 4
"""Frames whose costs are computed before they are used: what was just written is slow to read."""

Rows: TypeAlias = tuple[np.uint64, np.uint64, np.uint64, np.uint64, np.uint64]
"""Of costs now and before, and of sums now, one frame ago and two frames ago."""


@compiled
def feed_sloped(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    stream: FloatArray,
    columns: FloatArray,
    squared_weights: FloatArray,
    least_share: float,
    offsets: IntArray,
    first: int,
    memory: FloatArray,
    costs_out: FloatArray,
    starts_out: FloatArray,
) -> None:
    """Take `stream` (n, d), whose first frame has number `first`; `memory` (N_ROWS, M) goes on.

    `columns` (d, M) holds all models one behind the other, `offsets` (k + 1,) where they begin.
    The sum of the best path that ends with each frame, and where it began, go to `costs_out` and
    `starts_out` (n, k).
    """
    seen = memory[SCRATCH]
    for block in range(0, len(stream), AT_ONCE):
        end = min(block + AT_ONCE, len(stream))
        local_costs(
            stream, block, end, columns, squared_weights, least_share, seen,
            memory, (first + block) % N_COSTS, N_COSTS,
        )  # fmt: skip
        for t in range(block, end):
            advance(first + t, t, offsets, memory, costs_out, starts_out)


@compiled
def advance(
    now: int,
    row: int,
    offsets: IntArray,
    memory: FloatArray,
    costs_out: FloatArray,
    starts_out: FloatArray,
) -> None:
    """Take the frame of number `now`, whose costs stand in ``memory[now % N_COSTS]``.

    Rows are told by number: views of them would be counted in and out at every frame, which costs
    more than the steps.
    """
    cost, before = np.uint64(now % N_COSTS), np.uint64((now + N_COSTS - 1) % N_COSTS)
    this, one, two = (
        np.uint64(SUMS + now % 3),
        np.uint64(SUMS + (now + 2) % 3),
        np.uint64(SUMS + (now + 1) % 3),
    )
    rows = (cost, before, this, one, two)
    _steps_of_starts(memory, rows)
    _steps_of_sums(memory, rows)
    began = np.uint64(this + np.uint64(STARTS - SUMS))
    for k in range(len(offsets) - 1):
        at, end = offsets[k], offsets[k + 1] - 1
        slow = 0.5 * (memory[before, at] + memory[cost, at])
        memory[this, at], memory[began, at] = memory[cost, at], now
        if slow < memory[cost, at]:
            memory[this, at], memory[began, at] = slow, now - 1
        _second(memory, rows, at + 1, now)
        costs_out[row, k] = memory[this, end]
        starts_out[row, k] = memory[began, end]


@compiled
def _second(memory: FloatArray, rows: Rows, i: int, now: int) -> None:
    """Reach the second frame of a model: its (2, 1) step comes from before the model."""
    cost, before, this, one, two = rows
    apart = np.uint64(STARTS - SUMS)
    total, start = memory[one, i - 1] + memory[cost, i], memory[one + apart, i - 1]
    slow = memory[two, i - 1] + 0.5 * (memory[before, i] + memory[cost, i])
    if slow < total:
        total, start = slow, memory[two + apart, i - 1]
    fast = memory[cost, i - 1] + memory[cost, i]
    if fast < total:
        total, start = fast, now
    memory[this, i], memory[this + apart, i] = total, start


@compiled
def _steps_of_sums(memory: FloatArray, rows: Rows) -> None:
    # Unsigned places and rows of one array: only so are neighbours computed side by side.
    cost, before, out, one, two = rows
    for i in range(np.uint64(2), np.uint64(memory.shape[1])):
        last, last_but_one = i - np.uint64(1), i - np.uint64(2)
        a = memory[one, last] + memory[cost, i]
        b = memory[two, last] + 0.5 * (memory[before, i] + memory[cost, i])
        c = memory[one, last_but_one] + memory[cost, last] + memory[cost, i]
        a = min(a, b)
        memory[out, i] = min(a, c)


@compiled
def _steps_of_starts(memory: FloatArray, rows: Rows) -> None:
    cost, before, this, one, two = rows
    apart = np.uint64(STARTS - SUMS)
    out = this + apart
    for i in range(np.uint64(2), np.uint64(memory.shape[1])):
        last, last_but_one = i - np.uint64(1), i - np.uint64(2)
        a = memory[one, last] + memory[cost, i]
        b = memory[two, last] + 0.5 * (memory[before, i] + memory[cost, i])
        c = memory[one, last_but_one] + memory[cost, last] + memory[cost, i]
        # All of them are read first: a choice of what to read would be a jump.
        start, of_slow = memory[one + apart, last], memory[two + apart, last]
        of_fast = memory[one + apart, last_but_one]
        start = of_slow if b < a else start
        a = min(a, b)
        memory[out, i] = of_fast if c < a else start
