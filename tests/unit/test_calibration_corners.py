"""Corners of simulated boards, whose places are known exactly."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.calibration.corner_fit_kernels import N_UNKNOWNS, _row
from adibas.calibration.corner_response_kernels import peaks
from adibas.calibration.corner_saddle_kernels import harris, saddle_shift
from adibas.calibration.finder import (
    BoardProblem,
    as_gray,
    find_board,
    find_boards,
    search_board,
)
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards import render_boards
from adibas.simulation.boards_look import BoardLook, BoardView, Hand
from adibas.simulation.boards_poses import tilted
from adibas.simulation.color_noise import ColorNoise

BOARD = Board(7, 5, 0.03)
CAMERA = CameraCalibration(640, 480, Intrinsics(560, 560, 320, 240), (-0.25, 0.1, 0.001, -0.001))
LOOK = BoardLook(camera=ColorNoise(blur_px=1.4))


def pose(tilt=0.5, towards=0.7, roll=0.1, place_m=(-0.09, -0.06, 0.6)):
    return RigidTransform(tilted(tilt, towards, roll), np.array(place_m))


def picture(*views, look=LOOK, seed=1, board=BOARD):
    views = views or (BoardView(board, pose()),)
    return render_boards(views, CAMERA, np.random.default_rng(seed), look)


def error_px(corners, truth):
    return np.linalg.norm(corners.pixels - truth, axis=1)


@pytest.mark.parametrize("tilt", [0.0, 0.5, 0.9])
@pytest.mark.parametrize(
    "look",
    [
        LOOK,
        replace(LOOK, camera=ColorNoise(blur_px=4.0)),
        replace(LOOK, camera=ColorNoise(full_well=400.0, blur_px=1.4)),
        replace(LOOK, exposure=0.15, light_gradient=0.5),
    ],
    ids=["good", "blurred", "noisy", "dark and uneven"],
)
def test_corners_lie_within_a_few_hundredths_of_a_pixel_of_the_truth(look, tilt):
    shown = picture(BoardView(BOARD, pose(tilt)), look=look)
    corners = find_board(shown.image, BOARD, "one")
    assert corners is not None
    assert corners.n_seen == BOARD.n_corners
    assert np.sqrt((error_px(corners, shown.corners_px[0]) ** 2).mean()) < 0.06
    assert corners.is_mirrored is False


def test_a_lens_that_bends_edges_does_not_pull_corners_towards_its_middle():
    # Without the curvature of the outermost edges they lie 0.004 px too far inside.
    camera = replace(CAMERA, distortion=(-0.4, 0.15, 0.0, 0.0))
    middle = np.array([camera.intrinsics.cx, camera.intrinsics.cy])
    look = replace(LOOK, camera=ColorNoise(blur_px=1.4, full_well=1e9, read_noise=0.0))
    leans = []
    for place_m in ((-0.17, -0.12, 0.5), (-0.02, 0.0, 0.5), (-0.16, 0.0, 0.52), (0.0, -0.12, 0.55)):
        view = BoardView(BOARD, pose(0.05, 0.7, 0.2, place_m))
        shown = render_boards((view,), camera, np.random.default_rng(1), look)
        corners = find_board(shown.image, BOARD, "one")
        out = shown.corners_px[0] - middle
        radius_px = np.linalg.norm(out, axis=1)
        lean_px = ((corners.pixels - shown.corners_px[0]) * out).sum(axis=1) / radius_px
        leans += lean_px[radius_px > 150.0].tolist()
    assert len(leans) > 40
    assert abs(np.mean(leans)) < 0.0015


def test_the_error_of_a_corner_is_as_large_as_its_standard_deviation_says():
    normalised = []
    for seed in range(8):
        look = replace(LOOK, camera=ColorNoise(full_well=500.0 * (1 + seed % 4), blur_px=1.4))
        shown = picture(BoardView(BOARD, pose(0.1 * seed, seed)), look=look, seed=seed)
        corners = find_board(shown.image, BOARD, "one")
        normalised.append((corners.pixels - shown.corners_px[0]) / corners.sigma_px[:, None])
    assert 0.7 < np.sqrt(np.mean(np.square(normalised))) < 1.3


def test_a_hand_hides_corners_and_moves_none():
    hands = (Hand((0.10, 0.15), (0.10, 0.08), 0.012), Hand((0.13, 0.15), (0.13, 0.09), 0.012))
    shown = picture(BoardView(BOARD, pose(), hands=hands))
    corners = find_board(shown.image, BOARD, "hand")
    truth = shown.corners_px[0]
    assert np.isnan(truth).any()
    assert np.isnan(corners.pixels[np.isnan(truth[:, 0])]).all()
    assert np.nanmax(error_px(corners, truth)) < 0.3
    assert corners.n_seen > 0.6 * BOARD.n_corners


def test_an_arm_across_the_board_does_not_make_two_of_it():
    shown = picture(BoardView(BOARD, pose(), hands=(Hand((0.09, 0.3), (0.09, -0.2), 0.012),)))
    corners = find_board(shown.image, BOARD, "arm")
    assert corners is not None
    assert np.isnan(corners.pixels[3::7, 0]).all()
    assert np.nanmax(error_px(corners, shown.corners_px[0])) < 0.3


def test_a_mirrored_image_is_told_by_the_dots():
    shown = picture(look=replace(LOOK, is_mirrored=True))
    corners = find_board(shown.image, BOARD, "mirrored")
    assert corners.is_mirrored is True
    assert error_px(corners, shown.corners_px[0]).max() < 0.3


def test_without_dots_nobody_can_tell_a_mirrored_image():
    shown = picture(BoardView(BOARD, pose(), has_marks=False))
    assert find_board(shown.image, BOARD, "plain").is_mirrored is None


@pytest.mark.parametrize("roll", [0.0, 1.6, 3.1, -1.5])
def test_dots_tell_how_the_board_is_turned(roll):
    # Both odd: all four corner squares are dark, and only the dots know the first.
    shown = picture(BoardView(BOARD, pose(0.3, 0.0, roll, (0.0, 0.0, 0.75))))
    corners = find_board(shown.image, BOARD, "turned")
    assert error_px(corners, shown.corners_px[0]).max() < 0.3


@pytest.mark.parametrize("roll", [0.0, 3.1])
def test_colors_tell_how_a_board_of_odd_and_even_sides_is_turned(roll):
    board = Board(6, 5, 0.03)
    view = BoardView(board, pose(0.3, 0.0, roll, (0.0, 0.0, 0.75)), has_marks=False)
    shown = picture(view)
    corners = find_board(shown.image, board, "turned")
    assert error_px(corners, shown.corners_px[0]).max() < 0.3


def test_without_dots_the_corner_nearer_the_top_left_comes_first():
    view = BoardView(BOARD, pose(0.2, 0.0, 3.1, (0.05, 0.05, 0.75)), has_marks=False)
    shown = picture(view)
    corners = find_board(shown.image, BOARD, "turned")
    first, last = corners.pixels[0], corners.pixels[-1]
    assert np.linalg.norm(first) < np.linalg.norm(last)
    assert error_px(corners, shown.corners_px[0][::-1]).max() < 0.3


def test_dots_place_a_board_that_is_cut_by_the_border():
    view = BoardView(BOARD, pose(0.1, 0.0, 0.0, (0.17, -0.06, 0.5)))
    shown = picture(view)
    corners = find_board(shown.image, BOARD, "cut")
    truth = shown.corners_px[0]
    assert np.isnan(truth).any()
    assert corners is not None
    assert np.nanmax(error_px(corners, truth)) < 0.3


def test_a_cut_board_without_dots_is_refused_with_what_is_seen():
    view = BoardView(BOARD, pose(0.1, 0.0, 0.0, (0.17, -0.06, 0.5)), has_marks=False)
    search = search_board(picture(view).image, BOARD, "cut")
    assert search.corners is None
    assert search.problem is BoardProblem.PARTLY_SEEN
    assert search.fields["rows"] == 5
    assert search.fields["columns"] < 7


def test_a_board_of_another_size_is_refused_with_its_size():
    other = Board(6, 5, 0.03)
    search = search_board(picture(BoardView(other, pose())).image, BOARD, "other")
    assert search.problem is BoardProblem.ANOTHER_SIZE
    assert search.fields == {"columns": 6, "rows": 5, "wanted_columns": 7, "wanted_rows": 5}


def test_two_boards_are_two_grids_and_refused():
    left = BoardView(BOARD, pose(0.2, 0, 0, (-0.27, -0.06, 0.8)))
    right = BoardView(BOARD, pose(0.3, 1, 0, (0.05, -0.06, 0.8)))
    shown = picture(left, right)
    grids = find_boards(shown.image)
    assert [grid.n_seen for grid in grids] == [35, 35]
    assert search_board(shown.image, BOARD, "two").problem is BoardProblem.TWO_BOARDS


def test_a_board_beside_one_of_another_size_is_found():
    left = BoardView(BOARD, pose(0.2, 0, 0, (-0.27, -0.06, 0.8)))
    right = BoardView(Board(4, 3, 0.03), pose(0.3, 1, 0, (0.05, -0.06, 0.8)))
    shown = picture(left, right)
    corners = find_board(shown.image, BOARD, "two")
    assert error_px(corners, shown.corners_px[0]).max() < 0.3


IMAGES_WITHOUT_A_BOARD = {
    "black": np.zeros((480, 640), np.uint8),
    "noise": np.random.default_rng(2).integers(0, 256, (480, 640), np.uint8),
    "stripes": np.tile(np.where(np.arange(640) % 20 < 10, 200, 50).astype(np.uint8), (480, 1)),
    "lines": np.where((np.indices((480, 640)) % 40 < 3).any(axis=0), 60, 180).astype(np.uint8),
    "tiny": np.eye(8, dtype=np.uint8),
    "empty": np.zeros((0, 5), np.uint8),
}


@pytest.mark.parametrize("name", IMAGES_WITHOUT_A_BOARD)
def test_no_board_is_seen_where_there_is_none(name):
    search = search_board(IMAGES_WITHOUT_A_BOARD[name], BOARD, name)
    assert search.corners is None
    assert search.problem is BoardProblem.NO_BOARD


def test_a_perfect_checkerboard_has_its_corners_between_the_pixels():
    image = np.kron(np.indices((6, 8)).sum(axis=0) % 2 * 200 + 20, np.ones((20, 20)))
    (grid,) = find_boards(image.astype(np.uint8))
    assert (grid.rows, grid.columns) == (5, 7)
    rows, columns = np.indices((5, 7)) * 20 + 19.5
    np.testing.assert_allclose(grid.pixels, np.stack([columns, rows], axis=-1), atol=0.02)
    assert grid.is_origin_dark


def test_gray_is_the_luma_of_the_color():
    rgb = np.random.default_rng(0).integers(0, 256, (5, 7, 3), np.uint8)
    np.testing.assert_allclose(as_gray(rgb), rgb @ [0.299, 0.587, 0.114], atol=0.6)


def test_gray_refuses_an_image_without_channels():
    with pytest.raises(ValueError, match="color_rgb"):
        as_gray(np.zeros((4, 4), np.uint8))


def test_the_saddle_of_a_quadratic_surface_is_found_exactly():
    v, u = np.mgrid[:9, :9].astype(np.float32)
    right, down = u - 4.3, v - 3.8
    is_saddle, shift_u, shift_v = saddle_shift(2 * right**2 + 3 * right * down - down**2, 4, 4)
    assert is_saddle
    assert shift_u == pytest.approx(0.3, abs=1e-4)
    assert shift_v == pytest.approx(-0.2, abs=1e-4)


def test_a_bowl_is_no_saddle():
    v, u = np.mgrid[:9, :9].astype(np.float32)
    assert not saddle_shift((u - 4) ** 2 + (v - 4) ** 2, 4, 4)[0]


def test_harris_tells_a_corner_from_an_edge():
    v, u = np.mgrid[:11, :11]
    corner = np.where((u < 5.5) == (v < 5.5), 200, 0).astype(np.float32)
    edge = np.where(u < 5.5, 200, 0).astype(np.float32)
    assert harris(corner, 5, 5) > 0.1
    assert harris(edge, 5, 5) < 0


@pytest.mark.parametrize("decimals", [0, 3])
def test_a_peak_is_the_first_of_the_highest_in_its_five_by_five(decimals):
    response = np.round(np.random.default_rng(0).normal(0, 3, (40, 53)), decimals)
    response = response.astype(np.float32)
    wanted = []
    for row in range(2, 38):
        for column in range(2, 51):
            around = response[row - 2 : row + 3, column - 2 : column + 3].ravel()
            if response[row, column] > 1.0 and np.argmax(around) == 12:
                wanted.append((column, row))
    assert len(wanted) > 20
    np.testing.assert_array_equal(peaks(response, 1.0, 1000), wanted)
    np.testing.assert_array_equal(peaks(response, 1.0, 7), wanted[:7])


def test_derivatives_of_the_crossing_agree_with_differences():
    rng = np.random.default_rng(0)
    for _ in range(50):
        dots, light = rng.integers(0, 2, 4), rng.normal(0, 0.003, 2)
        shape = np.array([20, 2, -3, 22, 2e-3, -3e-3, 21, 20, 19, 22, *dots, *light], float)
        swing = rng.choice([-70.0, 70.0])
        blurs = rng.uniform(0.5, 4, 2)
        unknowns = np.array([50, 60, 0.1, 1.7, *blurs, 120, swing, 0.3])
        pixel = np.array([*rng.uniform((38, 48), (62, 72)), 100.0])

        def residual(values, pixel=pixel, shape=shape):
            row = np.empty(N_UNKNOWNS)
            angles = np.array([f(values[k]) for k in (2, 3) for f in (np.cos, np.sin)])
            return _row(pixel, values, angles, shape, row), row

        steps = 1e-5 * np.eye(N_UNKNOWNS)
        differences = [
            (residual(unknowns - step)[0] - residual(unknowns + step)[0]) / 2e-5 for step in steps
        ]
        np.testing.assert_allclose(residual(unknowns)[1], differences, rtol=2e-4, atol=2e-3)
