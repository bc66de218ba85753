"""Where a picture ends, and what it cuts off there.

Depth pictures end before their last pixel: the first columns have no depth, where the pattern
cannot be matched.
"""

import numpy as np

from adibas.arrays import BoolArray, IntArray

MOST_SHARE = 0.025
"""Of the width and of the height that may be without depth at each edge."""
LEAST_LINE = 0.3
"""Share of a line with depth from which on it is the picture's first or last one."""
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
    top, bottom = _ends(measured)
    left, right = _ends(measured.T)
    return top, bottom, left, right


def _ends(measured: BoolArray) -> tuple[int, int]:
    """Return the first row that can show anything, and one past the last.

    A row that shows a little is that of something that ends there, not of the picture.
    """
    n_rows = len(measured)
    most = int(MOST_SHARE * n_rows)
    rows = np.flatnonzero(measured.any(axis=1))
    if not len(rows):
        return 0, n_rows
    first, last = int(rows[0]), int(rows[-1])
    is_first = first <= most and measured[first].mean() >= LEAST_LINE
    is_last = last >= n_rows - 1 - most and measured[last].mean() >= LEAST_LINE
    return first if is_first else 0, last + 1 if is_last else n_rows


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
