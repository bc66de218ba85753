"""From the covariance of points to intervals of distances and angles.

A distance is the length of a vector; the deviation of an angle from straight (or from zero) is
the length of a vector of two small angles, in the plane of the three points and out of it. Far
from 0 such a length varies like its first-order part. Near 0 it does not: it cannot be negative,
noise pushes it up, and +-1.96 standard deviations miss the truth. Hence one method for both:

* The interval holds every length that no test rejects: those whose sphere of possible true
  vectors comes as near to the observed one, in standard deviations, as the limit of 95 % allows.
  The limit depends on how strongly the sphere is curved there. It is taken from a sphere of the
  same curvature (its mean curvature, for an ellipsoid), where it is exact: the chi-square's limit
  with as many degrees of freedom as dimensions at length 0, with one far from it, where this is
  the first-order interval. It never leaves [0, pi].
* The bias is the mean of the length under the noise, in closed form, minus the length that is
  left when the noise's own share of the square is taken away; for angles far from their ends
  also the rest of the second order.

Covariances are joint ones, so that points may share an error; `independent` makes them of points
that do not.

Source: Kendall & Stuart, The Advanced Theory of Statistics, vol. 2, chapter 20 (intervals from
tests), and Chuang & Lai, Hybrid resampling methods for confidence intervals, Statistica Sinica 10
(2000), for limits taken at the most likely point of each hypothesis; noncentral chi-square:
`scipy.special.chndtr`. Directions: Kanatani, Statistical Optimization for Geometric Computation,
section 3.4.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import chndtr

from adibas.arrays import FloatArray, check_shape
from adibas.geometry import uncertainty_kernels as kernels
from adibas.geometry.angles import ArmDerivatives, angle, arm_derivatives

CONFIDENCE = 0.95
N_RADII = 129
N_BISECTIONS = 60
N_NODES = 48


@dataclass(frozen=True, slots=True, eq=False)
class UncertainValues:
    """Measured values, each with what the noise of the points makes of it.

    Attributes
    ----------
    values : (N,) array
        As measured; metres or radians. NaN where points coincide or are missing.
    intervals : (N, 2) array
        Holds the truth in 95 % of cases.
    biases : (N,) array
        Expected value minus truth, at the truth that is most plausible.
    """

    values: FloatArray
    intervals: FloatArray
    biases: FloatArray


def independent(*covariances: FloatArray) -> FloatArray:
    """Join (..., 3, 3) covariances of n points without a common error into (..., 3n, 3n)."""
    n = len(covariances)
    joint = np.zeros((*np.shape(covariances[0])[:-2], 3 * n, 3 * n))
    for i, covariance in enumerate(covariances):
        joint[..., 3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = covariance
    return joint


def uncertain_distances(points_m: FloatArray, covariances_m2: FloatArray) -> UncertainValues:
    """Measure distances.

    Parameters
    ----------
    points_m : (N, 2, 3) array
        Pairs of points, metres.
    covariances_m2 : (N, 6, 6) array
        Joint covariance of each pair; see `independent`.

    Returns
    -------
    distances : UncertainValues
        Metres.
    """
    points_m, covariances_m2 = np.asarray(points_m, float), np.asarray(covariances_m2, float)
    check_shape("points_m", points_m, (None, 2, 3))
    check_shape("covariances_m2", covariances_m2, (len(points_m), 6, 6))
    difference = np.concatenate([np.eye(3), -np.eye(3)], axis=1)
    vectors_m = points_m[:, 0] - points_m[:, 1]
    spread_m2 = difference @ covariances_m2 @ difference.T
    intervals, biases = _lengths(vectors_m, spread_m2)
    return UncertainValues(np.linalg.norm(vectors_m, axis=-1), intervals, biases)


def uncertain_angles(points_m: FloatArray, covariances_m2: FloatArray) -> UncertainValues:
    """Measure unsigned angles at a vertex.

    Parameters
    ----------
    points_m : (N, 3, 3) array
        Triplets in the order a, vertex, c; metres.
    covariances_m2 : (N, 9, 9) array
        Joint covariance of each triplet; see `independent`.

    Returns
    -------
    angles : UncertainValues
        Radians; intervals inside [0, pi]. NaN where a point coincides with the vertex.
    """
    points_m, covariances_m2 = np.asarray(points_m, float), np.asarray(covariances_m2, float)
    check_shape("points_m", points_m, (None, 3, 3))
    check_shape("covariances_m2", covariances_m2, (len(points_m), 9, 9))
    corners = points_m[:, 0], points_m[:, 1], points_m[:, 2]
    values_rad = angle(*corners)
    arms = arm_derivatives(*corners)
    is_obtuse = values_rad > np.pi / 2
    # +1 where the angle grows with its deviation from its nearer end, 0 or 180 degrees.
    side = np.where(is_obtuse, -1.0, 1.0)
    deviations_rad = np.where(is_obtuse, np.pi - values_rad, values_rad)
    # Both arms lifted alike keep an angle of 0, but fold one of 180 degrees.
    fold = arms.lift_c - side[:, None, None] * arms.lift_a
    # The second order of a length, 1 / (2 length), is 1 / (2 sin) for an angle.
    is_bent = deviations_rad > 0
    ratio = np.where(is_bent, deviations_rad, 1.0) / np.where(is_bent, np.sin(deviations_rad), 1.0)
    fold = fold * np.sqrt(ratio)[:, None, None]
    widening = side[:, None, None] * (arms.turn_a + arms.turn_c)
    moves = np.stack([widening, fold], axis=1).reshape(-1, 2, 9)
    vectors_rad = np.stack([deviations_rad, np.zeros_like(deviations_rad)], axis=-1)
    intervals, biases = _lengths(vectors_rad, moves @ covariances_m2 @ moves.swapaxes(1, 2))
    intervals = np.minimum(intervals, np.pi)
    biases -= np.tan(deviations_rad / 2) / 2 * _lift_variances(arms, covariances_m2)
    return UncertainValues(
        values_rad,
        np.where(is_obtuse[:, None], np.pi - intervals[:, ::-1], intervals),
        side * biases + _stretch_biases(arms, covariances_m2),
    )


def _lift_variances(arms: ArmDerivatives, covariances_m2: FloatArray) -> FloatArray:
    """Return the (N) sums of both arms' variances across the plane of the angle."""
    return _products(arms.lift_a, arms.lift_a, covariances_m2) + _products(
        arms.lift_c, arms.lift_c, covariances_m2
    )


def _stretch_biases(arms: ArmDerivatives, covariances_m2: FloatArray) -> FloatArray:
    """Return the (N) biases in radians from turns that go along with a longer arm."""
    return -_products(arms.turn_a, arms.stretch_a, covariances_m2) - _products(
        arms.turn_c, arms.stretch_c, covariances_m2
    )


def _products(a: FloatArray, b: FloatArray, covariances: FloatArray) -> FloatArray:
    """Return the (N) covariances of two (N, 3, 3) derivatives."""
    a, b = a.reshape(-1, 9), b.reshape(-1, 9)
    return np.asarray(((covariances @ b[:, :, None])[:, :, 0] * a).sum(axis=-1))


def _lengths(vectors: FloatArray, covariances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the (N, 2) intervals and (N) biases of the lengths of (N, n) vectors."""
    is_known = np.isfinite(vectors).all(axis=-1) & np.isfinite(covariances).all(axis=(1, 2))
    intervals, biases = np.full((len(vectors), 2), np.nan), np.full(len(vectors), np.nan)
    variances, axes = np.linalg.eigh(covariances[is_known])
    variances = np.maximum(variances, 0.0)
    turned = np.ascontiguousarray(np.einsum("nji,nj->ni", axes, vectors[is_known]))
    table, nodes, weights = _tables(vectors.shape[-1])
    intervals[is_known] = kernels.length_intervals(turned, variances, table)
    squared = (turned**2).sum(axis=-1)
    left = np.maximum(1.0 - variances.sum(axis=-1) / np.where(squared > 0, squared, np.inf), 0.0)
    plausible = turned * np.sqrt(left)[:, None]
    biases[is_known] = kernels.length_biases(plausible, variances, nodes, weights)
    return intervals, biases


@lru_cache
def _tables(n_dimensions: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the limits by radius of curvature, and the nodes and weights of an integral."""
    shares = np.linspace(0.0, 1.0, N_RADII)[:-1]
    radii = shares / (1.0 - shares)
    low, high = np.zeros_like(radii), np.full_like(radii, 10.0)
    for _ in range(N_BISECTIONS):
        middle = 0.5 * (low + high)
        inner = np.maximum(radii - middle, 0.0)
        held = chndtr((radii + middle) ** 2, n_dimensions, radii**2) - chndtr(
            inner**2, n_dimensions, radii**2
        )
        low, high = (
            np.where(held < CONFIDENCE, middle, low),
            np.where(held < CONFIDENCE, high, middle),
        )
    limits = np.append(low**2, low[-1] ** 2)
    nodes, weights = np.polynomial.legendre.leggauss(N_NODES)
    return limits, 0.5 * (nodes + 1.0), 0.5 * weights
