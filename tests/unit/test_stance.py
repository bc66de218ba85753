"""How all joints of people who stand still lie together: densities, learning, and what it names."""

import csv
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import lognorm, multivariate_normal, norm, vonmises_fisher

from adibas.cli.command_line import main
from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.skeleton.given_names import nothing_given
from adibas.skeleton.known import Known
from adibas.skeleton.model_files import model_from_json, model_to_json
from adibas.skeleton.namer import Namer
from adibas.skeleton.parts import LIMB_NAMES
from adibas.skeleton.stance import (
    CONCENTRATIONS,
    LIFTED,
    REACH,
    Stance,
    bone_log_densities,
    stance_log_densities,
)
from adibas.skeleton.stance_training import StanceParams, learn_stance
from adibas.skeleton.starts import HEADINGS_RAD, turn_back

N = len(JOINT_NAMES)
ROOM_M3 = 3.0
HEAD, NECK, TORSO = (JOINT_NAMES.index(name) for name in ("head", "neck", "torso"))
SHOULDER, ELBOW, HAND = (JOINT_NAMES.index(name) for name in LIMB_NAMES[0])


@pytest.fixture(scope="module")
def stance():
    """Two components, drawn at random, of a covariance that joins all coordinates."""
    rng = np.random.default_rng(4)
    roots = rng.normal(size=(2, 3 * N, 3 * N)) * 0.05
    limbs = np.array([[JOINT_NAMES.index(name) for name in limb] for limb in LIMB_NAMES])
    return Stance(
        weights=np.array([0.3, 0.7]),
        means=rng.normal(scale=0.4, size=(2, 3 * N)),
        covariances=roots @ roots.transpose(0, 2, 1) + 0.01 * np.eye(3 * N),
        limbs=limbs,
        bone_means=np.log(np.full((4, 2), [0.3, 0.25])),
        bone_sds=np.full((4, 2), 0.1),
        bone_correlations=np.full((4, 2), 0.8),
    )


def ways_of(*pairs):
    """Return one way in which these labels have these points."""
    way = np.full((1, N), -1)
    for label, point in pairs:
        way[0, label] = point
    return way


def joint_log_density(stance, places_m, way):
    labels = np.flatnonzero(way[0] >= 0)
    at = (3 * labels[:, None] + np.arange(3)).ravel()
    row = places_m[way[0, labels]].ravel()
    return logsumexp([
        math.log(weight) + multivariate_normal(mean[at], covariance[np.ix_(at, at)]).logpdf(row)
        for weight, mean, covariance in zip(
            stance.weights, stance.means, stance.covariances, strict=True
        )
    ])  # fmt: skip


def test_the_density_of_a_way_is_the_mixture_of_the_labels_that_have_points(stance):
    places_m = np.random.default_rng(1).normal(scale=0.4, size=(7, 3))
    ways = np.concatenate([
        ways_of((HEAD, 0), (NECK, 1), (TORSO, 2)),
        ways_of((HEAD, 3), (NECK, 1), (TORSO, 2)),
        ways_of((HEAD, 0), (NECK, 1), (TORSO, 2), (SHOULDER, 6)),
    ])  # fmt: skip
    found = stance_log_densities(stance, places_m, ways, ROOM_M3, [1e-12] * 4)
    expected = [joint_log_density(stance, places_m, way[None]) for way in ways]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def free_bone(bone_m, usual_m, direction=None, concentration=0.0):
    """Return the log density at the end of a bone: its length's by SciPy, times its direction's."""
    length_m = np.linalg.norm(bone_m)
    of_length = lognorm(0.1, scale=usual_m).logpdf(length_m) - 2.0 * math.log(length_m)
    if direction is None:
        return of_length - math.log(4 * math.pi)
    mean = np.array(direction) / np.linalg.norm(direction)
    return of_length + vonmises_fisher(mean, concentration).logpdf(bone_m / length_m)


def test_one_limb_or_its_outer_bone_may_be_elsewhere_and_no_two(stance):
    places_m = np.random.default_rng(2).normal(scale=0.3, size=(6, 3))
    places_m[4] = places_m[3] + [0.17, 0.1, -0.22]
    places_m[5] = places_m[4] + [-0.05, -0.1, -0.22]
    trunk = (HEAD, 0), (NECK, 1), (TORSO, 2), (SHOULDER, 3)
    way = ways_of(*trunk, (ELBOW, 4), (HAND, 5))
    upper = free_bone(places_m[4] - places_m[3], 0.3, LIFTED[0], CONCENTRATIONS[0])
    lower = free_bone(places_m[5] - places_m[4], 0.25, LIFTED[1], CONCENTRATIONS[1])
    as_usual = joint_log_density(stance, places_m, way)
    no_arm = joint_log_density(stance, places_m, ways_of(*trunk))
    no_hand = joint_log_density(stance, places_m, ways_of(*trunk, (ELBOW, 4)))
    elsewhere = [0.02, 0.03, 0.004, 0.005]
    terms = [
        math.log(1 - 2 * sum(elsewhere)) + as_usual,
        math.log(0.02) + no_arm + upper + lower,
        math.log(0.02) + no_hand + lower,
        math.log(2 * sum(elsewhere[1:])) + as_usual,  # limbs that have no points to be elsewhere
    ]
    assert np.ptp(terms[1:3]) < 6.0 < max(terms) - terms[0]  # both count, and are told apart
    found = stance_log_densities(stance, places_m, way, ROOM_M3, elsewhere)
    assert found[0] == pytest.approx(logsumexp(terms), rel=1e-9)


@pytest.mark.parametrize(("limb", "sign"), [(0, 1.0), (1, -1.0)])
def test_lifted_arms_point_forwards_and_legs_anywhere(stance, limb, sign):
    """Seen by the camera that is faced, a left arm is at greater x, and forwards is towards it."""
    bone_m = 0.25 * np.array([-0.2 * sign, -0.4, -0.9])
    root_m = np.array([0.0, 0.3, 0.0])
    places_m = np.stack([root_m, root_m + bone_m, root_m - bone_m])
    _, elbow, hand = stance.limbs[limb]
    ahead, behind = (
        bone_log_densities(stance, limb, places_m, ways_of((elbow, 0), (hand, end)), ROOM_M3)
        for end in (1, 2)
    )
    assert ahead[0, 1] == pytest.approx(
        free_bone(bone_m, 0.25, LIFTED[1] * [sign, 1, 1], CONCENTRATIONS[1])
    )
    assert ahead[0, 1] - behind[0, 1] == pytest.approx(2 * CONCENTRATIONS[1], abs=0.02)
    _, knee, foot = stance.limbs[limb + 2]
    leg = bone_log_densities(stance, limb + 2, places_m, ways_of((knee, 0), (foot, 1)), ROOM_M3)
    assert leg[0, 1] == pytest.approx(free_bone(bone_m, 0.25))


@pytest.mark.parametrize(("limb", "other"), [(0, 1), (1, 0), (2, 3), (3, 2)])
def test_a_bone_that_is_elsewhere_is_about_as_long_as_that_of_the_other_side(stance, limb, other):
    """Against the normal distribution of both logarithms, given one of them."""
    given = stance._replace(
        bone_means=np.log([[0.3, 0.25], [0.32, 0.24], [0.4, 0.42], [0.41, 0.39]]),
        bone_sds=np.array([[0.1, 0.12], [0.13, 0.11], [0.1, 0.1], [0.1, 0.2]]),
    )
    of_limb, of_other = given.limbs[limb], given.limbs[other]
    places_m = np.zeros((6, 3))
    places_m[[1, 2, 4, 5], 1] = 0.28, 0.28 + 0.27, 0.36, 0.36 + 0.21
    own = [(label, point) for point, label in enumerate(of_limb)]
    both = [*own, *((label, 3 + point) for point, label in enumerate(of_other))]
    alone, beside = (
        bone_log_densities(given, limb, places_m, ways_of(*pairs), ROOM_M3) for pairs in (own, both)
    )
    for bone, (length_m, other_m) in enumerate([(0.28, 0.36), (0.27, 0.21)]):
        means = given.bone_means[[limb, other], bone]
        sds = given.bone_sds[[limb, other], bone]
        covariance = np.outer(sds, sds) * [[1.0, 0.8], [0.8, 1.0]]
        logs = np.log([length_m, other_m])
        joint = multivariate_normal(means, covariance).logpdf(logs)
        own_alone, of_the_other = norm(means, sds).logpdf(logs)
        gain = beside[0, bone] - alone[0, bone]
        assert gain == pytest.approx(joint - of_the_other - own_alone, rel=1e-9)
        assert abs(gain) > 0.1


def test_a_bone_of_the_other_side_that_has_lost_an_end_tells_nothing(stance):
    places_m = np.random.default_rng(6).normal(scale=0.3, size=(5, 3))
    own = (SHOULDER, 0), (ELBOW, 1), (HAND, 2)
    _, elbow, hand = stance.limbs[1]
    alone = bone_log_densities(stance, 0, places_m, ways_of(*own), ROOM_M3)
    beside = ways_of(*own, (elbow, 3), (hand, 4))
    found = bone_log_densities(stance, 0, places_m, beside, ROOM_M3)
    assert found[0, 0] == alone[0, 0]
    assert found[0, 1] != alone[0, 1]


def test_free_bones_fill_the_space_about_their_other_end_once(stance):
    """The density of a limb's point, summed over space, is 1: by Monte Carlo in a cube."""
    rng = np.random.default_rng(3)
    cube_m, n = 0.8, 400_000
    places_m = np.concatenate([np.zeros((2, 3)), rng.uniform(-cube_m, cube_m, (n, 3))])
    places_m[1] = [0.3, 0.0, 0.0]
    anywhere = np.arange(2, n + 2)

    def total(point, *fixed):
        ways = np.repeat(ways_of((SHOULDER, 0), *fixed), n, axis=0)
        ways[:, point] = anywhere
        logs = bone_log_densities(stance, 0, places_m, ways, ROOM_M3)[:, int(point == HAND)]
        return np.exp(logs).mean() * (2 * cube_m) ** 3

    assert total(ELBOW) == pytest.approx(1.0, abs=0.02)
    assert total(HAND, (ELBOW, 1)) == pytest.approx(1.0, abs=0.02)
    assert total(HAND) == pytest.approx(REACH**3, abs=0.02)  # a ball that is a little larger


def test_points_of_a_limb_that_hangs_on_nothing_are_anywhere_in_the_room(stance):
    places_m = np.array([[0.1, 0.2, 0.3], [0.2, 0.2, 0.3]])
    lone = bone_log_densities(stance, 0, places_m, ways_of((HAND, 1)), ROOM_M3)
    np.testing.assert_allclose(lone, [[0.0, -math.log(ROOM_M3)]])
    upper = bone_log_densities(stance, 0, places_m, ways_of((ELBOW, 0)), ROOM_M3)
    np.testing.assert_allclose(upper, [[-math.log(ROOM_M3), 0.0]])


def test_two_points_tell_nothing_together(stance):
    places_m = np.zeros((2, 3))
    way = ways_of((HEAD, 0), (NECK, 1))
    assert stance_log_densities(stance, places_m, way, ROOM_M3, [0.01] * 4)[0] == -np.inf


def standing(n, seed, sd_m=0.02):
    rng = np.random.default_rng(seed)
    figure = shipped_namer()._model.parts.stance.means[0].reshape(N, 3)
    return rng.uniform(0.9, 1.1, (n, 1, 1)) * figure + rng.normal(scale=sd_m, size=(n, N, 3))


def test_learning_finds_the_normal_distribution_that_shapes_were_drawn_from():
    shapes_m = standing(4000, 5)
    params = StanceParams(n_components=1, turn_rad=0.0, floor_m=1e-4)
    stance = learn_stance(JOINT_NAMES, shapes_m, params)
    centred = shapes_m - shapes_m.mean(axis=1, keepdims=True)
    np.testing.assert_allclose(stance.means[0], centred.mean(axis=0).ravel(), atol=1e-9)
    shifts = np.tile(np.eye(3), N) * params.shift_m
    own = stance.covariances[0] - shifts.T @ shifts
    np.testing.assert_allclose(own, np.cov(centred.reshape(4000, -1).T), atol=1e-5)
    upper_m = np.linalg.norm(shapes_m[:, ELBOW] - shapes_m[:, SHOULDER], axis=1)
    assert stance.bone_means[0, 0] == pytest.approx(np.log(upper_m).mean())
    assert stance.bone_sds[0, 0] == pytest.approx(max(np.log(upper_m).std(), 0.1))
    assert (stance.bone_correlations >= 0.0).all()


def test_learning_finds_how_alike_the_bones_of_both_sides_are():
    """Arms that grow alike, and legs with nothing in common."""
    rng = np.random.default_rng(9)
    shapes_m = np.repeat(standing(1, 5, 0.0), 4000, axis=0)
    shared, alone = rng.normal(scale=0.15, size=(2, 4000, 1))
    for side, own in (("left", alone), ("right", rng.normal(scale=0.15, size=(4000, 1)))):
        elbow, hand, knee, foot = (
            JOINT_NAMES.index(f"{side}_{name}") for name in ("elbow", "hand", "knee", "foot")
        )
        off = shared + rng.normal(scale=0.08, size=(4000, 1))
        shapes_m[:, hand] = shapes_m[:, elbow] + [0.0, 0.25, 0.0] * np.exp(off)
        shapes_m[:, foot] = shapes_m[:, knee] + [0.0, 0.4, 0.0] * np.exp(own)
    found = learn_stance(JOINT_NAMES, shapes_m, StanceParams(n_components=1)).bone_correlations
    alike = 0.15**2 / (0.15**2 + 0.08**2)
    np.testing.assert_allclose(found[:2, 1], alike, atol=0.02)
    np.testing.assert_allclose(found[2:, 1], 0.0, atol=0.03)


def test_bones_that_never_differ_are_not_taken_to_be_exactly_alike():
    params = StanceParams(n_components=1)
    shapes_m = standing(400, 5, 0.0)
    found = learn_stance(JOINT_NAMES, shapes_m, params)
    apart = 2.0 * found.bone_sds**2 * (1.0 - found.bone_correlations)
    np.testing.assert_allclose(np.sqrt(apart), params.least_side_sd, rtol=1e-9)


@pytest.mark.parametrize("view", HEADINGS_RAD)
def test_places_are_compared_in_the_axes_of_the_declared_view(view):
    person_m = standing(1, 6)[0] @ turn_back(HEADINGS_RAD[view]) + [0.2, 0.0, 2.5]
    namer = shipped_namer().holding_still()
    assert namer.label(person_m, view).names == JOINT_NAMES
    hidden = np.delete(person_m, HAND, axis=0)
    found = namer._by_parts(hidden, view, known_of(hidden))
    assert found.stands > 0.5
    quarter = next(
        one
        for one, heading_rad in HEADINGS_RAD.items()
        if abs(math.cos(heading_rad - HEADINGS_RAD[view])) < 0.5
    )
    turned_away = namer._by_parts(hidden, quarter, known_of(hidden))
    assert turned_away is None or turned_away.stands < 0.5


def known_of(points_m):
    return Known(np.zeros(len(points_m)), nothing_given(len(points_m)))


def test_who_holds_still_keeps_a_joint_from_a_chance_point_beside_its_usual_place():
    """A limb apart from the others is the only doubt that core and limbs do not settle."""
    free, still = shipped_namer(), shipped_namer().holding_still()
    person_m = standing(1, 7, 0.0)[0]
    chance_m = person_m[ELBOW] + [0.09, 0.05, 0.05]
    points_m = np.concatenate([np.delete(person_m, [ELBOW, HEAD], axis=0), [chance_m]])
    own = Namer._by_parts
    by_still = own(still, points_m, "anterior", known_of(points_m))
    by_free = own(free, points_m, "anterior", known_of(points_m))
    assert by_free.stands == 0.0
    assert by_still.stands > 0.5
    assert by_still.labelling.masses[-1, ELBOW] < by_free.labelling.masses[-1, ELBOW]


def test_nothing_is_known_of_somebody_whose_view_is_not_told():
    person_m = standing(1, 8)[0]
    still = shipped_namer().holding_still()
    points_m = np.delete(person_m, HAND, axis=0)
    assert still._by_parts(points_m, "", known_of(points_m)).stands == 0.0


def test_a_model_that_never_learned_how_people_stand_names_as_before():
    model = shipped_namer()._model
    without = Namer(replace(model, parts=replace(model.parts, stance=None)))
    points_m = np.delete(standing(1, 9)[0], HAND, axis=0)
    expected = without.label(points_m, "anterior")
    found = without.holding_still().label(points_m, "anterior")
    assert found.names == expected.names
    np.testing.assert_array_equal(found.masses, expected.masses)


def test_how_people_stand_is_kept_in_the_file_and_checked():
    model = shipped_namer()._model
    document = model_to_json(model)
    for name, array in model_from_json(document).parts.stance._asdict().items():
        np.testing.assert_array_equal(array, getattr(model.parts.stance, name))
    older = {**document, "parts": {**document["parts"], "stance": None}}
    assert model_from_json(older).parts.stance is None
    stance = document["parts"]["stance"]
    for field in ("means", "covariances", "limbs", "bone_means", "bone_correlations"):
        cut = {**stance, field: stance[field][:-1]}
        with pytest.raises(ValueError, match="must have shape"):
            model_from_json({**document, "parts": {**document["parts"], "stance": cut}})


@pytest.mark.parametrize(
    ("field", "value", "told"),
    [
        ("weights", -0.1, "positive"),
        ("bone_sds", [0.1, 0.0], "positive"),
        ("bone_correlations", [0.5, 1.0], "below 1"),
        ("limbs", [0, 1, N], "from 0 to 14"),
        ("limbs", [0, -1, 2], "from 0 to 14"),
        ("covariances", [[0.0] * (3 * N)] * (3 * N), "positive definite"),
    ],
)
def test_a_file_with_a_stance_that_nobody_has_is_refused(field, value, told):
    document = model_to_json(shipped_namer()._model)
    stance = document["parts"]["stance"]
    broken = {**stance, field: [value, *stance[field][1:]]}
    with pytest.raises(ValueError, match=told):
        model_from_json({**document, "parts": {**document["parts"], "stance": broken}})


def test_the_command_names_people_who_hold_still_as_a_capture_does(tmp_path, capsys):
    person_m = standing(1, 7, 0.0)[0]
    chance_m = person_m[ELBOW] + [0.09, 0.05, 0.05]
    points_m = np.concatenate([np.delete(person_m, [ELBOW, HEAD], axis=0), [chance_m]])
    lines = [f"one,{i},,{x!r},{y!r},{z!r}" for i, (x, y, z) in enumerate(points_m.tolist())]
    points, out = tmp_path / "points.csv", tmp_path / "labelled.csv"
    points.write_text("\n".join(["shape,point,label,x_m,y_m,z_m", *lines]))
    command = ["skeleton", "label", str(points), "--view", "anterior", "--out", str(out)]
    confidences = {}
    for namer, more in (
        (shipped_namer(), []),
        (shipped_namer().holding_still(), ["--still"]),
    ):
        assert main([*command, *more]) == 0
        with out.open() as file:
            told = [float(row["confidence"]) for row in csv.DictReader(file)]
        np.testing.assert_allclose(told, namer.label(points_m, "anterior").confidences, atol=1e-3)
        confidences[len(more)] = told
    assert confidences[0] != confidences[1]
    capsys.readouterr()
    assert main([*command, "--still", "--movement", "30"]) == 1
    assert "--still" in capsys.readouterr().err
