"""Where a picture ends, and what it cuts off there.

Depth pictures end before their last pixel: the first columns have no depth, where the pattern
cannot be matched.
"""

import numpy as np

from adibas.arrays import BoolArray, IntArray

MOST_SHARE = 0.025
"""Of the width and of the height that may be without depth at each edge."""
TOUCHING_PX = 2
Box = tuple[int, int, int, int]
"""First row, one past the last, first column, one past the last."""


def seen_box(measured: BoolArray) -> Box:
    """Return the part of a (H, W) picture that can show anything, within `MOST_SHARE` of its edge.

    Parameters
    ----------
    measured : (H, W) bool array
        Pixels with depth.
    """
    ends: list[int] = []
    for axis in (1, 0):
        lines = np.flatnonzero(measured.any(axis=axis))
        n = measured.shape[1 - axis]
        most = int(MOST_SHARE * n)
        first, last = (int(lines[0]), int(lines[-1])) if len(lines) else (0, n - 1)
        ends += [min(first, most), max(last + 1, n - most)]
    top, bottom, left, right = ends
    return top, bottom, left, right


def cut_px(pixels: BoolArray, box: Box) -> IntArray:
    """Return how many pixels of each edge (top, bottom, left, right) a (H, W) mask touches."""
    top, bottom, left, right = box
    bands = (
        pixels[: top + TOUCHING_PX].any(axis=0),
        pixels[bottom - TOUCHING_PX :].any(axis=0),
        pixels[:, : left + TOUCHING_PX].any(axis=1),
        pixels[:, right - TOUCHING_PX :].any(axis=1),
    )
    return np.array([np.count_nonzero(band) for band in bands], np.int64)
