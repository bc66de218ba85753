"""Normal equations of a few unknowns, without a library's threads: they cost more than these."""

import math

from adibas.arrays import FloatArray
from adibas.kernels import compiled

SINGULAR = 1e-12
"""A pivot below this share of its diagonal is rounding: the terms are not independent."""


@compiled
def factorise(matrix: FloatArray) -> bool:
    """Replace the lower triangle by its Cholesky factor; False where there is none."""
    for j in range(matrix.shape[0]):
        pivot = matrix[j, j]
        for k in range(j):
            pivot -= matrix[j, k] * matrix[j, k]
        if not pivot > SINGULAR * matrix[j, j]:
            return False
        matrix[j, j] = math.sqrt(pivot)
        for i in range(j + 1, matrix.shape[0]):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = total / matrix[j, j]
    return True


@compiled
def solve_factorised(factor: FloatArray, right: FloatArray) -> None:
    """Replace `right` (n,) by the solution of ``L L^T x = right``."""
    n = factor.shape[0]
    for i in range(n):
        total = right[i]
        for k in range(i):
            total -= factor[i, k] * right[k]
        right[i] = total / factor[i, i]
    for i in range(n - 1, -1, -1):
        total = right[i]
        for k in range(i + 1, n):
            total -= factor[k, i] * right[k]
        right[i] = total / factor[i, i]
