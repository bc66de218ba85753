"""Many whole alignments at once, shared between the threads."""

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.kernels import compiled_parallel, parallel_range
from adibas.timeseries.free_kernels import whole_cost


@compiled_parallel
def pair_costs(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    frames: FloatArray,
    columns: FloatArray,
    squared_weights: FloatArray,
    least_share: float,
    offsets: IntArray,
    gaps: BoolArray,
    pairs: IntArray,
    is_squared: bool,
    out: FloatArray,
) -> None:
    """Fill `out` (p,) with the sum of the best path of each pair of sequences.

    `frames` (N, d) holds all sequences one behind the other; `columns` (N * d,) each of them with
    its frames in columns, `squared_weights` likewise (or empty: nothing is missing); `gaps` (k,)
    says which have NaN. Every worker takes each n-th pair: long and short ones are shared evenly.
    """
    n_workers = 16
    dimension = frames.shape[1]
    longest = 0
    for k in range(len(offsets) - 1):
        longest = max(longest, offsets[k + 1] - offsets[k])
    for worker in parallel_range(n_workers):
        scratch = np.empty(6 * longest)
        for number in range(np.int64(worker), len(pairs), n_workers):
            a, b = pairs[number, 0], pairs[number, 1]
            begin, end = offsets[b], offsets[b + 1]
            area = slice(begin * dimension, end * dimension)
            # Without gaps in either the plain distance is the same, and several times faster.
            weights = squared_weights[:0].reshape(0, end - begin)
            if gaps[a] or gaps[b]:
                weights = squared_weights[area].reshape(dimension, end - begin)
            out[number] = whole_cost(
                frames[offsets[a] : offsets[a + 1]],
                columns[area].reshape(dimension, end - begin),
                weights,
                least_share,
                is_squared,
                scratch[: 6 * (end - begin)].reshape(6, end - begin),
            )
