"""Shape contexts: which point of one shape is which of another, and how much the two differ.

Source: thesis, equation 6.5 and figure 6.6; Belongie, Malik & Puzicha, Shape matching and object
recognition using shape contexts, PAMI 24 (2002): histograms, chi-square cost, dummy points for
outliers, the thin-plate spline with less smoothing from round to round, and the shape distance.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from adibas.arrays import FloatArray, IntArray, check_shape, read_only
from adibas.shapes import context_kernels as kernels
from adibas.shapes.thin_plate import Warp, fit_warp

LEAST_MATCHED = 4
"""Below, an affine map explains any match."""


@dataclass(frozen=True, slots=True)
class ContextParams:
    """Settings of shape contexts.

    Attributes
    ----------
    n_rings, n_angles : int
        5 and 12, as in the paper.
    inner, outer : float
        Radii of the first and the last ring, in mean distances of a pair (the paper's 1/8 and 2).
    outlier_cost : float
        Of a point without a partner; the costs of pairs are 0 to 1 (the paper's 0.25 is for
        hundreds of points a shape; the histograms of fifteen differ more by chance).
    smoothings : tuple of float
        Of the spline, a round each.
    position_weight, appearance_weight, bending_weight : float
        Parts of the costs beside the histograms' 1. Position: distance after the last round's
        map, in mean distances of a pair; it counts from the second round on. The paper's 0.3 for
        the bending energy and 1.6 for the appearance belong to its own digits.
    """

    n_rings: int = 5
    n_angles: int = 12
    inner: float = 0.125
    outer: float = 2.0
    outlier_cost: float = 0.6
    smoothings: tuple[float, ...] = (math.inf, 1.0, 0.1)
    position_weight: float = 1.0
    appearance_weight: float = 1.0
    bending_weight: float = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class ContextMatch:
    """Two shapes laid upon one another.

    Attributes
    ----------
    partners : (N,) int array
        For each point of the first shape the index of its partner in the second; -1 for none.
    costs : (N,) array
        Of each pair, without the outlier's; NaN without a partner.
    warp : Warp or None
        From the first shape to the second; None where too few points are matched.
    distance : float
        The shape distance: mean cost of the pairs with the outliers' cost for the others, and
        the bending energy.
    rounds : tuple of (N,) int arrays
        The partners after each round.
    """

    partners: IntArray
    costs: FloatArray
    warp: Warp | None
    distance: float
    rounds: tuple[IntArray, ...]

    def __post_init__(self) -> None:
        read_only(self.partners)
        read_only(self.costs)


def shape_contexts(
    points: FloatArray, params: ContextParams | None = None, *, scale: float | None = None
) -> FloatArray:
    """Return the (N, n_rings * n_angles) histograms of points, each of sum 1 (equation 6.5).

    Parameters
    ----------
    points : (N, 2) array
        In any unit.
    scale : float or None
        Mean distance of a pair; None: these points' own.
    """
    params = params or ContextParams()
    check_shape("points", points, (None, 2))
    if scale is None:
        scale = mean_distance(points)
    radii = scale * np.geomspace(params.inner, params.outer, params.n_rings)
    counts = kernels.count_contexts(np.ascontiguousarray(points, float), radii, params.n_angles)
    flat = counts.reshape(len(points), params.n_rings * params.n_angles)
    return np.asarray(flat / np.maximum(flat.sum(axis=1, keepdims=True), 1.0))


def mean_distance(points: FloatArray) -> float:
    """Return the mean distance of all pairs of (N, 2) points; 0 of a single one."""
    n = len(points)
    if n < 2:  # noqa: PLR2004  (a pair)
        return 0.0
    distances = np.linalg.norm(points[:, None] - points[None], axis=-1)
    return float(distances.sum() / (n * (n - 1)))


def match_shapes(
    first: FloatArray,
    second: FloatArray,
    appearance: FloatArray | None = None,
    params: ContextParams | None = None,
) -> ContextMatch:
    """Find which point of one shape is which of another.

    Parameters
    ----------
    first : (N, 2) array
        A shape that is known.
    second : (M, 2) array
        Points that are to be named; some may be missing, some too many.
    appearance : (N, M) array or None
        How much each pair differs in colour or size, 0 to 1.

    Returns
    -------
    match : ContextMatch
        Without a single pair where either shape has fewer than two points.
    """
    params = params or ContextParams()
    check_shape("first", first, (None, 2))
    check_shape("second", second, (None, 2))
    extra = np.zeros((len(first), len(second)))
    if appearance is not None:
        check_shape("appearance", appearance, extra.shape)
        extra = params.appearance_weight * appearance
    scale = mean_distance(second)
    if min(len(first), len(second)) < 2 or scale <= 0 or mean_distance(first) <= 0:  # noqa: PLR2004
        nobody = np.full(len(first), -1)
        return ContextMatch(nobody, np.full(len(first), np.nan), None, math.inf, (nobody,))
    return _matched(first, second, extra, params)


def nearest_shape(
    shape: FloatArray, known: Sequence[FloatArray], params: ContextParams | None = None
) -> tuple[int, float]:
    """Return which of the known shapes is nearest by shape distance, and that distance.

    Parameters
    ----------
    shape : (M, 2) array
        Unnamed points.
    known : sequence of (N, 2) arrays
        At least one, such as one of each posture.
    """
    distances = [match_shapes(one, shape, params=params).distance for one in known]
    best = int(np.argmin(distances))
    return best, distances[best]


def _matched(
    first: FloatArray, second: FloatArray, extra: FloatArray, params: ContextParams
) -> ContextMatch:
    of_second = shape_contexts(second, params)
    scale = mean_distance(second)
    moved, warp = first, None
    rounds: list[IntArray] = []
    costs = extra
    for smoothing in params.smoothings:
        costs = kernels.compare_contexts(shape_contexts(moved, params), of_second) + extra
        if warp is not None:
            apart = np.linalg.norm(moved[:, None] - second[None], axis=-1) / scale
            costs = costs + params.position_weight * apart
        partners = _assigned(costs, params.outlier_cost)
        rounds.append(partners)
        is_paired = partners >= 0
        if np.count_nonzero(is_paired) < LEAST_MATCHED:
            break
        warp = fit_warp(second[partners[is_paired]], first[is_paired], smoothing) or warp
        if warp is not None:
            moved = warp.apply(first)
    return _result(rounds, costs, warp, params)


def _assigned(costs: FloatArray, outlier_cost: float) -> IntArray:
    """Return the partner of each row, -1 where having none is cheaper for all together."""
    n, m = costs.shape
    padded = np.full((n + m, n + m), outlier_cost)
    padded[:n, :m] = costs
    padded[n:, m:] = 0.0
    rows, columns = linear_sum_assignment(padded)
    partners = np.full(n, -1)
    partners[rows[rows < n]] = columns[rows < n]
    partners[partners >= m] = -1
    return partners


def _result(
    rounds: list[IntArray], costs: FloatArray, warp: Warp | None, params: ContextParams
) -> ContextMatch:
    partners = rounds[-1]
    n, m = costs.shape
    is_paired = partners >= 0
    of_pairs = np.full(n, np.nan)
    of_pairs[is_paired] = costs[is_paired, partners[is_paired]]
    n_pairs = int(np.count_nonzero(is_paired))
    alone = n + m - 2 * n_pairs
    total = np.nansum(of_pairs) + params.outlier_cost * alone
    bending = 0.0 if warp is None else params.bending_weight * warp.bending_energy
    return ContextMatch(
        partners.copy(), of_pairs, warp, float(total / (n_pairs + alone) + bending), tuple(rounds)
    )
