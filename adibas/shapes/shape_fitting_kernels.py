"""The shape step of a fit: the most probable shape of points whose pose may follow."""

import math

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.kernels import compiled

RIDGE = 1e-12
"""Of the mean information, added to a pose that points on nearly one line hardly fix."""


@compiled
def most_probable_shape(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    off: FloatArray,
    is_there: BoolArray,
    modes: FloatArray,
    variances: FloatArray,
    shape: FloatArray,
    noise: float,
    has_scale: bool,
) -> FloatArray:
    """Return the (t,) shape b that explains best, with some pose, how points depart from a mean.

    Parameters
    ----------
    off : (N, D) array
        Points less the mean, in the model's frame; NaN where one is missing.
    is_there : (N,) bool array
    modes, variances : (t, N * D) and (t,) arrays
        Of the model.
    shape : (N, D) array
        About which the pose changes.
    noise : float
        Variance of a coordinate.
    has_scale : bool
        Whether the size is part of the pose.
    """
    n_modes, n_dimensions = len(variances), shape.shape[1]
    known = np.flatnonzero(is_there)
    changes = _pose_changes(shape[known], math.sqrt((shape**2).sum() / len(shape)), has_scale)
    directions = np.empty((n_modes + len(changes), len(known) * n_dimensions))
    directions[n_modes:] = changes
    values = np.empty(directions.shape[1])
    weight = 1.0 / math.sqrt(noise)
    for a in range(len(known)):
        for d in range(n_dimensions):
            values[n_dimensions * a + d] = off[known[a], d] * weight
            for k in range(n_modes):
                of_mode = modes[k, n_dimensions * known[a] + d]
                directions[k, n_dimensions * a + d] = of_mode * weight
    information = directions @ directions.T
    ridge = RIDGE * np.trace(information) / len(information)
    for k in range(len(information)):
        information[k, k] += 1.0 / variances[k] if k < n_modes else ridge
    solved: FloatArray = np.linalg.solve(information, directions @ values)
    return solved[:n_modes]


@compiled
def _pose_changes(points: FloatArray, size: float, has_scale: bool) -> FloatArray:
    """Return the (n, N * D) ways in which points change with their pose: shift, turn, size."""
    n_points, n_dimensions = points.shape
    n_turns = n_dimensions * (n_dimensions - 1) // 2
    changes = np.zeros((n_dimensions + n_turns + 1, n_points, n_dimensions))
    row = n_dimensions
    for d in range(n_dimensions):
        changes[d, :, d] = size
        for e in range(d + 1, n_dimensions):
            changes[row, :, d] = -points[:, e]
            changes[row, :, e] = points[:, d]
            row += 1
    changes[row] = points
    n_ways = len(changes) if has_scale else row
    return changes[:n_ways].copy().reshape(n_ways, n_points * n_dimensions)
