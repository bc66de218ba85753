"""Small least squares agree with NumPy's."""

import numpy as np
import pytest

from adibas.geometry import cholesky_kernels
from adibas.markers import least_squares_kernels as kernels


def run_as(is_compiled):
    return (lambda f: f) if is_compiled else (lambda f: f.py_func)


@pytest.mark.parametrize("is_compiled", [True, False])
def test_solution_and_variances_are_numpy_s(is_compiled):
    rng = np.random.default_rng(4)
    terms = rng.normal(size=(30, 6))
    values = rng.normal(size=30)
    inverse = np.empty((6, 7))
    assert run_as(is_compiled)(kernels.solve_normal)(np.column_stack([terms, values]), inverse)
    expected, *_ = np.linalg.lstsq(terms, values, rcond=None)
    np.testing.assert_allclose(inverse[:, 6], expected, rtol=1e-9)
    covariance = np.linalg.inv(terms.T @ terms)
    np.testing.assert_allclose((inverse[:, :6] ** 2).sum(axis=1), np.diag(covariance), rtol=1e-9)


@pytest.mark.parametrize("is_compiled", [True, False])
def test_the_factor_is_cholesky_s_and_solves(is_compiled):
    rng = np.random.default_rng(5)
    square = rng.normal(size=(8, 8))
    matrix = square @ square.T
    factor, columns = matrix.copy(), rng.normal(size=(8, 2))
    assert run_as(is_compiled)(cholesky_kernels.factorise)(factor)
    lower = np.tril(factor)
    np.testing.assert_allclose(lower @ lower.T, matrix, rtol=1e-9)
    solved = columns.copy()
    run_as(is_compiled)(kernels.solve_forward)(factor, solved)
    np.testing.assert_allclose(lower @ solved, columns, rtol=1e-9)
    whole = columns[:, 0].copy()
    run_as(is_compiled)(cholesky_kernels.solve_factorised)(factor, whole)
    np.testing.assert_allclose(matrix @ whole, columns[:, 0], rtol=1e-7)


@pytest.mark.parametrize("is_compiled", [True, False])
def test_what_cannot_be_solved_is_told(is_compiled):
    rows = np.ones((10, 7))
    assert not run_as(is_compiled)(kernels.solve_normal)(rows, np.empty((6, 7)))
    assert not run_as(is_compiled)(cholesky_kernels.factorise)(-np.eye(3))
