"""Alignment of two whole sequences by dynamic time warping, one pair or all pairs of many.

Source: thesis, equations 7.3, 7.4 and 7.6; Sakoe & Chiba, Dynamic programming algorithm
optimization for spoken word recognition, 1978.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.timeseries.free_kernels import whole_cost
from adibas.timeseries.pair_kernels import pair_costs
from adibas.timeseries.stacking import LEAST_SEEN, NOTHING_MISSING, stacked


def alignment_sum(
    a: FloatArray, b: FloatArray, weights: FloatArray | None = None, *, is_squared: bool = False
) -> float:
    """Return the least sum of distances over all warping paths from corner to corner (7.4).

    Parameters
    ----------
    a, b : (m, d) and (n, d) arrays
        NaN where something was not seen: distances are scaled up from what both frames show, and
        infinite where they share less than half of the weight.
    weights : (d,) array, optional
        Factor of each number (7.6).
    is_squared : bool
        Sum squared distances in place of distances.
    """
    stack = stacked([np.atleast_2d(a), np.atleast_2d(b)], weights)
    return float(
        _sums(stack.frames, stack.offsets, stack.shares, np.array([[0, 1]]), is_squared)[0]
    )


def alignment_cost(a: FloatArray, b: FloatArray, weights: FloatArray | None = None) -> float:
    """Return `alignment_sum` divided by m + n, so that long and short sequences compare."""
    return alignment_sum(a, b, weights) / (len(a) + len(b))


def pairwise_costs(
    sequences: Sequence[FloatArray], weights: FloatArray | None = None, *, is_squared: bool = False
) -> FloatArray:
    """Return (k, k): the cost of every pair, 0 on the diagonal, on all threads.

    A cost is the sum over the path divided by m + n; with `is_squared` the root of the sum of
    squared distances, not divided.
    """
    n = len(sequences)
    rows, columns = np.triu_indices(n, k=1)
    pairs = np.column_stack([rows, columns]).astype(np.int64)
    costs = np.zeros((n, n))
    if len(pairs):
        stack = stacked(sequences, weights)
        sums = _sums(stack.frames, stack.offsets, stack.shares, pairs, is_squared)
        found = np.sqrt(sums) if is_squared else sums / _lengths(stack.offsets, pairs)
        costs[rows, columns] = costs[columns, rows] = found
    return costs


def cross_costs(
    sequences: Sequence[FloatArray], others: Sequence[FloatArray], weights: FloatArray | None = None
) -> FloatArray:
    """Return (k, l): the cost of each of `sequences` with each of `others`, divided by m + n."""
    stack = stacked([*sequences, *others], weights)
    k, n_others = len(sequences), len(others)
    rows, columns = np.indices((k, n_others)).reshape(2, -1)
    pairs = np.column_stack([rows, columns + k]).astype(np.int64)
    sums = _sums(stack.frames, stack.offsets, stack.shares, pairs, False)
    return np.asarray((sums / _lengths(stack.offsets, pairs)).reshape(k, n_others))


def warping_path(
    a: FloatArray, b: FloatArray, weights: FloatArray | None = None
) -> tuple[float, IntArray]:
    """Return the cost divided by m + n, and the path: (T, 2) indices into `a` and `b`."""
    distances = _distances(a, b, weights)
    m, n = distances.shape
    sums = np.full((m + 1, n + 1), np.inf)
    sums[0, 0] = 0.0
    for i in range(m):
        for j in range(n):
            before = min(sums[i, j], sums[i, j + 1], sums[i + 1, j])
            sums[i + 1, j + 1] = distances[i, j] + before
    i, j = m, n
    path = [(i - 1, j - 1)]
    while (i, j) != (1, 1):
        steps = [(i - 1, j - 1), (i - 1, j), (i, j - 1)]
        # Where nothing can be compared all sums are infinite: the path still stays inside.
        i, j = min((at for at in steps if min(at) > 0), key=lambda at: sums[at])
        path.append((i - 1, j - 1))
    return float(sums[m, n]) / (m + n), np.array(path[::-1], np.int64)


def _distances(a: FloatArray, b: FloatArray, weights: FloatArray | None) -> FloatArray:
    stack = stacked([a, b], weights)
    first, second = stack.frames[: len(a)], stack.frames[len(a) :]
    difference = first[:, None] - second[None]
    shares = np.isfinite(difference) @ stack.shares
    squares = np.nansum(difference**2, axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        scaled = np.where(shares >= LEAST_SEEN, squares / shares, np.inf)
    return np.asarray(np.sqrt(scaled))


def _lengths(offsets: IntArray, pairs: IntArray) -> FloatArray:
    lengths = np.diff(offsets)
    return np.asarray(lengths[pairs].sum(axis=1), np.float64)


def _sums(
    frames: FloatArray, offsets: IntArray, shares: FloatArray, pairs: IntArray, is_squared: bool
) -> FloatArray:
    has_gaps = bool(np.isnan(frames).any())
    if is_squared and has_gaps:
        raise ValueError("squared distances are for sequences without gaps")
    blocks = [frames[begin:end] for begin, end in pairwise(offsets)]
    columns = np.concatenate([block.T.ravel() for block in blocks])
    seen = (
        np.concatenate([np.repeat(shares, len(block)) for block in blocks])
        if has_gaps
        else np.empty(0)
    )
    out = np.empty(len(pairs))
    if len(pairs) == 1:
        begin = offsets[pairs[0, 1]]
        last = np.ascontiguousarray(frames[begin : offsets[pairs[0, 1] + 1]].T)
        weights = np.repeat(shares[:, None], last.shape[1], axis=1) if has_gaps else NOTHING_MISSING
        first = frames[offsets[pairs[0, 0]] : offsets[pairs[0, 0] + 1]]
        scratch = np.empty((6, last.shape[1]))
        out[0] = whole_cost(first, last, weights, LEAST_SEEN, is_squared, scratch)
    else:
        gaps = np.array([bool(np.isnan(block).any()) for block in blocks])
        pair_costs(frames, columns, seen, LEAST_SEEN, offsets, gaps, pairs, is_squared, out)
    return out
