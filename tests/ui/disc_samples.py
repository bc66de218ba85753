"""Surfaces for the 3-D view of tests."""

import numpy as np

from adibas.data.discs import Discs


def discs_at(points_m, colors_rgb, radius_m=0.01):
    """Return discs at points; they face whoever looks."""
    n = len(points_m)
    return Discs(
        np.asarray(points_m, np.float32),
        np.full((n, 3), np.nan, np.float32),
        np.full(n, radius_m, np.float32),
        np.asarray(colors_rgb, np.uint8),
    )
