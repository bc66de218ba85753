"""Loops over pairs of neighbours: how much they differ, and what that weighs."""

import math

import numpy as np

from adibas.arrays import FloatArray, Int32Array
from adibas.kernels import compiled


@compiled
def _square_step(values: FloatArray, p: int, q: int) -> float:
    total = 0.0
    for channel in range(values.shape[1]):
        step = values[p, channel] - values[q, channel]
        total += step * step
    return total


@compiled
def mean_square_step(neighbors: Int32Array, values: FloatArray) -> float:
    """Return the mean squared difference of the pairs that are measured; 0 without any."""
    total, n_pairs = 0.0, 0
    for p in range(neighbors.shape[0]):
        for k in range(0, neighbors.shape[1], 2):
            if neighbors[p, k] >= 0:
                square = _square_step(values, p, neighbors[p, k])
                if not math.isnan(square):
                    total += square
                    n_pairs += 1
    return total / max(n_pairs, 1)


@compiled
def weigh(
    neighbors: Int32Array, values: FloatArray, mean_square: float, distances: FloatArray
) -> FloatArray:
    """Return the (N, K) weights; all 1 / distance where no pair differs."""
    weights = np.zeros(neighbors.shape)
    beta = 0.5 / mean_square if mean_square > 0.0 else 0.0
    for p in range(neighbors.shape[0]):
        for k in range(0, neighbors.shape[1], 2):
            q = neighbors[p, k]
            if q < 0:
                continue
            square = _square_step(values, p, q)
            if math.isnan(square):
                square = mean_square
            weight = math.exp(-beta * square) / distances[k]
            weights[p, k] = weight
            weights[q, k ^ 1] = weight
    return weights
