"""Which side is seen of somebody who turns while he is filmed."""

import math
from itertools import pairwise

import numpy as np
import pytest

from adibas.skeleton.followed_view import FollowedView
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.starts import HEADINGS_RAD, turn_back

RATE_HZ = 15.0
VIEWS = tuple(HEADINGS_RAD)


def labelling(heading_deg, n_named=10, n_points=10):
    names = ("head",) * n_named + (None,) * (n_points - n_named)
    return Labelling(
        names, names, np.ones(n_points), math.radians(heading_deg), np.ones((n_points, 2))
    )


def nearest(heading_deg):
    offs = [
        abs(math.remainder(math.radians(heading_deg) - HEADINGS_RAD[v], math.tau)) for v in VIEWS
    ]
    return VIEWS[int(np.argmin(offs))]


def between(heading_deg, least_deg=10.0):
    """Say whether two views are about equally near."""
    return abs(heading_deg % 90.0 - 45.0) < least_deg


def points_at(heading_deg, seed=1, n=8):
    rng = np.random.default_rng(seed)
    points_m = rng.normal(scale=(0.25, 0.5, 0.15), size=(n, 3))
    return points_m @ turn_back(math.radians(heading_deg)) + [0.3, 0.1, 2.5]


@pytest.mark.parametrize("view", VIEWS)
def test_at_first_the_declared_view_is_seen(view):
    seen = FollowedView(view)
    seen.go_to(3.0)
    assert seen.view == view
    assert seen.is_square


def test_a_view_that_is_not_declared_is_never_known():
    seen = FollowedView("")
    for number in range(20):
        seen.go_to(number / RATE_HZ)
        seen.learn(labelling(0.0))
        seen.turn(points_at(0.0), points_at(0.0))
    assert seen.view == ""
    assert not seen.is_square


@pytest.mark.parametrize("deg_per_s", [60.0, -90.0, 150.0])
def test_names_tell_how_far_somebody_has_turned(deg_per_s):
    seen = FollowedView("anterior")
    for number in range(90):
        heading_deg = deg_per_s * number / RATE_HZ
        seen.go_to(number / RATE_HZ)
        if number > 10 and not between(heading_deg):
            assert seen.view == nearest(heading_deg)
        seen.learn(labelling(heading_deg))


def test_points_without_names_tell_it_as_well():
    """All turn alike, to 5 mm; nobody says what they are called."""
    rng = np.random.default_rng(2)
    seen, before_m, rates = FollowedView("posterior"), None, []
    for number in range(60):
        heading_deg = 180.0 + 100.0 * number / RATE_HZ
        points_m = points_at(heading_deg) + rng.normal(scale=0.005, size=(8, 3))
        seen.go_to(number / RATE_HZ)
        if not between(heading_deg):
            assert seen.view == nearest(heading_deg)
        if before_m is not None:
            seen.turn(before_m, points_m)
            rates.append(math.degrees(seen._state[1]))
        before_m = points_m
    assert np.mean(rates[5:]) == pytest.approx(100.0, abs=3.0)


@pytest.mark.parametrize("n_points", [3, 8])
def test_somebody_who_stands_still_without_names_is_still_seen_from_there(n_points):
    rng = np.random.default_rng(3)
    seen = FollowedView("left_lateral")
    place_m = points_at(90.0, n=n_points)
    frames = [place_m + rng.normal(scale=0.005, size=place_m.shape) for _ in range(150)]
    for number, (before_m, points_m) in enumerate(pairwise(frames)):
        seen.go_to(number / RATE_HZ)
        seen.turn(before_m, points_m)
    assert seen.view == "left_lateral"
    assert seen.is_square


def test_arms_that_swing_do_not_turn_the_body():
    rng = np.random.default_rng(4)
    body_m = points_at(0.0, n=12)
    seen, before_m = FollowedView("anterior"), None
    for number in range(60):
        swing_m = 0.25 * math.sin(number / 3.0)
        points_m = body_m + rng.normal(scale=0.005, size=body_m.shape)
        points_m[:2] += [[0.0, 0.0, swing_m], [0.0, 0.0, -swing_m]]
        seen.go_to(number / RATE_HZ)
        if before_m is not None:
            seen.turn(before_m, points_m)
        before_m = points_m
        assert seen.view == "anterior"


def test_who_is_seen_by_one_point_and_did_not_turn_stays():
    """Of a patient from the side few markers are seen; the declared view had been lost in 0.4 s."""
    seen = FollowedView("left_lateral")
    for number in range(90):
        seen.go_to(number / RATE_HZ)
        seen.turn(np.zeros((1, 3)), np.zeros((1, 3)))
    assert seen.view == "left_lateral"
    assert seen.is_square


def test_who_turned_when_too_few_points_were_left_is_lost():
    seen, before_m = FollowedView("anterior"), None
    for number in range(30):
        points_m = points_at(100.0 * number / RATE_HZ)
        seen.go_to(number / RATE_HZ)
        if before_m is not None and number < 12:
            seen.turn(before_m, points_m)
        before_m = points_m
    assert seen.view == ""


def test_who_is_lost_for_a_time_is_seen_from_nowhere():
    seen = FollowedView("anterior")
    seen.go_to(0.0)
    seen.learn(labelling(0.0))
    seen.go_to(2.0)
    assert seen.view == ""
    assert not seen.is_square


def test_few_names_and_a_sudden_turn_tell_nothing():
    seen = FollowedView("anterior")
    for number in range(30):
        seen.go_to(number / RATE_HZ)
        seen.learn(labelling(0.0))
    seen.learn(labelling(90.0, n_named=3))
    seen.learn(labelling(90.0, n_named=6, n_points=14))
    seen.learn(labelling(150.0))
    seen.learn(labelling(math.nan))
    assert abs(math.degrees(seen._state[0])) < 1.0


def test_between_two_views_none_is_seen_squarely():
    seen = FollowedView("anterior")
    for number in range(40):
        heading_deg = min(2.0 * number, 44.0)
        seen.go_to(number / RATE_HZ)
        seen.learn(labelling(heading_deg))
    assert seen.view == "anterior"
    assert not seen.is_square


def test_new_points_and_a_flat_picture_tell_no_turn():
    seen = FollowedView("anterior")
    seen.go_to(0.0)
    seen.go_to(0.1)
    seen.turn(np.full((5, 3), np.nan), points_at(30.0, n=5))
    seen.turn(points_at(0.0, n=2), points_at(30.0, n=2))
    seen.turn(points_at(0.0)[:, :2], points_at(30.0)[:, :2])
    assert seen._state.tolist() == [0.0, 0.0]
