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
MOST_LOGS = 16383
"""Of a table that fits into a processor's second cache."""


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
def disorder(histogram: IntArray, weighted_logs: FloatArray) -> float:
    """Return the entropy of counts times their number, bits; of `weighted_logs_up_to`."""
    total, weighted = 0, 0.0
    for label in range(histogram.size):
        n = histogram[label]
        if n > 0:
            total += n
            weighted += weighted_log(n, weighted_logs)
    return weighted_log(total, weighted_logs) - weighted if total > 0 else 0.0


@compiled
def weighted_log(n: int, weighted_logs: FloatArray) -> float:
    """Return ``n log2(n)``, looked up where the table has it: logarithms are most of the work."""
    return float(weighted_logs[n]) if n < weighted_logs.size else n * math.log2(n)


@compiled
def weighted_logs_up_to(n_logs: int) -> FloatArray:
    """Return ``n log2(n)`` for n from 0 to `n_logs`."""
    logs = np.zeros(n_logs + 1)
    for n in range(1, n_logs + 1):
        logs[n] = n * math.log2(n)
    return logs


@compiled
def _find_split(
    counts: Int32Array,
    node: int,
    weighted_logs: FloatArray,
    gains: FloatArray,
    choices: Int32Array,
    left: IntArray,
) -> None:
    """Fill in the rows of `best_splits` for one node."""
    n_candidates, _, n_gaps, n_labels = counts.shape
    whole = np.zeros(n_labels, np.int64)
    for gap in range(n_gaps):
        whole += counts[0, node, gap]
    before, n_pixels = disorder(whole, weighted_logs), max(whole.sum(), 1)
    below, above = np.empty(n_labels, np.int64), np.empty(n_labels, np.int64)
    for candidate in range(n_candidates):
        below[:] = 0
        above[:] = whole
        for t in range(n_gaps - 1):
            n_moved = 0
            for label in range(n_labels):
                moved = counts[candidate, node, t, label]
                n_moved += moved
                below[label] += moved
                above[label] -= moved
            if n_moved == 0:  # the split before, again
                continue
            ordered = before - disorder(below, weighted_logs) - disorder(above, weighted_logs)
            gain = ordered / n_pixels
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
    weighted_logs = weighted_logs_up_to(MOST_LOGS)
    for node in parallel_range(n_nodes):
        _find_split(counts, node, weighted_logs, gains, choices, left)
    return gains, choices, left
