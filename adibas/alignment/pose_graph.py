"""Poses that agree best with all motions measured between them.

Source: thesis, section 5.2.1 (loop closure); Grisetti et al., A Tutorial on Graph-Based SLAM
(2010), section IV; Agarwal et al. (2013), equation 15, for the weights of doubtful motions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve
from scipy.spatial.transform import Rotation

from adibas.alignment.joint_fit import cross_matrices
from adibas.arrays import BoolArray, FloatArray, IntArray, check_shape, read_only
from adibas.geometry.rigid import RigidTransform

N_UNKNOWNS = 6
DOUBT_RATIO = 3.0
Solver = Literal["scipy", "gtsam"]
_Poses = tuple[FloatArray, FloatArray]
"""(N, 3, 3) rotations and (N, 3) places, of which the first stays."""


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """A measured motion.

    Attributes
    ----------
    target, source : int
        Between which poses.
    target_from_source : RigidTransform
    information : (6, 6) array
        Of a small turn (radians) and shift (metres) after the motion.
    is_doubtful : bool
        It may be wrong, as a loop may be; it counts less the worse it fits.
    """

    target: int
    source: int
    target_from_source: RigidTransform
    information: FloatArray
    is_doubtful: bool = False

    def __post_init__(self) -> None:
        check_shape("information", self.information, (N_UNKNOWNS, N_UNKNOWNS))
        read_only(self.information)


@dataclass(frozen=True, slots=True)
class GraphParams:
    """Settings.

    Attributes
    ----------
    rounds : int
        Gauss-Newton steps at most: 40.
    least_step : float
        They end where turns (radians) and shifts (metres) are smaller: 1e-7.
    doubt : float
        Squared error, in variances, from which a doubtful motion loses weight: 36; six
        unknowns make 6 on average, and motions are known worse than they say. The search begins
        without doubt and comes to it step by step, for drift makes right loops look wrong (Yang
        et al., Graduated Non-Convexity, 2020).
    solver : "scipy" or "gtsam"
        Who solves it: SciPy, or another's library, an optional extra (`gtsam_graph`).
    """

    rounds: int = 40
    least_step: float = 1e-7
    doubt: float = 36.0
    solver: Solver = "scipy"


@dataclass(frozen=True, slots=True, eq=False)
class Graph:
    """Poses and how much each motion counted.

    Attributes
    ----------
    world_from : tuple of RigidTransform
        The first is as given.
    weights : (E,) array
        1 for those that fit, towards 0 for doubtful ones that do not.
    """

    world_from: tuple[RigidTransform, ...]
    weights: FloatArray


def optimise(
    world_from: Sequence[RigidTransform], edges: Sequence[Edge], params: GraphParams | None = None
) -> Graph:
    """Move all poses but the first until the motions between them fit best.

    Parameters
    ----------
    world_from : sequence of RigidTransform
        Where the search begins.

    Raises
    ------
    ValueError
        A pose is reached by no motion.
    """
    params = params or GraphParams()
    reached = {0} | {edge.target for edge in edges} | {edge.source for edge in edges}
    if reached != set(range(len(world_from))):
        raise ValueError("every pose but the first needs a motion that reaches it")
    weights = np.ones(len(edges))
    if not edges:
        return Graph(tuple(world_from), weights)
    poses, motions = _stacked(world_from), _Motions.of(edges)
    misfits = _misfits(_errors(poses, motions)[0], motions)
    doubt = max([params.doubt, *misfits[motions.is_doubtful].tolist()])
    for _ in range(params.rounds):
        step, weights = _step(poses, motions, doubt)
        poses = _moved(poses, step.reshape(-1, N_UNKNOWNS))
        if doubt == params.doubt and np.abs(step).max() < params.least_step:
            break
        doubt = max(params.doubt, doubt / DOUBT_RATIO)
    found = (RigidTransform(turn, place_m) for turn, place_m in zip(*poses, strict=True))
    return Graph((world_from[0], *list(found)[1:]), weights)


@dataclass(frozen=True, slots=True, eq=False)
class _Motions:
    """All edges in arrays, so that a step takes as long for each in a long session as in a short.

    Attributes
    ----------
    targets, sources : (E,) arrays
    rotations, shifts_m : (E, 3, 3), (E, 3) arrays
        Of each target from its source.
    information : (E, 6, 6) array
    is_doubtful : (E,) bool array
    """

    targets: IntArray
    sources: IntArray
    rotations: FloatArray
    shifts_m: FloatArray
    information: FloatArray
    is_doubtful: BoolArray

    @classmethod
    def of(cls, edges: Sequence[Edge]) -> "_Motions":
        return cls(
            np.array([edge.target for edge in edges], np.int64),
            np.array([edge.source for edge in edges], np.int64),
            *_stacked([edge.target_from_source for edge in edges]),
            np.stack([edge.information for edge in edges]),
            np.array([edge.is_doubtful for edge in edges], np.bool_),
        )


def _stacked(poses: Sequence[RigidTransform]) -> _Poses:
    rotations = np.stack([pose.rotation for pose in poses])
    return rotations, np.stack([pose.translation_m for pose in poses])


def _moved(poses: _Poses, twists: FloatArray) -> _Poses:
    """Return the poses, all but the first moved by a twist (N - 1, 6) in their own axes."""
    rotations, places_m = (array.copy() for array in poses)
    places_m[1:] += (rotations[1:] @ twists[:, 3:, None])[..., 0]
    turned = rotations[1:] @ Rotation.from_rotvec(twists[:, :3]).as_matrix()
    # One to the last digit: see `joint_fit.moved`.
    rotations[1:] = turned @ (1.5 * np.eye(3) - 0.5 * turned.transpose(0, 2, 1) @ turned)
    return rotations, places_m


def _step(poses: _Poses, motions: _Motions, doubt: float) -> tuple[FloatArray, FloatArray]:
    """Return the twist of every pose but the first, and the weights of the motions."""
    n_poses = len(poses[1])
    n = N_UNKNOWNS * n_poses
    errors, by_target, by_source = _errors(poses, motions)
    misfits = _misfits(errors, motions)
    doubted = np.minimum(1.0, 2.0 * doubt / (doubt + misfits)) ** 2
    weights = np.where(motions.is_doubtful, doubted, 1.0)
    information = weights[:, None, None] * motions.information
    parts = ((motions.targets, by_target), (motions.sources, by_source))
    right = np.zeros((n_poses, N_UNKNOWNS))
    blocks = []
    for rows, one in parts:
        pulled = one.transpose(0, 2, 1) @ information
        np.add.at(right, rows, -(pulled @ errors[..., None])[..., 0])
        blocks += [(rows, columns, pulled @ other) for columns, other in parts]
    rows, columns, values = _triplets(blocks)
    whole = sparse.coo_array((values, (rows, columns)), shape=(n, n)).tocsc()
    step: FloatArray = spsolve(whole[N_UNKNOWNS:, N_UNKNOWNS:], right.ravel()[N_UNKNOWNS:])
    return step, weights


def _misfits(errors: FloatArray, motions: _Motions) -> FloatArray:
    """Return (E,) squared errors in variances."""
    return np.asarray(np.einsum("ei,eij,ej->e", errors, motions.information, errors), float)


def _errors(poses: _Poses, motions: _Motions) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (E, 6) errors and how they change with twists of both poses, in their own axes.

    An error is the twist after the measured motion that makes it the one between the poses.
    """
    rotations, places_m = poses
    back = rotations[motions.targets].transpose(0, 2, 1)
    turns = back @ rotations[motions.sources]
    ways_m = places_m[motions.sources] - places_m[motions.targets]
    shifts_m = (back @ ways_m[..., None])[..., 0]
    apart = turns @ motions.rotations.transpose(0, 2, 1)
    apart_m = shifts_m - (apart @ motions.shifts_m[..., None])[..., 0]
    errors = np.hstack([Rotation.from_matrix(apart).as_rotvec(), apart_m])
    by_source = np.zeros((len(errors), N_UNKNOWNS, N_UNKNOWNS))
    by_source[:, :3, :3] = by_source[:, 3:, 3:] = turns
    by_source[:, 3:, :3] = cross_matrices(shifts_m) @ turns
    turned = np.tile(np.eye(N_UNKNOWNS), (len(errors), 1, 1))
    turned[:, 3:, :3] = -cross_matrices(apart_m)
    return errors, -turned, turned @ by_source


def _triplets(
    blocks: Sequence[tuple[IntArray, IntArray, FloatArray]],
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return row, column and value of every number in (E, 6, 6) blocks."""
    inner_rows, inner_columns = np.indices((N_UNKNOWNS, N_UNKNOWNS))
    rows = np.concatenate(
        [(N_UNKNOWNS * row[:, None, None] + inner_rows).ravel() for row, _, _ in blocks]
    )
    columns = np.concatenate(
        [(N_UNKNOWNS * column[:, None, None] + inner_columns).ravel() for _, column, _ in blocks]
    )
    return rows, columns, np.concatenate([block.ravel() for _, _, block in blocks])
