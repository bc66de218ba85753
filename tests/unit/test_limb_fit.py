"""Limbs laid into surfaces whose bones are known, with parts that are told apart badly."""

import numpy as np
import pytest

from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES, other_side
from adibas.data.part_cloud import PartCloud
from adibas.skeleton.limb_fit import LimbFitParams, fit_limbs
from adibas.skeleton.limb_start_kernels import limb_points, limb_starts, limb_support

RADIUS_M = LimbFitParams().arm_radius_m
SHOULDER, ELBOW, HAND = (
    JOINT_NAMES.index(f"left_{name}") for name in ("shoulder", "elbow", "hand")
)
PARTS = [BODY_PART_NAMES.index(f"left_{name}") for name in ("upper_arm", "lower_arm", "hand")]


def arm(elbow_m, hand_m, shoulder_m=(0.0, 0.0, 2.0)):
    joints_m = np.full((len(JOINT_NAMES), 3), np.nan)
    joints_m[SHOULDER], joints_m[ELBOW], joints_m[HAND] = shoulder_m, elbow_m, hand_m
    return joints_m


def lengths_of(joints_m):
    lengths_m = np.zeros(len(JOINT_NAMES))
    lengths_m[ELBOW] = np.linalg.norm(joints_m[ELBOW] - joints_m[SHOULDER])
    lengths_m[HAND] = np.linalg.norm(joints_m[HAND] - joints_m[ELBOW])
    return lengths_m


def cloud_of(joints_m, upper_share, rng, n_points=150):
    """Points before the arm; `upper_share` (0 to 1) of each goes to the upper arm, wherever."""
    t = rng.uniform(0, 2, n_points)[:, None]
    upper = joints_m[SHOULDER] + t * (joints_m[ELBOW] - joints_m[SHOULDER])
    lower = joints_m[ELBOW] + (t - 1) * (joints_m[HAND] - joints_m[ELBOW])
    points_m = np.where(t < 1, upper, lower) + rng.normal(0, 0.012, (n_points, 3))
    points_m *= 1 - RADIUS_M / np.linalg.norm(points_m, axis=1, keepdims=True)
    weights = np.zeros((n_points, len(BODY_PART_NAMES)))
    weights[:, PARTS[0]] = 4e-4 * upper_share
    weights[:, PARTS[1]] = 4e-4 * (1 - upper_share)
    return PartCloud(points_m, weights)


NOWHERE = np.full((len(JOINT_NAMES), 3), np.nan)


@pytest.mark.parametrize("upper_share", [0.5, 0.7])
@pytest.mark.parametrize(
    ("elbow_m", "hand_m"),
    [
        ((0.05, 0.28, 2.0), (0.08, 0.53, 1.98)),
        ((0.25, 0.1, 2.0), (0.3, -0.15, 1.95)),
        ((0.1, 0.26, 1.95), (-0.1, 0.2, 1.8)),
    ],
)
def test_an_arm_is_found_though_its_parts_are_not_told_apart(elbow_m, hand_m, upper_share):
    true_m = arm(elbow_m, hand_m)
    cloud = cloud_of(true_m, upper_share, np.random.default_rng(0))
    known_m = true_m.copy()
    known_m[[ELBOW, HAND]] = np.nan
    found_m = fit_limbs(cloud, known_m, NOWHERE, lengths_of(true_m))
    assert np.linalg.norm(found_m[ELBOW] - true_m[ELBOW]) < 0.06
    assert np.linalg.norm(found_m[HAND] - true_m[HAND]) < 0.06


def test_a_hidden_forearm_is_not_invented():
    true_m = arm((0.05, 0.28, 2.0), (0.08, 0.53, 1.98))
    cloud = cloud_of(true_m, 1.0, np.random.default_rng(1))
    upper = cloud.points_m[:, 1] < 0.26
    cloud = PartCloud(cloud.points_m[upper].copy(), cloud.weights_m2[upper].copy())
    known_m = true_m.copy()
    known_m[[ELBOW, HAND]] = np.nan
    found_m = fit_limbs(cloud, known_m, NOWHERE, lengths_of(true_m))
    assert np.isnan(found_m[HAND]).all()


@pytest.mark.parametrize(("lowest_m", "is_seen"), [(0.16, False), (0.24, True)])
def test_an_elbow_that_nothing_was_proposed_for_needs_surface_beside_it(lowest_m, is_seen):
    """As a knee behind the edge of a table: the bone's length alone would put it there."""
    true_m = arm((0.05, 0.28, 2.0), (0.08, 0.53, 1.98))
    cloud = cloud_of(true_m, 1.0, np.random.default_rng(1), n_points=400)
    upper = cloud.points_m[:, 1] < lowest_m
    cloud = PartCloud(cloud.points_m[upper].copy(), cloud.weights_m2[upper].copy())
    known_m = true_m.copy()
    known_m[[ELBOW, HAND]] = np.nan
    for reach_m, expected in ((LimbFitParams().bare_reach_m, is_seen), (0.14, True)):
        params = LimbFitParams(bare_reach_m=reach_m)
        found_m = fit_limbs(cloud, known_m, NOWHERE, lengths_of(true_m), params)
        assert np.isfinite(found_m[ELBOW]).all() == expected


class TestStarts:
    ROOT_M = np.array([0.0, 0.0, 2.0])
    LENGTHS_M = np.array([0.3, 0.25])
    UNKNOWN_M = np.array([[0.0, 0.0, 2.0], [np.nan] * 3, [np.nan] * 3])

    @pytest.fixture
    def points(self):
        """Along an arm that is bent at a right angle, 0.3 and 0.25 m, a point each millimetre."""
        upper = [(0.0, 0.001 * k, 2.0, 1.0) for k in range(1, 300)]
        lower = [(0.001 * k, 0.3, 2.0, 1.0) for k in range(250)]
        return np.array(upper + lower)

    def test_the_first_is_stretched_to_the_middle_of_the_farthest_points(self, points):
        starts_m = limb_starts(points, self.UNKNOWN_M, self.UNKNOWN_M, self.LENGTHS_M)
        far_m = np.linalg.norm(points[:, :3] - self.ROOT_M, axis=1)
        end_m = points[far_m >= np.quantile(far_m, 0.95), :3].mean(axis=0)
        way = (end_m - self.ROOT_M) / np.linalg.norm(end_m - self.ROOT_M)
        np.testing.assert_allclose(
            starts_m[0], self.ROOT_M + np.array([[0.0], [0.3], [0.55]]) * way
        )

    def test_what_is_known_is_another_one_and_the_rest_of_it_stretched(self, points):
        known_m = self.UNKNOWN_M.copy()
        known_m[2] = (0.2, 0.3, 2.0)
        without = limb_starts(points, self.UNKNOWN_M, self.UNKNOWN_M, self.LENGTHS_M)
        starts_m = limb_starts(points, self.UNKNOWN_M, known_m, self.LENGTHS_M)
        assert len(starts_m) == len(without) + 1
        np.testing.assert_array_equal(starts_m[1], [self.ROOT_M, starts_m[0, 1], known_m[2]])

    def test_one_of_the_bent_ones_is_nearly_the_arm(self, points):
        starts_m = limb_starts(points, self.UNKNOWN_M, self.UNKNOWN_M, self.LENGTHS_M)
        arm_m = np.array([self.ROOT_M, (0.0, 0.3, 2.0), (0.25, 0.3, 2.0)])
        gaps_m = np.linalg.norm(starts_m - arm_m, axis=2).max(axis=1)
        assert gaps_m.min() < 0.1

    def test_where_nothing_is_a_bone_away_there_are_no_bent_ones(self, points):
        starts_m = limb_starts(points[:50], self.UNKNOWN_M, self.UNKNOWN_M, self.LENGTHS_M)
        assert len(starts_m) == 1


def test_points_of_a_limb_lie_behind_its_surface_to_the_last_bit():
    rng = np.random.default_rng(4)
    places_m, weights = rng.normal([0, 0, 2], 0.3, (60, 3)), rng.uniform(1e-5, 1e-3, (60, 3))
    total = weights.sum(axis=1)
    points, shares = limb_points(places_m, weights, total, total.mean(), RADIUS_M)
    stretch = 1.0 + RADIUS_M / np.linalg.norm(places_m, axis=1, keepdims=True)
    np.testing.assert_array_equal(points[:, :3], places_m * stretch)
    np.testing.assert_array_equal(points[:, 3], total / total.mean())
    of_part = weights / total[:, None]
    expected = np.column_stack([of_part[:, 0], of_part[:, 1] + of_part[:, 2]])
    np.testing.assert_array_equal(shares, expected)


def test_surface_speaks_for_the_joints_that_it_is_near_to():
    joints_m = np.array([[0.0, 0.0, 2.0], [0.0, 0.3, 2.0], [0.0, 0.6, 2.0]])
    rng = np.random.default_rng(5)
    points = rng.uniform((-0.2, -0.1, 1.9, 0.5), (0.2, 0.8, 2.1, 1.5), (300, 4))
    shares = rng.uniform(size=(300, 2))
    near = [np.linalg.norm(points[:, :3] - joints_m[k], axis=1) < 0.14 for k in (1, 2)]
    to_lower = points[:, :3] - np.clip(points[:, 1, None], 0.3, 0.6) * [0, 1, 0] - [0, 0, 2]
    to_upper = points[:, :3] - np.clip(points[:, 1, None], 0.0, 0.3) * [0, 1, 0] - [0, 0, 2]
    own = np.linalg.norm(to_lower, axis=1) < 0.14
    own &= (np.linalg.norm(to_upper, axis=1) > 0.06) | (shares[:, 1] > shares[:, 0])
    expected = [points[those, 3].sum() for those in (*near, own)]
    np.testing.assert_allclose(limb_support(points, shares, joints_m, 0.14, 0.06), expected)


def test_without_a_shoulder_or_surface_nothing_changes():
    true_m = arm((0.05, 0.28, 2.0), (0.08, 0.53, 1.98))
    cloud = cloud_of(true_m, 0.5, np.random.default_rng(2))
    no_root_m = true_m.copy()
    no_root_m[SHOULDER] = np.nan
    np.testing.assert_array_equal(
        fit_limbs(cloud, no_root_m, NOWHERE, lengths_of(true_m)), no_root_m
    )
    few = PartCloud(cloud.points_m[:5].copy(), cloud.weights_m2[:5].copy())
    np.testing.assert_array_equal(fit_limbs(few, true_m, NOWHERE, lengths_of(true_m)), true_m)


def test_a_cloud_changes_sides_and_back():
    cloud = cloud_of(arm((0, 0.3, 2), (0, 0.5, 2)), 0.3, np.random.default_rng(3))
    swapped = cloud.with_sides_swapped()
    right = BODY_PART_NAMES.index(other_side("left_upper_arm"))
    np.testing.assert_array_equal(swapped.weights_m2[:, right], cloud.weights_m2[:, PARTS[0]])
    again = swapped.with_sides_swapped()
    np.testing.assert_array_equal(again.weights_m2, cloud.weights_m2)
    assert other_side("head") == "head"
    with pytest.raises(ValueError, match="weights_m2 must have shape"):
        PartCloud(np.zeros((2, 3)), np.zeros((3, 15)))
