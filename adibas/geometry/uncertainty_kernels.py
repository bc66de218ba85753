"""The loops behind `adibas.geometry.uncertainty`, compiled.

All work in the principal axes of the noise: a vector d = mu + noise is observed, the noise's
variance along axis i is s[i], and |mu| is sought.
"""

import math

import numpy as np

from adibas.arrays import FloatArray
from adibas.kernels import compiled

# Axes with less than this share of the largest variance are treated as if they had it.
SMALLEST_SHARE = 1e-6
# Noise across a vector that lies exactly on an axis; stands for the limit, in standard deviations.
NUDGE = 1e-6
# Natural logarithms of the scales that stand for the origin and for infinity.
ORIGIN = 35.0
INFINITY = -20.0
MAX_STEPS = 60
TOLERANCE = 1e-9


@compiled
def critical_value(mu: FloatArray, s: FloatArray, table: FloatArray) -> float:
    """Return the limit of the squared distance from `mu`, by how the sphere |mu| is curved there.

    Scaled by the noise the sphere is an ellipsoid; `table` holds the limit for radii of curvature
    r, evenly spread in r / (1 + r).
    """
    gradient2 = 0.0
    trace = 0.0
    along = 0.0
    for i in range(mu.size):
        gradient2 += s[i] * mu[i] * mu[i]
        along += s[i] * s[i] * mu[i] * mu[i]
        trace += s[i]
    if gradient2 == 0.0:
        return float(table[0])
    curvature = (trace - along / gradient2) / ((mu.size - 1) * math.sqrt(gradient2))
    place = (table.size - 1) / (1.0 + curvature)
    low = min(int(place), table.size - 2)
    return float(table[low] + (place - low) * (table[low + 1] - table[low]))


@compiled
def excess(
    log_scale: float, d: FloatArray, s: FloatArray, table: FloatArray, mu: FloatArray
) -> float:
    """Fill `mu`, the nearest point of a sphere, and return how far it is beyond the limit.

    The sphere is named by its multiplier: nearest points are d / (1 + nu s), where nu is
    ``(scale - 1) / max(s)``; scale 1 is the sphere through d, infinity the origin.
    """
    nu = math.expm1(log_scale) / s[s.size - 1]
    distance2 = 0.0
    for i in range(d.size):
        mu[i] = d[i] / (1.0 + nu * s[i])
        distance2 += (d[i] - mu[i]) ** 2 / s[i]
    return math.sqrt(distance2) - math.sqrt(critical_value(mu, s, table))


@compiled
def limit_towards(
    farthest: float, d: FloatArray, s: FloatArray, table: FloatArray, mu: FloatArray
) -> float:
    """Return |mu| where the limit is reached between the logarithmic scales 0 and `farthest`.

    Source: Dowell & Jarratt, A modified regula falsi method, BIT 11 (1971): "Illinois".
    """
    inside, excess_inside = 0.0, -math.sqrt(table[0])
    steepness = math.sqrt((d * d * s).sum()) / s[s.size - 1]
    # Where the limit is if the sphere is flat; beyond the origin it is met later.
    outside = math.copysign(min(2.0 / steepness, 1.0), farthest)
    excess_outside = excess(outside, d, s, table, mu)
    while excess_outside < 0.0 and outside != farthest:
        inside, excess_inside = outside, excess_outside
        outside = math.copysign(min(2.0 * abs(outside), abs(farthest)), farthest)
        excess_outside = excess(outside, d, s, table, mu)
    if excess_outside < 0.0:
        return math.sqrt((mu * mu).sum())
    for _ in range(MAX_STEPS):
        middle = inside - excess_inside * (outside - inside) / (excess_outside - excess_inside)
        found = excess(middle, d, s, table, mu)
        if found * excess_outside > 0.0:
            excess_inside *= 0.5
        else:
            inside, excess_inside = outside, excess_outside
        outside, excess_outside = middle, found
        if abs(found) < TOLERANCE:
            break
    return math.sqrt((mu * mu).sum())


@compiled
def length_intervals(vectors: FloatArray, variances: FloatArray, table: FloatArray) -> FloatArray:
    """Return the (N, 2) intervals of |mu| for (N, n) vectors and variances (ascending)."""
    intervals = np.empty((vectors.shape[0], 2))
    mu = np.empty(vectors.shape[1])
    for k in range(vectors.shape[0]):
        d, s = np.abs(vectors[k]), variances[k].copy()
        largest = s[s.size - 1]
        if not largest > 0.0:
            # No noise, or a NaN.
            intervals[k, :] = math.sqrt((d * d).sum()) + largest
            continue
        for i in range(s.size):
            s[i] = max(s[i], SMALLEST_SHARE * largest)
        distance2_of_origin = (d * d / s).sum()
        d[d.size - 1] = max(d[d.size - 1], NUDGE * math.sqrt(largest))
        intervals[k, 0] = 0.0
        if distance2_of_origin > table[0]:
            intervals[k, 0] = limit_towards(ORIGIN, d, s, table, mu)
        intervals[k, 1] = limit_towards(INFINITY, d, s, table, mu)
    return intervals


@compiled
def length_biases(
    vectors: FloatArray, variances: FloatArray, nodes: FloatArray, weights: FloatArray
) -> FloatArray:
    """Return the (N) means of |mu + noise| - |mu| for (N, n) vectors mu and their variances.

    ``|x| = 1/sqrt(pi) * integral of (1 - exp(-v^2 x^2)) / v^2`` over v > 0, whose mean under the
    noise is known in closed form; `nodes` and `weights` integrate over 0 ... 1.
    """
    biases = np.zeros(vectors.shape[0])
    for k in range(vectors.shape[0]):
        mu2 = (vectors[k] ** 2).sum()
        size2 = mu2 + variances[k].sum()
        if size2 == 0.0:
            continue
        total = 0.0
        for j in range(nodes.size):
            y = nodes[j]
            v2 = (y / (1.0 - y)) ** 2 / size2
            exponent, log_spread = 0.0, 0.0
            for i in range(vectors.shape[1]):
                stretch = 1.0 + 2.0 * v2 * variances[k, i]
                exponent += v2 * vectors[k, i] ** 2 / stretch
                log_spread += math.log(stretch)
            # v^-2 dv = sqrt(size2) y^-2 dy
            noisy = math.exp(-exponent - 0.5 * log_spread)
            total += weights[j] * (math.exp(-v2 * mu2) - noisy) / (y * y)
        biases[k] = total * math.sqrt(size2 / math.pi)
    return biases
