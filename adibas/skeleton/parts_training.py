"""Learning core and limbs from named shapes in space; see `adibas.shapes.parts_types`.

Each shape is learned together with its mirror image. The core's components get shifts, small turns
and a palpation's noise added to what was seen.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray, IntArray, check_shape
from adibas.data.joints import mirror_order
from adibas.shapes.gaussian_mixture import Mixture, fit_mixture
from adibas.shapes.parts_types import Anchors, Core, Limbs
from adibas.skeleton.bones_training import learn_bones, without_bones
from adibas.skeleton.model import left_of
from adibas.skeleton.parts import ANCHOR_NAMES, CORE_NAMES, LIMB_NAMES, PartsModel
from adibas.skeleton.training import heading_of, turned_about_y

N_ROUNDS = 5
MIRROR = np.array([-1.0, 1.0, 1.0])
NO_WEIGHT = -1e30
N_WAY = 6
"""Coordinates of a limb's two points."""


@dataclass(frozen=True, slots=True)
class PartsParams:
    """Settings of the training.

    Attributes
    ----------
    rows_per_component : int
        100: shapes for each component of a kind of posture.
    most_core, most_limb : int
        Components of a kind: 5 and 8; more take longer and know real people no better.
    n_anchors : int
        Components for `Anchors`: 4.
    n_numbers : int
        That limbs depend on: 6, of which the last moves the core's points by some millimetres.
    noise_m : float
        Of a palpation and the skin, of limbs and where the search begins: 20 mm.
    core_noise_m : float
        The same of the core, whose points lie on bones: 15 mm.
    shift_m, turn_rad : float
        By which a core may be beside where it was laid: 0.5 m (the middle is of the points that
        are seen) and 0.08 rad.
    anchor_turn_rad : float
        About the heading that is tried: 0.15.
    core_floor_m, number_floor, way_floor : float
        Least standard deviations of a component: 10 mm, 0.05, 0.02 sizes of the core.
    strange_bones : float
        How often the lengths of a limb's bones are not as learned: 0.02.
    bone_noise : float
        Standard deviation added to the logarithm of a length: 0.04, a centimetre of a forearm.
    weights : Mapping
        How often each kind is met; those not named share as in the training.
    seed : int
    """

    rows_per_component: int = 100
    most_core: int = 5
    most_limb: int = 8
    n_anchors: int = 4
    n_numbers: int = 6
    noise_m: float = 0.02
    core_noise_m: float = 0.015
    shift_m: float = 0.5
    turn_rad: float = 0.08
    anchor_turn_rad: float = 0.15
    core_floor_m: float = 0.01
    number_floor: float = 0.05
    way_floor: float = 0.02
    strange_bones: float = 0.02
    bone_noise: float = 0.04
    weights: Mapping[str, float] = field(default_factory=dict)
    seed: int = 0


def learn_parts(
    names: tuple[str, ...],
    shapes_m: FloatArray,
    kinds: Sequence[str],
    params: PartsParams | None = None,
) -> PartsModel:
    """Learn from (S, N, 3) shapes, metres, y down, each of a kind of posture.

    Raises
    ------
    ValueError
        There are too few shapes.
    """
    params = params or PartsParams()
    check_shape("shapes_m", shapes_m, (len(kinds), len(names), 3))
    if len(shapes_m) < params.rows_per_component:
        raise ValueError(f"parts need {params.rows_per_component} shapes, got {len(shapes_m)}")
    rng = np.random.default_rng(params.seed)
    both = np.concatenate([shapes_m, shapes_m[:, mirror_order(names)] * MIRROR])
    of_kind = np.array([*kinds, *kinds])
    called = tuple(sorted(set(kinds)))
    labels = np.array([names.index(name) for name in CORE_NAMES])
    mirror = np.array(mirror_order(CORE_NAMES))
    laid, mean = _laid(both, labels, mirror)
    cores = laid[:, labels]
    sizes_m = np.sqrt((cores**2).sum(axis=2).mean(axis=1))
    unit = cores / sizes_m[:, None, None]
    off = (unit - unit.mean(axis=0)).reshape(len(unit), -1)
    directions = np.linalg.svd(off, full_matrices=False)[2][: params.n_numbers]
    basis = directions / (off @ directions.T).std(axis=0)[:, None]
    mixtures = [
        _fitted(cores[of_kind == kind].reshape(-1, cores[0].size), params.most_core, params,
                np.full(cores[0].size, params.core_floor_m**2), rng)
        for kind in called
    ]  # fmt: skip
    odds = _kind_weights(called, of_kind, params)
    core = _core(labels, mirror, mean, basis, unit.mean(axis=0), mixtures, odds, params)
    rows = off @ basis.T
    sides = [
        _limb(names, limb, laid, sizes_m, rows, of_kind, called, params, rng)
        for limb in LIMB_NAMES[::2]
    ]
    anchors = _anchors(cores, params, rng)
    limbs = learn_bones(
        laid, of_kind, called, core, _limbs(names, sides, len(called)), params.strange_bones,
        params.bone_noise, rng,
    )  # fmt: skip
    return PartsModel(names, called, core, limbs, anchors)


def _laid(both: FloatArray, labels: IntArray, mirror: IntArray) -> tuple[FloatArray, FloatArray]:
    """Turn shapes about y so that their cores lie on their mean, which is its own mirror image."""
    laid = both - both[:, labels].mean(axis=1, keepdims=True)
    left = left_of(laid[:, labels], CORE_NAMES)
    laid = turned_about_y(laid, np.arctan2(left[:, 2], left[:, 0]))
    mean = np.zeros(0)
    for done in range(N_ROUNDS + 1):
        mean = laid[:, labels].mean(axis=0)
        mean = 0.5 * (mean + mean[mirror] * MIRROR)
        if done < N_ROUNDS:
            laid = turned_about_y(laid, heading_of(laid[:, labels], mean))
    return laid, mean


def _kind_weights(
    called: tuple[str, ...], of_kind: FloatArray, params: PartsParams
) -> dict[str, float]:
    odds = {kind: params.weights.get(kind, float((of_kind == kind).mean())) for kind in called}
    total = sum(odds.values())
    return {kind: share / total for kind, share in odds.items()}


def _fitted(
    rows: FloatArray, most: int, params: PartsParams, floor: FloatArray, rng: np.random.Generator
) -> Mixture:
    n = max(1, min(most, len(rows) // params.rows_per_component))
    return fit_mixture(rows, n, floor, rng)


def _turn_covariance(mean: FloatArray, turn_rad: float) -> FloatArray:
    """Return how a flat (C, 3) shape varies by turns about y."""
    change = np.stack([mean[:, 2], np.zeros(len(mean)), -mean[:, 0]], axis=1).ravel()
    return np.outer(change, change) * turn_rad**2


def _core(  # noqa: PLR0913, PLR0917
    labels: IntArray,
    mirror: IntArray,
    mean: FloatArray,
    basis: FloatArray,
    basis_mean: FloatArray,
    mixtures: Sequence[Mixture],
    odds: Mapping[str, float],
    params: PartsParams,
) -> Core:
    shifts = np.tile(np.eye(3), len(mean)) * params.shift_m
    loose = shifts.T @ shifts + params.core_noise_m**2 * np.eye(mean.size)
    means = np.concatenate([one.means.reshape(-1, *mean.shape) for one in mixtures])
    covariances = np.concatenate([one.covariances for one in mixtures]) + loose
    covariances += np.stack([_turn_covariance(one, params.turn_rad) for one in means])
    weights = np.concatenate([
        one.weights * share for one, share in zip(mixtures, odds.values(), strict=True)
    ])  # fmt: skip
    kinds = [number for number, one in enumerate(mixtures) for _ in one.weights]
    return Core(
        labels, mirror, mean, basis, basis_mean, np.log(weights), np.array(kinds), means,
        covariances, _factors(covariances),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Limb:
    """The components of one limb, before they stand in arrays with those of others."""

    kinds: list[int]
    log_weights: list[float]
    core_means: list[FloatArray]
    core_covariances: list[FloatArray]
    means: list[FloatArray]
    slopes: list[FloatArray]
    covariances: list[FloatArray]


def _limb(  # noqa: PLR0913, PLR0917
    names: tuple[str, ...],
    limb: tuple[str, ...],
    laid: FloatArray,
    sizes_m: FloatArray,
    numbers: FloatArray,
    of_kind: FloatArray,
    called: tuple[str, ...],
    params: PartsParams,
    rng: np.random.Generator,
) -> _Limb:
    root, *beyond = (laid[:, names.index(name)] for name in limb)
    ways = np.concatenate([(point - root) / sizes_m[:, None] for point in beyond], axis=1)
    rows = np.concatenate([numbers, ways], axis=1)
    n = numbers.shape[1]
    floor = np.repeat([params.number_floor, params.way_floor], [n, N_WAY]) ** 2
    noise = (params.noise_m / float(sizes_m.mean())) ** 2 * np.eye(N_WAY)
    result = _Limb([], [], [], [], [], [], [])
    for number, kind in enumerate(called):
        mixture = _fitted(rows[of_kind == kind], params.most_limb, params, floor, rng)
        parts = zip(mixture.weights, mixture.means, mixture.covariances, strict=True)
        for weight, mean, covariance in parts:
            slope = np.linalg.solve(covariance[:n, :n], covariance[:n, n:]).T
            result.kinds.append(number)
            result.log_weights.append(math.log(weight))
            result.core_means.append(mean[:n])
            result.core_covariances.append(covariance[:n, :n])
            result.means.append(mean[n:])
            result.slopes.append(slope)
            result.covariances.append(covariance[n:, n:] - slope @ covariance[:n, n:] + noise)
    return result


def _limbs(names: tuple[str, ...], sides: Sequence[_Limb], n_kinds: int) -> Limbs:
    """Put the limbs of one side, each followed by its mirror image, into arrays."""
    doubled = [side for side in sides for _ in range(2)]
    most = max(len(side.kinds) for side in sides)

    def stacked(rows: Sequence[Sequence[object]]) -> FloatArray:
        return np.stack([np.array([*row, *[row[-1]] * (most - len(row))]) for row in rows])

    weights = [[*one.log_weights, *[NO_WEIGHT] * (most - len(one.kinds))] for one in doubled]
    covariances = stacked([one.covariances for one in doubled])
    return Limbs(
        labels=np.array([[names.index(name) for name in limb[1:]] for limb in LIMB_NAMES]),
        roots=np.array([CORE_NAMES.index(limb[0]) for limb in LIMB_NAMES]),
        signs=np.array([1.0, -1.0] * len(sides)),
        kinds=stacked([one.kinds for one in doubled]).astype(np.int64),
        log_weights=np.array(weights),
        core_means=stacked([one.core_means for one in doubled]),
        core_factors=_factors(stacked([one.core_covariances for one in doubled])),
        means=stacked([one.means for one in doubled]),
        slopes=stacked([one.slopes for one in doubled]),
        factors=_factors(covariances),
        outer_factors=_factors(covariances[:, :, 3:, 3:]),
        **without_bones(len(doubled), n_kinds),
    )


def _factors(covariances: FloatArray) -> FloatArray:
    return np.ascontiguousarray(np.linalg.cholesky(covariances), float)


def _anchors(cores: FloatArray, params: PartsParams, rng: np.random.Generator) -> Anchors:
    floor = np.full(cores[0].size, params.core_floor_m**2)
    mixture = _fitted(cores.reshape(len(cores), -1), params.n_anchors, params, floor, rng)
    points = np.array([CORE_NAMES.index(name) for name in ANCHOR_NAMES])
    n_core = len(CORE_NAMES)
    means = mixture.means.reshape(-1, n_core, 3)
    whiteners = np.zeros((len(means), len(points), n_core, 3, 3))
    constants = np.zeros(whiteners.shape[:3])
    for a, mean in enumerate(means):
        covariance = mixture.covariances[a] + _turn_covariance(mean, params.anchor_turn_rad)
        covariance = covariance + params.noise_m**2 * np.eye(len(covariance))
        blocks = covariance.reshape(n_core, 3, n_core, 3).transpose(0, 2, 1, 3)
        for p, anchor in enumerate(points):
            for i in set(range(n_core)) - {anchor}:
                shared = blocks[i, anchor] + blocks[anchor, i]
                spread = blocks[i, i] + blocks[anchor, anchor] - shared
                lower = np.linalg.cholesky(spread)
                whiteners[a, p, i] = np.linalg.inv(lower)
                constants[a, p, i] = -np.log(np.diagonal(lower)).sum() - 1.5 * math.log(2 * math.pi)
    return Anchors(-np.log(mixture.weights), means, points, whiteners, constants)
