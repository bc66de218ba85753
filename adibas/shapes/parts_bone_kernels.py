"""How long the bones of limbs are: what the places of a limb's points alone do not tell.

The components know where the points are, each blurred on its own, so that bones of any length are
likely. Here the density of the lengths that these let expect is replaced by the learned one: first
of each limb, then of a limb and its mirror image, whose bones are alike. Nothing counts twice.
Source: Bayes' rule; f(places) = f(places | lengths) f(lengths), and only the last is replaced.
"""

import math

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled
from adibas.shapes.labelling_kernels import LOG_2PI
from adibas.shapes.parts_types import Limbs

MOST_ALIKE = 3.0
"""Nats that bones like the other side's can gain at most."""


@compiled
def measure_bones(ways: FloatArray, pair: IntArray, has_root: bool) -> tuple[float, float]:
    """Return the logarithms of two bones' lengths, NaN where an end has no point.

    Parameters
    ----------
    ways : (M, 3) array
        Points from the limb's root.
    pair : (2,) int array
        Inner and outer point, -1 for none.
    """
    upper, lower = math.nan, math.nan
    if pair[0] >= 0 and has_root:
        upper = 0.5 * math.log(max((ways[pair[0]] ** 2).sum(), 1e-12))
    if pair[0] >= 0 and pair[1] >= 0:
        lower = 0.5 * math.log(max(((ways[pair[1]] - ways[pair[0]]) ** 2).sum(), 1e-12))
    return upper, lower


@compiled
def log_normal(x: float, y: float, covariance: FloatArray) -> float:
    """Return the log density of one or two numbers about 0; NaN: that one is not known."""
    if math.isnan(x) and math.isnan(y):
        return 0.0
    if math.isnan(y):
        return float(-0.5 * (x * x / covariance[0, 0] + math.log(covariance[0, 0]) + LOG_2PI))
    if math.isnan(x):
        return float(-0.5 * (y * y / covariance[1, 1] + math.log(covariance[1, 1]) + LOG_2PI))
    a, b, c = covariance[0, 0], covariance[0, 1], covariance[1, 1]
    determinant = a * c - b * b
    square = (c * x * x - 2.0 * b * x * y + a * y * y) / determinant
    return float(-0.5 * (square + math.log(determinant)) - LOG_2PI)


@compiled
def rate_bones(upper: float, lower: float, limbs: Limbs, limb: int, gains: FloatArray) -> None:
    """Fill for each kind of posture by how much a limb's lengths make it likelier, in nats."""
    strange = limbs.strange[limb]
    for q in range(len(gains)):
        gains[q] = 0.0
        if strange < 1.0 and not (math.isnan(upper) and math.isnan(lower)):
            mean, drawn = limbs.bone_means[limb, q], limbs.drawn_means[limb, q]
            covariance = limbs.bone_covariances[limb, q]
            of_drawn = limbs.drawn_covariances[limb, q]
            log_ratio = log_normal(upper - mean[0], lower - mean[1], covariance)
            log_ratio -= log_normal(upper - drawn[0], lower - drawn[1], of_drawn)
            gains[q] = math.log((1.0 - strange) * math.exp(min(log_ratio, 50.0)) + strange)


@compiled
def rate_sides(
    mine: FloatArray, others: FloatArray, limbs: Limbs, limb: int, gains: FloatArray
) -> None:
    """Fill for each kind by how much bones are likelier as they are like the other side's.

    Only lengths that are known of both sides (2,) are compared.
    """
    strange = limbs.strange[limb]
    is_known = False
    for d in range(2):
        is_known = is_known or not math.isnan(mine[d] + others[d])
    for q in range(len(gains)):
        gains[q] = 0.0
        if is_known and strange < 1.0:
            log_ratio = _log_alike(
                mine - limbs.bone_means[limb, q],
                others - limbs.bone_means[limb, q],
                limbs.bone_covariances[limb, q],
                limbs.side_covariances[limb, q],
            )
            log_odds = math.log((1.0 - strange) * math.exp(min(log_ratio, 50.0)) + strange)
            gains[q] = min(log_odds, MOST_ALIKE)


@compiled
def _log_alike(
    mine: FloatArray, others: FloatArray, covariance: FloatArray, of_sides: FloatArray
) -> float:
    """Return the log density of both sides' lengths together less those of each alone."""
    for d in range(2):
        if math.isnan(mine[d] + others[d]):
            mine[d], others[d] = math.nan, math.nan
    half = math.sqrt(0.5)
    sums, off = (mine + others) * half, (mine - others) * half
    together = log_normal(sums[0], sums[1], covariance + of_sides)
    together += log_normal(off[0], off[1], covariance - of_sides)
    alone = log_normal(mine[0], mine[1], covariance) + log_normal(others[0], others[1], covariance)
    return float(together - alone)


@compiled
def add_bones(
    ways: FloatArray,
    pairs: IntArray,
    by_kind: FloatArray,
    has_root: bool,
    limbs: Limbs,
    limb: int,
) -> None:
    """Add to the log odds of each choice what the lengths of its bones say."""
    gains = np.empty(by_kind.shape[1])
    for c in range(len(pairs)):
        upper, lower = measure_bones(ways, pairs[c], has_root)
        rate_bones(upper, lower, limbs, limb, gains)
        by_kind[c] += gains
