"""The body that the depth shows tells which marker is which, however many are hidden."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES, mirror_order, other_side
from adibas.data.limbs import FULL_BODY, LimbParts
from adibas.data.markers import Marker
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.quarter_turns import QuarterTurn
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.limbs.around_points import shares_around
from adibas.limbs.judging import judge_mask
from adibas.pipeline.body_marks_file import shipped_marks
from adibas.pipeline.body_marks_training import Example, examples_of, learn_marks
from adibas.pipeline.marked_people import (
    KINDS,
    MARKER_SD_M,
    ON_THIGHS,
    SHOWN_M,
    marked_pictures,
)
from adibas.pipeline.seen_body import body_in, body_odds, see_body, with_body
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.pipeline.skeleton_labelling import shipped_namer
from adibas.pipeline.skeleton_names import upright_turn, with_names
from adibas.pipeline.upright import turned_camera
from adibas.skeleton.body_marks import (
    FOUND_ELSEWHERE,
    LEAST_SHARE,
    N_PARTS,
    OTHER_SIDE,
    PART_WEIGHT,
    ROOM_M3,
    VIEWS,
    BodyMarks,
    ViewMarks,
    mark_log_odds,
    marks_from_json,
    marks_to_json,
)
from adibas.skeleton.given_names import nothing_given
from adibas.skeleton.known import Known

SEED = 6021
"""Of people that nothing was learned from."""
N = len(JOINT_NAMES)
COLOR_FROM_DEPTH = RigidTransform(
    rotation_from_vector(np.array([0.03, -0.05, 0.02])), np.array([0.025, -0.004, 0.002])
)


def some_marks(seed=1):
    rng = np.random.default_rng(seed)
    roots = rng.normal(scale=0.03, size=(N, 3, 3))
    covariances_m2 = roots @ roots.transpose(0, 2, 1) + 4e-4 * np.eye(3)
    return ViewMarks(
        rng.normal(scale=0.05, size=(N, 3)), covariances_m2, rng.normal(size=(N, N_PARTS))
    )


def some_points(seed=2, n_points=6):
    rng = np.random.default_rng(seed)
    joints_m = rng.normal(scale=0.4, size=(N, 3))
    points_m = joints_m[:n_points] + rng.normal(scale=0.1, size=(n_points, 3))
    return points_m, joints_m, rng.dirichlet(np.ones(N_PARTS), n_points)


@pytest.fixture(scope="module")
def pictures():
    return tuple(marked_pictures(SEED, 40))


def test_odds_are_those_of_a_normal_distribution_that_may_be_elsewhere_and_of_parts():
    marks = some_marks()
    points_m, joints_m, shares = some_points()
    odds = mark_log_odds(marks, points_m, joints_m, shares)
    likely = np.empty((len(points_m), N))
    for m, point_m in enumerate(points_m):
        for n, joint_m in enumerate(joints_m):
            there = multivariate_normal(joint_m + marks.offsets_m[n], marks.covariances_m2[n])
            by_joint = (1 - FOUND_ELSEWHERE) * there.pdf(point_m) * ROOM_M3 + FOUND_ELSEWHERE
            by_parts = shares[m] @ np.exp(marks.part_odds[n])
            likely[m, n] = by_joint * max(by_parts, LEAST_SHARE) ** PART_WEIGHT
    for n, name in enumerate(JOINT_NAMES):
        other = JOINT_NAMES.index(other_side(name))
        expected = (1 - OTHER_SIDE) * likely[:, n] + OTHER_SIDE * likely[:, other]
        np.testing.assert_allclose(odds[:, n], np.log(expected))


def test_what_is_not_seen_tells_nothing():
    points_m, joints_m, shares = some_points()
    head = JOINT_NAMES.index("head")
    joints_m[head], shares[2] = np.nan, np.nan
    odds = mark_log_odds(some_marks(), points_m, joints_m, shares)
    assert odds[2, head] == pytest.approx(0.0, abs=1e-12)
    assert np.isfinite(odds).all()
    assert np.count_nonzero(np.abs(odds) > 1e-9) == odds.size - 1


def test_the_mirror_image_of_a_body_has_the_mirror_images_odds():
    marks, across = some_marks(), np.array([-1.0, 1.0, 1.0])
    points_m, joints_m, shares = some_points()
    joints, parts = mirror_order(JOINT_NAMES), [*mirror_order(BODY_PART_NAMES), N_PARTS - 1]
    mirrored = mark_log_odds(
        marks.mirrored(), points_m * across, joints_m[joints] * across, shares[:, parts]
    )
    np.testing.assert_allclose(
        mirrored[:, joints], mark_log_odds(marks, points_m, joints_m, shares), atol=1e-12
    )


def test_the_left_side_is_the_mirror_image_of_the_right_one():
    marks = BodyMarks(dict(zip(VIEWS, map(some_marks, range(3)), strict=True)))
    right, left = marks.of_view("right_lateral"), marks.of_view("left_lateral")
    hand, other = JOINT_NAMES.index("left_hand"), JOINT_NAMES.index("right_hand")
    np.testing.assert_array_equal(left.offsets_m[hand], right.offsets_m[other] * [-1, 1, 1])
    assert marks.of_view("posterior") is marks.views["posterior"]


def test_shares_are_of_the_pixels_that_are_near_in_the_picture_and_in_depth():
    focal_px, depth_m = 500.0, np.full((40, 40), 2.0, np.float32)
    depth_m[:, 20:] = 2.5
    mask = np.zeros((40, 40), bool)
    mask[::2, ::2] = True
    mask[:10] = False
    rng = np.random.default_rng(5)
    said = 0.9 * rng.dirichlet(np.ones(len(FULL_BODY)), np.count_nonzero(mask)).astype(np.float32)
    parts = LimbParts(FULL_BODY, mask, said, np.full((40, 40), -1, np.int16))
    uv = np.array([[19.0, 25.0], [12.0, 2.0], [np.nan, np.nan]])
    points_m = np.array([[0.0, 0.0, 2.02], [0.0, 0.0, 2.0], [0.0, 0.0, 2.0]])
    shares = shares_around(parts, depth_m, points_m, uv, focal_px)
    rows, columns = np.nonzero(mask)
    near = [
        i
        for i, (row, column) in enumerate(zip(rows, columns, strict=True))
        if (row - 25.0) ** 2 + (column - 19.0) ** 2 < (0.025 / 2.02 * focal_px) ** 2 and column < 20
    ]
    assert 0 < len(near) < 30
    np.testing.assert_allclose(shares[0, :-1], said[near].mean(axis=0), rtol=1e-5)
    assert shares[0].sum() == pytest.approx(1.0)
    assert shares[0, -1] == pytest.approx(0.1, abs=1e-5)
    assert np.isnan(shares[1:]).all()


def test_probabilities_of_names_follow_bayes():
    masses = np.array([[0.6, 0.1, 0.3], [0.0, 0.5, 0.5]])
    known = Known(np.log([3.0, 0.25]), nothing_given(2))
    weighed = known.weighed(masses)
    np.testing.assert_allclose(weighed[0], np.array([1.8, 0.3, 0.3]) / 2.4)
    np.testing.assert_allclose(weighed[1], [0.0, 0.2, 0.8])
    with_body = replace(known, body_odds=np.log([[1.0, 6.0], [1.0, 4.0]]))
    weighed = with_body.weighed(masses)
    np.testing.assert_allclose(weighed[0], np.array([1.8, 1.8, 0.3]) / 3.9)
    np.testing.assert_allclose(weighed[1], [0.0, 0.5, 0.5])


def test_a_way_has_the_odds_of_its_points():
    rng = np.random.default_rng(4)
    known = Known(rng.normal(size=5), nothing_given(5), body_odds=rng.normal(size=(5, 3)))
    partners = np.array([[0, 4, 2], [3, -1, 1], [-1, -1, -1]])
    of_sizes, of_body = known.size_odds_of(partners), known.body_odds_of(partners)
    for way, by_size, by_body in zip(partners, of_sizes, of_body, strict=True):
        named = [(m, n) for n, m in enumerate(way) if m >= 0]
        assert by_size == pytest.approx(sum(known.size_odds[m] for m, _n in named))
        assert by_body == pytest.approx(sum(known.body_odds[m, n] for m, n in named))


def test_marks_come_back_from_their_file_and_others_are_refused():
    marks = BodyMarks({view: some_marks(i) for i, view in enumerate(VIEWS)}, {"seed": 3})
    document = json.loads(json.dumps(marks_to_json(marks)))
    again = marks_from_json(document)
    assert again.provenance == {"seed": 3}
    for view in VIEWS:
        for name in ViewMarks.__slots__:
            np.testing.assert_array_equal(
                getattr(again.views[view], name), getattr(marks.views[view], name)
            )
    for change in (
        {"joints": JOINT_NAMES[::-1]},
        {"parts": BODY_PART_NAMES[1:]},
        {"version": 2},
    ):
        with pytest.raises(ValueError, match=r"joints|version"):
            marks_from_json({**document, **change})
    document["views"]["lateral"]["covariances_m2"][4] = (-np.eye(3)).tolist()
    with pytest.raises(ValueError, match="positive definite"):
        marks_from_json(document)


def test_the_shipped_marks_were_learned_with_the_shipped_limbs():
    assert shipped_model().is_made(shipped_marks().provenance["limbs_created_utc"])


def test_what_is_learned_is_where_markers_are_and_not_where_joints_were_found_wrongly():
    rng = np.random.default_rng(8)
    n, whole = 4000, rng.dirichlet(np.ones(N_PARTS))
    mean_m, root = np.array([0.02, -0.05, -0.06]), rng.normal(scale=0.02, size=(3, 3))
    offsets_m = mean_m + rng.normal(size=(n, 3)) @ root.T
    offsets_m[:200] = rng.uniform(-1.0, 1.0, (200, 3))
    offsets_m[200:240] = np.nan
    shares = rng.dirichlet(np.ones(N_PARTS), n)
    shares[:50] = np.nan
    examples = [
        Example(view, np.full(n, joint), offsets_m, shares, whole)
        for view in VIEWS
        for joint in range(N)
    ]
    learned = learn_marks(examples, {}).of_view("anterior")
    np.testing.assert_allclose(learned.offsets_m, np.tile(mean_m, (N, 1)), atol=0.003)
    spread = root @ root.T + 1e-4 * np.eye(3)
    np.testing.assert_allclose(learned.covariances_m2[7], spread, atol=0.1 * spread.max())
    expected = np.log(np.nanmean(shares, axis=0) / whole)
    np.testing.assert_allclose(learned.part_odds[2], expected, atol=1e-3)


def test_markers_of_simulated_people_lie_where_the_picture_shows_the_body(pictures):
    assert {one.kind for one in pictures} == set(KINDS)
    off_m, is_body = [], []
    for one in pictures:
        assert len(set(one.names)) == len(one.names) == len(one.points_m)
        assert set(one.names) <= set(JOINT_NAMES)
        lens, (x, y, z) = one.camera.intrinsics, one.points_m.T
        columns = np.rint(lens.fx * x / z + lens.cx).astype(int)
        rows = np.rint(lens.fy * y / z + lens.cy).astype(int)
        off_m.extend(np.abs(one.depth_m[rows, columns] - z))
        is_body.extend(one.mask[rows, columns])
    # A hand is off by a pixel, so that some markers at an outline lie beside it.
    assert np.mean(np.array(off_m) < SHOWN_M + 3 * MARKER_SD_M) > 0.87
    assert np.mean(is_body) > 0.93
    again = next(marked_pictures(SEED, 8, first=7))
    np.testing.assert_array_equal(again.points_m, pictures[7].points_m)


def test_hands_on_thighs_are_hidden_by_nothing_and_lie_between_hip_and_knee(pictures):
    fronts = [one for one in pictures if one.kind == ON_THIGHS and one.view == "anterior"]
    assert fronts
    for one in fronts:
        places = dict(zip(one.names, one.points_m, strict=True))
        for side in ("left", "right"):
            if f"{side}_hand" in places and f"{side}_knee" in places:
                off_m = places[f"{side}_hand"] - places[f"{side}_knee"]
                assert np.linalg.norm(off_m) < 0.45


def calibration_of(picture, camera=None, up=None):
    color = CameraCalibration(1280, 1024, Intrinsics(1050.0, 1050.0, 639.5, 511.5))
    return RgbdCalibration(
        color=color,
        depth=camera or picture.camera,
        color_from_depth=COLOR_FROM_DEPTH,
        gravity=-(picture.up if up is None else up),
        gravity_sd_rad=0.01,
    )


def markers_of(points_m):
    return tuple(
        Marker(f"m{i:02d}", 0.0, 0.0, 4.0, np.eye(2), one.copy(), 1e-6 * np.eye(3))
        for i, one in enumerate(COLOR_FROM_DEPTH.apply(points_m), 1)
    )


def labels_of(namer, picture, calibration):
    markers = with_names(namer, markers_of(picture.points_m), picture.view, calibration)
    return tuple(one.label for one in markers)


def found_by(picture):
    """Return a picture's namer of upright points, or None."""
    body = body_in(picture.depth_m, picture.mask, picture.view, picture.camera)
    if body is None:
        return None
    turn = RigidTransform(upright_turn(picture.up), np.zeros(3))
    return shipped_namer().holding_still().who_sees(body_odds(body, picture.view, turn))


def test_more_people_who_sit_are_named_right_and_fewer_wrongly_where_their_body_is_known():
    alone, known = [], []
    for picture in marked_pictures(SEED, 160):
        namer = found_by(picture)
        if namer is None or picture.kind not in ("seated", ON_THIGHS):
            continue
        points_m = picture.points_m @ upright_turn(picture.up).T
        for counted, one in ((alone, shipped_namer().holding_still()), (known, namer)):
            names = one.label(points_m, picture.view).names
            pairs = list(zip(names, picture.names, strict=True))
            counted.append(
                [all(a == b for a, b in pairs), any(a not in (None, b) for a, b in pairs)]
            )
    n_right, n_wrong = np.sum(known, axis=0)
    n_right_alone, n_wrong_alone = np.sum(alone, axis=0)
    assert n_right > n_right_alone + 5
    assert n_wrong < 0.6 * n_wrong_alone


def test_the_body_tells_the_same_of_markers_in_colour_axes_as_in_the_depth_cameras(pictures):
    """Both cameras look the same way: about the vertical their upright axes would differ."""
    rotation = rotation_from_vector(np.array([0.04, 0.0, 0.02]))
    color_from_depth = RigidTransform(rotation, np.array([0.3, -0.1, 0.05]))
    picture = next(one for one in pictures if one.view == "anterior" and found_by(one) is not None)
    calibration = replace(calibration_of(picture), color_from_depth=color_from_depth)
    namer, view = shipped_namer(), picture.view
    from_color = with_body(namer, picture.depth_m, view, calibration)._body_odds
    body = see_body(picture.depth_m, view, calibration)
    upright = RigidTransform(upright_turn(picture.up), np.zeros(3))
    points_m, up = picture.points_m, rotation @ picture.up
    shares = body.shares_around(points_m)
    assert not np.isnan(shares).any()
    marks, joints_m = shipped_marks().of_view(view), upright.apply(body.joints_m)
    expected = mark_log_odds(marks, upright.apply(points_m), joints_m, shares)
    from_depth = body_odds(body, view, upright)
    np.testing.assert_allclose(from_depth(upright.apply(points_m)), expected, atol=1e-6)
    in_color_m = color_from_depth.apply(points_m) @ upright_turn(up).T
    np.testing.assert_allclose(from_color(in_color_m), expected, atol=0.1)
    assert np.ptp(expected) > 5.0


def test_markers_are_named_with_the_body_of_their_capture(pictures):
    n_named = n_markers = 0
    for picture in pictures[:16]:
        calibration = calibration_of(picture)
        namer = with_body(shipped_namer(), picture.depth_m, picture.view, calibration)
        names = labels_of(namer, picture, calibration)
        n_named += sum(name == own for name, own in zip(names, picture.names, strict=True))
        n_markers += len(names)
    assert n_named > 0.7 * n_markers


def test_a_sensor_on_its_side_tells_the_same(pictures):
    picture = next(one for one in pictures if found_by(one) is not None)
    upright = see_body(picture.depth_m, picture.view, calibration_of(picture))
    turn = QuarterTurn(1)
    camera = turned_camera(picture.camera, turn)
    on_side = see_body(
        turn.picture(picture.depth_m),
        picture.view,
        calibration_of(picture, camera, turn.points(picture.up)),
    )
    np.testing.assert_allclose(on_side.joints_m, turn.points(upright.joints_m), atol=1e-6)
    np.testing.assert_allclose(
        on_side.shares_around(turn.points(picture.points_m)),
        upright.shares_around(picture.points_m),
        atol=1e-6,
    )


def test_the_back_has_left_and_right_as_it_is_declared(pictures):
    picture = next(
        one
        for one in pictures
        if one.view == "posterior" and one.kind == "standing" and found_by(one) is not None
    )
    body = body_in(picture.depth_m, picture.mask, "posterior", picture.camera)
    left, right = (body.joints_m[JOINT_NAMES.index(f"{s}_shoulder")] for s in ("left", "right"))
    assert left[0] < right[0]
    rows, columns = np.nonzero(body.parts.of("left_upper_leg"))
    assert columns.mean() < np.nonzero(body.parts.of("right_upper_leg"))[1].mean()
    assert len(rows)


def test_nothing_is_known_of_nobody_of_no_view_and_of_other_landmarks(pictures):
    picture = next(one for one in pictures if found_by(one) is not None)
    namer, calibration = shipped_namer(), calibration_of(picture)
    wall = np.full_like(picture.depth_m, 3.0)
    assert with_body(namer, wall, "anterior", calibration) is namer
    assert with_body(namer, picture.depth_m, "", calibration) is namer
    nothing = np.full_like(picture.depth_m, np.nan)
    assert with_body(namer, nothing, "anterior", calibration) is namer
    assert with_body(namer, picture.depth_m, "anterior", calibration) is not namer


def test_a_body_in_dark_clothes_is_found_as_well(pictures):
    """Two of five pixels have no depth, which is too little for a skeleton, not to tell markers."""
    picture = next(one for one in pictures if one.view == "anterior" and found_by(one) is not None)
    depth_m = picture.depth_m.copy()
    depth_m[picture.mask & (np.random.default_rng(4).random(depth_m.shape) < 0.4)] = np.nan
    assert not judge_mask(depth_m, picture.mask).is_person
    found = body_in(depth_m, picture.mask, picture.view, picture.camera)
    whole = body_in(picture.depth_m, picture.mask, picture.view, picture.camera)
    off_m = np.linalg.norm(found.joints_m - whole.joints_m, axis=1)
    assert np.nanmedian(off_m) < 0.03
    assert np.isfinite(found.joints_m).all(axis=1).sum() >= 12


def test_half_of_what_teaches_is_the_mirror_image(pictures):
    fronts = [one for one in pictures if one.view == "anterior"]
    first, second = tuple(examples_of(fronts))[:2]
    np.testing.assert_array_equal(first.mirrored().joints, second.joints)
    np.testing.assert_array_equal(first.offsets_m * [-1, 1, 1], second.offsets_m)
