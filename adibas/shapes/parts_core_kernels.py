"""The core of a body under points: how it lies, how likely it is, where other points would be."""

import math

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.kernels import compiled
from adibas.shapes.labelling_kernels import LOG_2PI, factor_rows, solve_lower
from adibas.shapes.parts_types import Core, Odds

NEVER = -1e30
LAID_SD_M = 0.07
"""How far points of a core lie from the mean in x and z: 68 mm in the shipped model (standard
deviation)."""
LEAST_CORE = 2
"""Points that tell how a core is turned: both hips of a patient of whom nothing above is seen."""


@compiled
def count_named(own: IntArray) -> int:
    """Return how many labels have a point."""
    n = 0
    for j in own:
        n += 1 if j >= 0 else 0
    return n


@compiled
def label_odds_of(own: IntArray, labels: IntArray, odds: Odds) -> float:
    """Return the log odds of the points of a core by what is known of them beside the places."""
    total = 0.0
    for i in range(len(own)):
        total += odds.label_odds[own[i], labels[i]] if own[i] >= 0 else 0.0
    return total


@compiled
def turned_to_mean(
    points: FloatArray, own: IntArray, mean: FloatArray, odds: Odds
) -> tuple[FloatArray, float]:
    """Return (M, 3) points turned about y so that the named ones lie best on the mean, and by what.

    The origin is then in the middle of the named points. A declared heading counts beside them, as
    a distribution of von Mises: of a core of which little is named the points tell it badly.
    """
    n = count_named(own)
    middle, of_mean = np.zeros(3), np.zeros(3)
    for i in range(len(own)):
        if own[i] >= 0:
            middle += points[own[i]] / n
            of_mean += mean[i] / n
    across, along = 0.0, 0.0
    for i in range(len(own)):
        if own[i] >= 0:
            x, z = points[own[i], 0] - middle[0], points[own[i], 2] - middle[2]
            to_x, to_z = mean[i, 0] - of_mean[0], mean[i, 2] - of_mean[2]
            across += z * to_x - x * to_z
            along += x * to_x + z * to_z
    if not math.isnan(odds.heading_rad):
        declared = odds.kappa * LAID_SD_M**2
        across -= declared * math.sin(odds.heading_rad)
        along += declared * math.cos(odds.heading_rad)
    angle_rad = math.atan2(across, along)
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    moved = np.empty_like(points)
    for j in range(len(points)):
        x, z = points[j, 0] - middle[0], points[j, 2] - middle[2]
        moved[j, 0] = cos * x + sin * z
        moved[j, 1] = points[j, 1] - middle[1]
        moved[j, 2] = cos * z - sin * x
    return moved, angle_rad


@compiled
def heading_energy(heading_rad: float, odds: Odds) -> float:
    """Return minus the log probability of a heading, up to a constant."""
    if math.isnan(odds.heading_rad):
        return 0.0
    return odds.kappa * (1.0 - math.cos(heading_rad - odds.heading_rad))


@compiled
def known_rows(moved: FloatArray, own: IntArray) -> tuple[IntArray, FloatArray]:
    """Return which of the core's 3 C coordinates are known, and their values."""
    n = 3 * count_named(own)
    rows, values = np.empty(n, np.int64), np.empty(n)
    at = 0
    for i in range(len(own)):
        if own[i] >= 0:
            for d in range(3):
                rows[at] = 3 * i + d
                values[at] = moved[own[i], d]
                at += 1
    return rows, values


@compiled
def picked(matrix: FloatArray, rows: IntArray, columns: IntArray) -> FloatArray:
    """Return some rows and columns of a matrix."""
    part = np.empty((len(rows), len(columns)))
    for i in range(len(rows)):
        for j in range(len(columns)):
            part[i, j] = matrix[rows[i], columns[j]]
    return part


@compiled
def log_density(values: FloatArray, rows: IntArray, mean: FloatArray, lower: FloatArray) -> float:
    """Return the log density of some coordinates of a flat mean; `lower` is their own factor."""
    n = len(rows)
    white = np.empty(n)
    total, diagonal = 0.5 * n * LOG_2PI, 1.0
    for i in range(n):
        off = values[i] - mean[rows[i]]
        for j in range(i):
            off -= lower[i, j] * white[j]
        white[i] = off / lower[i, i]
        total += 0.5 * white[i] * white[i]
        diagonal *= lower[i, i]
    return -total - math.log(diagonal)


@compiled
def rate_core(
    rows: IntArray, values: FloatArray, core: Core, odds: Odds, by_kind: FloatArray
) -> int:
    """Fill the (kinds,) log densities of a core against anywhere; return the best component."""
    logs = rate_components(rows, values, core, odds)
    sum_by_kind(logs, core.kinds, by_kind)
    return int(np.argmax(logs))


@compiled
def rate_components(rows: IntArray, values: FloatArray, core: Core, odds: Odds) -> FloatArray:
    """Return the (K,) log densities of a core by each component, weighed, against anywhere."""
    n_components, n_core, _ = core.means.shape
    is_whole = len(rows) == 3 * n_core
    logs = np.empty(n_components)
    of_rows = np.empty((len(rows), len(rows)))
    for k in range(n_components):
        lower = core.factors[k]
        if not is_whole:
            lower = of_rows
            factor_rows(core.covariances[k], rows, lower)
        logs[k] = core.log_weights[k] + log_density(values, rows, core.means[k].ravel(), lower)
        logs[k] += len(rows) // 3 * odds.log_room
    return logs


@compiled
def sum_by_kind(logs: FloatArray, kinds: IntArray, by_kind: FloatArray) -> None:
    """Fill the logarithms of the sums of what each kind has."""
    by_kind[:] = NEVER
    for k in range(len(logs)):
        by_kind[kinds[k]] = max(by_kind[kinds[k]], logs[k])
    sums = np.zeros(len(by_kind))
    for k in range(len(logs)):
        if logs[k] > NEVER:
            sums[kinds[k]] += math.exp(logs[k] - by_kind[kinds[k]])
    for q in range(len(by_kind)):
        if sums[q] > 0.0:
            by_kind[q] += math.log(sums[q])


@compiled
def expected_core(
    rows: IntArray, values: FloatArray, own: IntArray, core: Core, component: int
) -> tuple[FloatArray, FloatArray]:
    """Return the (C, 3) core, missing points where the others let expect them, and how surely.

    How surely is a covariance (C, 3, 3), 0 of a point that is known. Source: the normal
    distribution of some coordinates where the others are known.
    """
    n_core, n = len(own), len(rows)
    whole, spreads = core.means[component].copy(), np.zeros((n_core, 3, 3))
    if n < 3 * n_core:
        covariance, mean = core.covariances[component], core.means[component].ravel()
        lower, told = np.empty((n, n)), np.empty((3, n))
        factor_rows(covariance, rows, lower)
        white = solve_lower(lower, values - mean[rows])
        for i in range(n_core):
            if own[i] >= 0:
                continue
            for d in range(3):
                told[d] = solve_lower(lower, covariance[3 * i + d][rows])
            for d in range(3):
                whole[i, d] += (told[d] * white).sum()
                for e in range(3):
                    spreads[i, d, e] = covariance[3 * i + d, 3 * i + e] - (told[d] * told[e]).sum()
    for at in range(n):
        whole[rows[at] // 3, rows[at] % 3] = values[at]
    return whole, spreads


@compiled
def mirrored_spread(spread: FloatArray, sign: float) -> FloatArray:
    """Return a covariance (3, 3) where x is mirrored if the sign is -1."""
    mirrored = spread.copy()
    mirrored[0] *= sign
    mirrored[:, 0] *= sign
    return mirrored


@compiled
def leave_one_out_core(
    rows: IntArray, values: FloatArray, own: IntArray, core: Core, best: int
) -> tuple[FloatArray, FloatArray]:
    """Return where each point of the core is by all others (C, 3), and how surely (C, 3, 3)."""
    places, spreads = expected_core(rows, values, own, core, best)
    precision = np.linalg.inv(picked(core.covariances[best], rows, rows))
    pull = precision @ (values - core.means[best].ravel()[rows])
    for at in range(0, len(rows), 3):
        i = rows[at] // 3
        spreads[i] = np.linalg.inv(np.ascontiguousarray(precision[at : at + 3, at : at + 3]))
        places[i] = values[at : at + 3] - spreads[i] @ pull[at : at + 3]
    return places, spreads


@compiled
def core_numbers(whole: FloatArray, core: Core) -> tuple[FloatArray, FloatArray, float]:
    """Return what limbs depend on (B,), the same of the mirror image, and the size in metres."""
    n_core = len(whole)
    middle = np.zeros(3)
    for i in range(n_core):
        middle += whole[i] / n_core
    size_m = math.sqrt(((whole - middle) ** 2).sum() / n_core)
    plain, mirrored = np.empty(3 * n_core), np.empty(3 * n_core)
    for i in range(n_core):
        for d in range(3):
            other = (whole[core.mirror[i], d] - middle[d]) / size_m
            plain[3 * i + d] = (whole[i, d] - middle[d]) / size_m - core.basis_mean[i, d]
            mirrored[3 * i + d] = (-other if d == 0 else other) - core.basis_mean[i, d]
    return core.basis @ plain, core.basis @ mirrored, size_m
