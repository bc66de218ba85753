"""The search for the names of points: where it starts, and the pose of what was found."""

import math

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled
from adibas.shapes.assignment_kernels import assign
from adibas.shapes.labelling_kernels import (
    information,
    leave_one_out,
    pair_costs,
    projected,
    solve_lower,
    solve_upper,
)
from adibas.shapes.tree_kernels import (
    add_lengths,
    describe_pairs,
    direction_costs,
    min_marginals,
)

PLANE = 2
NO_TURN = 1e-12


@compiled
def turn_of(vector: FloatArray, n_dimensions: int) -> FloatArray:
    """Return the (D, D) rotation by a vector (3,), of which the plane takes the last number."""
    turn = np.eye(n_dimensions)
    if n_dimensions == PLANE:
        cos, sin = math.cos(vector[2]), math.sin(vector[2])
        turn[0, 0], turn[0, 1], turn[1, 0], turn[1, 1] = cos, -sin, sin, cos
        return turn
    angle = math.sqrt((vector**2).sum())
    if angle < NO_TURN:
        return turn
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn += math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return turn


@compiled
def rate_starts(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray,
    turns: FloatArray,
    means: FloatArray,
    whiteners: FloatArray,
    constants: FloatArray,
    scales: FloatArray,
    alones: FloatArray,
) -> FloatArray:
    """Return (K, R) hopes for each model and turn: energies if points could share labels.

    Parameters
    ----------
    points : (M, D) array
        Centred.
    turns : (R, D, D) array
        Rotations to try, model from points.
    means : (K, N, D) array
    whiteners : (K, N, D, D) array
        Lower triangular: they make the spread of a label in any shape a unit one.
    constants : (K, N) array
        Minus the log density of a label at its mean.
    scales, alones : (K,) arrays
        Units of points in one of the model; what a missing pair costs.
    """
    n_models, n_labels, n_dimensions = means.shape
    n_points = len(points)
    ratings = np.zeros((n_models, len(turns)))
    moved = np.empty((n_points, n_dimensions))
    of_points = np.empty(n_points)
    for r in range(len(turns)):
        turned = points @ turns[r].T
        for k in range(n_models):
            moved[:] = turned / scales[k]
            of_points[:] = 0.0
            total = 0.0
            for i in range(n_labels):
                least = 0.0
                for j in range(n_points):
                    cost = constants[k, i] - alones[k]
                    cost += 0.5 * _whitened(moved[j], means[k, i], whiteners[k, i])
                    least = min(least, cost)
                    of_points[j] = min(of_points[j], cost)
                total += least
            ratings[k, r] = 0.5 * (total + of_points.sum())
    return ratings


@compiled
def _whitened(point: FloatArray, mean: FloatArray, whitener: FloatArray) -> float:
    """Return the squared Mahalanobis distance of a (D,) point."""
    total = 0.0
    for d in range(len(point)):
        off = 0.0
        for e in range(d + 1):
            off += whitener[d, e] * (point[e] - mean[e])
        total += off * off
    return total


@compiled
def rate_models(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray,
    partners: IntArray,
    means: FloatArray,
    whiteners: FloatArray,
    constants: FloatArray,
    scales: FloatArray,
    alones: FloatArray,
) -> FloatArray:
    """Return (K,) hopes for each model, the names being known; `points` are turned already."""
    n_models, n_labels, _ = means.shape
    ratings = np.zeros(n_models)
    for k in range(n_models):
        for i in range(n_labels):
            j = partners[i]
            if j >= 0:
                off = _whitened(points[j] / scales[k], means[k, i], whiteners[k, i])
                ratings[k] += constants[k, i] - alones[k] + 0.5 * off
    return ratings


@compiled
def assign_start(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray,
    turn: FloatArray,
    scale: float,
    mean: FloatArray,
    spread: FloatArray,
    loadings: FloatArray,
    noise: FloatArray,
    alone: float,
    n_rounds: int,
) -> IntArray:
    """Return partners (N,) of one start: each point by all others, wide at first."""
    moved = np.ascontiguousarray(points @ turn.T) / scale
    partners = assign(pair_costs(moved, mean, spread, alone, 1.0))
    for done in range(n_rounds):
        lower = information(loadings, noise, partners)
        places, covariances, _ = leave_one_out(moved, mean, loadings, noise, partners, lower)
        widening = 4.0 if done == 0 else (2.0 if done == 1 else 1.0)
        new = assign(pair_costs(moved, places, covariances, alone, widening))
        is_same = (new == partners).all()
        partners = new
        if is_same and done > 1:
            break
    return partners


@compiled
def assign_by_tree(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray,
    shifts: IntArray,
    edges: IntArray,
    log_lengths: FloatArray,
    sds: FloatArray,
    directions: FloatArray,
    log_room: float,
    alone: float,
) -> IntArray:
    """Return (R, N) partners by neighbours alone, one for each turn (in sectors) of the points."""
    n_labels = len(edges) + 1
    _, n_bands, n_sectors = directions.shape
    pairs, bands, sectors = describe_pairs(points, n_bands, n_sectors)
    partners = np.empty((len(shifts), n_labels), np.int64)
    for r in range(len(shifts)):
        costs = direction_costs(
            pairs, bands, sectors, directions, points.shape[1], log_room, shifts[r]
        )
        add_lengths(costs, pairs, log_lengths, sds)
        partners[r] = assign(min_marginals(costs, edges, n_labels, alone))
    return partners


@compiled
def lay(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray,
    turn: FloatArray,
    scale: float,
    mean: FloatArray,
    loadings: FloatArray,
    noise: FloatArray,
    pose_sd: FloatArray,
    partners: IntArray,
    n_rounds: int,
) -> tuple[FloatArray, FloatArray, float]:
    """Find the pose of named points: the pose found becomes the start of the next round.

    Returns
    -------
    moved : (M, D) array
        The points in the model's frame.
    turn : (D, D) array
        Model from points.
    scale : float
        Units of points in one of the model.
    """
    n_dimensions = points.shape[1]
    moved = np.ascontiguousarray(points @ turn.T) / scale
    lower = information(loadings, noise, partners)
    for _ in range(n_rounds):
        half = solve_lower(lower, projected(moved, mean, loadings, noise, partners))
        z = solve_upper(lower, half)
        vector = -z[n_dimensions : n_dimensions + 3] * pose_sd[n_dimensions : n_dimensions + 3]
        back = turn_of(vector, n_dimensions)
        grown = max(1.0 + z[n_dimensions + 3] * pose_sd[n_dimensions + 3], 0.5)
        shift = z[:n_dimensions] * pose_sd[:n_dimensions]
        moved = np.ascontiguousarray((moved - shift) @ back.T) / grown
        turn = np.ascontiguousarray(back @ turn)
        scale = scale * grown
    return moved, turn, scale
