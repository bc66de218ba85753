"""The judge that knows the simulator weighs all names near to the right ones, by all it knows."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.stats import loguniform, norm

from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.skeleton_simulator import simulate_shapes
from benchmarks.labelling_judge import (
    N_JOINTS,
    NO_POINT,
    Judge,
    _log_count,
    _log_prior,
    _log_size_odds,
    probabilities,
    ways_near,
)
from benchmarks.labelling_sets import MARKER_SD_M, SPURIOUS_DIAMETERS_M, marker_sets

RIGHT = np.array([3, NO_POINT, 0, 1, 2, 4, 14, 6, NO_POINT, 8, 9, 10, 11, 12, 13])
"""Of 15 points two, 5 and 7, are spurious, and of 15 joints two have none."""


@pytest.fixture(scope="module")
def shapes_m():
    return simulate_shapes(4, 10, 31, lambda _done, _all: None, {"standing": 1.0}).shapes_m


@pytest.fixture(scope="module")
def judge():
    return Judge("standing", 5, 40, 2, 32)


def one_set(shapes_m, n_changed, seed=1):
    return next(marker_sets(shapes_m, 1, n_changed, seed))


def test_ways_begin_with_the_right_one_and_no_two_are_alike():
    ways = ways_near(RIGHT, 15)
    assert (ways[0] == RIGHT).all()
    assert len(np.unique(ways, axis=0)) == len(ways)
    assert all(len(set(way[way >= 0])) == (way >= 0).sum() for way in ways)


def test_every_joint_may_lose_its_point_or_get_a_spurious_one_or_exchange_it():
    ways = {tuple(way) for way in ways_near(RIGHT, 15)}
    for joint, point in product(range(N_JOINTS), (5, 7, NO_POINT)):
        way = RIGHT.copy()
        way[joint] = point
        assert tuple(way) in ways
    both = RIGHT.copy()
    both[[1, 8]] = 7, 5
    assert tuple(both) in ways
    exchanged = RIGHT.copy()
    exchanged[[0, 14]] = RIGHT[[14, 0]]
    assert tuple(exchanged) in ways


def test_of_a_whole_set_two_or_three_joints_exchange_their_points():
    n_pairs, n_triples = math.comb(15, 2), math.comb(15, 3)
    ways = ways_near(np.arange(15), 15)
    whole = ways[(ways != NO_POINT).all(axis=1)]
    assert len(whole) == 1 + n_pairs + 2 * n_triples


def test_how_many_are_hidden_is_a_probability():
    assert sum(math.exp(_log_count(n)) for n in range(60)) == pytest.approx(1.0)


@pytest.mark.parametrize(("n_hidden", "n_spurious"), [(0, 0), (1, 0), (2, 2)])
def test_each_choice_of_what_is_hidden_is_alike_probable(n_hidden, n_spurious):
    n_choices = math.comb(15, n_hidden) / math.factorial(n_spurious)
    whole = math.exp(_log_count(n_hidden) + _log_count(n_spurious))
    assert n_choices * math.exp(_log_prior(n_hidden, n_spurious)) == pytest.approx(whole)


def test_sizes_tell_by_the_ratio_of_both_densities():
    sizes_m = np.array([0.0045, 0.009, 0.0095, 0.05])
    of_marker = norm.logpdf(np.log(sizes_m), math.log(0.009), 0.09)
    of_chance = loguniform.logpdf(sizes_m, *SPURIOUS_DIAMETERS_M) + np.log(sizes_m)
    assert _log_size_odds(sizes_m) == pytest.approx(of_marker - of_chance)


def test_places_are_rated_whatever_the_order_of_the_points_and_the_view(judge, shapes_m):
    sets = list(marker_sets(shapes_m[:1].repeat(4, axis=0), 4, 0, 3))
    assert len({one.view for one in sets}) == 4
    for one in sets:
        weighed = judge.weigh(one)
        order = np.argsort(weighed.points[0])
        assert tuple(JOINT_NAMES[i] for i in order) == one.truth
        assert weighed.log_odds.argmax() == 0


def test_a_point_that_is_far_away_is_no_joint(judge, shapes_m):
    one = one_set(shapes_m, 1)
    spurious = one.truth.index(None)
    one.points_m[spurious] += 3.0
    weighed = judge.weigh(one)
    takes_it = (weighed.points == spurious).any(axis=1)
    assert weighed.log_odds[takes_it].max() < weighed.log_odds[0] - 20.0


def test_a_spurious_point_in_the_place_of_a_hidden_joint_is_taken_for_it_until_that_is_excluded(
    judge, shapes_m
):
    one = one_set(shapes_m, 1)
    hidden = next(name for name in JOINT_NAMES if name not in one.truth)
    whole = one_set(shapes_m, 0)
    moved_m = np.mean(
        [one.points_m[one.truth.index(name)] - whole.points_m[whole.truth.index(name)]
         for name in one.truth if name is not None], axis=0,
    )  # fmt: skip
    assert np.abs(moved_m).max() < 5 * MARKER_SD_M
    one.points_m[one.truth.index(None)] = whole.points_m[whole.truth.index(hidden)]
    weighed = judge.weigh(one)
    assert weighed.points[weighed.log_odds.argmax()][JOINT_NAMES.index(hidden)] != NO_POINT
    assert (weighed.log_odds + weighed.is_as_many).argmax() == 0


def test_a_larger_room_makes_each_spurious_point_less_likely(judge, shapes_m):
    one = one_set(shapes_m, 2)
    narrow, wide = judge.weigh(one), judge.weigh(replace(one, room_m3=math.e * one.room_m3))
    n_spurious = len(one.points_m) - (narrow.points != NO_POINT).sum(axis=1)
    assert narrow.log_odds - wide.log_odds == pytest.approx(n_spurious)


def test_probabilities_are_shares_in_the_ratio_of_the_odds():
    shares = probabilities(np.array([0.0, math.log(3.0), -np.inf]) + 1000.0)
    assert shares == pytest.approx([0.25, 0.75, 0.0])
