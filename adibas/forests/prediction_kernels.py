"""The walk of every pixel of a mask down every tree."""

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array, IntArray
from adibas.forests.feature_kernels import BEGIN, STRIDE, feature_value
from adibas.kernels import compiled, compiled_parallel, parallel_range

THRESHOLD = 5
CHUNK = 512
"""Pixels that one thread takes at once."""


@compiled
def walk_down(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    depth_m: Float32Array,
    slope_x: Float32Array,
    slope_y: Float32Array,
    places: IntArray,
    at: Int32Array,
    scales: Float32Array,
    first: int,
    child: Int32Array,
    nodes: Float32Array,
    walkers: Int32Array,
    at_node: Int32Array,
) -> None:
    """Take the pixels ``first + walkers`` from `at_node` down to their leaves.

    All take one step, then the next: steps of different pixels do not wait for one another's
    reading of memory, those of one pixel do.
    """
    n_walking = walkers.size
    while n_walking > 0:
        n_left = 0
        for w in range(n_walking):
            walker = walkers[w]
            node = at_node[walker]
            here = (0, at[first + walker, 0], at[first + walker, 1])
            value = feature_value(
                depth_m, slope_x, slope_y, places, here, scales[walker], nodes, node
            )
            node = child[node] + np.int32(np.float32(value) >= nodes[node, THRESHOLD])
            at_node[walker] = node
            walkers[n_left] = walker
            n_left += child[node] >= 0
        n_walking = n_left


@compiled_parallel
def predict(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    depth_m: Float32Array,
    slope_x: Float32Array,
    slope_y: Float32Array,
    places: IntArray,
    at: Int32Array,
    focal_and_far: FloatArray,
    roots: Int32Array,
    child: Int32Array,
    nodes: Float32Array,
    leaves: Float32Array,
) -> Float32Array:
    """Return the (N, L) mean of the leaves of all trees at (N, 2) rows and columns."""
    n_pixels, n_labels = at.shape[0], leaves.shape[1]
    probabilities = np.empty((n_pixels, n_labels), np.float32)
    for chunk in parallel_range((n_pixels + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        _predict_chunk(
            depth_m,
            slope_x,
            slope_y,
            places,
            at,
            focal_and_far,
            roots,
            child,
            nodes,
            leaves,
            first,
            min(n_pixels, first + CHUNK) - first,
            probabilities,
        )
    return probabilities


@compiled
def _predict_chunk(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    depth_m: Float32Array,
    slope_x: Float32Array,
    slope_y: Float32Array,
    places: IntArray,
    at: Int32Array,
    focal_and_far: FloatArray,
    roots: Int32Array,
    child: Int32Array,
    nodes: Float32Array,
    leaves: Float32Array,
    first: int,
    n_pixels: int,
    probabilities: Float32Array,
) -> None:
    """Fill in the rows of `n_pixels` pixels; even where there is no depth."""
    scales = np.zeros(n_pixels, np.float32)
    seen = np.empty(n_pixels, np.int32)
    n_seen, n_labels = 0, leaves.shape[1]
    for i in range(n_pixels):
        z = depth_m[places[0, BEGIN] + at[first + i, 0] * places[0, STRIDE] + at[first + i, 1]]
        is_seen = z < focal_and_far[1]
        seen[n_seen] = i
        n_seen += is_seen
        scales[i] = focal_and_far[0] / z
        for label in range(n_labels):
            probabilities[first + i, label] = 0.0 if is_seen else 1.0 / n_labels
    share = np.float32(1.0 / roots.size)
    at_node = np.empty(n_pixels, np.int32)
    for tree in range(roots.size):
        at_node[:] = roots[tree]
        if child[roots[tree]] >= 0:
            walkers = seen[:n_seen].copy()
            walk_down(
                depth_m, slope_x, slope_y, places, at, scales, first, child, nodes, walkers, at_node
            )
        for s in range(n_seen):
            leaf = -1 - child[at_node[seen[s]]]
            for label in range(n_labels):
                probabilities[first + seen[s], label] += share * leaves[leaf, label]
