"""The pose graph by gtsam, an optional extra: what `pose_graph` does, by another's library.

Source: Yang et al., Graduated Non-Convexity (2020), as gtsam's GncLMOptimizer has it, with
truncated least squares: a loop counts wholly or not at all.
"""

import importlib
import importlib.util
from collections.abc import Sequence
from typing import Any

import numpy as np

from adibas.alignment.pose_graph import Edge, Graph, GraphParams
from adibas.errors import MapError
from adibas.geometry.rigid import RigidTransform

MODULE = "gtsam"
DOUBT_FACTOR = 3.5
"""Of `GraphParams.doubt`: where SciPy gives a loop less than 0.2, and it counts as wrong."""
FIRST_POSE_SD = 1e-6
"""Radians and metres: the first pose is as given."""


def check_gtsam() -> None:
    """See that the library is there.

    Raises
    ------
    MapError
        It is not.
    """
    if importlib.util.find_spec(MODULE) is None:
        raise MapError(
            "The library gtsam is not installed, and the pose graph was to be solved by it. "
            "Install it: pip install 'adibas[gtsam]', or leave --pose-graph out."
        )


def optimise_by_gtsam(
    world_from: Sequence[RigidTransform], edges: Sequence[Edge], params: GraphParams | None = None
) -> Graph:
    """Move all poses but the first until the motions between them fit best.

    Raises
    ------
    MapError
        The library is not installed.
    """
    params = params or GraphParams()
    if len(world_from) == 1:
        return Graph(tuple(world_from), np.ones(len(edges)))
    check_gtsam()
    gtsam: Any = importlib.import_module(MODULE)
    factors, begin = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for number, pose in enumerate(world_from):
        begin.insert(number, _pose(gtsam, pose))
    for edge in edges:
        measured = _pose(gtsam, edge.target_from_source)
        # Our errors stand before the measured motion, gtsam's behind it.
        to_ours = measured.AdjointMap()
        information = to_ours.T @ edge.information @ to_ours
        noise = gtsam.noiseModel.Gaussian.Information((information + information.T) / 2.0)
        factors.add(gtsam.BetweenFactorPose3(edge.target, edge.source, measured, noise))
    still = gtsam.noiseModel.Isotropic.Sigma(6, FIRST_POSE_SD)
    factors.add(gtsam.PriorFactorPose3(0, _pose(gtsam, world_from[0]), still))
    settings = gtsam.GncLMParams(gtsam.LevenbergMarquardtParams())
    settings.setLossType(gtsam.GncLossType.TLS)
    sure = [number for number, edge in enumerate(edges) if not edge.is_doubtful]
    settings.setKnownInliers([*sure, len(edges)])
    solver = gtsam.GncLMOptimizer(factors, begin, settings)
    solver.setInlierCostThresholds(DOUBT_FACTOR * params.doubt / 2.0)
    found = solver.optimize()
    weights = np.asarray(solver.getWeights(), float)[: len(edges)]
    poses = [found.atPose3(number) for number in range(1, len(world_from))]
    return Graph((world_from[0], *(_transform(pose) for pose in poses)), weights)


def _pose(gtsam: Any, pose: RigidTransform) -> Any:
    return gtsam.Pose3(gtsam.Rot3(pose.rotation), pose.translation_m)


def _transform(pose: Any) -> RigidTransform:
    return RigidTransform(pose.rotation().matrix(), np.asarray(pose.translation(), float))
