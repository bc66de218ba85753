"""Joints are named by core and limbs: the energies are those of the model, and the names right."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from adibas.data.joints import JOINT_NAMES, mirror_order, other_side
from adibas.shapes import parts_core_kernels as cores
from adibas.shapes import parts_search_kernels as search
from adibas.shapes.parts_bone_kernels import MOST_ALIKE
from adibas.shapes.parts_choice_kernels import judge_core
from adibas.shapes.parts_limb_kernels import place_limb
from adibas.shapes.parts_rootless_kernels import ALIKE_M, COMPONENT_GAP, alike_components
from adibas.shapes.parts_types import Odds, Pool
from adibas.skeleton import parts_naming as naming
from adibas.skeleton.bones_training import without_bones
from adibas.skeleton.given_names import nothing_given
from adibas.skeleton.known import Known
from adibas.skeleton.labelling import Labelling
from adibas.skeleton.model import SkeletonModel
from adibas.skeleton.model_files import read_model, write_model
from adibas.skeleton.namer import Namer
from adibas.skeleton.parts import CORE_NAMES, LIMB_NAMES, has_parts
from adibas.skeleton.parts_naming import label_parts
from adibas.skeleton.parts_odds import THOROUGH, PartsOdds, expected_odds
from adibas.skeleton.parts_training import PartsParams, learn_parts
from adibas.skeleton.prepared import PoseSpread, prepare
from adibas.skeleton.second_opinion import combined, is_in_doubt
from adibas.skeleton.starts import HEADINGS_RAD, turn_back
from adibas.skeleton.training import TrainingParams, learn_points

# Somebody who stands and faces the camera, metres: x to the image's right, y down.
PLACES = {
    "head": (0.0, -1.62, -0.03), "neck": (0.0, -1.42, 0.03), "torso": (0.0, -1.15, 0.06),
    "left_shoulder": (0.19, -1.4, 0.0), "left_elbow": (0.25, -1.12, 0.02),
    "left_hand": (0.28, -0.86, -0.06), "left_hip": (0.1, -0.92, 0.0),
    "left_knee": (0.11, -0.48, -0.03), "left_foot": (0.12, -0.06, 0.03),
}  # fmt: skip
FIGURE = np.array([
    PLACES[name] if name in PLACES else np.array(PLACES[other_side(name)]) * [-1, 1, 1]
    for name in JOINT_NAMES
])  # fmt: skip


def people(n=160, seed=0, sd_m=0.025):
    rng = np.random.default_rng(seed)
    sizes = rng.uniform(0.85, 1.1, (n, 1, 1))
    return sizes * (FIGURE + rng.normal(scale=sd_m, size=(n, *FIGURE.shape)))


@pytest.fixture(scope="module")
def parts():
    kinds = ["standing", "seated"] * 80
    return learn_parts(JOINT_NAMES, people(), kinds, PartsParams(rows_per_component=60))


@pytest.fixture(scope="module")
def model(parts):
    space = learn_points(JOINT_NAMES, people(), params=TrainingParams(n_prototypes=1))
    return SkeletonModel(space, {}, 1.0, parts=parts)


def shuffled(points, seed=0):
    order = np.random.default_rng(seed).permutation(len(points))
    names = (*JOINT_NAMES, *[None] * (len(points) - len(JOINT_NAMES)))
    return points[order], tuple(names[i] for i in order)


@pytest.mark.parametrize("view", HEADINGS_RAD)
def test_shuffled_joints_find_their_names_in_every_view(model, view):
    person = people(1, seed=5)[0] @ turn_back(HEADINGS_RAD[view] + 0.2) + [0.3, 0.1, 2.5]
    points, truth = shuffled(person)
    found = Namer(model).label(points, view)
    assert found.names == truth
    assert abs(np.angle(np.exp(1j * (found.heading_rad - HEADINGS_RAD[view] - 0.2)))) < 0.15
    np.testing.assert_allclose(found.masses.sum(axis=1), 1)


def test_hidden_joints_are_not_replaced_and_chance_points_get_no_name(model):
    person = np.concatenate([people(1, seed=6)[0], [[0.9, -1.0, 0.4], [-0.8, -0.2, -0.4]]])
    points, truth = shuffled(person)
    hidden = [truth.index("right_shoulder"), truth.index("left_hand")]
    found = Namer(model).label(np.delete(points, hidden, axis=0), "anterior")
    assert found.names == tuple(np.delete(np.array(truth, object), hidden))


def test_names_without_a_view_are_right_or_none(model):
    points, truth = shuffled(people(1, seed=7)[0] @ turn_back(1.0))
    for name, right in zip(Namer(model).label(points).names, truth, strict=True):
        assert name in (None, right)


def test_a_person_who_is_unlikely_for_one_is_searched_thoroughly(parts, model, monkeypatch):
    searches = []

    def noted(*arguments):
        searches.append(arguments[2])
        return searched(*arguments)

    searched = naming._searched
    monkeypatch.setattr(naming, "_searched", noted)
    prepared = prepare(model.space, PoseSpread())
    person = people(1, seed=8)[0]
    label_parts(parts, prepared, person, "anterior")
    assert len(searches) == 1
    hardly_ever = PartsOdds(usual=1e6)
    strange = label_parts(parts, prepared, person, "anterior", odds=hardly_ever)
    assert len(searches) == 3
    assert strange.labelling.names == JOINT_NAMES


def test_no_core_is_lost_however_many_points_there_are(model, monkeypatch):
    """Mirror images come last: a list that is full would leave out one of both ways to face."""
    n_found = []

    def counted(parts, points, starts, expected, given):
        listed = np.empty((search.MOST_CORES, len(parts.core.labels)), np.int64)
        hopes = np.empty(len(listed))
        n_found.append(search._gathered(points, starts, parts.core, expected, listed, hopes))
        return searched(parts, points, starts, expected, given)

    searched = naming._searched
    monkeypatch.setattr(naming, "_searched", counted)
    rng = np.random.default_rng(3)
    n_chance = naming.MOST_POINTS - len(JOINT_NAMES)
    chance = rng.uniform([-0.8, -1.9, -0.5], [0.8, 0.2, 0.5], (n_chance, 3))
    Namer(model).label(np.concatenate([people(1, seed=9)[0], chance]))
    assert 0 < n_found[-1] < search.MOST_CORES


def test_points_anywhere_are_no_person_even_if_fifteen(model):
    rng = np.random.default_rng(4)
    for _cloud in range(10):
        points = rng.uniform([-0.5, -0.9, -0.3], [0.5, 0.9, 0.3], (len(JOINT_NAMES), 3))
        assert set(Namer(model).label(points, "anterior").names) == {None}


def test_points_in_one_place_are_no_person(model):
    assert set(Namer(model).label(np.zeros((15, 3)), "anterior").names) == {None}


def test_a_file_of_the_model_names_as_the_model_did(model, tmp_path):
    path = tmp_path / "model.json"
    write_model(model, path)
    again = read_model(path)
    points, truth = shuffled(people(1, seed=9)[0])
    assert Namer(again).label(points, "anterior").names == truth
    np.testing.assert_allclose(again.parts.core.means, model.parts.core.means, rtol=1e-5)
    assert again.parts.limbs.labels.dtype == np.int64


def test_right_limbs_are_left_ones_mirrored(parts):
    mirror = np.array(mirror_order(CORE_NAMES))
    np.testing.assert_allclose(parts.core.mean, parts.core.mean[mirror] * [-1, 1, 1], atol=1e-12)
    for field in parts.limbs._fields[3:]:
        array = getattr(parts.limbs, field)
        np.testing.assert_array_equal(array[0], array[1])


def odds_of(parts, view):
    return expected_odds(parts, np.zeros((15, 15)), view, PartsOdds(), THOROUGH)


def test_a_core_is_turned_onto_its_mean(parts):
    own = np.array([JOINT_NAMES.index(name) for name in CORE_NAMES])
    turned = FIGURE @ turn_back(0.7)
    moved, angle_rad = cores.turned_to_mean(turned, own, parts.core.mean, odds_of(parts, ""))
    assert angle_rad == pytest.approx(-0.7, abs=0.05)
    back = moved[own] - moved[own].mean(axis=0)
    assert np.abs(back - parts.core.mean).max() < 0.08


@pytest.mark.parametrize("view", ["", "anterior", "left_lateral", "posterior"])
@pytest.mark.parametrize("hidden", [(), ("left_shoulder", "right_shoulder", "torso")])
def test_a_core_is_turned_by_its_points_and_by_the_declared_view_as_sure_as_each_is(
    parts, view, hidden
):
    odds, mean = odds_of(parts, view), parts.core.mean
    own = np.where(np.isin(CORE_NAMES, hidden), -1, parts.core.labels)
    person = people(1, seed=5, sd_m=0.06)[0] @ turn_back(odds.heading_rad if view else 0.4)

    def minus_log_density(angle_rad):
        turned = person[own[own >= 0]] @ turn_back(angle_rad)
        off = turned - turned.mean(axis=0) - (mean[own >= 0] - mean[own >= 0].mean(axis=0))
        by_points = 0.5 * (off**2).sum() / cores.LAID_SD_M**2
        return by_points + cores.heading_energy(-angle_rad, odds)

    angles_rad = np.linspace(-np.pi, np.pi, 20001)
    likeliest_rad = angles_rad[np.argmin([minus_log_density(one) for one in angles_rad])]
    _moved, angle_rad = cores.turned_to_mean(person, own, mean, odds)
    assert np.cos(angle_rad - likeliest_rad) > np.cos(1e-3)


def test_a_few_points_marked_behind_do_not_turn_round_a_patient_whose_view_is_declared(parts):
    own = np.where(np.isin(CORE_NAMES, ("head", "torso")), parts.core.labels, -1)
    person = FIGURE.copy()
    person[JOINT_NAMES.index("head"), 2] += 0.12  # on the occiput, and on the sternum
    person[JOINT_NAMES.index("torso"), 2] -= 0.12
    _moved, angle_rad = cores.turned_to_mean(person, own, parts.core.mean, odds_of(parts, ""))
    assert np.cos(angle_rad) < -0.9
    declared = odds_of(parts, "anterior")
    _moved, angle_rad = cores.turned_to_mean(person, own, parts.core.mean, declared)
    assert np.cos(angle_rad) > 0.9


def test_a_hidden_point_of_the_core_is_expected_where_the_normal_distribution_says(parts):
    core, own = parts.core, np.array([0, 1, -1, 3, 4, 5, 6])
    moved = core.means[0] + 0.01
    rows, values = cores.known_rows(moved, own)
    places, spreads = cores.leave_one_out_core(rows, values, own, core, 0)
    mean, covariance = core.means[0].ravel(), core.covariances[0]
    for i in range(len(own)):
        mine = np.arange(3 * i, 3 * i + 3)
        others = np.setdiff1d(rows, mine)
        slope = covariance[np.ix_(mine, others)] @ np.linalg.inv(covariance[np.ix_(others, others)])
        off = moved.ravel()[others] - mean[others]
        np.testing.assert_allclose(places[i], mean[mine] + slope @ off, atol=1e-8)
        rest = covariance[np.ix_(mine, mine)] - slope @ covariance[np.ix_(others, mine)]
        np.testing.assert_allclose(spreads[i], rest, atol=1e-8)
    whole, missing = cores.expected_core(rows, values, own, core, 0)
    np.testing.assert_allclose(whole, np.where(own[:, None] < 0, places, moved), atol=1e-8)
    np.testing.assert_allclose(missing[2], spreads[2], atol=1e-8)
    assert not missing[own >= 0].any()


def one_person():
    person = people(1, seed=12)[0]
    return np.ascontiguousarray(person - person.mean(axis=0))


def with_body(named):
    """Return what is expected where a body tells of each point each name's log odds."""
    counts, mixed = np.arange(16.0), np.array([0.1, 0.1, 0.0, 0.0])
    return Odds(2, math.log(3.0), counts, counts, 0.5, 4.0, 0.3, 9.0, 7.0, mixed, named, 6, 1, 15.0)


def empty_pool(n):
    return Pool(np.empty(n), np.empty(n), np.empty((n, 15), np.int64), np.zeros(1, np.int64))


def test_a_full_pool_leaves_out_what_a_better_way_makes_too_unlikely(parts):
    pool = empty_pool(40)
    pool.energies[:], pool.headings[:], pool.partners[:] = 1000.0, 0.0, -1
    pool.energies[7], pool.headings[7], pool.partners[7] = -1000.0, 0.7, 3
    pool.n_filled[0] = 40
    odds = with_body(np.zeros((15, 15)))
    judge_core(one_person(), parts.core.labels, parts.core, parts.limbs, odds, np.inf, pool)
    n = int(pool.n_filled[0])
    assert (pool.partners[:n] == range(15)).all(axis=1).any()
    (kept,) = np.flatnonzero(pool.energies[:n] == -1000.0)
    assert pool.headings[kept] == 0.7
    assert (pool.partners[kept] == 3).all()
    assert 1000.0 not in pool.energies[:n]
    pool.energies[:], pool.partners[:], pool.n_filled[0] = -1000.0, -1, 40
    judge_core(one_person(), parts.core.labels, parts.core, parts.limbs, odds, -1000.0, pool)
    assert (pool.partners == -1).all()


@pytest.mark.parametrize(("apart_m", "n_groups"), [(0.04, 1), (0.08, 2)])
def test_components_are_asked_together_that_place_a_missing_root_alike(parts, apart_m, n_groups):
    shoulder = CORE_NAMES.index("left_shoulder")
    own = np.arange(len(CORE_NAMES))
    own[shoulder] = -1
    means = np.stack([parts.core.means[0]] * 2)
    means[1, shoulder, 1] += apart_m
    of_both = {"covariances": np.stack([parts.core.covariances[0]] * 2)}
    core = parts.core._replace(means=means, kinds=np.array([0, 1]), **of_both)
    rows, values = cores.known_rows(core.means[0], own)
    logs, odds = np.array([-1.0, -2.0]), with_body(np.zeros((15, 15)))
    wholes, spreads, by_kinds = alike_components(
        rows, values, own, logs, np.array([0, 1]), core, parts.limbs, odds
    )
    np.testing.assert_allclose(wholes[:, shoulder], means[:n_groups, shoulder])
    assert len(spreads) == n_groups
    assert by_kinds.max(axis=0).tolist() == [-1.0, -2.0]


@pytest.mark.parametrize("hidden", [None, "left_shoulder", "right_hip"])
def test_the_energy_of_names_is_minus_the_log_of_their_odds(parts, hidden):
    core, limbs = parts.core, parts.limbs
    person = one_person()
    named = np.random.default_rng(3).normal(size=(15, 15))
    odds, pool = with_body(named), empty_pool(500)
    own = np.where(np.array(CORE_NAMES) == hidden, -1, core.labels)
    lowest = judge_core(person, own, core, limbs, odds, np.inf, pool)
    n = int(pool.n_filled[0])
    right = [-1 if name == hidden else i for i, name in enumerate(JOINT_NAMES)]
    found = np.flatnonzero((pool.partners[:n] == right).all(axis=1))
    assert len(found) == 1 or hidden is not None
    energy = -logsumexp(-pool.energies[found])
    assert pool.energies[:n].min() == pytest.approx(lowest)
    heading = 4.0 * (1.0 - math.cos(pool.headings[found[0]] - 0.3))
    n_hidden = int(hidden is not None)
    expected = heading + n_hidden - log_odds_of_names(person, own, core, limbs, odds)
    expected -= sum(named[i, i] for i in right if i >= 0)
    assert energy == pytest.approx(expected, abs=1e-6)


def test_a_way_that_is_there_more_than_once_has_the_sum_of_the_odds():
    partners = np.array([[0, 1], [1, 0], [0, 1], [-1, 0]])
    pool = Pool(np.array([2.0, 1.0, 3.0, 4.0]), np.array([0.1, 0.2, 0.1, 0.3]), partners, None)
    once = naming._each_once(pool)
    assert sorted(map(tuple, once.partners)) == [(-1, 0), (0, 1), (1, 0)]
    for way, energy, heading in zip(once.partners, once.energies, once.headings, strict=True):
        is_same = (partners == way).all(axis=1)
        assert energy == pytest.approx(-logsumexp(-pool.energies[is_same]))
        assert heading in pool.headings[is_same]


def test_the_core_that_a_body_tells_is_a_start(parts):
    """Each name has the point that suits it, no point twice, and none that is a chance one."""
    gains = np.full((4, 15), -2.0)
    right = {"head": 2, "left_shoulder": 0, "left_knee": 1}
    for name, point in right.items():
        gains[point, JOINT_NAMES.index(name)] = 3.0
    gains[2, JOINT_NAMES.index("neck")] = 2.5
    (core,) = naming._by_body(Known(np.zeros(4), nothing_given(4), body_odds=gains), parts)
    assert core.tolist() == [right.get(name, -1) for name in CORE_NAMES]
    assert len(naming._by_body(Known(np.zeros(4), nothing_given(4)), parts)) == 0


def log_odds_of_names(person, own, core, limbs, odds):
    """Return the log odds of the right names, by SciPy.

    Where a limb begins at a missing point, each component of the core says by itself where that is;
    those that say nearly the same are asked once, the likeliest for all of them.
    """
    moved, _ = cores.turned_to_mean(person, own, core.mean, odds)
    rows, values = cores.known_rows(moved, own)
    logs = np.array([
        weight
        + multivariate_normal(mean.ravel()[rows], covariance[np.ix_(rows, rows)]).logpdf(values)
        for weight, mean, covariance in zip(
            core.log_weights, core.means, core.covariances, strict=True
        )
    ])  # fmt: skip
    of_room = (len(rows) // 3 + 8) * odds.log_room
    likeliest = int(np.argmax(logs))
    rooted = own[limbs.roots] >= 0
    by_likeliest = limbs_at(moved, own, core, limbs, odds, likeliest)
    if rooted.all():
        of_core = np.array([logsumexp(logs[core.kinds == q]) for q in range(odds.n_kinds)])
        return logsumexp(of_core + of_limbs(*by_likeliest, limbs, odds.n_kinds)) + of_room
    totals, groups = [], {}
    missing = limbs.roots[~rooted]
    for component in np.argsort(-logs):
        if logs[component] < logs[likeliest] - COMPONENT_GAP:
            break
        roots_m = cores.expected_core(rows, values, own, core, component)[0][missing]
        first = next(
            (
                one
                for one, there_m in groups.items()
                if np.linalg.norm(roots_m - there_m, axis=1).max() <= ALIKE_M
            ),
            component,
        )
        groups.setdefault(first, roots_m)
        alone = limbs_at(moved, own, core, limbs, odds, first)
        by_kind, lengths = (
            np.where(rooted[:, None], *both) for both in zip(by_likeliest, alone, strict=True)
        )
        of_kinds = of_limbs(by_kind, lengths, limbs, odds.n_kinds)
        totals.append(logs[component] + of_kinds[core.kinds[component]])
    assert len(totals) > 1
    return logsumexp(totals) + of_room


def of_limbs(by_kind, lengths, limbs, n_kinds):
    """Return what all limbs add for each kind of posture."""
    return by_kind.sum(axis=0) + log_odds_of_sides(lengths, limbs, n_kinds)


def limbs_at(moved, own, core, limbs, odds, component):
    """Return the (L, Q) log densities of limbs at a core filled by a component, and lengths."""
    rows, values = cores.known_rows(moved, own)
    whole, _ = cores.expected_core(rows, values, own, core, component)
    _, spreads = cores.leave_one_out_core(rows, values, own, core, component)
    plain, mirrored, size_m = cores.core_numbers(whole, core)
    lengths = np.empty((len(limbs.roots), 2))
    by_kind = np.empty((len(limbs.roots), odds.n_kinds))
    for limb, points in enumerate(limbs.labels):
        sign, root = limbs.signs[limb], limbs.roots[limb]
        way = (moved[points] - whole[root]) / size_m * [sign, 1, 1]
        bones = np.linalg.norm([way[0], way[1] - way[0]], axis=1)
        lengths[limb] = np.log(bones) + np.array([0 if own[root] >= 0 else math.nan, 0])
        numbers = plain if sign > 0 else mirrored
        weights, places = place_limb(numbers, limbs, limb, odds.n_kinds)
        mirror = np.diag([sign, 1, 1])
        of_root = mirror @ spreads[root] @ mirror / size_m**2 * (own[root] < 0)
        densities = np.array([
            multivariate_normal(place, lower @ lower.T + np.tile(of_root, (2, 2))).logpdf(
                way.ravel()
            )
            for place, lower in zip(places, limbs.factors[limb], strict=True)
        ])  # fmt: skip
        of_limb = np.array([
            logsumexp((weights + densities)[limbs.kinds[limb] == q])
            + log_odds_of_length(lengths[limb], limbs, limb, q)
            for q in range(odds.n_kinds)
        ])  # fmt: skip
        of_any = logsumexp(of_limb) - math.log(odds.n_kinds)
        share = odds.mixed[limb]
        by_kind[limb] = np.log((1.0 - share) * np.exp(of_limb) + share * np.exp(of_any))
        by_kind[limb] -= 2 * 3 * math.log(size_m)
    return by_kind, lengths


def log_odds_of_length(lengths, limbs, limb, q):
    """Return what the (2,) logarithms of a limb's lengths, NaN if not known, add for a kind."""
    k = np.flatnonzero(np.isfinite(lengths))
    own = limbs.bone_covariances[limb, q][np.ix_(k, k)]
    drawn = limbs.drawn_covariances[limb, q][np.ix_(k, k)]
    log_ratio = multivariate_normal(limbs.bone_means[limb, q][k], own).logpdf(lengths[k])
    log_ratio -= multivariate_normal(limbs.drawn_means[limb, q][k], drawn).logpdf(lengths[k])
    strange = limbs.strange[limb]
    return np.log((1 - strange) * np.exp(log_ratio) + strange)


def log_odds_of_sides(lengths, limbs, n_kinds):
    """Return what the (4, 2) logarithms of lengths of both sides together add for each kind."""
    result = np.zeros(n_kinds)
    for q in range(n_kinds):
        for left in (0, 2):
            own, across = limbs.bone_covariances[left, q], limbs.side_covariances[left, q]
            mean, strange = limbs.bone_means[left, q], limbs.strange[left]
            k = np.flatnonzero(np.isfinite(lengths[left : left + 2]).all(axis=0))
            a, b, m = own[np.ix_(k, k)], across[np.ix_(k, k)], mean[k]
            both = np.concatenate([lengths[left, k], lengths[left + 1, k]])
            of_both = multivariate_normal(np.tile(m, 2), np.block([[a, b], [b, a]]))
            alone = sum(multivariate_normal(m, a).logpdf(one) for one in np.split(both, 2))
            log_ratio = of_both.logpdf(both) - alone
            result[q] += min(np.log((1 - strange) * np.exp(log_ratio) + strange), MOST_ALIKE)
    return result


def bending_people(n, seed):
    """People whose upper arms hang or point anywhere before them, and forearms anywhere."""
    rng = np.random.default_rng(seed)
    shapes = np.tile(FIGURE, (n, 1, 1))
    for side in ("left", "right"):
        at = JOINT_NAMES.index(f"{side}_shoulder")
        for name, length_m in (("elbow", 0.3), ("hand", 0.2)):
            ways = rng.normal(size=(n, 3))
            ways[:, 2] = -np.abs(ways[:, 2])
            ways *= length_m / np.linalg.norm(ways, axis=1, keepdims=True)
            point = JOINT_NAMES.index(f"{side}_{name}")
            shapes[:, point] = shapes[:, at] + ways
            at = point
    sizes = rng.uniform(0.85, 1.1, (n, 1, 1))
    return sizes * shapes + rng.normal(scale=0.005, size=shapes.shape)


def test_elbows_are_told_from_hands_by_how_long_the_bones_are():
    params = PartsParams(noise_m=0.01, most_limb=4)
    parts = learn_parts(JOINT_NAMES, bending_people(400, 1), ["standing"] * 400, params)
    space = learn_points(JOINT_NAMES, people(), params=TrainingParams(n_prototypes=1))
    prepared = prepare(space, PoseSpread())
    blind = replace(parts, limbs=parts.limbs._replace(**without_bones(4, 1)))
    persons = bending_people(20, 2)
    wrong = [
        sum(
            label_parts(one, prepared, person, "anterior").labelling.names != JOINT_NAMES
            for person in persons
        )
        for one in (parts, blind)
    ]
    assert wrong[0] <= 0.5 * wrong[1] - 1, wrong


def people_with_one_arm_up(n, seed):
    """People who stand as all do, but the left arm points up as in no standing shape."""
    shapes = people(n, seed, sd_m=0.015)
    shoulder = shapes[:, [JOINT_NAMES.index("left_shoulder")]]
    for name, way in (("left_elbow", (0.1, -0.25, -0.05)), ("left_hand", (0.1, -0.48, -0.1))):
        shapes[:, [JOINT_NAMES.index(name)]] = shoulder + way
    return shapes


def test_an_arm_may_do_what_is_known_of_another_kind_of_posture():
    lifted = people_with_one_arm_up(160, 3)
    # Who lifts an arm bends the knees in this training: nobody of it does both as the patient.
    for side in ("left", "right"):
        lifted[:, JOINT_NAMES.index(f"{side}_knee"), 2] -= 0.25
    kinds = ["standing"] * 160 + ["lifting"] * 160
    parts = learn_parts(
        JOINT_NAMES,
        np.concatenate([people(160), lifted]),
        kinds,
        PartsParams(rows_per_component=60),
    )
    prepared = prepare(
        learn_points(JOINT_NAMES, people(), params=TrainingParams(n_prototypes=1)), PoseSpread()
    )
    persons = people_with_one_arm_up(10, 4)
    seen = np.delete(persons, JOINT_NAMES.index("right_foot"), axis=1)
    truth = tuple(name for name in JOINT_NAMES if name != "right_foot")

    def count_right(arms_free):
        odds = PartsOdds(arms_free=arms_free)
        found = [label_parts(parts, prepared, one, "anterior", odds=odds) for one in seen]
        return sum(one.labelling.names == truth for one in found if one is not None)

    assert count_right(PartsOdds().arms_free) == len(persons)
    assert count_right(1e-9) < len(persons)


def test_limbs_of_which_no_lengths_are_known_name_without_them(model):
    parts = model.parts
    limbs = parts.limbs._replace(**without_bones(4, len(parts.kinds)))
    again = replace(model, parts=replace(parts, limbs=limbs))
    points, truth = shuffled(people(1, seed=9)[0])
    assert Namer(again).label(points, "anterior").names == truth


def test_only_the_joints_have_core_and_limbs():
    assert has_parts(JOINT_NAMES)
    assert not has_parts(JOINT_NAMES[1:])
    assert {name for limb in LIMB_NAMES for name in limb} <= set(JOINT_NAMES)


def test_too_few_shapes_make_no_parts():
    with pytest.raises(ValueError, match="shapes"):
        learn_parts(JOINT_NAMES, people(20), ["standing"] * 20)


def test_parts_of_other_names_are_refused(parts):
    space = learn_points(JOINT_NAMES[::-1], people(), params=TrainingParams(n_prototypes=1))
    with pytest.raises(ValueError, match="same names"):
        SkeletonModel(space, {}, 1.0, parts=parts)


def test_two_namers_together_are_surer_where_they_agree():
    names = ("left_hand", "right_hand")
    nobody = (None, None)
    sure = np.array([[0.7, 0.2, 0.1], [0.2, 0.6, 0.2]])
    one = Labelling(nobody, nobody, np.zeros(2), 0.0, sure.copy())
    both = combined(one, one, names, 0.5, 0.25)
    np.testing.assert_allclose(both.masses, sure)
    assert both.names == names
    contrary = np.array([[0.002, 0.99, 0.008], [0.99, 0.002, 0.008]])
    other = Labelling(nobody, nobody, np.zeros(2), 0.0, contrary)
    assert combined(one, other, names, 0.5, 0.25).names == nobody
    assert is_in_doubt(one)
    assert not is_in_doubt(Labelling((None,), (None,), np.zeros(1), 0.0, np.eye(3)[:1]))
