"""What limbs the pixels about points of a body show."""

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.data.limbs import LimbParts

REACH_M, DEEP_M = 0.025, 0.06
"""Pixels count within `REACH_M` across and `DEEP_M` along the line of sight."""


def shares_around(
    parts: LimbParts,
    depth_m: Float32Array,
    points_m: FloatArray,
    pixels_uv: FloatArray,
    focal_px: float,
) -> FloatArray:
    """Return (M, L + 1) mean probabilities of limbs about points; the last: of something else.

    Parameters
    ----------
    parts : LimbParts
    depth_m : (H, W) float32 array
        That they were found in, metres; NaN where not measured: such pixels count by the picture.
    points_m : (M, 3) array
        In the camera's axes.
    pixels_uv : (M, 2) array
        Where the camera sees them; NaN where it does not.
    focal_px : float

    Returns
    -------
    array
        NaN where no pixel of the person is near a point.
    """
    rows, columns = np.nonzero(parts.pixels)
    depths_m = depth_m[rows, columns]
    shares = np.full((len(points_m), len(parts.labels) + 1), np.nan)
    for number, ((u, v), z_m) in enumerate(zip(pixels_uv, points_m[:, 2], strict=True)):
        apart_m = np.hypot(rows - v, columns - u) * z_m / focal_px
        is_near = (apart_m < REACH_M) & ~(np.abs(depths_m - z_m) > DEEP_M)
        if is_near.any():
            mean = parts.probabilities[is_near].mean(axis=0, dtype=float)
            shares[number] = np.append(mean, 1.0 - mean.sum())
    return shares
