"""Convolutions over occupied cells: products of matrices of neighbours, block by block."""

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array
from adibas.even_blocks import even_blocks
from adibas.kernels import compiled, compiled_parallel, parallel_range

_BLOCK = 128
"""Most cells of a product: what they gather stays in a core's own cache."""
_GRADIENT_BLOCK = 512
"""Likewise, of a product that sums over cells: longer ones are done at a higher rate."""
_N_SUMS = 8
"""Parts that gradients are summed in: always the same ones, whatever the number of cores."""
RECTIFIED, AS_IT_IS = np.float32(0.0), np.float32(-np.inf)
"""The least that a convolution makes: nothing below zero, or anything."""


@compiled_parallel
def convolved(
    features: Float32Array,
    neighbors: Int32Array,
    weights: Float32Array,
    bias: Float32Array,
    least: np.float32,
) -> Float32Array:
    """Return (N + 1, D) sums over neighbours, `least` at the least, and a last row of zeros.

    Parameters
    ----------
    features : (N + 1, C) float32 array
        The last row is what lies where no cell is.
    neighbors : (N, 9) int32 array
    weights : (9 C, D) float32 array
        Of all features of the first neighbour, the second, ...
    bias : (D,) float32 array
    least : float32
        `RECTIFIED`, or `AS_IT_IS`.
    """
    n_sites, n_neighbors = neighbors.shape
    n_features, n_made = features.shape[1], weights.shape[1]
    made = np.empty((n_sites + 1, n_made), np.float32)
    made[n_sites] = 0
    n_blocks, size = even_blocks(n_sites, _BLOCK)
    for block in parallel_range(n_blocks):
        first = min(block * size, n_sites)
        past = min(first + size, n_sites)
        gathered = np.empty((past - first, n_neighbors * n_features), np.float32)
        for site in range(first, past):
            for number in range(n_neighbors):
                neighbor, start = neighbors[site, number], number * n_features
                for feature in range(n_features):
                    gathered[site - first, start + feature] = features[neighbor, feature]
        product = np.dot(gathered, weights)
        for site in range(first, past):
            for feature in range(n_made):
                made[site, feature] = max(product[site - first, feature] + bias[feature], least)
    return made


@compiled_parallel
def weight_gradient(
    features: Float32Array, neighbors: Int32Array, gradient: Float32Array
) -> Float32Array:
    """Return (9 C, D) derivatives by the weights of `convolved`.

    Parameters
    ----------
    features : (N + 1, C) float32 array
    neighbors : (N, 9) int32 array
    gradient : (N + 1, D) float32 array
        Derivatives by what `convolved` returned; the last row does not count.
    """
    n_sites, n_neighbors = neighbors.shape
    n_features, n_made = features.shape[1], gradient.shape[1]
    n_gathered = n_neighbors * n_features
    sums = np.zeros((_N_SUMS, n_gathered, n_made), np.float32)
    share = (n_sites + _N_SUMS - 1) // _N_SUMS
    for part in parallel_range(_N_SUMS):
        end = min((part + 1) * share, n_sites)
        for first in range(part * share, end, _GRADIENT_BLOCK):
            past = min(first + _GRADIENT_BLOCK, end)
            gathered = np.empty((past - first, n_gathered), np.float32)
            for site in range(first, past):
                for number in range(n_neighbors):
                    neighbor, start = neighbors[site, number], number * n_features
                    for feature in range(n_features):
                        gathered[site - first, start + feature] = features[neighbor, feature]
            sums[part] += np.dot(gathered.T, gradient[first:past])
    total = np.zeros((n_gathered, n_made), np.float32)
    for part in range(_N_SUMS):
        total += sums[part]
    return total


def mirrored(weights: Float32Array, n_features: int) -> Float32Array:
    """Return (9 D, C) weights with which `convolved` takes gradients back to the (C,) features."""
    n_made = weights.shape[1]
    by_neighbor = weights.reshape(-1, n_features, n_made)[::-1]
    return np.ascontiguousarray(by_neighbor.transpose(0, 2, 1)).reshape(-1, n_features)


@compiled_parallel
def pooled(features: Float32Array, children: Int32Array) -> tuple[Float32Array, Int32Array]:
    """Return (M + 1, C) largest features of each cell's children, and (M, C) whose they are.

    A last row of zeros is added. Features are none below zero, so that a child that is not there
    changes nothing.
    """
    n_sites, n_features = len(children), features.shape[1]
    most = np.zeros((n_sites + 1, n_features), np.float32)
    whose = np.empty((n_sites, n_features), np.int32)
    nobody = len(features) - 1
    for site in parallel_range(n_sites):
        for feature in range(n_features):
            whose[site, feature] = nobody
        for number in range(children.shape[1]):
            child = children[site, number]
            if child == nobody:
                continue
            for feature in range(n_features):
                if features[child, feature] > most[site, feature]:
                    most[site, feature] = features[child, feature]
                    whose[site, feature] = child
    return most, whose


@compiled
def risen(features: Float32Array, parents: Int32Array, skipped: Float32Array) -> Float32Array:
    """Return (N + 1, C + D) features of each cell's parent, then its own; a last row of zeros.

    Parameters
    ----------
    features : (M + 1, C) float32 array
        Of the coarser level.
    parents : (N,) int32 array
    skipped : (N + 1, D) float32 array
    """
    n_sites, n_coarse, n_own = len(parents), features.shape[1], skipped.shape[1]
    made = np.empty((n_sites + 1, n_coarse + n_own), np.float32)
    made[n_sites] = 0
    for site in range(n_sites):
        made[site, :n_coarse] = features[parents[site]]
        made[site, n_coarse:] = skipped[site]
    return made


@compiled_parallel
def sums_with(values: Float32Array, others: Float32Array) -> FloatArray:
    """Return (2, D) sums of the first N rows of (N + 1, D) values, and of values times others."""
    n_sites, n_features = values.shape[0] - 1, values.shape[1]
    sums = np.zeros((_N_SUMS, 2, n_features))
    share = (n_sites + _N_SUMS - 1) // _N_SUMS
    for part in parallel_range(_N_SUMS):
        for site in range(part * share, min((part + 1) * share, n_sites)):
            for feature in range(n_features):
                value = np.float64(values[site, feature])
                sums[part, 0, feature] += value
                sums[part, 1, feature] += value * others[site, feature]
    total = np.zeros((2, n_features))
    for part in range(_N_SUMS):
        total += sums[part]
    return total


@compiled_parallel
def rectified(values: Float32Array, factor: Float32Array, offset: Float32Array) -> Float32Array:
    """Return (N + 1, D) what is above zero of ``values * factor + offset``; a last row of zeros."""
    n_sites, n_features = values.shape[0] - 1, values.shape[1]
    made = np.empty((n_sites + 1, n_features), np.float32)
    made[n_sites] = 0
    for site in parallel_range(n_sites):
        for feature in range(n_features):
            value = values[site, feature] * factor[feature] + offset[feature]
            made[site, feature] = max(value, np.float32(0))
    return made


@compiled_parallel
def slopes_of_rectified(by_made: Float32Array, made: Float32Array) -> Float32Array:
    """Return (N + 1, D) derivatives by what `rectified` returned, zero where that is zero."""
    found = np.empty_like(by_made)
    for site in parallel_range(by_made.shape[0]):
        for feature in range(by_made.shape[1]):
            is_above = made[site, feature] > 0
            found[site, feature] = by_made[site, feature] if is_above else np.float32(0)
    return found


@compiled_parallel
def combined(
    slopes: Float32Array,
    factor: Float32Array,
    values: Float32Array,
    bend: Float32Array,
    offset: Float32Array,
) -> Float32Array:
    """Return (N + 1, D) ``slopes * factor - (values * bend + offset)``; a last row of zeros."""
    n_sites, n_features = values.shape[0] - 1, values.shape[1]
    found = np.empty((n_sites + 1, n_features), np.float32)
    found[n_sites] = 0
    for site in parallel_range(n_sites):
        for feature in range(n_features):
            common = values[site, feature] * bend[feature] + offset[feature]
            found[site, feature] = slopes[site, feature] * factor[feature] - common
    return found
