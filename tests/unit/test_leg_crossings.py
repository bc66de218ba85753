"""Legs that go through each other make a way to name points less likely; others are left alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.stats import norm

from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.resources import resource_path
from adibas.shapes.parts_crossing_kernels import rate_crossings, segments_apart
from adibas.skeleton.model_files import read_model
from adibas.skeleton.namer import Namer
from adibas.skeleton.parts_odds import PartsOdds
from adibas.skeleton.starts import HEADINGS_RAD, turn_back

APART_M, SPREAD_M, STRANGE = 0.03, 0.02, 0.02
LEGS = np.arange(6).reshape(2, 3)
STRAIGHT = np.array([
    [0.1, 0.0, 0.0], [0.1, 0.4, 0.0], [0.06, 0.8, 0.0],
    [-0.1, 0.0, 0.0], [-0.1, 0.4, 0.0], [-0.06, 0.8, 0.0],
])  # fmt: skip

coordinates = st.lists(st.integers(-20, 20), min_size=12, max_size=12)


def rated(points, partners):
    rows = np.ascontiguousarray(np.atleast_2d(partners))
    return rate_crossings(points, rows, LEGS, APART_M, SPREAD_M, STRANGE)


@given(coordinates)
def test_segments_are_as_far_apart_as_the_nearest_two_of_their_points(numbers):
    a, b, c, d = np.array(numbers, float).reshape(4, 3) / 10.0

    def apart(at):
        return float(((a + at[0] * (b - a) - c - at[1] * (d - c)) ** 2).sum())

    starts = [(s, t) for s in (0.0, 0.5, 1.0) for t in (0.0, 0.5, 1.0)]
    bounds = [(0.0, 1.0)] * 2
    least = min(minimize(apart, start, bounds=bounds, tol=1e-12).fun for start in starts)
    assert segments_apart(a, b, c, d) == pytest.approx(np.sqrt(least), abs=1e-4)


def test_exchanged_feet_of_straight_legs_cross():
    straight, crossed = rated(STRAIGHT, [[0, 1, 2, 3, 4, 5], [0, 1, 5, 3, 4, 2]])
    assert straight == pytest.approx(-np.log(0.98 * norm.cdf((0.12 - APART_M) / SPREAD_M) + 0.02))
    assert crossed == pytest.approx(-np.log(0.98 * norm.cdf(-APART_M / SPREAD_M) + 0.02))


def test_the_further_a_leg_is_before_the_other_the_less_it_matters_that_they_cross():
    crossed = np.array([0, 1, 5, 3, 4, 2])
    costs = []
    for before_m in (0.0, 0.02, 0.05, 0.15):
        points = STRAIGHT.copy()
        points[[1, 5], 2] -= before_m
        costs.append(float(rated(points, crossed)[0]))
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] < 0.01


@pytest.mark.parametrize("hidden", [1, 4])
def test_nothing_is_said_of_legs_of_which_a_knee_is_hidden(hidden):
    partners = np.array([0, 1, 5, 3, 4, 2])
    partners[hidden] = -1
    assert rated(STRAIGHT, partners)[0] == 0.0


@pytest.mark.parametrize("view", HEADINGS_RAD)
def test_feet_close_together_are_surely_told_apart_below_lifted_arms(view):
    places = {
        "head": (0.0, -0.55, 0.0), "neck": (0.0, -0.36, 0.02), "torso": (0.0, 0.0, 0.0),
        "left_shoulder": (0.17, -0.27, 0.02), "right_shoulder": (-0.17, -0.27, 0.0),
        "left_elbow": (0.2, -0.2, -0.22), "right_elbow": (-0.3, -0.4, -0.1),
        "left_hand": (0.15, -0.3, -0.45), "right_hand": (-0.2, -0.55, -0.25),
        "left_hip": (0.08, 0.26, 0.0), "right_hip": (-0.08, 0.26, 0.0),
        "left_knee": (0.05, 0.7, 0.02), "right_knee": (-0.05, 0.69, 0.02),
        "left_foot": (0.03, 1.06, 0.06), "right_foot": (-0.03, 1.04, 0.06),
    }  # fmt: skip
    points = np.array([places[name] for name in JOINT_NAMES]) @ turn_back(HEADINGS_RAD[view])
    foot = JOINT_NAMES.index("left_foot")
    found = shipped_namer().label(points, view)
    model = read_model(resource_path("models", "skeleton.json"))
    may_cross = Namer(model, odds=PartsOdds(legs_through=1.0)).label(points, view)
    assert found.names == JOINT_NAMES
    assert 1.0 - found.confidences[foot] < 0.25 * (1.0 - may_cross.confidences[foot])
