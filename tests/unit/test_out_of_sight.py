"""Labels without a point that must be out of the cameras' sight do not speak against a name."""

from itertools import product

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.joints import JOINT_NAMES
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.pipeline.seen_spaces import seen_spaces
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.shapes import parts_sight_kernels as sight
from adibas.shapes.parts_core_kernels import turned_to_mean
from adibas.skeleton.parts_odds import THOROUGH, PartsOdds, expected_odds, hidden_costs
from adibas.skeleton.seen_space import EVERYWHERE, SeenSpace

COLOR = CameraCalibration(1280, 1024, Intrinsics(1050.0, 1060.0, 630.0, 500.0))
DEPTH = CameraCalibration(640, 480, Intrinsics(570.0, 575.0, 318.0, 241.0))
COLOR_FROM_DEPTH = RigidTransform(
    rotation_from_vector(np.array([0.02, -0.03, 0.01])), np.array([0.025, -0.004, 0.002])
)
CALIBRATION = RgbdCalibration(color=COLOR, depth=DEPTH, color_from_depth=COLOR_FROM_DEPTH)
# Somebody who stands 1.2 m away and faces the camera, metres: x to the image's right, y down.
PERSON_M = {
    "head": (0.0, -0.62, -0.03), "neck": (0.0, -0.44, 0.03), "torso": (0.0, -0.16, 0.0),
    "left_shoulder": (0.18, -0.38, 0.03), "right_shoulder": (-0.18, -0.38, 0.03),
    "left_elbow": (0.26, -0.12, 0.04), "right_elbow": (-0.26, -0.12, 0.04),
    "left_hand": (0.3, 0.14, 0.0), "right_hand": (-0.3, 0.14, 0.0),
    "left_hip": (0.1, 0.06, 0.0), "right_hip": (-0.1, 0.06, 0.0),
    "left_knee": (0.12, 0.48, 0.02), "right_knee": (-0.12, 0.48, 0.02),
    "left_foot": (0.13, 0.88, 0.05), "right_foot": (-0.13, 0.88, 0.05),
}  # fmt: skip


def random_planes(rng, n):
    normals = rng.normal(size=(n, 3))
    return normals / np.linalg.norm(normals, axis=1)[:, None], rng.normal(size=n)


def test_how_probably_a_point_is_beyond_a_plane_is_the_tail_of_a_normal_distribution():
    rng = np.random.default_rng(1)
    normals, offsets = random_planes(rng, 2)
    factor = 0.3 * rng.normal(size=(3, 3))
    place, spread = rng.normal(size=3), factor @ factor.T
    alone = [
        norm.cdf((c - n @ place) / np.sqrt(n @ spread @ n + 0.05**2))
        for n, c in zip(normals, offsets, strict=True)
    ]
    for k in range(2):
        share = sight.share_out_of_sight(
            place, spread, normals[k : k + 1], offsets[k : k + 1], 0.05
        )
        assert share == pytest.approx(alone[k], abs=1e-12)
    both = sight.share_out_of_sight(place, spread, normals, offsets, 0.05)
    assert both == pytest.approx(max(alone), abs=1e-12)


def test_planes_turn_with_the_points():
    rng = np.random.default_rng(2)
    points, mean = rng.normal(size=(9, 3)), rng.normal(size=(4, 3))
    own = np.array([3, -1, 0, 7])
    normals, offsets = random_planes(rng, 5)
    parts = shipped_namer()._model.parts
    odds = expected_odds(parts, np.zeros((len(points), 15)), "", PartsOdds(), THOROUGH)
    moved, angle_rad = turned_to_mean(points, own, mean, odds)
    turned, edges = sight.in_turned_axes(points, own, angle_rad, normals, offsets)
    np.testing.assert_allclose(moved @ turned.T - edges, points @ normals.T - offsets, atol=1e-12)


def test_what_may_be_hidden_is_all_that_there_is():
    costs = hidden_costs(15, PartsOdds())
    for n_out in (0, 4, 15):
        n_ways = [
            float(sum(1 for chosen in product((0, 1), repeat=15 - n_out) if sum(chosen) == n))
            for n in range(16 - n_out)
        ]
        whole = np.sum(n_ways * np.exp(-costs[n_out, : 16 - n_out]))
        never = PartsOdds().complete + (1 - PartsOdds().complete) * (1 - 0.5 ** (15 - n_out))
        assert whole == pytest.approx(never)
        assert np.isinf(costs[n_out, 16 - n_out :]).all()


@pytest.mark.parametrize("n_missing", [0, 1, 5])
def test_the_cost_of_missing_labels_is_that_of_all_ways_in_which_they_are_out_of_sight(n_missing):
    shares = np.random.default_rng(n_missing).uniform(size=n_missing)
    costs = hidden_costs(15, PartsOdds())
    total = sum(
        np.prod(np.where(is_out, shares, 1 - shares))
        * np.exp(-costs[sum(is_out), n_missing - sum(is_out)])
        for is_out in product((False, True), repeat=n_missing)
    )
    found = sight.cost_of_sight(shares, costs)
    assert found == pytest.approx(-np.log(total) - costs[0, n_missing], abs=1e-10)


def test_labels_that_are_in_sight_cost_what_they_cost_and_those_that_are_not_nothing():
    costs = hidden_costs(15, PartsOdds())
    assert sight.cost_of_sight(np.zeros(6), costs) == pytest.approx(0.0)
    assert sight.cost_of_sight(np.ones(6), costs) == pytest.approx(costs[6, 0] - costs[0, 6])


@pytest.mark.parametrize("known", [None, 0, 1])
def test_the_points_of_a_limb_are_where_the_known_one_lets_expect_them(known):
    rng = np.random.default_rng(5)
    factors = 0.2 * rng.normal(size=(3, 6, 6)) + 0.3 * np.eye(6)
    covariances = factors @ factors.transpose(0, 2, 1)
    places, weights = rng.normal(size=(3, 6)), np.log([0.2, 0.5, 0.3])
    normals, offsets = random_planes(rng, 1)
    point = rng.normal(size=3)
    pair = np.array([-1, -1])
    if known is not None:
        pair[known] = 0
    shares = sight.limb_out_of_sight(
        point[None], pair, weights, places, covariances, normals, offsets, 0.1
    )
    for d in range(2):
        if d == known:
            assert shares[d] == 0.0
            continue
        mine, other = slice(3 * d, 3 * d + 3), slice(3 - 3 * d, 6 - 3 * d)
        odds, beyond = [], []
        for weight, place, covariance in zip(weights, places, covariances, strict=True):
            mean, spread, likely = place[mine], covariance[mine, mine], np.exp(weight)
            if known is not None:
                gain = covariance[mine, other] @ np.linalg.inv(covariance[other, other])
                mean = mean + gain @ (point - place[other])
                spread = spread - gain @ covariance[other, mine]
                of_point = multivariate_normal(place[other], covariance[other, other])
                likely *= of_point.pdf(point)
            n = normals[0]
            sd = np.sqrt(n @ spread @ n + 0.1**2)
            odds.append(likely)
            beyond.append(norm.cdf((offsets[0] - n @ mean) / sd))
        assert shares[d] == pytest.approx(np.dot(odds, beyond) / np.sum(odds), abs=1e-9)


def test_what_lies_below_the_picture_is_out_of_sight_and_what_lies_in_it_is_not():
    namer = shipped_namer()
    parts = namer._model.parts
    points = np.array([PERSON_M[name] for name in JOINT_NAMES])
    partners = np.arange(15)
    gone = [JOINT_NAMES.index(name) for name in ("left_knee", "left_foot", "right_foot", "neck")]
    partners[gone] = -1
    above_knees = np.array([[0.0, -1.0, 0.0]]), np.array([-0.35])
    odds = expected_odds(parts, np.zeros((11, 15)), "anterior", PartsOdds(), THOROUGH)
    shares = sight._labels_out_of_sight(
        points, partners, parts.core, parts.limbs, odds, *above_knees
    )
    assert (shares[gone[:3]] > 0.9).all()
    assert shares[gone[3]] < 0.01
    assert (np.delete(shares, gone) == 0.0).all()


BAND = ("torso", "left_hip", "right_hip", "left_knee", "right_knee")


def test_a_band_of_neighbouring_markers_gets_its_names_where_the_rest_is_out_of_sight():
    """So few are no plausible person where the others could be seen."""
    points = np.array([PERSON_M[name] for name in BAND]) + np.array([0.0, 0.0, 1.2])
    between = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]), np.array([-0.27, -0.68])
    namer = shipped_namer()
    assert set(namer.label(points, "anterior").names) == {None}
    assert namer.label(points, "anterior", seen=SeenSpace(*between)).names == BAND
    given = ("", "left_hip", "", "", "")
    found = namer.label(points, "anterior", given=given, seen=SeenSpace(*between))
    assert found.names == BAND


LEGS = ("left_hip", "right_hip", "left_knee", "right_knee", "left_foot", "right_foot")
HANDS = ("left_hand", "right_hand")
ARMS = ("left_elbow", "right_elbow", *HANDS)


@pytest.mark.parametrize(
    ("names", "top_m", "bottom_m"),
    [
        (LEGS, 0.0, 1.0),
        ((*LEGS, *HANDS), 0.0, 1.0),
        ((*LEGS[:4], *HANDS), 0.0, 0.68),
        ((*LEGS[:2], *ARMS), -0.14, 0.3),
        (("torso", *LEGS[:4], *ARMS), -0.27, 0.68),
    ],
)
def test_the_hips_are_enough_of_the_trunk_to_name_what_hangs_on_it(names, top_m, bottom_m):
    """Hands and elbows beside them are no shoulders, though these would be more of a trunk."""
    points = np.array([PERSON_M[name] for name in names]) + np.array([0.0, 0.0, 1.2])
    between = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]), np.array([top_m, -bottom_m])
    found = shipped_namer().label(points, "anterior", seen=SeenSpace(*between))
    assert found.names == names


def test_a_space_is_the_same_with_another_origin_and_in_other_axes():
    rng = np.random.default_rng(8)
    space = SeenSpace(*random_planes(rng, 4))
    points, origin = rng.normal(size=(20, 3)), rng.normal(size=3)
    rotation = rotation_from_vector(rng.normal(size=3))
    inside = points @ space.normals.T - space.offsets_m
    moved = space.about(origin)
    np.testing.assert_allclose((points - origin) @ moved.normals.T - moved.offsets_m, inside)
    turned = space.turned(rotation)
    np.testing.assert_allclose((points @ rotation.T) @ turned.normals.T - turned.offsets_m, inside)
    with pytest.raises(ValueError, match="read-only"):
        space.normals[0, 0] = 1.0
    with pytest.raises(ValueError, match="offsets_m"):
        SeenSpace(space.normals, space.offsets_m[:3])


def is_in_picture(points_m, camera):
    lens = camera.intrinsics
    u = lens.fx * points_m[:, 0] / points_m[:, 2] + lens.cx
    v = lens.fy * points_m[:, 1] / points_m[:, 2] + lens.cy
    return (u > -0.5) & (u < camera.width - 0.5) & (v > -0.5) & (v < camera.height - 0.5)


def is_seen(points_m, space):
    return (points_m @ space.normals.T >= space.offsets_m).all(axis=1)


def test_seen_is_what_is_in_the_picture_of_markers_in_the_colour_cameras_axes():
    points_m = np.random.default_rng(9).uniform([-2, -2, 0.8], [2, 2, 4], (4000, 3))
    in_color, in_both = seen_spaces(CALIBRATION)
    of_color = is_in_picture(points_m, COLOR)
    of_depth = is_in_picture(COLOR_FROM_DEPTH.inverse().apply(points_m), DEPTH)
    np.testing.assert_array_equal(is_seen(points_m, in_color), of_color)
    np.testing.assert_array_equal(is_seen(points_m, in_both), of_color & of_depth)
    assert (of_color & ~of_depth).sum() + (of_depth & ~of_color).sum() > 200


def test_a_camera_that_is_not_calibrated_is_taken_to_see_everything():
    in_color, in_both = seen_spaces(RgbdCalibration(depth=DEPTH))
    assert len(in_color.normals) == len(EVERYWHERE.normals) == 0
    assert len(in_both.normals) == 4
    assert len(seen_spaces(RgbdCalibration(color=COLOR))[1].normals) == 4
