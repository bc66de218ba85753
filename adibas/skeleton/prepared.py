"""A point model as the search takes it: arrays of all prototypes, with the pose among the modes."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.data.joints import mirror_order
from adibas.skeleton.model import PointModel, Prototype

PLANE, SPACE = 2, 3
SIZE_GUESS_SD = 0.1


@dataclass(frozen=True, slots=True)
class PoseSpread:
    """How far a pose may be from the one that a search starts at: standard deviations.

    Attributes
    ----------
    shift : float
        In root mean square radii: 0.4, since points without a name pull the middle aside.
    heading_rad : float
        About the vertical, half the step between starts: 0.3.
    tilt_rad : float
        Of an upright model: 0.12, as sensors are set up.
    any_rad : float
        Of one in any turn: 0.35.
    scale : float
        0.15.
    """

    shift: float = 0.4
    heading_rad: float = 0.3
    tilt_rad: float = 0.12
    any_rad: float = 0.35
    scale: float = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class PreparedModel:
    """Arrays of K prototypes with N names in D dimensions and Q factors.

    Attributes
    ----------
    means : (K, N, D) array
    loadings : (K, N, D, Q) array
        Shifts, turns, scale, modes; zeros where a prototype has fewer modes.
    noise : (K, N) array
    spreads, whiteners : (K, N, D, D) arrays
        Covariance of each point before anything is known, and the inverse of its factor.
    constants : (K, N) array
        Minus the log density of it at its mean.
    pose_sd : (D + 4,) array
    weight_costs, log_sizes, log_size_sds : (K,) arrays
    wide_sds : (E,) array
        Of the tree's log lengths where the size is only guessed.
    moves : (P, N) array
        Exchanges of labels to doubt a result by.
    """

    model: PointModel
    means: FloatArray
    loadings: FloatArray
    noise: FloatArray
    spreads: FloatArray
    whiteners: FloatArray
    constants: FloatArray
    pose_sd: FloatArray
    weight_costs: FloatArray
    log_sizes: FloatArray
    log_size_sds: FloatArray
    wide_sds: FloatArray
    moves: IntArray


def prepare(model: PointModel, spread: PoseSpread) -> PreparedModel:
    """Return the arrays of a model."""
    pose_sd = _pose_sd(model, spread)
    n_modes = max(len(prototype.modes) for prototype in model.prototypes)
    loadings = np.stack([_loadings(one, pose_sd, n_modes) for one in model.prototypes])
    noise = np.stack([one.noise for one in model.prototypes])
    spreads = np.einsum("knda,knea->knde", loadings, loadings)
    spreads += noise[:, :, None, None] * np.eye(model.n_dimensions)
    lower = np.linalg.cholesky(spreads)
    constants = np.log(np.diagonal(lower, axis1=2, axis2=3)).sum(axis=2)
    constants += 0.5 * model.n_dimensions * np.log(2 * np.pi)
    return PreparedModel(
        model=model,
        means=np.stack([one.mean for one in model.prototypes]),
        loadings=np.ascontiguousarray(loadings),
        noise=noise,
        spreads=np.ascontiguousarray(spreads),
        whiteners=np.ascontiguousarray(np.linalg.inv(lower)),
        constants=constants,
        pose_sd=pose_sd,
        weight_costs=-np.log([one.weight for one in model.prototypes]),
        log_sizes=np.array([one.log_size for one in model.prototypes]),
        log_size_sds=np.array([one.log_size_sd for one in model.prototypes]),
        wide_sds=np.hypot(model.tree.log_length_sds, SIZE_GUESS_SD),
        moves=_moves(model.names),
    )


def _pose_sd(model: PointModel, spread: PoseSpread) -> FloatArray:
    if not model.is_upright:
        turns = [spread.any_rad] * SPACE
    elif model.n_dimensions == SPACE:
        turns = [spread.tilt_rad, spread.heading_rad, spread.tilt_rad]
    else:
        turns = [0.0, 0.0, spread.tilt_rad]
    if model.n_dimensions == PLANE:
        turns[:2] = [0.0, 0.0]
    return np.array([*[spread.shift] * model.n_dimensions, *turns, spread.scale])


def _loadings(prototype: Prototype, pose_sd: FloatArray, n_modes: int) -> FloatArray:
    """Return (N, D, Q) changes of the shape by one standard deviation of each factor."""
    mean = prototype.mean
    n_points, n_dimensions = mean.shape
    columns = [np.tile(axis, (n_points, 1)) for axis in np.eye(n_dimensions)]
    in_space = np.zeros((n_points, SPACE))
    in_space[:, :n_dimensions] = mean
    columns += [np.cross(axis, in_space)[:, :n_dimensions] for axis in np.eye(SPACE)]
    columns = [column * sd for column, sd in zip([*columns, mean], pose_sd, strict=True)]
    columns += [*prototype.modes, *[np.zeros_like(mean)] * (n_modes - len(prototype.modes))]
    return np.stack(columns, axis=-1)


def _moves(names: tuple[str, ...]) -> IntArray:
    """Return permutations: each two labels, and one, two or all pairs of left and right."""
    n = len(names)
    mirror = mirror_order(names)
    pairs = [(i, k) for i, k in enumerate(mirror) if i < k]
    groups: list[tuple[tuple[int, int], ...]] = [((i, k),) for i, k in combinations(range(n), 2)]
    groups += [*combinations(pairs, 2), *combinations(pairs, 3)]
    groups += [tuple(pairs)] if len(pairs) > SPACE else []
    moves = np.tile(np.arange(n), (len(groups), 1))
    for row, group in zip(moves, groups, strict=True):
        for i, k in group:
            row[i], row[k] = k, i
    return moves
