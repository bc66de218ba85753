"""The cheapest assignment of points to labels, where both may stay alone.

Source: Kuhn, The Hungarian method for the assignment problem (1955), in the form with shortest
augmenting paths: Jonker & Volgenant, Computing 38 (1987).
"""

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.kernels import compiled


@compiled
def assign(costs: FloatArray) -> IntArray:
    """Return for each row of (N, M) costs its column, -1 for none.

    A pair is made only where its cost is below 0: what it costs to leave both alone.
    """
    n_rows, n_columns = costs.shape
    is_turned = n_rows > n_columns
    square = np.minimum(costs.T if is_turned else costs, 0.0)
    row_of = _matched(np.ascontiguousarray(square))
    partners = np.full(n_rows, -1, np.int64)
    for column in range(1, len(row_of)):
        if row_of[column] == 0:
            continue
        i, j = row_of[column] - 1, column - 1
        if is_turned:
            i, j = j, i
        if costs[i, j] < 0.0:
            partners[i] = j
    return partners


@compiled
def _matched(costs: FloatArray) -> IntArray:
    """Return for each column of (n, m) costs, n <= m, its row; both counted from 1, 0 for none."""
    n, m = costs.shape
    row_prices = np.zeros(n + 1)
    column_prices = np.zeros(m + 1)
    row_of = np.zeros(m + 1, np.int64)
    way = np.zeros(m + 1, np.int64)
    slack = np.empty(m + 1)
    is_used = np.empty(m + 1, np.bool_)
    for row in range(1, n + 1):
        row_of[0] = row
        column = 0
        slack[:] = np.inf
        is_used[:] = False
        while True:
            is_used[column] = True
            column = _nearest(costs, row_prices, column_prices, row_of, way, slack, is_used, column)
            if row_of[column] == 0:
                break
        while column != 0:
            before = way[column]
            row_of[column] = row_of[before]
            column = before
    return row_of


@compiled
def _nearest(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    costs: FloatArray,
    row_prices: FloatArray,
    column_prices: FloatArray,
    row_of: IntArray,
    way: IntArray,
    slack: FloatArray,
    is_used: BoolArray,
    column: int,
) -> int:
    """Lengthen the shortest path by one column, move the prices, and return that column."""
    row = row_of[column]
    least, best = np.inf, 0
    for j in range(1, len(slack)):
        if is_used[j]:
            continue
        reduced = costs[row - 1, j - 1] - row_prices[row] - column_prices[j]
        if reduced < slack[j]:
            slack[j] = reduced
            way[j] = column
        if slack[j] < least:
            least = slack[j]
            best = j
    for j in range(len(slack)):
        if is_used[j]:
            row_prices[row_of[j]] += least
            column_prices[j] -= least
        else:
            slack[j] -= least
    return best
