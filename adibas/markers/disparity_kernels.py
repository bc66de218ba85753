"""The pixel loops of a burst's disparity."""

import math

import numpy as np

from adibas.arrays import Float32Array, FloatArray
from adibas.kernels import compiled


@compiled
def accumulate(depth_m: Float32Array, sums: FloatArray) -> None:
    """Add 1, 1/z and 1/z^2 of every measured pixel to `sums` (3, H, W)."""
    height, width = depth_m.shape
    for row in range(height):
        for column in range(width):
            z_m = float(depth_m[row, column])
            if z_m > 0.0:
                disparity = 1.0 / z_m
                sums[0, row, column] += 1.0
                sums[1, row, column] += disparity
                sums[2, row, column] += disparity * disparity


@compiled
def summarise(sums: FloatArray, least: float, greatest_sd_per_m: float) -> Float32Array:
    """Return the mean 1/z, NaN where fewer than `least` readings stand or they scatter."""
    _, height, width = sums.shape
    mean_per_m = np.full((height, width), np.nan, np.float32)
    for row in range(height):
        for column in range(width):
            n = sums[0, row, column]
            if n < least:
                continue
            mean = sums[1, row, column] / n
            variance = sums[2, row, column] / n - mean * mean
            if math.sqrt(max(variance, 0.0)) <= greatest_sd_per_m:
                mean_per_m[row, column] = mean
    return mean_per_m
