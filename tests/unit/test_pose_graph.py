"""Poses in a ring: exact motions are kept, drift is spread, a wrong loop loses its weight."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adibas.alignment.gtsam_graph import optimise_by_gtsam
from adibas.alignment.joint_fit import moved
from adibas.alignment.pose_graph import Edge, optimise
from adibas.geometry.rigid import IDENTITY, RigidTransform, rotation_vector

N = 12


def ring():
    turns = [Rotation.from_euler("y", 360.0 * k / N, degrees=True).as_matrix() for k in range(N)]
    poses = [RigidTransform(turn, turn @ [0.0, 0.1 * k, -2.0]) for k, turn in enumerate(turns)]
    first = poses[0].inverse()
    return [first @ pose for pose in poses]


def edges_of(poses, rng, sd=0.0):
    pairs = [(k, k + 1) for k in range(N - 1)]
    return [
        Edge(
            i,
            j,
            moved(poses[i].inverse() @ poses[j], sd * rng.standard_normal(6)),
            np.eye(6) / max(sd, 1e-3) ** 2,
        )
        for i, j in pairs
    ]


def chained(edges):
    poses = [IDENTITY]
    for edge in edges:
        poses.append(poses[-1] @ edge.target_from_source)
    return poses


def error_of(poses, truth):
    return max(
        np.linalg.norm(rotation_vector((one.inverse() @ other).rotation))
        + np.linalg.norm((one.inverse() @ other).translation_m)
        for one, other in zip(poses, truth, strict=True)
    )


def test_exact_motions_bring_disturbed_poses_home():
    truth, rng = ring(), np.random.default_rng(0)
    loop = Edge(N - 1, 0, truth[N - 1].inverse() @ truth[0], np.eye(6))
    start = [truth[0], *(moved(pose, 0.1 * rng.standard_normal(6)) for pose in truth[1:])]
    graph = optimise(start, [*edges_of(truth, rng), loop])
    assert error_of(graph.world_from, truth) < 1e-6


@pytest.mark.parametrize("has_wrong_loop", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_gtsam_finds_the_same_poses(seed, has_wrong_loop):
    pytest.importorskip("gtsam")
    truth, rng = ring(), np.random.default_rng(seed)
    edges = edges_of(truth, rng, sd=0.01)
    uneven = rng.normal(size=(6, 6))
    information = 1e4 * (np.eye(6) + uneven @ uneven.T / 30.0)
    exact = truth[N - 1].inverse() @ truth[0]
    edges.append(Edge(N - 1, 0, exact, information, is_doubtful=True))
    if has_wrong_loop:
        far = moved(truth[8].inverse() @ truth[2], np.full(6, 0.5))
        edges.append(Edge(8, 2, far, information, is_doubtful=True))
    ours = optimise(chained(edges[: N - 1]), edges)
    theirs = optimise_by_gtsam(chained(edges[: N - 1]), edges)
    assert error_of(ours.world_from, theirs.world_from) < 5e-4
    np.testing.assert_allclose(theirs.weights, np.round(ours.weights))


def test_a_closed_loop_takes_most_of_the_drift_away():
    truth, rng = ring(), np.random.default_rng(1)
    edges = edges_of(truth, rng, sd=0.01)
    drifted = chained(edges)
    loop = Edge(0, N - 1, truth[0].inverse() @ truth[N - 1], 1e8 * np.eye(6), is_doubtful=True)
    graph = optimise(drifted, [*edges, loop])
    assert error_of(graph.world_from[-1:], truth[-1:]) < 1e-3
    assert error_of(graph.world_from, truth) < 0.6 * error_of(drifted, truth)


def test_a_wrong_loop_hardly_counts_beside_right_ones():
    truth, rng = ring(), np.random.default_rng(2)
    edges = edges_of(truth, rng, sd=0.002)
    good = [
        Edge(i, j, truth[i].inverse() @ truth[j], np.eye(6) / 0.002**2, is_doubtful=True)
        for i, j in ((0, 6), (2, 9), (0, 11))
    ]
    wrong = moved(truth[1].inverse() @ truth[10], np.full(6, 0.5))
    bad = Edge(1, 10, wrong, np.eye(6) / 0.002**2, is_doubtful=True)
    graph = optimise(chained(edges), [*edges, *good, bad])
    assert graph.weights[-1] < 0.01
    assert (graph.weights[:-1] > 0.5).all()
    assert error_of(graph.world_from, truth) < 0.02


def test_a_pose_that_nothing_reaches_is_refused():
    with pytest.raises(ValueError, match="reaches"):
        optimise([IDENTITY, IDENTITY], [])
