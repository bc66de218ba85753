"""How far every pixel is from the learned colours."""

import math

import numpy as np

from adibas.arrays import Float32Array
from adibas.kernels import compiled


@compiled
def unlikeness(
    lab: Float32Array, centroids_lab: Float32Array, lightness_weight: float, light_range: float
) -> Float32Array:
    """Return the (H, W) distance to the nearest centroid, whatever the light.

    CIELAB is a cube root of light: in dimmer light (L + 16, a, b) shrink together. So each
    centroid is brought to the pixel's own lightness first, by a factor between 1/`light_range`
    and `light_range`; what difference of lightness is left counts by `lightness_weight`.
    """
    height, width, _ = lab.shape
    distance = np.empty((height, width), np.float32)
    weight, most = np.float32(lightness_weight), np.float32(light_range)
    least = np.float32(1.0) / most
    for row in range(height):
        for column in range(width):
            nearest = np.float32(np.inf)
            lightness = lab[row, column, 0] + np.float32(16.0)
            for i in range(centroids_lab.shape[0]):
                own = centroids_lab[i, 0] + np.float32(16.0)
                light = min(max(lightness / own, least), most)
                dl = lightness - light * own
                da = lab[row, column, 1] - light * centroids_lab[i, 1]
                db = lab[row, column, 2] - light * centroids_lab[i, 2]
                nearest = min(nearest, weight * dl * dl + da * da + db * db)
            distance[row, column] = math.sqrt(nearest)
    return distance
