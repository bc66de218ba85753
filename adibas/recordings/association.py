"""Which colour image belongs to which depth image where a format keeps two lists."""

import numpy as np

from adibas.arrays import IntArray

MAX_DIFFERENCE_NS = 20_000_000
"""As TUM's own ``associate.py`` (0.02 s): more than half a frame at 30 frames/s, less than one."""
NEIGHBOURS = 4
"""Colour images looked at on either side of a depth image: a list of equal times stays linear."""


def associate(depth_ns: IntArray, color_ns: IntArray) -> tuple[tuple[int | None, int | None], ...]:
    """Pair images by their times; the nearest pairs first, each image once.

    Parameters
    ----------
    depth_ns, color_ns : (N,), (M,) arrays
        Times, nanoseconds, in any order.

    Returns
    -------
    pairs : tuple of (depth index or None, colour index or None)
        In the order of time (the depth's where there is one). An image without a partner within
        `MAX_DIFFERENCE_NS` stands alone.
    """
    color_of: dict[int, int] = {}
    taken: set[int] = set()
    for _, i, j in sorted(_candidates(depth_ns, color_ns)):
        if i not in color_of and j not in taken:
            color_of[i] = j
            taken.add(j)
    pairs: list[tuple[int | None, int | None]] = [
        (i, color_of.get(i)) for i in range(len(depth_ns))
    ]
    pairs += [(None, j) for j in range(len(color_ns)) if j not in taken]

    def time_of(pair: tuple[int | None, int | None]) -> int:
        depth, color = pair
        return int(depth_ns[depth] if depth is not None else color_ns[color or 0])

    return tuple(sorted(pairs, key=time_of))


def _candidates(depth_ns: IntArray, color_ns: IntArray) -> list[tuple[int, int, int]]:
    """Return (difference, depth index, colour index) of all near pairs; few neighbours each."""
    if not len(depth_ns) or not len(color_ns):
        return []
    order = np.argsort(color_ns, kind="stable")
    sorted_ns = color_ns[order]
    first = np.searchsorted(sorted_ns, depth_ns - MAX_DIFFERENCE_NS, "left")
    last = np.searchsorted(sorted_ns, depth_ns + MAX_DIFFERENCE_NS, "right")
    middle = np.searchsorted(sorted_ns, depth_ns, "left")
    first = np.maximum(first, middle - NEIGHBOURS)
    last = np.minimum(last, middle + NEIGHBOURS)
    return [
        (abs(int(depth_ns[i]) - int(sorted_ns[k])), i, int(order[k]))
        for i in range(len(depth_ns))
        for k in range(first[i], last[i])
    ]
