"""The walk of every pixel of a mask down every tree."""

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array, IntArray
from adibas.forests.feature_kernels import BEGIN, WIDTH, feature_value
from adibas.kernels import compiled_parallel, parallel_range

THRESHOLD = 5
CHUNK = 512
"""Pixels that one thread takes at once."""


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
    focal_px, far_m = focal_and_far[0], focal_and_far[1]
    probabilities = np.zeros((n_pixels, n_labels), np.float32)
    share = np.float32(1.0 / roots.size)
    for chunk in parallel_range((n_pixels + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        for i in range(first, min(n_pixels, first + CHUNK)):
            row, column = at[i, 0], at[i, 1]
            z = depth_m[places[0, BEGIN] + row * places[0, WIDTH] + column]
            if z >= far_m:
                probabilities[i, :] = np.float32(1.0 / n_labels)
                continue
            scale: float = np.float32(focal_px / z)  # type: ignore[assignment]
            for tree in range(roots.size):
                node = roots[tree]
                while child[node] >= 0:
                    value = feature_value(
                        depth_m,
                        slope_x,
                        slope_y,
                        places,
                        (0, row, column),
                        scale,
                        nodes,
                        node,
                        far_m,
                    )
                    node = child[node] + np.int32(np.float32(value) >= nodes[node, THRESHOLD])
                leaf = -1 - child[node]
                for label in range(n_labels):
                    probabilities[i, label] += share * leaves[leaf, label]
    return probabilities
