"""The least squares behind `adibas.shapes.similarity`."""

import numpy as np

from adibas.arrays import FloatArray
from adibas.kernels import compiled

DEGENERATE_SHARE = 1e-9
"""Points spread less than this share of the widest direction do not fix a rotation."""


@compiled
def best_similarity(
    target: FloatArray, source: FloatArray, share: FloatArray, has_scale: bool
) -> tuple[float, FloatArray, FloatArray]:
    """Return scale, rotation (D, D) and translation (D,); a scale of 0: nothing is fixed.

    `share` (N,) are the weights of the pairs; those of 0 are left out, NaN or not.
    """
    n_dimensions = target.shape[1]
    mean_target, mean_source = np.zeros(n_dimensions), np.zeros(n_dimensions)
    total = share.sum()
    for i in range(len(share)):
        if share[i] > 0:
            mean_target += share[i] / total * target[i]
            mean_source += share[i] / total * source[i]
    covariance = np.zeros((n_dimensions, n_dimensions))
    variance = 0.0
    for i in range(len(share)):
        if share[i] > 0:
            weight = share[i] / total
            off = source[i] - mean_source
            covariance += weight * np.outer(target[i] - mean_target, off)
            variance += weight * (off**2).sum()
    left, spread, right = np.linalg.svd(covariance)
    nothing = np.zeros((n_dimensions, n_dimensions)), np.zeros(n_dimensions)
    if not spread[n_dimensions - 2] > DEGENERATE_SHARE * spread[0]:
        return 0.0, *nothing
    if np.linalg.det(left) * np.linalg.det(right) < 0:
        left[:, -1] *= -1.0
        spread[-1] *= -1.0
    rotation = left @ right
    scale = spread.sum() / variance if has_scale else 1.0
    return max(scale, 0.0), rotation, mean_target - scale * (rotation @ mean_source)
