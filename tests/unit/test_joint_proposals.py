"""Modes of parts against closed forms, and joints of simulated people whose parts are known."""

import numpy as np
import pytest

from adibas.body.rays import viewing_rays
from adibas.data.calibration import CameraCalibration
from adibas.data.joint_proposals import JointProposals
from adibas.data.joints import JOINT_NAMES
from adibas.data.limbs import FULL_BODY, NO_LABEL, UPPER_BODY, LimbParts
from adibas.errors import LimbError
from adibas.geometry.pinhole import Intrinsics
from adibas.limbs.joint_offsets import (
    JointOffsets,
    OffsetExample,
    learn_offset,
    offsets_from_json,
    offsets_to_json,
)
from adibas.limbs.joint_places import PLACES
from adibas.limbs.mean_shift_kernels import find_modes, find_modes_of_joints
from adibas.limbs.proposals import PartPoints, part_points, propose_joints
from adibas.pipeline.pose_model import shipped_joint_model

CAMERA = CameraCalibration(160, 120, Intrinsics(140.0, 140.0, 79.5, 59.5))
NOTHING = np.empty((0, 4))


def cloud(rng, middle_m, n_points=400, spread_m=0.03):
    points = rng.normal(middle_m, spread_m, (n_points, 3))
    return np.column_stack([points, np.full(n_points, 1e-4)])


def square_of_hand(z_m=2.0, probability=1.0, pixels=None):
    """A hand of 7 x 7 pixels (10 cm) about the middle of the image, everything else torso."""
    depth_m = np.full((120, 160), z_m, np.float32)
    chosen = np.full(depth_m.shape, NO_LABEL, np.int16)
    chosen[20:110, 20:140] = FULL_BODY.names.index("torso")
    hand = FULL_BODY.names.index("left_hand")
    chosen[56:63, 76:83] = hand
    pixels = chosen >= 0 if pixels is None else pixels & (chosen >= 0)
    rows = np.zeros((int(pixels.sum()), len(FULL_BODY)), np.float32)
    rows[np.arange(len(rows)), chosen[pixels]] = probability
    return depth_m, LimbParts(FULL_BODY, pixels, rows, chosen)


def test_the_mode_of_a_round_cloud_is_its_middle():
    middle_m = np.array([0.2, -0.1, 2.0])
    modes = np.empty((2, 4))
    find_modes(cloud(np.random.default_rng(0), middle_m), NOTHING, 0.1, modes)
    assert np.linalg.norm(modes[0, :3] - middle_m) < 0.008
    assert modes[0, 3] > 0


def test_two_clouds_have_two_modes_the_heavier_first():
    rng = np.random.default_rng(1)
    light, heavy = np.array([0.0, 0.0, 2.0]), np.array([0.4, 0.0, 2.0])
    points = np.concatenate([cloud(rng, light, 150), cloud(rng, heavy, 450)])
    modes = np.empty((3, 4))
    find_modes(points, NOTHING, 0.1, modes)
    assert np.linalg.norm(modes[0, :3] - heavy) < 0.01
    assert np.linalg.norm(modes[1, :3] - light) < 0.01
    assert modes[0, 3] / modes[1, 3] == pytest.approx(3.0, rel=0.15)


def test_the_mode_of_a_pair_is_where_both_meet():
    x = np.linspace(-0.3, 0.3, 121)
    line = np.column_stack([x, np.zeros_like(x), np.full_like(x, 2.0), np.full_like(x, 1e-4)])
    modes = np.empty((1, 4))
    find_modes(line[:60].copy(), line[61:].copy(), 0.08, modes)
    np.testing.assert_allclose(modes[0, :3], [0.0, 0.0, 2.0], atol=1e-3)


def test_parts_that_do_not_meet_have_no_mode_between():
    rng = np.random.default_rng(2)
    modes = np.empty((1, 4))
    find_modes(cloud(rng, [0, 0, 2.0]), cloud(rng, [1.0, 0, 2.0]), 0.08, modes)
    assert np.isnan(modes[0, :3]).all()
    assert modes[0, 3] == 0


def test_no_points_have_no_mode():
    modes = np.empty((1, 4))
    find_modes(NOTHING, NOTHING, 0.08, modes)
    assert np.isnan(modes[0, :3]).all()


def test_all_joints_at_once_have_the_modes_that_each_has_alone():
    rng = np.random.default_rng(3)
    middles_m = rng.uniform(-0.1, 0.1, (5, 3)) + np.array([0, 0, 2.0])
    clouds = [cloud(rng, middle_m, 40 * number) for number, middle_m in enumerate(middles_m)]
    starts = np.cumsum([0, *map(len, clouds)])
    pairs, widths_m = np.array([[1, -1], [2, 3], [0, 4], [4, -1], [3, 0]]), np.full(5, 0.1)
    found = find_modes_of_joints(np.concatenate(clouds), starts, pairs, widths_m, 2)
    for modes, (one, other) in zip(found, pairs, strict=True):
        alone = np.empty((2, 4))
        find_modes(clouds[one], clouds[other] if other >= 0 else NOTHING, 0.1, alone)
        np.testing.assert_array_equal(modes, alone)
    assert np.isfinite(found[[0, 1, 3, 4], 0]).all()
    assert np.isnan(found[2, :, :3]).all()


def test_weights_add_up_to_the_surface_of_the_part():
    depth_m, parts = square_of_hand()
    points = part_points(depth_m, parts, viewing_rays(CAMERA))
    wanted_m2 = 7 * 7 * (2.0 / 140.0) ** 2
    assert points.of("left_hand")[:, 3].sum() == pytest.approx(wanted_m2, rel=1e-5)


def test_the_middle_of_a_part_is_its_weighted_mean():
    rng = np.random.default_rng(5)
    starts = np.array([0, 4, 4, 9])
    points = np.column_stack([rng.normal(0, 1, (9, 3)), rng.uniform(0.1, 2.0, 9)])
    found = PartPoints(("a", "b", "c"), points, starts, np.empty((0, 3, 4))).middles_m()
    assert set(found) == {"a", "c"}
    for name, rows in (("a", points[:4]), ("c", points[4:])):
        wanted = np.average(rows[:, :3], axis=0, weights=rows[:, 3])
        np.testing.assert_allclose(found[name], wanted, rtol=1e-12)


def test_squares_are_the_sums_of_their_pixels():
    rng = np.random.default_rng(6)
    pixels = rng.random((120, 160)) < 0.3
    pixels[:, 90:] = False
    rows = rng.dirichlet(np.ones(15), int(pixels.sum())).astype(np.float32)
    chosen = np.where(pixels, rng.integers(0, 15, pixels.shape), NO_LABEL).astype(np.int16)
    depth_m = rng.uniform(1.9, 2.1, pixels.shape).astype(np.float32)
    depth_m[rng.random(pixels.shape) < 0.1] = np.nan
    points = part_points(depth_m, LimbParts(FULL_BODY, pixels, rows, chosen), viewing_rays(CAMERA))
    weights = 0.5 * rows + 0.5 * (chosen[pixels][:, None] == np.arange(15))
    depths_m = np.nan_to_num(depth_m[pixels])
    weights = weights * (depths_m / 140.0)[:, None] ** 2
    of_square = np.ravel_multi_index(np.argwhere(pixels).T // 2, (60, 80))
    squares, first, number = np.unique(of_square, return_index=True, return_inverse=True)
    expected = np.zeros((len(squares), 15))
    np.add.at(expected, number, weights)
    np.testing.assert_allclose(
        points.cells[:, :, 3], expected[np.argsort(first)], rtol=1e-5, atol=1e-12
    )
    found = points.cloud()
    used = expected[np.argsort(first)].sum(axis=1) > 0
    np.testing.assert_array_equal(found.weights_m2, points.cells[used, :, 3])
    of_all = points.cells[used].sum(axis=1)
    np.testing.assert_array_equal(found.points_m, of_all[:, :3] / of_all[:, 3:])


def test_every_second_pixel_gives_the_same_surface():
    every = np.zeros((120, 160), np.bool_)
    every[::2, ::2] = True
    depth_m, parts = square_of_hand(pixels=every)
    points = part_points(depth_m, parts, viewing_rays(CAMERA))
    wanted_m2 = 7 * 7 * (2.0 / 140.0) ** 2
    assert points.of("left_hand")[:, 3].sum() == pytest.approx(wanted_m2, rel=0.4)


def test_pixels_without_depth_count_for_nothing():
    depth_m, parts = square_of_hand()
    depth_m[56:63, 76:83] = np.nan
    points = part_points(depth_m, parts, viewing_rays(CAMERA))
    assert len(points.of("left_hand")) == 0
    proposals = propose_joints(points, shipped_joint_model().offsets)
    assert np.isnan(proposals.positions_m[JOINT_NAMES.index("left_hand")]).all()


def test_a_hand_lies_behind_its_surface_and_what_is_not_there_has_no_place():
    depth_m, parts = square_of_hand()
    points = part_points(depth_m, parts, viewing_rays(CAMERA))
    proposals = propose_joints(points, shipped_joint_model().offsets)
    hand_m = proposals.positions_m[JOINT_NAMES.index("left_hand"), 0]
    assert 2.0 < hand_m[2] < 2.05
    assert np.abs(hand_m[:2]).max() < 0.02
    for name in ("head", "right_hand", "left_knee"):
        at = JOINT_NAMES.index(name)
        assert np.isnan(proposals.positions_m[at]).all()
        assert (proposals.weights_m2[at] == 0).all()


def test_an_empty_mask_proposes_nothing():
    depth_m, parts = square_of_hand(pixels=np.zeros((120, 160), np.bool_))
    empty = LimbParts(
        FULL_BODY, parts.pixels, parts.probabilities, np.full((120, 160), NO_LABEL, np.int16)
    )
    points = part_points(depth_m, empty, viewing_rays(CAMERA))
    assert np.isnan(propose_joints(points, shipped_joint_model().offsets).positions_m).all()


def test_a_model_for_the_upper_body_is_refused_in_words():
    pixels = np.zeros((120, 160), np.bool_)
    parts = LimbParts(
        UPPER_BODY, pixels, np.zeros((0, 7), np.float32), np.full(pixels.shape, NO_LABEL, np.int16)
    )
    points = part_points(np.ones(pixels.shape, np.float32), parts, viewing_rays(CAMERA))
    with pytest.raises(LimbError, match="full body"):
        propose_joints(points, shipped_joint_model().offsets)


def test_offsets_are_learned_exactly_from_exact_examples():
    rng = np.random.default_rng(3)
    place = next(place for place in PLACES if place.joint == "left_elbow")
    examples = []
    for _number in range(40):
        mode_m = rng.normal([0, 0, 2.0], 0.3)
        middles_m = {name: mode_m + rng.normal(0, 0.2, 3) for name in place.neighbors}
        ways = [middles_m[name] - mode_m for name in place.neighbors]
        joint_m = mode_m + 0.05 * mode_m / np.linalg.norm(mode_m) + 0.3 * ways[0] - 0.2 * ways[1]
        examples.append(OffsetExample(place, mode_m, joint_m, middles_m))
    learned = learn_offset(examples)
    assert learned.push_m == pytest.approx(0.05)
    assert learned.shares == pytest.approx((0.3, -0.2))
    offsets = JointOffsets({"elbow": learned})
    one = examples[0]
    found_m = offsets.joints_m(place, one.mode_m[None], one.middles_m)
    np.testing.assert_allclose(found_m[0], one.joint_m, atol=1e-9)
    bare_m = offsets.joints_m(place, one.mode_m[None], {})
    assert np.linalg.norm(bare_m[0] - one.mode_m) == pytest.approx(abs(learned.bare_push_m))


def test_examples_without_neighbours_teach_the_way_back_alone():
    place = PLACES[0]
    mode_m = np.array([0.0, 0.0, 2.0])
    example = OffsetExample(place, mode_m, mode_m + np.array([0, 0, 0.07]), {})
    learned = learn_offset([example, example, example])
    assert learned.bare_push_m == pytest.approx(0.07)
    assert learned.shares == ()


def test_offsets_survive_their_file():
    offsets = shipped_joint_model().offsets
    again = offsets_from_json(offsets_to_json(offsets))
    assert again.of_kind == offsets.of_kind
    with pytest.raises(ValueError, match="no adibas-joint-offsets"):
        offsets_from_json({"format": "another"})


def test_proposals_must_have_a_place_for_each_joint():
    with pytest.raises(ValueError, match="positions_m must have shape"):
        JointProposals(np.zeros((3, 2, 3)), np.zeros((3, 2)))
