"""Distance of one frame to every frame of the models: the inner loop of all alignments."""

import math

from adibas.arrays import FloatArray
from adibas.kernels import compiled, compiled_fused


@compiled_fused
def squared_distances(frame: FloatArray, columns: FloatArray, out: FloatArray) -> None:
    """Fill `out` (n,) with the squared distances of `frame` (d,) to `columns` (d, n).

    Frames lie in columns, so that neighbours are summed side by side; four rows at a time, since
    a pass costs more in memory than in sums.
    """
    n_rows, n_columns = columns.shape
    whole = n_rows - n_rows % 4
    for i in range(n_columns):
        out[i] = 0.0
    for k in range(0, whole, 4):
        a, b, c, d = columns[k], columns[k + 1], columns[k + 2], columns[k + 3]
        p, q, r, s = frame[k], frame[k + 1], frame[k + 2], frame[k + 3]
        for i in range(n_columns):
            e, f, g, h = a[i] - p, b[i] - q, c[i] - r, d[i] - s
            out[i] += (e * e + f * f) + (g * g + h * h)
    for k in range(whole, n_rows):
        a, p = columns[k], frame[k]
        for i in range(n_columns):
            e = a[i] - p
            out[i] += e * e


@compiled_fused
def squared_distances_of_seen(
    frame: FloatArray,
    columns: FloatArray,
    squared_weights: FloatArray,
    least_share: float,
    seen: FloatArray,
    out: FloatArray,
) -> None:
    """Like `squared_distances` over the rows that both sides have, scaled up to all rows.

    NaN marks what was not seen. `squared_weights` (d, n) sums to 1 in each column; where less than
    `least_share` of it is seen on both sides, the distance is infinite. `seen` (n,) is scratch.
    """
    n_rows, n_columns = columns.shape
    for i in range(n_columns):
        out[i] = 0.0
        seen[i] = 0.0
    for k in range(n_rows):
        row, weights, p = columns[k], squared_weights[k], frame[k]
        if math.isnan(p):
            continue
        for i in range(n_columns):
            e = row[i] - p
            known = e == e  # noqa: PLR0124  (false for NaN alone)
            out[i] += e * e if known else 0.0
            seen[i] += weights[i] if known else 0.0
    for i in range(n_columns):
        out[i] = out[i] / seen[i] if seen[i] > 0.0 and seen[i] >= least_share else math.inf


@compiled
def local_costs(
    frame: FloatArray,
    columns: FloatArray,
    squared_weights: FloatArray,
    least_share: float,
    seen: FloatArray,
    out: FloatArray,
) -> None:
    """Fill `out` (n,) with the distances of `frame` to `columns`; see the two functions above.

    With an empty `squared_weights` the columns have no NaN, nor has any frame.
    """
    if squared_weights.shape[0] > 0:
        squared_distances_of_seen(frame, columns, squared_weights, least_share, seen, out)
    else:
        squared_distances(frame, columns, out)
    for i in range(len(out)):
        out[i] = math.sqrt(out[i])
