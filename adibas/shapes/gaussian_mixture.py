"""Mixtures of normal distributions, fitted to rows of numbers.

Source: Dempster, Laird & Rubin, Maximum likelihood from incomplete data via the EM algorithm,
JRSS B 39 (1977); begun by k-means++ (Arthur & Vassilvitskii 2007). Covariances are drawn towards
that of all rows and get a floor, so that no component falls into a single row.
"""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape, read_only

LEAST_ROWS = 40
"""Of a component: fewer do not tell a covariance."""
POOLED_ROWS = 0.02
"""Weight of the covariance of all rows against a component's own, in rows for each column."""
N_GROUPING_ROUNDS = 15
MOST_ROUNDS = 60
DONE = 1e-3
TINY = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Mixture:
    """K normal distributions in D dimensions.

    Attributes
    ----------
    weights : (K,) array
        They sum to 1.
    means : (K, D) array
    covariances : (K, D, D) array
    """

    weights: FloatArray
    means: FloatArray
    covariances: FloatArray

    def __post_init__(self) -> None:
        check_shape("means", self.means, (len(self.weights), None))
        check_shape("covariances", self.covariances, (*self.means.shape, self.means.shape[1]))
        for array in (self.weights, self.means, self.covariances):
            read_only(array)

    def marginal(self, columns: IntArray) -> "Mixture":
        """Return the mixture of some of the dimensions."""
        covariances = self.covariances[:, columns[:, None], columns]
        return Mixture(self.weights, self.means[:, columns], covariances)

    def log_densities(self, rows: FloatArray) -> FloatArray:
        """Return the (S, K) log densities of (S, D) rows, each with its component's weight."""
        return normal_log_densities(rows, self.means, self.covariances) + np.log(self.weights)


def normal_log_densities(
    rows: FloatArray, means: FloatArray, covariances: FloatArray
) -> FloatArray:
    """Return the (S, K) log densities of (S, D) rows in K normal distributions."""
    lowers = np.linalg.cholesky(covariances)
    off = np.swapaxes(rows[None] - means[:, None], 1, 2)
    squares = (np.linalg.solve(lowers, off) ** 2).sum(axis=1)
    log_volumes = np.log(np.diagonal(lowers, axis1=1, axis2=2)).sum(axis=1)
    constants = -log_volumes - 0.5 * means.shape[1] * math.log(2.0 * math.pi)
    return np.asarray(constants - 0.5 * squares.T)


def fit_mixture(
    rows: FloatArray, n_components: int, floor: FloatArray, rng: np.random.Generator
) -> Mixture:
    """Fit at most `n_components` to (S, D) rows.

    Parameters
    ----------
    floor : (D,) array
        Variance that every component has at least in each column.
    rng : Generator
        Of the start.
    """
    check_shape("rows", rows, (None, len(floor)))
    n_components = max(1, min(n_components, len(rows) // LEAST_ROWS))
    shares = np.eye(n_components)[_grouped(rows, n_components, rng)]
    before = -math.inf
    mixture = _maximised(rows, shares, floor)
    for _ in range(MOST_ROUNDS):
        logs = mixture.log_densities(rows)
        highest = logs.max(axis=1, keepdims=True)
        shares = np.exp(logs - highest)
        totals = shares.sum(axis=1, keepdims=True)
        likelihood = float((highest + np.log(totals)).mean())
        mixture = _maximised(rows, shares / totals, floor)
        if likelihood - before < DONE:
            break
        before = likelihood
    return mixture


def _maximised(rows: FloatArray, shares: FloatArray, floor: FloatArray) -> Mixture:
    """Return the mixture of rows of which each component has (S, K) shares."""
    n_dimensions = rows.shape[1]
    counts = shares.sum(axis=0) + TINY
    means = shares.T @ rows / counts[:, None]
    pooled = np.atleast_2d(np.cov(rows.T))
    weight = POOLED_ROWS * n_dimensions
    covariances = np.empty((len(counts), n_dimensions, n_dimensions))
    for k, count in enumerate(counts):
        off = rows - means[k]
        own = (off * shares[:, [k]]).T @ off
        covariances[k] = (own + weight * pooled) / (count + weight) + np.diag(floor)
    return Mixture(counts / counts.sum(), means, covariances)


def _grouped(rows: FloatArray, n_groups: int, rng: np.random.Generator) -> IntArray:
    """Return a group for each row: k-means of the columns in standard deviations."""
    scaled = rows / (rows.std(axis=0) + TINY)
    centres = scaled[[int(rng.integers(len(scaled)))]]
    for _ in range(n_groups - 1):
        nearest = _squared(scaled, centres).min(axis=1) + TINY
        chosen = int(rng.choice(len(scaled), p=nearest / nearest.sum()))
        centres = np.concatenate([centres, scaled[[chosen]]])
    for _ in range(N_GROUPING_ROUNDS):
        groups = _squared(scaled, centres).argmin(axis=1)
        centres = np.stack([
            scaled[groups == k].mean(axis=0) if (groups == k).any() else centres[k]
            for k in range(n_groups)
        ])  # fmt: skip
    return np.asarray(_squared(scaled, centres).argmin(axis=1))


def _squared(rows: FloatArray, centres: FloatArray) -> FloatArray:
    apart = (rows**2).sum(axis=1)[:, None] - 2 * rows @ centres.T + (centres**2).sum(axis=1)
    return np.asarray(np.maximum(apart, 0.0))
