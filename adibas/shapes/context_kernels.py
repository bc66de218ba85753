"""The hot loops of shape contexts."""

import math

import numpy as np

from adibas.arrays import FloatArray
from adibas.kernels import compiled

TINY = 1e-300


@compiled
def count_contexts(points: FloatArray, radii: FloatArray, n_angles: int) -> FloatArray:
    """Return the (N, n_rings, n_angles) log-polar histograms of (N, 2) points.

    `radii` (n_rings,) are the rings' outer edges in the points' unit; what is nearer than the
    first is in the first ring, what is farther than the last in none. Each point is shared
    between the two angles next to it, so that a small turn changes little.
    """
    n_points, n_rings = len(points), len(radii)
    histograms = np.zeros((n_points, n_rings, n_angles))
    for i in range(n_points):
        for j in range(n_points):
            if i == j:
                continue
            right = points[j, 0] - points[i, 0]
            down = points[j, 1] - points[i, 1]
            r = math.hypot(right, down)
            if r > radii[n_rings - 1]:
                continue
            ring = np.searchsorted(radii, r)
            place = (math.atan2(down, right) / (2.0 * math.pi) % 1.0) * n_angles - 0.5
            lower = math.floor(place)
            share = place - lower
            histograms[i, ring, int(lower) % n_angles] += 1.0 - share
            histograms[i, ring, int(lower + 1) % n_angles] += share
    return histograms


@compiled
def compare_contexts(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the (N, M) chi-square distances of (N, k) and (M, k) histograms, each of sum 1."""
    costs = np.empty((len(first), len(second)))
    for i in range(len(first)):
        for j in range(len(second)):
            total = 0.0
            for k in range(first.shape[1]):
                both = first[i, k] + second[j, k]
                if both > TINY:
                    total += (first[i, k] - second[j, k]) ** 2 / both
            costs[i, j] = 0.5 * total
    return costs
