"""The walk of every pixel of a mask down every tree."""

import numpy as np

from adibas.arrays import Float32Array, FloatArray, Int32Array, IntArray
from adibas.even_blocks import even_blocks
from adibas.forests.feature_kernels import (
    BEGIN,
    HEIGHT,
    STRIDE,
    U_COLUMN,
    U_ROW,
    V_COLUMN,
    V_ROW,
    WIDTH,
    feature_value,
    offset,
)
from adibas.kernels import compiled, compiled_parallel, parallel_range

THRESHOLD, LINK = 5, 6
N_COLUMNS = 8
"""Of a table of steps: what a step needs is 32 bytes in a row, half of what memory gives at once.

Read as float32 its columns are those of nodes, read as int32 column `LINK` is the left child, or
-1 - l for leaf l.
"""
CHUNK = 512
"""Most pixels that one thread takes at once."""


@compiled
def walk_down(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    depth_m: Float32Array,
    slope_x: Float32Array,
    slope_y: Float32Array,
    places: IntArray,
    at: Int32Array,
    scales: Float32Array,
    first: int,
    steps: Float32Array,
    links: Int32Array,
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
                depth_m, slope_x, slope_y, places, here, scales[walker], steps, node
            )
            node = links[node, LINK] + np.int32(np.float32(value) >= steps[node, THRESHOLD])
            at_node[walker] = node
            walkers[n_left] = walker
            n_left += links[node, LINK] >= 0
        n_walking = n_left


@compiled
def walk_by_depth(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    depth_m: Float32Array,
    place: tuple[int, int, int, int],
    at: Int32Array,
    scales: Float32Array,
    first: int,
    steps: Float32Array,
    links: Int32Array,
    walkers: Int32Array,
    at_node: Int32Array,
) -> None:
    """Do as `walk_down` where all nodes ask for depth: the image's place is four numbers then.

    A table of them would be read anew at every step, since the compiler cannot know that nothing
    is written there.
    """
    begin, height, width, stride = place
    n_walking = walkers.size
    while n_walking > 0:
        n_left = 0
        for w in range(n_walking):
            walker = walkers[w]
            node, scale = at_node[walker], scales[walker]
            row, column = at[first + walker, 0], at[first + walker, 1]
            u_row = min(max(row + offset(steps, node, U_ROW, scale), -1), height)
            u_column = min(max(column + offset(steps, node, U_COLUMN, scale), -1), width)
            v_row = min(max(row + offset(steps, node, V_ROW, scale), -1), height)
            v_column = min(max(column + offset(steps, node, V_COLUMN, scale), -1), width)
            u_m = float(depth_m[begin + u_row * stride + u_column])
            value = u_m - float(depth_m[begin + v_row * stride + v_column])
            node = links[node, LINK] + np.int32(np.float32(value) >= steps[node, THRESHOLD])
            at_node[walker] = node
            walkers[n_left] = walker
            n_left += links[node, LINK] >= 0
        n_walking = n_left


@compiled_parallel
def predict(  # noqa: PLR0913, PLR0917  (kernel: arrays one by one)
    depth_m: Float32Array,
    slope_x: Float32Array,
    slope_y: Float32Array,
    places: IntArray,
    at: Int32Array,
    optics: FloatArray,
    roots: Int32Array,
    steps: Float32Array,
    links: Int32Array,
    leaves: Float32Array,
) -> Float32Array:
    """Return the (N, L) mean of the leaves of all trees at (N, 2) rows and columns.

    `steps` and `links` are one (M, 8) table, read as float32 and as int32; `optics` are the focal
    length in pixels, how far away outside is, and whether a node asks for gradients.
    """
    n_pixels, n_labels = at.shape[0], leaves.shape[1]
    probabilities = np.empty((n_pixels, n_labels), np.float32)
    n_chunks, size = even_blocks(n_pixels, CHUNK)
    for chunk in parallel_range(n_chunks):
        first = min(chunk * size, n_pixels)
        _predict_chunk(
            depth_m,
            slope_x,
            slope_y,
            places,
            at,
            optics,
            roots,
            steps,
            links,
            leaves,
            first,
            min(n_pixels, first + size) - first,
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
    optics: FloatArray,
    roots: Int32Array,
    steps: Float32Array,
    links: Int32Array,
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
        is_seen = z < optics[1]
        seen[n_seen] = i
        n_seen += is_seen
        scales[i] = optics[0] / z
        for label in range(n_labels):
            probabilities[first + i, label] = 0.0 if is_seen else 1.0 / n_labels
    share = np.float32(1.0 / roots.size)
    place = (places[0, BEGIN], places[0, HEIGHT], places[0, WIDTH], places[0, STRIDE])
    at_node = np.empty(n_pixels, np.int32)
    for tree in range(roots.size):
        at_node[:] = roots[tree]
        if links[roots[tree], LINK] >= 0:
            walkers = seen[:n_seen].copy()
            if optics[2] == 0.0:
                walk_by_depth(depth_m, place, at, scales, first, steps, links, walkers, at_node)
            else:
                walk_down(
                    *(depth_m, slope_x, slope_y, places, at, scales),
                    *(first, steps, links, walkers, at_node),
                )
        for s in range(n_seen):
            leaf = -1 - links[at_node[seen[s]], LINK]
            for label in range(n_labels):
                probabilities[first + seen[s], label] += share * leaves[leaf, label]
