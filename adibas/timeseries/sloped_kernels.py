"""Begin-end alignment with limited slope: between half and twice the model's speed.

Steps (model, stream): (1, 1) costs d(i, j); (1, 2) the mean of d(i, j-1) and d(i, j); (2, 1)
d(i-1, j) + d(i, j). Each weighs as many frames of the model as it passes, so that every path to
the last frame weighs m: paths of different lengths compare fairly.

Source: Sakoe & Chiba, Dynamic programming algorithm optimization for spoken word recognition,
1978 (slope constraint P = 1, asymmetric weights).
"""

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled
from adibas.timeseries.frame_cost_kernels import local_costs


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
    """Take `stream` (n, d), whose first frame has number `first`; `memory` (9, M) goes on.

    `columns` (d, M) holds all models one behind the other, `offsets` (k + 1,) where they begin.
    The sum of the best path that ends with each frame, and where it began, go to `costs_out` and
    `starts_out` (n, k).
    """
    seen = memory[8]
    for t in range(len(stream)):
        now = first + t
        local_costs(stream[t], columns, squared_weights, least_share, seen, memory[now % 2])
        advance(now, offsets, memory, costs_out[t], starts_out[t])


@compiled
def advance(
    now: int,
    offsets: IntArray,
    memory: FloatArray,
    costs_out: FloatArray,
    starts_out: FloatArray,
) -> None:
    """Take the frame of number `now`, whose costs stand in ``memory[now % 2]``."""
    cost, cost_before = memory[now % 2], memory[(now + 1) % 2]
    sums, sums_1, sums_2 = (
        memory[2 + now % 3],
        memory[2 + (now + 2) % 3],
        memory[2 + (now + 1) % 3],
    )
    began = memory[5 + now % 3]
    began_1, began_2 = memory[5 + (now + 2) % 3], memory[5 + (now + 1) % 3]
    _steps_of_starts(
        cost[2:], cost[1:-1], cost_before[2:], sums_1[1:-1], sums_2[1:-1], sums_1[:-2],
        began_1[1:-1], began_2[1:-1], began_1[:-2], began[2:],
    )  # fmt: skip
    _steps_of_sums(
        cost[2:], cost[1:-1], cost_before[2:], sums_1[1:-1], sums_2[1:-1], sums_1[:-2],
        sums[2:],
    )  # fmt: skip
    for k in range(len(offsets) - 1):
        at, end = offsets[k], offsets[k + 1] - 1
        slow = 0.5 * (cost_before[at] + cost[at])
        sums[at], began[at] = cost[at], now
        if slow < cost[at]:
            sums[at], began[at] = slow, now - 1
        _second(at + 1, now, cost, cost_before, sums_1[at], sums_2[at],
                began_1[at], began_2[at], sums, began)  # fmt: skip
        costs_out[k] = sums[end]
        starts_out[k] = began[end]


@compiled
def _second(  # noqa: PLR0913, PLR0917
    i: int,
    now: float,
    cost: FloatArray,
    cost_before: FloatArray,
    sum_1: float,
    sum_2: float,
    began_1: float,
    began_2: float,
    sums: FloatArray,
    began: FloatArray,
) -> None:
    """Reach the second frame of a model: its (2, 1) step comes from before the model."""
    sums[i], began[i] = sum_1 + cost[i], began_1
    slow = sum_2 + 0.5 * (cost_before[i] + cost[i])
    if slow < sums[i]:
        sums[i], began[i] = slow, began_2
    fast = cost[i - 1] + cost[i]
    if fast < sums[i]:
        sums[i], began[i] = fast, now


@compiled
def _steps_of_sums(  # noqa: PLR0913, PLR0917
    cost: FloatArray,
    cost_of_last: FloatArray,
    cost_before: FloatArray,
    even: FloatArray,
    slow: FloatArray,
    fast: FloatArray,
    out: FloatArray,
) -> None:
    # Slices in place of i - 1 and i - 2: only so are neighbours computed side by side.
    for i in range(len(out)):
        a = even[i] + cost[i]
        b = slow[i] + 0.5 * (cost_before[i] + cost[i])
        c = fast[i] + cost_of_last[i] + cost[i]
        a = min(a, b)
        out[i] = min(a, c)


@compiled
def _steps_of_starts(  # noqa: PLR0913, PLR0917
    cost: FloatArray,
    cost_of_last: FloatArray,
    cost_before: FloatArray,
    even: FloatArray,
    slow: FloatArray,
    fast: FloatArray,
    even_start: FloatArray,
    slow_start: FloatArray,
    fast_start: FloatArray,
    out: FloatArray,
) -> None:
    for i in range(len(out)):
        a = even[i] + cost[i]
        b = slow[i] + 0.5 * (cost_before[i] + cost[i])
        c = fast[i] + cost_of_last[i] + cost[i]
        start, of_slow, of_fast = even_start[i], slow_start[i], fast_start[i]
        start = of_slow if b < a else start
        a = min(a, b)
        out[i] = of_fast if c < a else start
