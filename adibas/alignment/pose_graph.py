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

from adibas.alignment.joint_fit import cross_matrices, moved
from adibas.arrays import FloatArray, IntArray, check_shape, read_only
from adibas.geometry.rigid import IDENTITY, RigidTransform, rotation_vector

N_UNKNOWNS = 6
DOUBT_RATIO = 3.0
Solver = Literal["scipy", "gtsam"]


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
    poses = list(world_from)
    weights = np.ones(len(edges))
    doubt = max([params.doubt, *(_misfit(poses, edge) for edge in edges if edge.is_doubtful)])
    for _ in range(params.rounds if len(poses) > 1 else 0):
        step, weights = _step(poses, edges, doubt)
        poses[1:] = [
            pose @ moved(IDENTITY, twist)
            for pose, twist in zip(poses[1:], step.reshape(-1, N_UNKNOWNS), strict=True)
        ]
        if doubt == params.doubt and np.abs(step).max() < params.least_step:
            break
        doubt = max(params.doubt, doubt / DOUBT_RATIO)
    return Graph(tuple(poses), weights)


def _step(
    poses: Sequence[RigidTransform], edges: Sequence[Edge], doubt: float
) -> tuple[FloatArray, FloatArray]:
    """Return the twist of every pose but the first, and the weights of the motions."""
    n = N_UNKNOWNS * len(poses)
    blocks: list[tuple[int, int, FloatArray]] = []
    right = np.zeros(n)
    weights = np.ones(len(edges))
    for number, edge in enumerate(edges):
        error, by_target, by_source = _linear(poses, edge)
        misfit = float(error @ edge.information @ error)
        if edge.is_doubtful:
            weights[number] = min(1.0, 2.0 * doubt / (doubt + misfit)) ** 2
        information = weights[number] * edge.information
        parts = ((edge.target, by_target), (edge.source, by_source))
        for row, one in parts:
            right[N_UNKNOWNS * row :][:N_UNKNOWNS] -= one.T @ information @ error
            blocks += [(row, column, one.T @ information @ other) for column, other in parts]
    rows, columns, values = _triplets(blocks)
    whole = sparse.coo_array((values, (rows, columns)), shape=(n, n)).tocsc()
    matrix = whole[N_UNKNOWNS:, N_UNKNOWNS:]
    step: FloatArray = spsolve(matrix, right[N_UNKNOWNS:])
    return step, weights


def _misfit(poses: Sequence[RigidTransform], edge: Edge) -> float:
    """Return an edge's squared error in variances."""
    error, _, _ = _linear(poses, edge)
    return float(error @ edge.information @ error)


def _linear(
    poses: Sequence[RigidTransform], edge: Edge
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return an edge's error and how it changes with twists of its two poses, in their own axes.

    The error is the twist after the measured motion that makes it the one between the poses.
    """
    motion = poses[edge.target].inverse() @ poses[edge.source]
    apart = motion @ edge.target_from_source.inverse()
    error = np.concatenate([rotation_vector(apart.rotation), apart.translation_m])
    by_source = np.zeros((N_UNKNOWNS, N_UNKNOWNS))
    by_source[:3, :3] = by_source[3:, 3:] = motion.rotation
    by_source[3:, :3] = cross_matrices(motion.translation_m[None])[0] @ motion.rotation
    turned = np.eye(N_UNKNOWNS)
    turned[3:, :3] = -cross_matrices(apart.translation_m[None])[0]
    return error, -turned, turned @ by_source


def _triplets(
    blocks: Sequence[tuple[int, int, FloatArray]],
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return row, column and value of every number in (6, 6) blocks."""
    inner_rows, inner_columns = np.indices((N_UNKNOWNS, N_UNKNOWNS))
    rows = np.concatenate([(N_UNKNOWNS * row + inner_rows).ravel() for row, _, _ in blocks])
    columns = np.concatenate(
        [(N_UNKNOWNS * column + inner_columns).ravel() for _, column, _ in blocks]
    )
    return rows, columns, np.concatenate([block.ravel() for _, _, block in blocks])
