"""Bodies with bent spines: the bend is where it was asked for, and leans with the body."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.simulation.looks import Look
from adibas.simulation.patient import SHAPES, Patient
from adibas.simulation.poses import LEFT, standing
from adibas.simulation.rotations import about
from benchmarks.body_scenes import bent_pose, midline


@pytest.fixture(scope="module")
def body():
    return Patient.dressed(SHAPES[1], Look()).body


def test_a_bent_spine_moves_the_back_and_leaves_the_legs(body):
    straight = body.posed(standing())
    bent = body.posed(replace(standing(), spine=np.stack([np.eye(3), about(LEFT, 0.2), np.eye(3)])))
    anchors = midline(body)
    triangles = body.model.triangles
    moved_m = np.linalg.norm(
        anchors.on(bent.vertices_m, triangles) - anchors.on(straight.vertices_m, triangles), axis=1
    )
    assert moved_m[0] > 0.005
    assert moved_m[-1] < 0.002
    knees = [11, 12]
    np.testing.assert_allclose(bent.joints_m[knees], straight.joints_m[knees], atol=1e-9)


def test_leaning_takes_the_spine_along():
    pose = bent_pose(np.random.default_rng(3))
    turn = about(LEFT, 0.1)
    np.testing.assert_allclose(pose.leaned(turn).spine, turn @ pose.spine)


def test_a_spine_has_three_parts():
    with pytest.raises(ValueError, match="spine"):
        replace(standing(), spine=np.stack([np.eye(3)] * 2))
