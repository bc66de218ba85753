"""Distance of one frame to every frame of the models: the inner loop of all alignments.

Frames and results are told by number: a view of a row would be counted in and out, which costs as
much as a dozen rows of sums. Numbers are unsigned, since only then are neighbours computed side by
side: a negative one would count from the end.
"""

import math

import numpy as np

from adibas.arrays import FloatArray
from adibas.kernels import compiled, compiled_fused

AT_ONCE = 8
"""Rows that are summed in one pass: a pass costs more in memory than in sums."""


@compiled_fused
def squared_distances(
    frames: FloatArray, number: int, columns: FloatArray, out: FloatArray, row: int
) -> None:
    """Fill ``out[row, :n]`` with the squared distances of a frame to `columns` (d, n).

    Parameters
    ----------
    frames : (N, d) array
    number : int
        Of the frame.
    columns : (d, n) array
        Frames lie in columns, so that neighbours are summed side by side.
    out : (R, n or more) array
    row : int
    """
    n_rows, n_columns = np.uint64(columns.shape[0]), np.uint64(columns.shape[1])
    t, o = np.uint64(number), np.uint64(row)
    whole = n_rows - n_rows % np.uint64(AT_ONCE)
    for i in range(n_columns):
        out[o, i] = 0.0
    for k in range(np.uint64(0), whole, np.uint64(AT_ONCE)):
        k1, k2, k3 = k + np.uint64(1), k + np.uint64(2), k + np.uint64(3)
        k4, k5, k6, k7 = (k + np.uint64(4), k1 + np.uint64(4), k2 + np.uint64(4), k3 + np.uint64(4))
        p, p1, p2, p3 = frames[t, k], frames[t, k1], frames[t, k2], frames[t, k3]
        p4, p5, p6, p7 = frames[t, k4], frames[t, k5], frames[t, k6], frames[t, k7]
        for i in range(n_columns):
            a, b = columns[k, i] - p, columns[k1, i] - p1
            c, d = columns[k2, i] - p2, columns[k3, i] - p3
            e, f = columns[k4, i] - p4, columns[k5, i] - p5
            g, h = columns[k6, i] - p6, columns[k7, i] - p7
            first = (a * a + b * b) + (c * c + d * d)
            out[o, i] += first + ((e * e + f * f) + (g * g + h * h))
    for k in range(whole, n_rows):
        p = frames[t, k]
        for i in range(n_columns):
            e = columns[k, i] - p
            out[o, i] += e * e


@compiled_fused
def squared_distances_of_seen(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    frames: FloatArray,
    number: int,
    columns: FloatArray,
    squared_weights: FloatArray,
    least_share: float,
    seen: FloatArray,
    out: FloatArray,
    row: int,
) -> None:
    """Like `squared_distances` over the rows that both sides have, scaled up to all rows.

    NaN marks what was not seen. `squared_weights` (d, n) sums to 1 in each column; where less than
    `least_share` of it is seen on both sides, the distance is infinite. `seen` (n or more,) is
    scratch.
    """
    n_rows, n_columns = np.uint64(columns.shape[0]), np.uint64(columns.shape[1])
    t, o = np.uint64(number), np.uint64(row)
    for i in range(n_columns):
        out[o, i] = 0.0
        seen[i] = 0.0
    for k in range(n_rows):
        p = frames[t, k]
        if math.isnan(p):
            continue
        for i in range(n_columns):
            e = columns[k, i] - p
            known = e == e  # noqa: PLR0124  (false for NaN alone)
            out[o, i] += e * e if known else 0.0
            seen[i] += squared_weights[k, i] if known else 0.0
    for i in range(n_columns):
        is_enough = seen[i] > 0.0 and seen[i] >= least_share
        out[o, i] = out[o, i] / seen[i] if is_enough else math.inf


@compiled
def local_costs(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    frames: FloatArray,
    begin: int,
    end: int,
    columns: FloatArray,
    squared_weights: FloatArray,
    least_share: float,
    seen: FloatArray,
    out: FloatArray,
    row: int,
    n_rows: int,
) -> None:
    """Fill rows of `out` with the distances of some frames; see the two functions above.

    Frame ``begin + j`` gets row ``(row + j) % n_rows``. With an empty `squared_weights` the columns
    have no NaN, nor has any frame; which of the two it is, is asked once and not in the loop, where
    the question would cost as much as a third of the sums.
    """
    n_columns = columns.shape[1]
    if squared_weights.shape[0] > 0:
        for t in range(begin, end):
            here = (row + t - begin) % n_rows
            squared_distances_of_seen(
                frames, t, columns, squared_weights, least_share, seen, out, here
            )
            _take_roots(out, here, n_columns)
    else:
        for t in range(begin, end):
            here = (row + t - begin) % n_rows
            squared_distances(frames, t, columns, out, here)
            _take_roots(out, here, n_columns)


@compiled
def _take_roots(out: FloatArray, row: int, n_columns: int) -> None:
    o = np.uint64(row)
    for i in range(np.uint64(n_columns)):
        out[o, i] = math.sqrt(out[o, i])
