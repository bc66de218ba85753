"""How sure pose and depth bias are.

Cells err together with their neighbours in the image, since the sensor matches windows, and with
the same place in other shots, since part of its noise is a fixed pattern. Both correlations are
taken from the residuals, of which the fit itself has taken a known share, and go into the
covariance of the estimate.

Source: Huber, Robust statistics (1981), section 6.3, for an estimate whose weights are not the
noise's own; Conley, GMM estimation with cross sectional dependence, Journal of Econometrics 92
(1999), for neighbours.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from adibas.arrays import FloatArray, IntArray
from adibas.calibration.extrinsics_descent import (
    Problem,
    Weights,
    normal_equations,
    prior_slopes,
    unknowns_of,
)
from adibas.calibration.extrinsics_model import DepthState
from adibas.calibration.shots import N_PLANE
from adibas.geometry.projection import CAMERA_PARAMETERS

LARGEST_NEIGHBOUR = 0.45
"""Correlation of neighbours beyond which the pattern of all could not be one."""


@dataclass(frozen=True, slots=True, eq=False)
class DepthUncertainty:
    """How sure the free globals are.

    Attributes
    ----------
    covariance : (n, n) array
        By the noise of depth and corners.
    by_camera : (n, 17) array
        See `DepthFit`.
    sigma_per_m : float
        Standard deviation of a full cell's 1/z.
    neighbours : (2,) array
        Correlation with the cell beside and the cell below.
    pattern_share : float
        Of the noise's variance that is the same in all shots.
    """

    covariance: FloatArray
    by_camera: FloatArray
    sigma_per_m: float
    neighbours: FloatArray
    pattern_share: float


@dataclass(frozen=True, slots=True, eq=False)
class _Stack:
    """All cells of all shots with some weight, in units of their noise as the fit saw it."""

    residuals: FloatArray
    slopes: FloatArray
    weights: FloatArray
    shots: IntArray
    places: IntArray
    """(2, N): row and column of the cell."""


def uncertainty_of(problem: Problem, state: DepthState, weights: Weights) -> DepthUncertainty:
    """Return how sure the estimate is."""
    inverse = _inverse(problem, state, weights)
    stack = _stacked(problem, state, weights)
    moved = stack.slopes @ inverse
    taken = stack.weights * np.einsum("ni,ni->n", moved, stack.slopes)
    n_free = max(float(stack.weights.sum() - taken.sum()), 1.0)
    variance = float((stack.weights * stack.residuals**2).sum()) / n_free
    neighbours = np.array(
        [
            _correlation(stack, moved, variance, _beside(stack, step))
            for step in ((0, 0, 1), (0, 1, 0))
        ]
    )
    neighbours = np.clip(neighbours, 0.0, LARGEST_NEIGHBOUR)
    share = float(np.clip(_pattern(stack, moved, variance), 0.0, 1.0))
    scatter = variance * _scatter(stack, neighbours, share)
    n_kept = problem.n_kept
    # That the colour camera's error was thought to be none is no noise: `by_camera` tells it.
    scatter[:n_kept, :n_kept] += np.diag(problem.information[:n_kept])
    by_camera = np.zeros((len(inverse), len(CAMERA_PARAMETERS)))
    for index, (plane, prior) in enumerate(zip(problem.planes, problem.priors, strict=True)):
        pull = prior_slopes(problem, index).T @ prior.information
        scatter += pull @ prior_slopes(problem, index)
        by_camera += inverse @ pull @ plane.by_camera
    covariance = inverse @ scatter @ inverse
    free = problem.free[problem.free < n_kept]
    return DepthUncertainty(
        covariance[np.ix_(free, free)],
        by_camera[free],
        weights.sigma_per_m * float(np.sqrt(variance)),
        neighbours,
        share,
    )


def _inverse(problem: Problem, state: DepthState, weights: Weights) -> FloatArray:
    """Return the inverse of the normal matrix, 0 for what is not sought."""
    normal, _ = normal_equations(problem, state, weights)
    unknowns = unknowns_of(problem)
    part = normal[np.ix_(unknowns, unknowns)]
    scale = 1.0 / np.sqrt(np.diag(part))
    inverse = np.zeros_like(normal)
    inverse[np.ix_(unknowns, unknowns)] = np.linalg.pinv(
        part * np.outer(scale, scale), hermitian=True
    ) * np.outer(scale, scale)
    return inverse


def _stacked(problem: Problem, state: DepthState, weights: Weights) -> _Stack:
    n_global = problem.n_global
    parts = []
    for index, of_cells in enumerate(weights.of_cells):
        rows, cells = problem.rows(index, state), problem.cells[index]
        slopes = np.zeros((len(cells), n_global + N_PLANE * len(problem.cells)))
        slopes[:, : problem.n_kept] = rows.by_global
        slopes[:, n_global + N_PLANE * index : n_global + N_PLANE * (index + 1)] = rows.by_plane
        scale = np.sqrt(cells.shares) / weights.sigma_per_m
        is_used = of_cells > 0
        parts.append(
            (
                (rows.residuals * scale)[is_used],
                (slopes * scale[:, None])[is_used],
                (of_cells / cells.shares)[is_used],
                np.full(int(is_used.sum()), index),
                cells.blocks[is_used],
            )
        )
    residuals, slopes, of_cells, shots, blocks = (
        np.concatenate(part) for part in zip(*parts, strict=True)
    )
    return _Stack(residuals, slopes, of_cells, shots, blocks.T)


def _beside(stack: _Stack, step: tuple[int, int, int]) -> tuple[IntArray, IntArray]:
    """Return the pairs of cells that are `step` (shots, rows, columns) from each other."""
    size = np.array([stack.shots.max(), *stack.places.max(axis=1)]) + 2
    number = np.full(size, -1)
    number[stack.shots, stack.places[0], stack.places[1]] = np.arange(len(stack.shots))
    there = number[stack.shots + step[0], stack.places[0] + step[1], stack.places[1] + step[2]]
    here = np.flatnonzero(there >= 0)
    return here, there[here]


def _correlation(
    stack: _Stack, moved: FloatArray, variance: float, pairs: tuple[IntArray, IntArray]
) -> float:
    """Return the correlation of pairs of cells; what the fit took makes residuals too unlike."""
    first, second = pairs
    if not len(first):
        return 0.0
    taken = np.einsum("ni,ni->n", moved[first], stack.slopes[second])
    products = stack.residuals[first] * stack.residuals[second] + variance * taken
    return float(products.mean()) / variance


def _pattern(stack: _Stack, moved: FloatArray, variance: float) -> float:
    """Return the correlation of different shots at one place."""
    at_places = _at_places(stack)
    n_pairs = float((at_places.sum(axis=1).A1 ** 2).sum()) - len(stack.residuals)
    if n_pairs == 0.0:
        return 0.0
    total = ((at_places @ stack.residuals) ** 2).sum() - (stack.residuals**2).sum()
    taken = ((at_places @ moved) * (at_places @ stack.slopes)).sum()
    taken -= (moved * stack.slopes).sum()
    return float(total + variance * taken) / n_pairs / variance


def _scatter(stack: _Stack, neighbours: FloatArray, share: float) -> FloatArray:
    """Return the (N, N) scatter of the slope of the squares, for noise of variance 1."""
    pull = stack.slopes * stack.weights[:, None]
    beside, below = neighbours
    scatter = np.zeros((pull.shape[1], pull.shape[1]))
    at_places = _at_places(stack)
    size = stack.places.max(axis=1) + 1
    everywhere = np.zeros((*(size + 2), pull.shape[1]))
    everywhere[1:-1, 1:-1] = (at_places @ pull).reshape(*size, -1)
    inner = everywhere[1:-1, 1:-1].reshape(-1, pull.shape[1])
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            correlation = beside ** abs(right) * below ** abs(down)
            here, there = _beside(stack, (0, down, right))
            scatter += (1.0 - share) * correlation * (pull[here].T @ pull[there])
            rows, columns = slice(1 + down, size[0] + 1 + down), slice(1 + right, None)
            moved = everywhere[rows, columns][:, : size[1]].reshape(-1, pull.shape[1])
            scatter += share * correlation * (inner.T @ moved)
    return scatter


def _at_places(stack: _Stack) -> csr_matrix:
    """Return the (places, cells) matrix that sums cells of all shots at each place."""
    size = stack.places.max(axis=1) + 1
    place = stack.places[0] * size[1] + stack.places[1]
    n = len(place)
    return csr_matrix((np.ones(n), (place, np.arange(n))), shape=(int(size.prod()), n))
