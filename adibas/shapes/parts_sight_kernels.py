"""Which labels without a point are out of the cameras' sight: that they are missing tells nothing.

For each way to name the points the missing labels are placed where the named ones let expect them;
the more surely that is beyond the border of the pictures, the less it costs that they are missing.
"""

import math

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled
from adibas.shapes.labelling_kernels import factor
from adibas.shapes.parts_core_kernels import (
    core_numbers,
    count_named,
    expected_core,
    known_rows,
    mirrored_spread,
    rate_core,
    turned_to_mean,
)
from adibas.shapes.parts_limb_kernels import place_limb, whiten, with_root
from adibas.shapes.parts_types import Core, Limbs, Odds

BORDER_SD_M = 0.03
"""How surely the border of what is seen is known: a marker is a disc, and stands off its joint."""


@compiled
def share_out_of_sight(
    place: FloatArray,
    spread: FloatArray,
    normals: FloatArray,
    offsets: FloatArray,
    border_sd: float,
) -> float:
    """Return the probability that a point (3,) known so surely (3, 3) lies beyond some plane.

    Where it is near two of them the nearer decides: that of one border hardly depends on the other.
    """
    greatest = 0.0
    for k in range(len(normals)):
        depth, variance = -offsets[k], border_sd**2
        for d in range(3):
            depth += normals[k, d] * place[d]
            for e in range(3):
                variance += normals[k, d] * spread[d, e] * normals[k, e]
        greatest = max(greatest, 0.5 * math.erfc(depth / math.sqrt(2.0 * variance)))
    return greatest


@compiled
def in_turned_axes(
    points: FloatArray, own: IntArray, angle_rad: float, normals: FloatArray, offsets: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return planes in the axes of `turned_to_mean`, which gave the angle."""
    n = count_named(own)
    middle = np.zeros(3)
    for j in own:
        if j >= 0:
            middle += points[j] / n
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    turned = normals.copy()
    turned[:, 0] = cos * normals[:, 0] + sin * normals[:, 2]
    turned[:, 2] = cos * normals[:, 2] - sin * normals[:, 0]
    edges: FloatArray = offsets - normals @ middle
    return turned, edges


@compiled
def cost_of_sight(shares: FloatArray, hidden_costs: FloatArray) -> float:
    """Return what the missing labels cost more, in nats, than if all of them were in sight.

    Parameters
    ----------
    shares : (M,) array
        Probability that each missing label is out of sight.
    hidden_costs : (N + 1, N + 1) array
        Minus the log probability that so many of N labels are out of sight (row), and so many of
        the others are hidden all the same (column).
    """
    n = len(shares)
    counts = np.zeros(n + 1)
    counts[0] = 1.0
    for i in range(n):
        for k in range(i + 1, 0, -1):
            counts[k] = counts[k] * (1.0 - shares[i]) + counts[k - 1] * shares[i]
        counts[0] *= 1.0 - shares[i]
    total = 0.0
    for k in range(n + 1):
        total += counts[k] * math.exp(hidden_costs[0, n] - hidden_costs[k, n - k])
    return -math.log(total)


@compiled
def limb_out_of_sight(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    ways: FloatArray,
    pair: IntArray,
    weights: FloatArray,
    places: FloatArray,
    covariances: FloatArray,
    normals: FloatArray,
    offsets: FloatArray,
    border_sd: float,
) -> FloatArray:
    """Return the probabilities (2,) that the points of a limb are out of sight; 0 if they are seen.

    Parameters
    ----------
    ways : (M, 3) array
        From the root to all points.
    pair : (2,) int array
        The limb's points, -1 for none.
    weights, places, covariances : (K,), (K, 6) and (K, 6, 6) arrays
        Components: log weights, and where both points are from the root.
    normals, offsets, border_sd : (P, 3) and (P,) arrays, and a number
        Of what is seen, in the unit and axes of `ways`.
    """
    shares = np.zeros(2)
    logs = weights.copy()
    for d in range(2):
        if pair[d] >= 0:
            part = slice(3 * d, 3 * d + 3)
            for k in range(len(logs)):
                lower = factor(np.ascontiguousarray(covariances[k, part, part]))
                logs[k] -= whiten(ways[pair[d]], places[k, part], lower, np.empty(3))
    odds = np.exp(logs - logs.max())
    odds /= odds.sum()
    for d in range(2):
        if pair[d] >= 0:
            continue
        mine, others = slice(3 * d, 3 * d + 3), slice(3 - 3 * d, 6 - 3 * d)
        for k in range(len(odds)):
            place = places[k, mine].copy()
            spread = covariances[k, mine, mine].copy()
            if pair[1 - d] >= 0:
                off = ways[pair[1 - d]] - places[k, others]
                shared = np.ascontiguousarray(covariances[k, mine, others])
                known = np.ascontiguousarray(covariances[k, others, others])
                place += shared @ np.linalg.solve(known, off)
                spread -= shared @ np.linalg.solve(known, shared.T)
            shares[d] += odds[k] * share_out_of_sight(place, spread, normals, offsets, border_sd)
    return shares


@compiled
def _core_out_of_sight(
    own: IntArray, whole: FloatArray, spreads: FloatArray, normals: FloatArray, offsets: FloatArray
) -> FloatArray:
    """Return the probabilities (C,) that the core's points are out of sight; 0 if seen."""
    shares = np.zeros(len(own))
    for i in range(len(own)):
        if own[i] < 0:
            shares[i] = share_out_of_sight(whole[i], spreads[i], normals, offsets, BORDER_SD_M)
    return shares


@compiled
def rate_sight(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray,
    partners: IntArray,
    core: Core,
    limbs: Limbs,
    odds: Odds,
    hidden_costs: FloatArray,
    normals: FloatArray,
    offsets: FloatArray,
) -> FloatArray:
    """Return what (W, N) ways to name (M, 3) points cost more, in nats, by what is out of sight.

    Parameters
    ----------
    partners : (W, N) int array
        Point of each label, -1 for none.
    hidden_costs : (N + 1, N + 1) array
        See `cost_of_sight`.
    normals, offsets : (P, 3) and (P,) arrays
        Planes: seen is where `normals` @ point >= `offsets`.
    """
    costs = np.empty(len(partners))
    for w in range(len(partners)):
        shares = _labels_out_of_sight(points, partners[w], core, limbs, odds, normals, offsets)
        costs[w] = cost_of_sight(shares[partners[w] < 0], hidden_costs)
    return costs


@compiled
def _labels_out_of_sight(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    points: FloatArray, partners: IntArray, core: Core, limbs: Limbs, odds: Odds,
    normals: FloatArray, offsets: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the probability (N,) of each label that it is out of sight; 0 if it has a point."""
    shares = np.zeros(len(partners))
    own = partners[core.labels]
    moved, angle_rad = turned_to_mean(points, own, core.mean, odds)
    inward, edges = in_turned_axes(points, own, angle_rad, normals, offsets)
    rows, values = known_rows(moved, own)
    by_kind = np.empty(odds.n_kinds)
    component = rate_core(rows, values, core, odds, by_kind)
    whole, spreads = expected_core(rows, values, own, core, component)
    shares[core.labels] = _core_out_of_sight(own, whole, spreads, inward, edges)
    plain, mirrored, size_m = core_numbers(whole, core)
    for limb in range(len(limbs.roots)):
        root, sign = limbs.roots[limb], limbs.signs[limb]
        pair = partners[limbs.labels[limb]]
        if pair.min() >= 0:
            continue
        ways = (moved - whole[root]) / size_m
        ways[:, 0] *= sign
        weights, places = place_limb(plain if sign > 0 else mirrored, limbs, limb, odds.n_kinds)
        weights += by_kind[limbs.kinds[limb]]
        spread = mirrored_spread(spreads[root], sign) / size_m**2
        covariances = np.empty(limbs.factors[limb].shape)
        for k in range(len(covariances)):
            with_root(limbs.factors[limb, k], spread, covariances[k])
        from_root = (edges - inward @ whole[root]) / size_m
        towards = inward.copy()
        towards[:, 0] *= sign
        shares[limbs.labels[limb]] = limb_out_of_sight(
            ways, pair, weights, places, covariances, towards, from_root, BORDER_SD_M / size_m
        )
    return shares
