"""Pose and depth error of a depth camera from boards and walls."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from adibas.calibration.extrinsics import DepthFitParams, DepthStart, fit_depth
from adibas.calibration.extrinsics_model import (
    DepthState,
    bias_numbers,
    board_rows,
    moved_bias,
    wall_rows,
    with_terms,
)
from adibas.calibration.extrinsics_pose import find_pose
from adibas.calibration.extrinsics_start import start_extrinsics
from adibas.calibration.shots import BoardShot, moved_plane, plane_of
from adibas.data.board import Board, BoardCorners
from adibas.data.calibration import DepthBias
from adibas.geometry.rigid import RigidTransform, rotation_from_vector, rotation_vector
from tests.unit.depth_shots import (
    BIAS,
    BOARD,
    COLOR,
    COLOR_FROM_DEPTH,
    DEPTH,
    board_shot,
    board_view,
    corners_of,
    random_pose,
    wall_shot,
)

RNG = np.random.default_rng
START = DepthStart(DEPTH)
NO_PRIOR = DepthFitParams(offset_sd_m=1e3, factor_sd=1e3, square_sd_per_m=1e3, image_sd_per_m=1e3)


def errors(fit):
    turn = fit.color_from_depth.rotation @ COLOR_FROM_DEPTH.rotation.T
    shift_m = fit.color_from_depth.translation_m - COLOR_FROM_DEPTH.translation_m
    return np.concatenate(
        [rotation_vector(turn), shift_m, bias_numbers(fit.bias) - bias_numbers(BIAS)]
    )


def test_pose_of_exact_corners_is_exact():
    rng = RNG(1)
    for _ in range(5):
        true = random_pose(rng)
        found = find_pose(corners_of(true, rng, 0.0), BOARD, COLOR).camera_from_board
        np.testing.assert_allclose(found.rotation, true.rotation, atol=1e-9)
        np.testing.assert_allclose(found.translation_m, true.translation_m, atol=1e-9)


def test_pose_is_that_of_opencv():
    rng = RNG(2)
    corners = corners_of(random_pose(rng), rng, 0.3)
    found = find_pose(corners, BOARD, COLOR).camera_from_board
    _, turn, shift = cv2.solvePnP(
        BOARD.points_m(),
        corners.pixels,
        COLOR.intrinsics.matrix(),
        np.array(COLOR.distortion),
        flags=cv2.SOLVEPNP_ITERATIVE,
    )
    np.testing.assert_allclose(rotation_vector(found.rotation), turn[:, 0], atol=1e-6)
    np.testing.assert_allclose(found.translation_m, shift[:, 0], atol=1e-6)


def test_covariance_of_a_pose_is_its_scatter():
    rng = RNG(3)
    true = random_pose(rng)
    poses = [find_pose(corners_of(true, rng, 0.1), BOARD, COLOR) for _ in range(300)]
    moves = [
        np.concatenate(
            [
                rotation_vector(pose.camera_from_board.rotation @ true.rotation.T),
                pose.camera_from_board.translation_m - true.translation_m,
            ]
        )
        for pose in poses
    ]
    squares = [m @ np.linalg.inv(p.covariance) @ m for m, p in zip(moves, poses, strict=True)]
    assert np.mean(squares) == pytest.approx(6.0, rel=0.1)
    assert np.mean([pose.squares / pose.n_degrees for pose in poses]) == pytest.approx(1, rel=0.05)


def test_a_pose_goes_with_the_camera_as_its_derivatives_say():
    rng = RNG(4)
    corners = corners_of(random_pose(rng), rng, 0.0)
    before = find_pose(corners, BOARD, COLOR)
    for index, name, step in ((0, "fx", 0.1), (1, "fy", 0.1), (3, "cy", 0.1), (5, "k1", 1e-4)):
        if name == "k1":
            moved = replace(COLOR, distortion=(COLOR.distortion[0] + step, *COLOR.distortion[1:]))
        else:
            k = COLOR.intrinsics
            moved = replace(COLOR, intrinsics=replace(k, **{name: getattr(k, name) + step}))
        after = find_pose(corners, BOARD, moved).camera_from_board
        found = np.concatenate(
            [
                rotation_vector(after.rotation @ before.camera_from_board.rotation.T),
                after.translation_m - before.camera_from_board.translation_m,
            ]
        )
        expected = before.by_camera[:, index] * step
        np.testing.assert_allclose(found, expected, atol=0.01 * np.abs(expected).max())


def test_a_small_far_board_that_two_poses_fit_has_none():
    far = Board(4, 3, 0.03)
    rotation = rotation_from_vector(np.array([0.0, 0.35, 0.0]))
    pose = RigidTransform(rotation, np.array([0.1, 0.1, 4.0]))
    rng = RNG(5)
    assert find_pose(corners_of(pose, rng, 0.2, board=far), far, COLOR) is None
    near = RigidTransform(rotation, np.array([0.0, 0.0, 0.5]))
    assert find_pose(corners_of(near, rng, 0.05, board=far), far, COLOR) is not None


def test_a_wrong_corner_takes_no_part_in_the_pose():
    rng = RNG(6)
    true = random_pose(rng)
    corners = corners_of(true, rng, 0.05)
    pixels = corners.pixels.copy()
    pixels[17] += 3.0
    wrong = BoardCorners("wrong", COLOR.width, COLOR.height, pixels, corners.sigma_px.copy())
    found, clean = find_pose(wrong, BOARD, COLOR), find_pose(corners, BOARD, COLOR)
    assert found.n_degrees == clean.n_degrees - 2
    shift_m = found.camera_from_board.translation_m - clean.camera_from_board.translation_m
    assert np.abs(shift_m).max() < 0.001


@pytest.mark.parametrize("seen", [range(5), range(10)])
def test_few_corners_or_a_line_of_them_have_no_pose(seen):
    rng = RNG(7)
    corners = corners_of(random_pose(rng), rng, 0.0)
    pixels, sigmas = np.full_like(corners.pixels, np.nan), np.full(BOARD.n_corners, np.nan)
    pixels[list(seen)], sigmas[list(seen)] = corners.pixels[list(seen)], 0.05
    hidden = BoardCorners("part", COLOR.width, COLOR.height, pixels, sigmas)
    assert find_pose(hidden, BOARD, COLOR) is None


def test_the_inverse_plane_gives_the_depth_of_the_board():
    rng = RNG(8)
    true = random_pose(rng)
    plane = plane_of(find_pose(corners_of(true, rng, 0.0), BOARD, COLOR))
    points_m = true.apply(BOARD.points_m())
    rays = points_m / points_m[:, 2:]
    np.testing.assert_allclose(rays @ plane.m, 1.0 / points_m[:, 2], rtol=1e-9)
    in_depth_m = COLOR_FROM_DEPTH.inverse().apply(points_m)
    rays = in_depth_m / in_depth_m[:, 2:]
    moved = moved_plane(plane.m, COLOR_FROM_DEPTH)
    np.testing.assert_allclose(rays @ moved, 1.0 / in_depth_m[:, 2], rtol=1e-9)


def test_covariance_of_the_inverse_plane_is_its_scatter():
    rng = RNG(9)
    true = random_pose(rng)
    exact = plane_of(find_pose(corners_of(true, rng, 0.0), BOARD, COLOR)).m
    squares = []
    for _ in range(300):
        plane = plane_of(find_pose(corners_of(true, rng, 0.1), BOARD, COLOR))
        squares.append((plane.m - exact) @ np.linalg.inv(plane.covariance) @ (plane.m - exact))
    assert np.mean(squares) == pytest.approx(3.0, rel=0.12)


@pytest.mark.parametrize("is_board", [True, False])
def test_derivatives_are_those_of_differences(is_board):
    rng = RNG(10)
    cells = board_shot("b", rng).cells
    n_bias = len(bias_numbers(BIAS))
    make = board_rows if is_board else wall_rows
    bent = replace(DEPTH, distortion=(0.01, -0.02, 0.0, 0.0))
    planes = np.array([[0.02, -0.05, 0.5]])
    state = DepthState(COLOR_FROM_DEPTH, BIAS, bent, planes, np.zeros(0))
    rows = make(cells, state.planes[0], state)
    slopes = np.concatenate([rows.by_global, rows.by_plane], axis=1)
    n = 6 + n_bias + 4 + 3
    for index in range(n):
        step = np.zeros(n)
        step[index] = 1e-6
        after, before = state.moved(step), state.moved(-step)
        change = (
            make(cells, after.planes[0], after).residuals
            - make(cells, before.planes[0], before).residuals
        ) / 2e-6
        # By the camera they are good to some percent: see `_rows`.
        is_camera = 6 + n_bias <= index < 6 + n_bias + 4
        within = 0.05 * np.abs(change).max() if is_camera else 1e-8
        np.testing.assert_allclose(slopes[:, index], change, atol=within)


def test_closed_form_gives_the_pose_of_exact_planes():
    rng = RNG(11)
    poses = [random_pose(rng) for _ in range(5)]
    color = np.array([plane_of(find_pose(corners_of(p, rng, 0.0), BOARD, COLOR)).m for p in poses])
    depth = np.array([moved_plane(m, COLOR_FROM_DEPTH) for m in color])
    found = start_extrinsics(color, depth)
    np.testing.assert_allclose(found.rotation, COLOR_FROM_DEPTH.rotation, atol=1e-8)
    np.testing.assert_allclose(found.translation_m, COLOR_FROM_DEPTH.translation_m, atol=1e-7)


def test_two_planes_or_parallel_ones_have_no_closed_form():
    plane = np.array([0.0, 0.0, 1.0])
    assert start_extrinsics(np.tile(plane, (2, 1)), np.tile(plane, (2, 1))) is None
    assert start_extrinsics(np.tile(plane, (9, 1)), np.tile(plane, (9, 1))) is None


@pytest.mark.parametrize("start", [None, RigidTransform(np.eye(3), np.array([-0.02, 0.0, 0.0]))])
def test_exact_shots_give_back_the_device(start):
    rng = RNG(12)
    boards = [board_shot(f"b{i}", rng) for i in range(10)]
    fit = fit_depth(START, boards, start=start, params=NO_PRIOR)
    np.testing.assert_allclose(errors(fit), 0.0, atol=2e-6)
    assert fit.by_camera.shape == (14, 17)


def test_intervals_hold_the_truth():
    squares, held = [], []
    for seed in range(12):
        rng = RNG(100 + seed)
        boards = [board_shot(f"b{i}", rng, 0.1, 0.0005) for i in range(15)]
        walls = [wall_shot(f"w{i}", 1.0 + i, rng, 0.0005) for i in range(2)]
        fit = fit_depth(START, boards, walls)
        error = errors(fit)
        squares.append(error @ np.linalg.solve(fit.covariance, error) / len(error))
        held.append(np.abs(error) < 1.96 * fit.standard_deviations)
        assert fit.sigma_per_m == pytest.approx(0.0005, rel=0.15)
    assert 0.7 < np.mean(squares) < 1.4
    assert np.mean(held) > 0.9


def shots_by(color, seed, sd_px=0.0):
    """Return boards whose poses are those that a wrong colour camera sees."""
    rng = RNG(seed)
    views = [board_view(rng, sd_px, 0.0002) for _ in range(8)]
    return [
        BoardShot(f"b{i}", find_pose(corners, BOARD, color), cells)
        for i, (corners, cells) in enumerate(views)
    ]


def moved_color(step):
    k, lens = COLOR.intrinsics, COLOR.distortion
    moved = replace(k, fx=k.fx + step[0], fy=k.fy + step[1], cx=k.cx + step[2])
    return replace(COLOR, intrinsics=moved, distortion=(lens[0] + step[5], *lens[1:]))


def test_a_wrong_color_camera_is_not_taken_for_a_wrong_depth():
    sds = np.zeros(17)
    sds[[0, 1, 2, 5]] = 0.5, 0.5, 0.5, 0.0005
    covariance = np.diag(sds**2)
    covariance[0, 1] = covariance[1, 0] = 0.95 * sds[0] * sds[1]
    away, by_each, squares = [], [], []
    for seed in range(8):
        color = moved_color(RNG(200 + seed).multivariate_normal(np.zeros(17), covariance))
        boards = shots_by(color, seed, 0.05)
        starts = START, replace(START, color_covariance=covariance)
        fits = [fit_depth(start, boards, params=NO_PRIOR) for start in starts]
        away.append([errors(fit) for fit in fits])
        by_each.append(
            [fit.covariance + fit.by_camera @ covariance @ fit.by_camera.T for fit in fits]
        )
        squares.append(away[-1][1] @ np.linalg.solve(by_each[-1][1], away[-1][1]) / 14)
    at_2_m = np.zeros(14)
    at_2_m[6:9] = 1.0, 2.0, 4.0
    trusting_m, knowing_m = np.sqrt(np.mean((np.array(away) @ at_2_m) ** 2, axis=0))
    assert knowing_m < 0.8 * trusting_m
    sds_m = np.sqrt(at_2_m @ np.array(by_each) @ at_2_m)
    assert (sds_m[:, 1] < sds_m[:, 0]).all()
    assert 0.6 < np.mean(squares) < 1.5


def test_the_fit_goes_with_the_color_camera_as_it_says():
    covariance = np.diag([1.0, 1.0, 0.25, 0.0, 0.0, 4e-6, *np.zeros(11)])
    start = replace(START, color_covariance=covariance)
    for index, step in ((0, 0.2), (2, 0.2), (5, 5e-4)):
        steps = np.eye(17)[index] * step
        there, here = (fit_depth(start, shots_by(moved_color(s), 1)) for s in (steps, -steps))
        moved = (errors(there) - errors(here)) / (2.0 * step)
        scale = np.sqrt(np.diag(here.covariance))
        np.testing.assert_allclose(
            moved * step / scale, here.by_camera[:, index] * step / scale, atol=0.05
        )


def test_a_depth_camera_that_the_maker_does_not_know_well_is_refined():
    rng = RNG(15)
    boards = [board_shot(f"b{i}", rng) for i in range(20)]
    k = DEPTH.intrinsics
    wrong = replace(k, fx=k.fx + 4.0, fy=k.fy + 3.0, cx=k.cx - 3.0, cy=k.cy + 2.0)
    params = replace(NO_PRIOR, focal_sd=10.0, centre_sd_px=1e3)
    fit = fit_depth(DepthStart(replace(DEPTH, intrinsics=wrong)), boards, params=params)
    found = fit.camera.intrinsics
    np.testing.assert_allclose(
        [found.fx, found.fy, found.cx, found.cy], [k.fx, k.fy, k.cx, k.cy], atol=0.02
    )
    np.testing.assert_allclose(errors(fit), 0.0, atol=5e-5)
    assert fit.parameter_names[-4:] == ("depth.fx", "depth.fy", "depth.cx", "depth.cy")
    assert fit_depth(START, boards).camera is DEPTH


def test_a_centre_that_nobody_knows_is_found_with_a_known_lens():
    rng = RNG(15)
    boards = [board_shot(f"b{i}", rng) for i in range(20)]
    k = DEPTH.intrinsics
    start = DepthStart(replace(DEPTH, intrinsics=replace(k, cx=k.cx + 4.8, cy=k.cy + 3.9)))
    fit = fit_depth(start, boards, params=replace(NO_PRIOR, centre_sd_px=1e3))
    found = fit.camera.intrinsics
    np.testing.assert_allclose([found.cx, found.cy], [k.cx, k.cy], atol=0.02)
    assert (found.fx, found.fy) == (k.fx, k.fy)
    np.testing.assert_allclose(errors(fit), 0.0, atol=5e-5)
    assert fit.parameter_names[-2:] == ("depth.cx", "depth.cy")
    assert "depth.fx" not in fit.parameter_names


def test_a_board_that_contradicts_the_others_is_named():
    rng = RNG(13)
    boards = [board_shot(f"b{i}", rng, 0.1, 0.0005) for i in range(12)]
    stale = board_shot("b12", rng, 0.1, 0.0005)
    boards[7] = BoardShot("stale", stale.pose, boards[7].cells)
    fit = fit_depth(START, boards)
    assert [shot.name for shot in fit.shots if shot.is_outlier] == ["stale"]
    assert (np.abs(errors(fit)) < 4.0 * fit.standard_deviations).all()


def test_walls_alone_tell_how_the_image_bends_and_nothing_else():
    rng = RNG(14)
    walls = [wall_shot(f"w{i}", distance_m, rng) for i, distance_m in enumerate((1.0, 2.0, 3.0))]
    before = DepthBias(BIAS.a, BIAS.b, BIAS.c)
    start = RigidTransform(np.eye(3), np.array([-0.02, 0.0, 0.0]))
    fit = fit_depth(DepthStart(DEPTH, before), (), walls, start, NO_PRIOR)
    assert fit.parameter_names == tuple(f"depth_bias.image_term.{i}" for i in (2, 3, 4))
    assert fit.color_from_depth is start or (fit.color_from_depth.rotation == np.eye(3)).all()
    assert (fit.bias.a, fit.bias.b, fit.bias.c) == (BIAS.a, BIAS.b, BIAS.c)
    # The terms x and y of the device turn each wall a little, which changes the others little.
    np.testing.assert_allclose(fit.bias.image_term[2:], BIAS.image_term[2:], atol=2e-4)
    assert [shot.name for shot in fit.shots] == ["w0", "w1", "w2"]


def test_without_a_shot_there_is_no_calibration():
    with pytest.raises(ValueError, match="needs a board or a wall"):
        fit_depth(START, ())


def test_biases_move_and_change_their_length():
    assert with_terms(DepthBias(0.1), 2).image_term == (0.0, 0.0)
    assert with_terms(BIAS, 2).image_term == BIAS.image_term[:2]
    moved = moved_bias(DepthBias(0.1, 1.1, 0.2, (1.0, 2.0)), np.arange(5.0))
    assert moved == DepthBias(0.1, 2.1, 2.2, (4.0, 6.0))
    assert DEPTH.width == 640
