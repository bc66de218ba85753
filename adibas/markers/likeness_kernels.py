"""How far every pixel is from the learned colours."""

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
    distance = np.full((height, width), np.inf, np.float32)
    weight, most = np.float32(lightness_weight), np.float32(light_range)
    least, offset = np.float32(1.0) / most, np.float32(16.0)
    for row in range(height):
        # The columns are the innermost loop, so that several are computed at once.
        for i in range(centroids_lab.shape[0]):
            own, a, b = centroids_lab[i, 0] + offset, centroids_lab[i, 1], centroids_lab[i, 2]
            per_own = np.float32(1.0) / own
            for column in range(width):
                lightness = lab[row, column, 0] + offset
                light = lightness * per_own
                light = max(least, light)
                light = min(most, light)
                dl = lightness - light * own
                da = lab[row, column, 1] - light * a
                db = lab[row, column, 2] - light * b
                squared = weight * dl * dl + da * da + db * db
                nearest = distance[row, column]
                distance[row, column] = min(nearest, squared)
        for column in range(width):
            distance[row, column] = np.sqrt(distance[row, column])
    return distance
