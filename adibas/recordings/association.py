"""Which colour image belongs to which depth image where a format keeps two lists."""

from typing import NamedTuple

import numpy as np

from adibas.arrays import BoolArray, IntArray

MAX_DIFFERENCE_NS = 20_000_000
"""As TUM's own ``associate.py`` (0.02 s): more than half a frame at 30 frames/s, less than one."""
NEIGHBOURS = 4
"""Colour images looked at on either side of a depth image: a list of equal times stays linear."""
NONE = -1


class _Candidates(NamedTuple):
    """Near pairs, the nearest first: (K,) depth indices, (K,) colour indices."""

    depth: IntArray
    color: IntArray


def associate(depth_ns: IntArray, color_ns: IntArray) -> IntArray:
    """Pair images by their times; the nearest pairs first, each image once.

    Parameters
    ----------
    depth_ns, color_ns : (N,), (M,) arrays
        Times, nanoseconds, in any order; none negative.

    Returns
    -------
    pairs : (P, 2) array
        Depth index and colour index, -1 for none, in the order of time (the depth's where there is
        one). An image without a partner within `MAX_DIFFERENCE_NS` stands alone.
    """
    color_of = np.full(len(depth_ns), NONE)
    depth_of = np.full(len(color_ns), NONE)
    candidates = _candidates(depth_ns, color_ns)
    is_sure = _are_best_of_both(candidates, len(depth_ns), len(color_ns))
    i, j = candidates.depth[is_sure], candidates.color[is_sure]
    color_of[i], depth_of[j] = j, i
    is_open = (color_of[candidates.depth] == NONE) & (depth_of[candidates.color] == NONE)
    for i, j in zip(candidates.depth[is_open], candidates.color[is_open], strict=True):
        if color_of[i] == NONE and depth_of[j] == NONE:
            color_of[i], depth_of[j] = j, i
    alone = np.flatnonzero(depth_of == NONE)
    of_depth = np.column_stack([np.arange(len(depth_ns)), color_of])
    of_color = np.column_stack([np.full(len(alone), NONE), alone])
    times_ns = np.concatenate([depth_ns, color_ns[alone]])
    return np.concatenate([of_depth, of_color])[np.argsort(times_ns, kind="stable")]


def _candidates(depth_ns: IntArray, color_ns: IntArray) -> _Candidates:
    """Return all near pairs, few neighbours each; of equally near ones the first index first."""
    order = np.argsort(color_ns, kind="stable")
    sorted_ns = color_ns[order]
    latest_ns = np.iinfo(np.int64).max - MAX_DIFFERENCE_NS  # a later sum would turn negative
    until_ns = np.minimum(depth_ns, latest_ns) + MAX_DIFFERENCE_NS
    middle = np.searchsorted(sorted_ns, depth_ns, "left")
    first = np.searchsorted(sorted_ns, depth_ns - MAX_DIFFERENCE_NS, "left")
    last = np.searchsorted(sorted_ns, until_ns, "right")
    first, last = np.maximum(first, middle - NEIGHBOURS), np.minimum(last, middle + NEIGHBOURS)
    n_near = last - first
    depth = np.repeat(np.arange(len(depth_ns)), n_near)
    ends = np.cumsum(n_near)
    place = np.arange(len(depth)) + np.repeat(first - ends + n_near, n_near)
    color = order[place]
    difference_ns = np.abs(depth_ns[depth] - sorted_ns[place])
    nearest_first = np.lexsort((color, depth, difference_ns))
    return _Candidates(depth[nearest_first], color[nearest_first])


def _are_best_of_both(candidates: _Candidates, n_depth: int, n_color: int) -> BoolArray:
    """Say which pairs are the first of either image: nothing can take one from the other."""
    rank = np.arange(len(candidates.depth))
    best_of_depth, best_of_color = np.full(n_depth, len(rank)), np.full(n_color, len(rank))
    np.minimum.at(best_of_depth, candidates.depth, rank)
    np.minimum.at(best_of_color, candidates.color, rank)
    is_best: BoolArray = (best_of_depth[candidates.depth] == rank) & (
        best_of_color[candidates.color] == rank
    )
    return is_best
