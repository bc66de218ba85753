"""Alignment by the recurrence 7.4 of the thesis: steps (1, 1), (1, 0) and (0, 1) without limit.

Four frames of the stream are computed at once, each one model frame behind the other: within one
frame every cell waits for its neighbour, between frames they do not.
"""

import math

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled
from adibas.timeseries.frame_cost_kernels import local_costs, squared_distances

LANES = 4
PAD = LANES - 1
"""Infinite costs before and behind each row of `costs`."""


@compiled
def feed_free(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
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
    """Take frames as `feed_sloped` does; `memory` (8, M + 6) goes on."""
    n_frames, n_columns = len(stream), columns.shape[1]
    sums, began, cost, seen = memory[0], memory[1], memory[2:6], memory[6, :n_columns]
    whole = n_frames - n_frames % LANES
    for t in range(0, whole, LANES):
        local_costs(
            stream, t, t + LANES, columns, squared_weights, least_share, seen, cost, 0, LANES
        )
        for k in range(len(offsets) - 1):
            at, end = offsets[k], offsets[k + 1]
            _four_frames(cost[:, at:end], sums[at:end], began[at:end], first + t,
                         costs_out[t : t + LANES, k], starts_out[t : t + LANES, k])  # fmt: skip
    for t in range(whole, n_frames):
        local_costs(stream, t, t + 1, columns, squared_weights, least_share, seen, cost, 0, LANES)
        for k in range(len(offsets) - 1):
            at, end = offsets[k], offsets[k + 1]
            _one_frame(cost[0, at:end], sums[at:end], began[at:end], first + t)
            costs_out[t, k], starts_out[t, k] = sums[end - 1], began[end - 1]


@compiled
def _one_frame(cost: FloatArray, sums: FloatArray, began: FloatArray, now: float) -> None:
    """Replace the sums of the frame before by those of this one."""
    corner, corner_start = sums[0], began[0]
    sums[0], began[0] = cost[0], now
    for i in range(1, len(cost)):
        best, start = corner, corner_start
        corner, corner_start = sums[i], began[i]
        if corner < best:
            best, start = corner, corner_start
        if sums[i - 1] < best:
            best, start = sums[i - 1], began[i - 1]
        sums[i], began[i] = best + cost[i], start


@compiled
def _cell(  # noqa: PLR0913, PLR0917
    cost: float,
    corner: float,
    corner_start: float,
    above: float,
    above_start: float,
    left: float,
    left_start: float,
) -> tuple[float, float]:
    start = above_start if above < corner else corner_start
    best = min(corner, above)
    start = left_start if left < best else start
    best = min(best, left)
    return best + cost, start


@compiled
def _four_frames(  # noqa: PLR0915  (unrolled by hand: four lanes in registers)
    cost: FloatArray,
    sums: FloatArray,
    began: FloatArray,
    now: float,
    costs_out: FloatArray,
    starts_out: FloatArray,
) -> None:
    """Do what four calls of `_one_frame` do: lane k is at model frame s - k."""
    m = len(sums)
    inf = math.inf
    a0 = a1 = a2 = a3 = b0 = b1 = b2 = inf
    p0 = p1 = p2 = p3 = q0 = q1 = q2 = now
    last, last_start = inf, now
    for s in range(m + PAD):
        above, above_start = (sums[s], began[s]) if s < m else (inf, now)
        d0 = cost[0, s] if s < m else inf
        d1 = cost[1, s - 1] if 1 <= s <= m else inf
        d2 = cost[2, s - 2] if 2 <= s <= m + 1 else inf  # noqa: PLR2004
        d3 = cost[3, s - 3] if s >= PAD else inf
        n0, r0 = _cell(d0, last, last_start, above, above_start, a0, p0)
        n1, r1 = _cell(d1, b0, q0, a0, p0, a1, p1)
        n2, r2 = _cell(d2, b1, q1, a1, p1, a2, p2)
        n3, r3 = _cell(d3, b2, q2, a2, p2, a3, p3)
        if s < LANES:  # the first frame of the model may begin at any time
            n0, r0 = (d0, now) if s == 0 else (n0, r0)
            n1, r1 = (d1, now + 1) if s == 1 else (n1, r1)
            n2, r2 = (d2, now + 2) if s == 2 else (n2, r2)  # noqa: PLR2004
            n3, r3 = (d3, now + 3) if s == PAD else (n3, r3)
        if s >= PAD:
            sums[s - PAD], began[s - PAD] = n3, r3
        if s == m - 1:
            costs_out[0], starts_out[0] = n0, r0
        if s == m:
            costs_out[1], starts_out[1] = n1, r1
        if s == m + 1:
            costs_out[2], starts_out[2] = n2, r2
        last, last_start = above, above_start
        b0, b1, b2, q0, q1, q2 = a0, a1, a2, p0, p1, p2
        a0, a1, a2, a3, p0, p1, p2, p3 = n0, n1, n2, n3, r0, r1, r2, r3
    costs_out[3], starts_out[3] = sums[m - 1], began[m - 1]


@compiled
def whole_cost(
    frames: FloatArray,
    columns: FloatArray,
    squared_weights: FloatArray,
    least_share: float,
    is_squared: bool,
    scratch: FloatArray,
) -> float:
    """Return the sum of the best path from corner to corner; `scratch` (6, m) is overwritten.

    With `is_squared` the local cost is the squared distance.
    """
    cost, sums, seen = scratch[:LANES], scratch[LANES], scratch[LANES + 1]
    for t in range(0, len(frames), LANES):
        n_rows = min(LANES, len(frames) - t)
        if is_squared:
            for lane in range(n_rows):
                squared_distances(frames, t + lane, columns, cost, lane)
        else:
            local_costs(
                frames, t, t + n_rows, columns, squared_weights, least_share, seen, cost, 0, LANES
            )
        if t > 0 and n_rows == LANES:
            _four_rows(cost, sums)
        else:
            for lane in range(n_rows):
                _one_row(cost[lane], sums, t + lane == 0)
    return float(sums[len(sums) - 1])


@compiled
def _one_row(cost: FloatArray, sums: FloatArray, is_first: bool) -> None:
    if is_first:
        total = 0.0
        for i in range(len(cost)):
            total += cost[i]
            sums[i] = total
        return
    corner = sums[0]
    sums[0] += cost[0]
    for i in range(1, len(cost)):
        best = corner
        corner = sums[i]
        best = min(best, corner)
        best = min(best, sums[i - 1])
        sums[i] = best + cost[i]


@compiled
def _four_rows(cost: FloatArray, sums: FloatArray) -> None:
    """Do what four calls of `_one_row` do."""
    m = len(sums)
    inf = math.inf
    a0 = a1 = a2 = a3 = b0 = b1 = b2 = last = inf
    for s in range(m + PAD):
        above = sums[s] if s < m else inf
        d0 = cost[0, s] if s < m else inf
        d1 = cost[1, s - 1] if 1 <= s <= m else inf
        d2 = cost[2, s - 2] if 2 <= s <= m + 1 else inf  # noqa: PLR2004
        d3 = cost[3, s - 3] if s >= PAD else inf
        n0 = min(last, above, a0) + d0
        n1 = min(b0, a0, a1) + d1
        n2 = min(b1, a1, a2) + d2
        n3 = min(b2, a2, a3) + d3
        if s >= PAD:
            sums[s - PAD] = n3
        last = above
        b0, b1, b2 = a0, a1, a2
        a0, a1, a2, a3 = n0, n1, n2, n3
