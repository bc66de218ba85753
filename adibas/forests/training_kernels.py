"""Loops of training: where pixels are in a tree, and what candidates would make of them.

Tables: ``pixels`` (P, 4) int32: image of the batch, row, column, label; ``at_node`` (P,) int32;
``features`` (G C, 5) and ``thresholds`` (G C, T) float32, rising, of G nodes; ``counts``
(C, G, T + 1, L) int32: pixels of each label with a value in each gap between thresholds.
"""

import math

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array, IntArray
from adibas.forests.feature_kernels import BEGIN, STRIDE, feature_value
from adibas.kernels import compiled, compiled_parallel, parallel_range

IMAGE, ROW, COLUMN, LABEL = range(4)
THRESHOLD = 5
LEAF = -1


@compiled
def scales_of(
    depth_m: Float32Array, places: IntArray, focal_px: Float32Array, pixels: Int32Array
) -> Float32Array:
    """Return how many pixels a metre is at each of (P, 4) pixels."""
    scales = np.empty(pixels.shape[0], np.float32)
    for i in range(pixels.shape[0]):
        image = pixels[i, IMAGE]
        row_begin = places[image, BEGIN] + pixels[i, ROW] * places[image, STRIDE]
        scales[i] = focal_px[image] / depth_m[row_begin + pixels[i, COLUMN]]
    return scales


@compiled_parallel
def route(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    depth_m: Float32Array,
    slope_x: Float32Array,
    slope_y: Float32Array,
    places: IntArray,
    pixels: Int32Array,
    scales: Float32Array,
    child: Int32Array,
    nodes: Float32Array,
    at_node: Int32Array,
) -> None:
    """Move each pixel one level down, where its node was split: left where the value is less.

    `child` (M,) is `LEAF` or the left child; `nodes` (M, 6) are features and thresholds.
    """
    for i in parallel_range(pixels.shape[0]):
        node = at_node[i]
        if child[node] != LEAF:
            at = (pixels[i, IMAGE], pixels[i, ROW], pixels[i, COLUMN])
            value = feature_value(depth_m, slope_x, slope_y, places, at, scales[i], nodes, node)
            at_node[i] = child[node] + np.int32(np.float32(value) >= nodes[node, THRESHOLD])


@compiled_parallel
def count_values(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    depth_m: Float32Array,
    slope_x: Float32Array,
    slope_y: Float32Array,
    places: IntArray,
    pixels: Int32Array,
    scales: Float32Array,
    slots: Int32Array,
    features: Float32Array,
    thresholds: Float32Array,
    counts: Int32Array,
) -> None:
    """Add what every candidate makes of each pixel; `slots` (P,) is the node's row, or -1.

    Each candidate is counted by one thread, so that threads never meet.
    """
    for candidate in parallel_range(counts.shape[0]):
        for i in range(pixels.shape[0]):
            slot = slots[i]
            if slot < 0:
                continue
            at = (pixels[i, IMAGE], pixels[i, ROW], pixels[i, COLUMN])
            feature = slot * counts.shape[0] + candidate
            value = np.float32(
                feature_value(depth_m, slope_x, slope_y, places, at, scales[i], features, feature)
            )
            gap = 0
            for t in range(thresholds.shape[1]):
                gap += value >= thresholds[feature, t]
            counts[candidate, slot, gap, pixels[i, LABEL]] += 1


@compiled
def disorder(histogram: IntArray) -> float:
    """Return the entropy of counts times their number, bits."""
    total, weighted = 0, 0.0
    for label in range(histogram.size):
        n = histogram[label]
        if n > 0:
            total += n
            weighted += n * math.log2(n)
    return total * math.log2(total) - weighted if total > 0 else 0.0


@compiled
def _find_split(
    counts: Int32Array, node: int, gains: FloatArray, choices: Int32Array, left: IntArray
) -> None:
    """Fill in the rows of `best_splits` for one node."""
    n_candidates, _, n_gaps, n_labels = counts.shape
    whole = np.zeros(n_labels, np.int64)
    for gap in range(n_gaps):
        whole += counts[0, node, gap]
    before, n_pixels = disorder(whole), max(whole.sum(), 1)
    for candidate in range(n_candidates):
        below = np.zeros(n_labels, np.int64)
        for t in range(n_gaps - 1):
            below += counts[candidate, node, t]
            gain = (before - disorder(below) - disorder(whole - below)) / n_pixels
            if gain > gains[node]:
                gains[node] = gain
                choices[node, 0], choices[node, 1] = candidate, t
                left[node] = below


@compiled_parallel
def best_splits(counts: Int32Array) -> tuple[FloatArray, Int32Array, IntArray]:
    """Return for each node the split that tells most about the label.

    Returns
    -------
    gains : (G,) array
        Bits a pixel; 0 where nothing splits the node.
    choices : (G, 2) int32 array
        Candidate and threshold, the first of equals.
    left : (G, L) int64 array
        Pixels with values below that threshold.
    """
    n_nodes, n_labels = counts.shape[1], counts.shape[3]
    gains = np.zeros(n_nodes)
    choices = np.zeros((n_nodes, 2), np.int32)
    left = np.zeros((n_nodes, n_labels), np.int64)
    for node in parallel_range(n_nodes):
        _find_split(counts, node, gains, choices, left)
    return gains, choices, left
