"""Random poses are within what joints allow, and those of a kind look like it."""

import math

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.random_poses import KINDS, random_figure

N_POSES = 60


@pytest.fixture(scope="module")
def body():
    return load_body_model().shaped(BodyShape("female", 35, 1.66, 60))


@pytest.fixture(scope="module")
def joints_m(body):
    """Joints of many poses of each kind, floor at y = 0, y down."""
    rng = np.random.default_rng(3)
    return {
        kind: np.stack(
            [body.posed(random_figure(rng, kind).pose()).joints_m for _ in range(N_POSES)]
        )
        for kind in KINDS
    }


def at(joints_m, name):
    return joints_m[:, JOINT_NAMES.index(name)]


@pytest.mark.parametrize("kind", KINDS)
def test_one_seed_gives_one_figure(kind):
    first, second = (random_figure(np.random.default_rng(5), kind) for _ in range(2))
    assert first == second
    assert first != random_figure(np.random.default_rng(6), kind)


@pytest.mark.parametrize("kind", KINDS)
def test_no_elbow_and_no_knee_bends_the_wrong_way(kind):
    rng = np.random.default_rng(1)
    for _ in range(300):
        figure = random_figure(rng, kind)
        for arm in (figure.left_arm, figure.right_arm):
            assert 0 <= arm.elbow <= math.radians(150)
            assert 0 <= arm.elevation <= math.radians(180)
        for leg in (figure.left_leg, figure.right_leg):
            assert 0 <= leg.knee <= math.radians(135)


def test_who_stands_to_be_measured_is_upright_with_hanging_arms(joints_m):
    standing = joints_m["standing"]
    assert (at(standing, "head")[:, 1] < at(standing, "torso")[:, 1]).all()
    for side in ("left", "right"):
        assert (at(standing, f"{side}_hand")[:, 1] > at(standing, f"{side}_shoulder")[:, 1]).all()
        assert (at(standing, f"{side}_hip")[:, 1] < -0.6).all()
    assert (at(standing, "left_shoulder")[:, 0] > at(standing, "right_shoulder")[:, 0]).all()


def test_who_sits_has_the_thighs_level(joints_m):
    seated = joints_m["seated"]
    for side in ("left", "right"):
        thigh = at(seated, f"{side}_knee") - at(seated, f"{side}_hip")
        slope = np.abs(thigh[:, 1]) / np.linalg.norm(thigh, axis=1)
        assert np.median(slope) < 0.3
        assert (thigh[:, 2] < 0).all()  # forward


def test_who_moves_has_hands_over_the_head_and_below_the_hips(joints_m):
    moving = joints_m["moving"]
    hand, head, hip = (at(moving, name)[:, 1] for name in ("left_hand", "head", "left_hip"))
    assert 0.1 < np.mean(hand < head) < 0.7
    assert 0.05 < np.mean(hand > hip) < 0.7


def test_left_and_right_are_drawn_alike(joints_m):
    moving = joints_m["moving"]
    for name in ("elevation", "elbow"):
        rng = np.random.default_rng(2)
        figures = [random_figure(rng, "moving") for _ in range(600)]
        left = np.mean([getattr(figure.left_arm, name) for figure in figures])
        right = np.mean([getattr(figure.right_arm, name) for figure in figures])
        assert left == pytest.approx(right, abs=math.radians(7))
    assert np.isfinite(moving).all()
