"""The hot loops of naming points: one shape model of many laid onto points without names.

Everything is in a model's own frame and unit. A shape is ``mean + loadings z + noise`` with z of
standard normal numbers: first D shifts, then turns, a scale, then the model's modes, so that pose
and shape are found together, and a point is judged by what all others say of it.

`marginal` and `leave_one_out` follow from the Gaussian of the assigned points with the covariance
``C = W W' + Psi``: Petersen & Pedersen, The matrix cookbook (2012), 8.1.3 and 9.1.3 (Woodbury).
"""

import math

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled

LOG_2PI = math.log(2.0 * math.pi)


@compiled
def factor(matrix: FloatArray) -> FloatArray:
    """Return the lower Cholesky factor of a positive definite matrix."""
    lower = np.zeros(matrix.shape)
    factor_rows(matrix, np.arange(len(matrix)), lower)
    return lower


@compiled
def factor_rows(matrix: FloatArray, rows: IntArray, lower: FloatArray) -> None:
    """Fill the lower half of the Cholesky factor of some rows and columns of a matrix.

    Of the matrix the lower half alone is read, if `rows` rise.
    """
    for i in range(len(rows)):
        for j in range(i + 1):
            total = matrix[rows[i], rows[j]]
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if i == j:
                lower[i, i] = math.sqrt(total)
            else:
                lower[i, j] = total / lower[j, j]


@compiled
def solve_lower(lower: FloatArray, right: FloatArray) -> FloatArray:
    """Return x of ``lower x = right``."""
    n = len(right)
    x = np.empty(n)
    for i in range(n):
        total = right[i]
        for k in range(i):
            total -= lower[i, k] * x[k]
        x[i] = total / lower[i, i]
    return x


@compiled
def solve_upper(lower: FloatArray, right: FloatArray) -> FloatArray:
    """Return x of ``lower' x = right``."""
    n = len(right)
    x = np.empty(n)
    for i in range(n - 1, -1, -1):
        total = right[i]
        for k in range(i + 1, n):
            total -= lower[k, i] * x[k]
        x[i] = total / lower[i, i]
    return x


@compiled
def information(loadings: FloatArray, noise: FloatArray, partners: IntArray) -> FloatArray:
    """Return the Cholesky factor (Q, Q) of ``I + W' Psi^-1 W`` over the labels with a partner."""
    n_labels, n_dimensions, n_factors = loadings.shape
    matrix = np.eye(n_factors)
    for i in range(n_labels):
        if partners[i] < 0:
            continue
        for d in range(n_dimensions):
            for a in range(n_factors):
                scaled = loadings[i, d, a] / noise[i]
                for b in range(a + 1):
                    matrix[a, b] += scaled * loadings[i, d, b]
    return factor(matrix)


@compiled
def projected(
    points: FloatArray,
    mean: FloatArray,
    loadings: FloatArray,
    noise: FloatArray,
    partners: IntArray,
) -> FloatArray:
    """Return ``W' Psi^-1 r`` (Q,) of the assigned points."""
    n_labels, n_dimensions, n_factors = loadings.shape
    total = np.zeros(n_factors)
    for i in range(n_labels):
        j = partners[i]
        if j < 0:
            continue
        for d in range(n_dimensions):
            off = (points[j, d] - mean[i, d]) / noise[i]
            for a in range(n_factors):
                total[a] += loadings[i, d, a] * off
    return total


@compiled
def marginal(
    points: FloatArray,
    mean: FloatArray,
    loadings: FloatArray,
    noise: FloatArray,
    partners: IntArray,
    lower: FloatArray,
) -> float:
    """Return minus the log density of the assigned points; `lower` is of `information`."""
    n_labels, n_dimensions, n_factors = loadings.shape
    energy = 0.0
    for i in range(n_labels):
        j = partners[i]
        if j < 0:
            continue
        energy += 0.5 * n_dimensions * (LOG_2PI + math.log(noise[i]))
        for d in range(n_dimensions):
            energy += 0.5 * (points[j, d] - mean[i, d]) ** 2 / noise[i]
    for a in range(n_factors):
        energy += math.log(lower[a, a])
    half = solve_lower(lower, projected(points, mean, loadings, noise, partners))
    for a in range(n_factors):
        energy -= 0.5 * half[a] ** 2
    return energy


@compiled
def pair_costs(
    points: FloatArray, places: FloatArray, covariances: FloatArray, alone: float, widening: float
) -> FloatArray:
    """Return (N, M) minus log densities of points about places, less what being alone costs."""
    n_labels, n_dimensions = places.shape
    n_points = len(points)
    costs = np.empty((n_labels, n_points))
    for i in range(n_labels):
        lower = factor(covariances[i] * widening)
        constant = 0.5 * n_dimensions * LOG_2PI - alone
        for d in range(n_dimensions):
            constant += math.log(lower[d, d])
        for j in range(n_points):
            total = 0.0
            white = np.empty(n_dimensions)
            for d in range(n_dimensions):
                off = points[j, d] - places[i, d]
                for k in range(d):
                    off -= lower[d, k] * white[k]
                white[d] = off / lower[d, d]
                total += white[d] ** 2
            costs[i, j] = constant + 0.5 * total
    return costs


@compiled
def leave_one_out(
    points: FloatArray,
    mean: FloatArray,
    loadings: FloatArray,
    noise: FloatArray,
    partners: IntArray,
    lower: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where each label is by all other labels' points, and with which covariance.

    Returns
    -------
    places : (N, D) array
    covariances : (N, D, D) array
    z : (Q,) array
        The most probable factors given all points.
    """
    n_labels, n_dimensions, _ = loadings.shape
    z = solve_upper(lower, solve_lower(lower, projected(points, mean, loadings, noise, partners)))
    places = np.empty((n_labels, n_dimensions))
    covariances = np.empty((n_labels, n_dimensions, n_dimensions))
    for i in range(n_labels):
        spread = _spread(loadings[i], lower)
        places[i] = mean[i] + loadings[i] @ z
        j = partners[i]
        if j < 0:
            covariances[i] = spread + noise[i] * np.eye(n_dimensions)
            continue
        precision = (np.eye(n_dimensions) - spread / noise[i]) / noise[i]
        covariances[i] = np.linalg.inv(precision)
        pull = (points[j] - places[i]) / noise[i]
        places[i] = points[j] - covariances[i] @ pull
    return places, covariances, z


@compiled
def _spread(loadings: FloatArray, lower: FloatArray) -> FloatArray:
    """Return the (D, D) covariance of one label's place that the factors' leaves."""
    n_dimensions, n_factors = loadings.shape
    whitened = np.empty((n_dimensions, n_factors))
    for d in range(n_dimensions):
        whitened[d] = solve_lower(lower, loadings[d])
    return whitened @ whitened.T
