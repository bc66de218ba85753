"""How far every pixel is from the learned colours."""

import math

import numpy as np

from adibas.arrays import Float32Array
from adibas.kernels import compiled


@compiled
def unlikeness(
    lab: Float32Array, centroids_lab: Float32Array, lightness_weight: float
) -> Float32Array:
    """Return the (H, W) distance to the nearest centroid, with lightness weighted."""
    height, width, _ = lab.shape
    distance = np.empty((height, width), np.float32)
    weight = np.float32(lightness_weight)
    for row in range(height):
        for column in range(width):
            nearest = np.float32(np.inf)
            for i in range(centroids_lab.shape[0]):
                dl = lab[row, column, 0] - centroids_lab[i, 0]
                da = lab[row, column, 1] - centroids_lab[i, 1]
                db = lab[row, column, 2] - centroids_lab[i, 2]
                nearest = min(nearest, weight * dl * dl + da * da + db * db)
            distance[row, column] = math.sqrt(nearest)
    return distance
