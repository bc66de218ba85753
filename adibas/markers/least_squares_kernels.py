"""Small least squares without a library's threads: they cost more than the arithmetic."""

import numpy as np

from adibas.arrays import FloatArray
from adibas.geometry.cholesky_kernels import factorise
from adibas.kernels import compiled


@compiled
def solve_forward(factor: FloatArray, columns: FloatArray) -> None:
    """Solve ``L x = b`` in place for every column of `columns`."""
    for i in range(factor.shape[0]):
        for column in range(columns.shape[1]):
            total = columns[i, column]
            for k in range(i):
                total -= factor[i, k] * columns[k, column]
            columns[i, column] = total / factor[i, i]


@compiled
def solve_normal(rows: FloatArray, inverse: FloatArray) -> bool:
    """Solve least squares for `rows` (N, n_terms + 1), the last column being the values.

    `inverse` (n_terms, n_terms + 1) gets the solution in its last column, and before it the
    inverse of the factor of the normal matrix, whose squares are variances.
    """
    n_terms = rows.shape[1] - 1
    normal = np.zeros((n_terms, n_terms))
    for i in range(n_terms):
        for j in range(i + 1):
            for n in range(rows.shape[0]):
                normal[i, j] += rows[n, i] * rows[n, j]
    if not factorise(normal):
        return False
    right = np.zeros((n_terms, n_terms + 1))
    for i in range(n_terms):
        right[i, i] = 1.0
        for n in range(rows.shape[0]):
            right[i, n_terms] += rows[n, i] * rows[n, n_terms]
    solve_forward(normal, right)
    # The solution is L^-T (L^-1 b), and column c of L^-1 is already at hand.
    for i in range(n_terms):
        inverse[i, :n_terms] = right[:, i]
        inverse[i, n_terms] = (right[:, i] * right[:, n_terms]).sum()
    return True
