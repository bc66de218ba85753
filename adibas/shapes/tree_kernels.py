"""Naming points by their neighbours: how far and in which direction one lies from another.

A tree joins the labels. Each of its edges has a length that hardly varies, and directions that are
more or less likely. On a tree the best names under these alone are found exactly by passing
messages; points may be taken twice, which the assignment after it does not allow.

Source: Felzenszwalb & Huttenlocher, Pictorial structures for object recognition, IJCV 61 (2005);
min-marginals: Pearl, Probabilistic reasoning in intelligent systems (1988), chapter 4.
"""

import math

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled

LOG_ROOT_2PI = 0.5 * math.log(2.0 * math.pi)
SHORTEST = 1e-6
PLANE = 2
IMPOSSIBLE = 1e6


@compiled
def describe_pairs(
    points: FloatArray, n_bands: int, n_sectors: int
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return of each ordered pair the log distance and the direction's cell.

    Parameters
    ----------
    points : (M, D) array

    Returns
    -------
    log_lengths : (M, M) array
    bands : (M, M) array
        Of the height of the direction: the sphere in parts of equal area; 0 in the plane.
    sectors : (M, M) array
        Of the angle from x towards z, or in the plane towards y.
    """
    n_points, n_dimensions = points.shape
    log_lengths = np.zeros((n_points, n_points))
    bands = np.zeros((n_points, n_points), np.int64)
    sectors = np.zeros((n_points, n_points), np.int64)
    for j in range(n_points):
        for k in range(n_points):
            if j == k:
                continue
            x = points[k, 0] - points[j, 0]
            y = points[k, 1] - points[j, 1]
            z = points[k, 2] - points[j, 2] if n_dimensions > PLANE else y
            length = math.hypot(x, z)
            if n_dimensions > PLANE:
                length = math.hypot(length, y)
                height = 0.5 * (y / max(length, SHORTEST) + 1.0)
                bands[j, k] = min(int(height * n_bands), n_bands - 1)
            log_lengths[j, k] = math.log(max(length, SHORTEST))
            angle = math.atan2(z, x) / (2.0 * math.pi) % 1.0
            sectors[j, k] = min(int(angle * n_sectors), n_sectors - 1)
    return log_lengths, bands, sectors


@compiled
def direction_costs(  # noqa: PLR0913, PLR0917  (a kernel: its arrays are its interface)
    log_lengths: FloatArray,
    bands: IntArray,
    sectors: IntArray,
    directions: FloatArray,
    n_dimensions: int,
    log_room: float,
    shift: int,
) -> FloatArray:
    """Return (E, M, M) costs of a pair as an edge but for its length; 0 is as likely as anywhere.

    Parameters
    ----------
    log_lengths, bands, sectors : (M, M) arrays
        See `describe_pairs`.
    directions : (E, n_bands, n_sectors) array
        Minus the log density of directions, per unit of angle or of solid angle.
    log_room : float
        Logarithm of the volume in which points may be.
    shift : int
        By how many sectors the points are turned.
    """
    n_edges, _, n_sectors = directions.shape
    n_points = len(log_lengths)
    costs = np.empty((n_edges, n_points, n_points))
    for e in range(n_edges):
        for j in range(n_points):
            for k in range(n_points):
                sector = (sectors[j, k] + shift) % n_sectors
                costs[e, j, k] = (
                    n_dimensions * log_lengths[j, k]
                    - log_room
                    + LOG_ROOT_2PI
                    + directions[e, bands[j, k], sector]
                )
            costs[e, j, j] = IMPOSSIBLE
    return costs


@compiled
def add_lengths(
    costs: FloatArray, log_lengths: FloatArray, means: FloatArray, sds: FloatArray
) -> None:
    """Add to `direction_costs` those of the lengths, whose logarithms are normal."""
    for e in range(len(costs)):
        for j in range(len(log_lengths)):
            for k in range(len(log_lengths)):
                off = (log_lengths[j, k] - means[e]) / sds[e]
                costs[e, j, k] += math.log(sds[e]) + 0.5 * off * off


@compiled
def min_marginals(costs: FloatArray, edges: IntArray, n_labels: int, alone: float) -> FloatArray:
    """Return (N, M) costs of the best names in which label i has point j, less without i.

    Parameters
    ----------
    costs : (E, M, M) array
        First index of an edge's points: that of its parent.
    edges : (E, 2) array
        (parent, child), parents first.
    alone : float
        What a label without a point costs, beside its edges.
    """
    n_edges, n_points, _ = costs.shape
    up = np.zeros((n_labels, n_points + 1))
    up[:, n_points] = alone
    to_parent = np.empty((n_edges, n_points + 1))
    for e in range(n_edges - 1, -1, -1):
        parent, child = edges[e]
        _pass(costs[e], up[child], to_parent[e], False)
        up[parent] += to_parent[e]
    total = up.copy()
    own = np.empty(n_points + 1)
    message = np.empty(n_points + 1)
    for e in range(n_edges):
        parent, child = edges[e]
        own[:] = total[parent] - to_parent[e]
        _pass(costs[e], own, message, True)
        total[child] += message
    result = np.empty((n_labels, n_points))
    for i in range(n_labels):
        for j in range(n_points):
            result[i, j] = total[i, j] - total[i, n_points]
    return result


@compiled
def _pass(costs: FloatArray, belief: FloatArray, message: FloatArray, is_down: bool) -> None:
    """Fill a message with the least belief plus cost; no point: as likely as anywhere."""
    n_points = len(costs)
    lowest = belief.min()
    for j in range(n_points):
        least = belief[n_points]
        for k in range(n_points):
            cost = costs[k, j] if is_down else costs[j, k]
            least = min(least, belief[k] + cost)
        message[j] = least
    message[n_points] = lowest
