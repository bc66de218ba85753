"""Ways to name points that core and limbs do not list: by how people stand, and by one change."""

from itertools import permutations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.shapes.parts_types import Pool
from adibas.skeleton.changed_ways import not_listed, one_change_away
from adibas.skeleton.given_names import given_index
from adibas.skeleton.known import Known
from adibas.skeleton.parts_odds import HOLDING_STILL, THOROUGH, PartsOdds, expected_odds
from adibas.skeleton.sizes import size_log_odds
from adibas.skeleton.stance import OF_NATS, Stance, components_of
from adibas.skeleton.stance_ways import FEWEST, THEN_OFF_M, ways_of_stance
from adibas.skeleton.standing_odds import rate_standing

N = len(JOINT_NAMES)
LOG_ROOM = np.log(3.0)
LONE = 3.0

CHANCE_BEFORE_THE_PELVIS = """
left_shoulder 0.098 -0.316 -0.053 9.4, left_knee 0.152 0.436 -0.065 9.1,
left_elbow 0.246 -0.108 -0.066 7.8, left_foot 0.065 0.746 -0.034 7.8,
right_elbow -0.213 -0.022 -0.109 9.3, right_hand -0.203 0.198 -0.145 9.7,
torso -0.018 -0.029 0.036 7.8, left_hand 0.299 0.139 -0.095 9.6, - 0.552 -0.321 -0.311 6.3,
left_hip 0.1 0.109 -0.102 7.8, right_shoulder -0.196 -0.259 -0.083 8.2,
head -0.004 -0.461 -0.144 9.7, neck -0.053 -0.281 -0.096 7.9, - -0.007 0.182 -0.026 54.5,
right_knee -0.128 0.425 -0.094 9.3
"""
CHANCE_BESIDE_THE_TRUNK = """
left_elbow 0.154 0.028 -0.045 9.4, - -0.027 -0.162 -0.146 6.2, - 0.496 0.231 0.222 21.8,
left_hand 0.245 0.198 -0.089 8.5, right_hip -0.091 0.1 -0.097 8.4,
right_knee -0.094 0.461 -0.024 9.2, neck -0.002 -0.231 0.04 10.5,
right_foot -0.047 0.775 -0.042 10.1, right_elbow -0.208 0.043 0.009 8.8,
torso 0.0 -0.082 0.042 11.1, left_knee 0.096 0.452 -0.007 8.8,
right_hand -0.271 0.229 -0.114 10.3, left_foot 0.08 0.755 -0.001 9.6,
left_shoulder 0.102 -0.196 -0.068 8.9, head -0.034 -0.333 -0.141 8.7
"""
"""Simulated people who face the camera, two joints hidden: name, x, y, z in m, diameter in mm."""


def ways_to_name(n_names, n_points):
    """All of them: each name a point of its own, or none."""
    choices = permutations([*range(n_points), *[-1] * n_names], n_names)
    return np.array(sorted(set(choices)))


def is_one_change(old, new):
    names = np.flatnonzero(old != new)
    if len(names) == 1:
        return True
    if len(names) != 2:
        return False
    before, after = set(old[names].tolist()), set(new[names].tolist())
    return before == after and -1 in before


@pytest.mark.parametrize("way", [[0, 1, 2], [2, -1, 0], [-1, -1, 3], [-1, -1, -1]])
def test_ways_at_one_change_are_all_that_differ_by_a_point_taken_given_or_lost(way):
    way = np.array(way)
    expected = [one for one in ways_to_name(3, 4) if is_one_change(way, one)]
    found = one_change_away(way, 4)
    np.testing.assert_array_equal(sorted(found.tolist()), sorted(np.array(expected).tolist()))


def test_ways_that_are_listed_are_not_listed_again():
    listed = np.array([[0, 1], [1, -1]])
    found = not_listed(np.array([[1, 0], [1, -1], [0, -1]]), listed)
    np.testing.assert_array_equal(found, [[1, 0], [0, -1]])
    assert len(not_listed(listed, listed)) == 0


def small_stance(n_names, rng, shift_m=0.0):
    roots = rng.normal(size=(1, 3 * n_names, 3 * n_names)) * 0.01
    shifts = np.tile(np.eye(3), n_names) * shift_m
    own = 1e-3 * np.eye(3 * n_names)
    return Stance(
        weights=np.ones(1),
        means=rng.normal(scale=0.3, size=(1, 3 * n_names)),
        covariances=roots @ roots.transpose(0, 2, 1) + own + shifts.T @ shifts,
        limbs=np.zeros((0, 3), int),
        bone_means=np.zeros((0, 2)),
        bone_sds=np.ones((0, 2)),
        bone_correlations=np.zeros((0, 2)),
    )  # fmt: skip


def drawn(stance, rng):
    return rng.multivariate_normal(stance.means[0], stance.covariances[0]).reshape(-1, 3)


def about_their_mean(covariance, rng):
    """Of each joint, by drawing shapes and putting their means together."""
    shapes = rng.multivariate_normal(np.zeros(len(covariance)), covariance, 20_000)
    shapes = shapes.reshape(len(shapes), -1, 3)
    shapes = shapes - shapes.mean(axis=1, keepdims=True)
    return [np.cov(shapes[:, joint].T) for joint in range(shapes.shape[1])]


def test_a_way_by_how_people_stand_is_the_cheapest_one_of_all():
    """Against every way there is, for a body that lies where its own names put it."""
    n_names, n_compared = 6, 0
    ways = ways_to_name(n_names, n_names)
    for seed in range(30):
        rng = np.random.default_rng(seed)
        stance = small_stance(n_names, rng)
        places_m = drawn(stance, rng)
        places_m[0] += rng.normal(scale=0.15, size=3)
        (found,) = ways_of_stance(stance, places_m, LOG_ROOM, LONE)
        named = found >= 0
        if named.sum() < FEWEST:
            continue
        at_m = np.median(places_m[found[named]] - stance.means.reshape(-1, 3)[named], axis=0)
        own = about_their_mean(stance.covariances[0], rng)
        costs = np.array([
            -multivariate_normal(mean + at_m, spread + THEN_OFF_M**2 * np.eye(3)).logpdf(places_m)
            for mean, spread in zip(stance.means.reshape(-1, 3), own, strict=True)
        ])  # fmt: skip
        own_costs = np.take_along_axis(costs, np.maximum(ways, 0).T, axis=1).T - LOG_ROOM
        totals = np.where(ways >= 0, own_costs, LONE).sum(axis=1)
        of_found = totals[(ways == found).all(axis=1)][0]
        assert of_found <= totals.min() + 0.02
        n_compared += 1
    assert n_compared >= 20


def test_where_the_body_stands_and_how_surely_that_is_known_changes_no_way():
    rng = np.random.default_rng(3)
    stance = small_stance(6, rng)
    places_m = np.delete(drawn(stance, rng), 2, axis=0)
    (way,) = ways_of_stance(stance, places_m, LOG_ROOM, LONE)
    np.testing.assert_array_equal(way, [0, 1, -1, 2, 3, 4])
    shifted = small_stance(6, np.random.default_rng(3), shift_m=2.0)
    moved_m = places_m + np.array([7.0, -2.0, 40.0])
    (other,) = ways_of_stance(shifted, moved_m, LOG_ROOM, LONE)
    np.testing.assert_array_equal(other, way)


def test_with_points_that_are_nobody_no_name_has_one():
    stance = small_stance(6, np.random.default_rng(4))
    far_m = 50.0 * np.eye(3)[[0, 1, 2, 0, 1, 2]] * np.arange(1, 7)[:, None]
    (way,) = ways_of_stance(stance, far_m, LOG_ROOM, LONE)
    assert (way >= 0).sum() < FEWEST


def test_components_of_a_way_are_those_that_its_points_may_be_of():
    stance = shipped_namer()._model.parts.stance
    places_m = stance.means[3].reshape(N, 3)
    way = np.arange(N)
    way[[4, 9]] = -1
    at = np.delete(np.arange(3 * N).reshape(N, 3), [4, 9], axis=0).ravel()
    row = stance.means[3][at]
    every = zip(stance.weights, stance.means, stance.covariances, strict=True)
    logs = np.array([
        np.log(weight) + multivariate_normal(mean[at], spread[np.ix_(at, at)]).logpdf(row)
        for weight, mean, spread in every
    ])  # fmt: skip
    kept = components_of(stance, places_m, way)
    expected = logs > logs.max() - OF_NATS
    assert 0 < expected.sum() < len(expected)
    np.testing.assert_array_equal(kept.means, stance.means[expected])
    np.testing.assert_array_equal(kept.weights, stance.weights[expected])


def read_markers(text):
    rows = [row.split() for row in text.split(",")]
    names = tuple(None if name == "-" else name for name, *_ in rows)
    numbers = np.array([[float(one) for one in row[1:]] for row in rows])
    return names, numbers[:, :3], numbers[:, 3] / 1e3


@pytest.mark.parametrize("markers", [CHANCE_BEFORE_THE_PELVIS, CHANCE_BESIDE_THE_TRUNK])
def test_who_holds_still_is_named_where_core_and_limbs_go_astray(markers):
    names, points_m, diameters_m = read_markers(markers)
    free, still = shipped_namer(), shipped_namer().holding_still()
    assert free.label(points_m, "anterior", diameters_m).names != names
    assert still.label(points_m, "anterior", diameters_m).names == names


def rated_from_one_way(given):
    """What is asked about where core and limbs list the right way alone."""
    names, points_m, diameters_m = read_markers(CHANCE_BESIDE_THE_TRUNK)
    model, odds = shipped_namer()._model.parts, PartsOdds(stands=HOLDING_STILL)
    expected = expected_odds(model, np.zeros((len(names), 15)), "anterior", odds, THOROUGH)
    way = [names.index(name) if name in names else -1 for name in JOINT_NAMES]
    pool = Pool(np.array([-45.0]), np.zeros(1), np.array([way]), np.ones(1, np.int64))
    known = Known(size_log_odds(diameters_m), given_index(given, JOINT_NAMES))
    centred_m = points_m - points_m.mean(axis=0)
    return rate_standing(model, centred_m, known, pool, expected, odds)


def test_no_way_that_is_added_takes_the_name_from_a_point_that_has_it():
    free = rated_from_one_way([""] * N)
    right = free.pool.partners[0]
    is_lost = (free.pool.partners != right) & (right >= 0)
    assert is_lost.any()
    point = right[is_lost.any(axis=0)][0]
    names = read_markers(CHANCE_BESIDE_THE_TRUNK)[0]
    bound = rated_from_one_way([names[point] if one == point else "" for one in range(N)])
    kept = ~(is_lost & (right == point)).any(axis=1)
    np.testing.assert_array_equal(bound.pool.partners, free.pool.partners[kept])
    assert 1 < kept.sum() < len(kept)


def test_an_added_way_is_never_likelier_than_listed_ones_where_nobody_stands():
    rated = rated_from_one_way([""] * N)
    assert (rated.pool.energies[1:] >= rated.pool.energies[0]).all()
    assert len(np.unique(rated.pool.partners, axis=0)) == len(rated.pool.partners)


def test_clouds_of_chance_points_are_rated_by_numbers_and_named_by_nothing():
    """A way by how people stand may leave too few names for anybody: it is none."""
    rng = np.random.default_rng(0)
    still = shipped_namer().holding_still()
    for _ in range(6):
        found = still.label(rng.uniform(-1.0, 1.0, (20, 3)), "anterior")
        assert not any(found.names)
        assert np.isfinite(found.masses).all()


@pytest.mark.parametrize(
    "scale", [0.0, 1e-5, 1e20], ids=["one place", "a dust grain", "farther than the moon"]
)
def test_points_that_no_person_has_get_no_names(scale):
    figure_m = shipped_namer()._model.parts.stance.means[0].reshape(N, 3)
    for namer in (shipped_namer(), shipped_namer().holding_still()):
        assert namer.label(figure_m, "anterior").names == JOINT_NAMES
        assert namer.label(scale * figure_m, "anterior").names == (None,) * N
