"""Left against right: by how much each place of the back lies behind its mirrored place."""

import numpy as np

from adibas.arrays import FloatArray
from adibas.surface.back_grid import BackGrid
from adibas.surface.symmetry_line import SymmetryLine


def asymmetry_m(grid: BackGrid, line: SymmetryLine) -> FloatArray:
    """Return (H, W) metres: positive where a place lies further back than its mirrored place.

    Each row is mirrored about the line; NaN where either place is not known, and beyond the ends
    of the line.
    """
    mirrored = np.full(grid.back_m.shape, np.nan)
    middles_m = line.at(grid.y_m)
    inside = (grid.y_m <= line.y_m[0]) & (grid.y_m >= line.y_m[-1])
    for row in np.flatnonzero(inside):
        heights_m = grid.back_m[row]
        known = np.isfinite(heights_m)
        if known.sum() < 2:  # noqa: PLR2004  (nothing lies between fewer)
            continue
        other_m = 2.0 * middles_m[row] - grid.x_m
        value = np.interp(other_m, grid.x_m[known], heights_m[known], left=np.nan, right=np.nan)
        # A gap between two known places must not be bridged.
        near = np.interp(other_m, grid.x_m, known.astype(float), left=0.0, right=0.0)
        mirrored[row] = np.where(near > 0.99, value, np.nan)  # noqa: PLR2004
    return np.asarray(grid.back_m - mirrored)
