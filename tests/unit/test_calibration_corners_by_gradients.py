"""Corners where the lines along the edges meet, as other calibration tools place them."""

import cv2
import numpy as np
import pytest
from scipy.io import loadmat
from scipy.spatial import KDTree

from adibas.calibration.camera_fitting import FittingParams, fit_camera
from adibas.calibration.corner_gradient_kernels import meet_all
from adibas.calibration.corners import CornerMethod, FitParams
from adibas.calibration.finder import FinderParams, find_board
from adibas.calibration.lens_models import BROWN_4
from adibas.calibration.refinement import Loss, RefinementParams
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards import render_boards
from adibas.simulation.boards_look import BoardLook, BoardView
from adibas.simulation.boards_poses import tilted
from adibas.simulation.color_noise import ColorNoise

BOARD = Board(7, 5, 0.03)
CAMERA = CameraCalibration(640, 480, Intrinsics(560, 560, 320, 240), (0.0, 0.0, 0.0, 0.0))
POSE = RigidTransform(tilted(0.3, 0.7, 0.1), np.array([-0.09, -0.06, 0.6]))
BY_GRADIENTS = FinderParams(fit=FitParams(method=CornerMethod.GRADIENT))
SQUARE = np.array([20.0, 0.0, 0.0, 20.0] + [0.0] * 12)
LIMITS = np.array([0.45, 8.0, 0.0, 0.0])


def picture():
    look = BoardLook(camera=ColorNoise(blur_px=1.6, full_well=1e5))
    view = BoardView(BOARD, POSE, has_marks=False)
    return render_boards((view,), CAMERA, np.random.default_rng(4), look)


def rms_px(pixels, truth):
    return np.sqrt((np.linalg.norm(pixels - truth, axis=1) ** 2).mean())


def test_with_a_symmetric_blur_both_methods_find_the_same_corners():
    shown = picture()
    corners = find_board(shown.image, BOARD, "one", BY_GRADIENTS)
    assert corners.n_seen == BOARD.n_corners
    assert rms_px(corners.pixels, shown.corners_px[0]) < 0.08
    modelled = find_board(shown.image, BOARD, "one")
    assert rms_px(corners.pixels, modelled.pixels) < 0.08


def test_gradients_keep_to_the_sharp_side_of_a_blur_with_a_tail():
    shown = picture()
    tail = np.exp(-np.arange(9) / 3.0)
    tail[0] += 2.0
    kernel = np.zeros((1, 17))
    kernel[0, :9] = (tail / tail.sum())[::-1]  # light moves to the right
    drawn_out = cv2.filter2D(shown.image, -1, kernel)
    right_px = [
        np.mean(find_board(drawn_out, BOARD, "one", params).pixels - shown.corners_px[0], axis=0)[0]
        for params in (FinderParams(), BY_GRADIENTS)
    ]
    middle_px = (tail / tail.sum()) @ np.arange(9)
    assert 0.5 * middle_px < right_px[0] < 1.1 * middle_px
    assert 0.0 < right_px[1] < 0.75 * right_px[0]


def crossing(u, v, width_px=1.5):
    rows, columns = np.indices((41, 41))
    sharp = np.tanh((columns - u) / width_px) * np.tanh((rows - v) / width_px)
    return np.round(128 + 90 * sharp).astype(np.uint8)


@pytest.mark.parametrize(("u", "v"), [(20.0, 20.0), (20.3, 19.8), (19.55, 20.45)])
def test_a_crossing_is_found_from_a_start_beside_it(u, v):
    starts = np.array([[20.0, 20.0]])
    # Edges of 1.5 px are so sharp that straight lines between the pixels cost up to 0.014 px.
    met = meet_all(crossing(u, v, 2.0), starts, SQUARE[None], LIMITS)
    np.testing.assert_allclose(met[0, :2], [u, v], atol=0.01)
    assert 0.0 <= met[0, 2] < 0.2


@pytest.mark.parametrize("reach", [4, 7])
def test_in_a_whole_window_a_corner_is_that_of_opencv(reach):
    rng = np.random.default_rng(reach)
    truth = rng.uniform(19.5, 21.5, (20, 2))
    for u, v in truth:
        noisy = np.clip(crossing(u, v) + rng.normal(0.0, 8.0, (41, 41)), 0, 255).astype(np.uint8)
        start = np.array([[u + 0.2, v - 0.2]])
        met = meet_all(noisy, start, SQUARE[None], np.array([np.inf, reach, 0.0, 0.0]))
        theirs = cv2.cornerSubPix(
            noisy,
            start.astype(np.float32)[None],
            (reach, reach),
            (-1, -1),
            (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-6),
        )
        np.testing.assert_allclose(met[0, :2], theirs.ravel(), atol=1e-3)


def test_no_corner_is_where_a_single_edge_runs_or_nothing_or_too_far():
    edge = np.where(np.arange(41) < 20, 30, 220)[None].repeat(41, axis=0).astype(np.uint8)
    plain = np.full((41, 41), 99, np.uint8)
    for image, place in ((edge, 20.0), (plain, 20.0), (crossing(22.5, 20.0), 20.0)):
        met = meet_all(image, np.array([[place, 20.0]]), SQUARE[None], LIMITS)
        assert np.isnan(met).all()
    assert np.isnan(meet_all(plain, np.array([[20.0, 20.0]]), 0.0 * SQUARE[None], LIMITS)).all()


@pytest.mark.parametrize(
    ("folder", "stem", "file", "board", "share"),
    [
        ("bouguet", "Image{}.tif", "calib_data.mat", Board(12, 13, 0.03), 0.999),
        ("kinect1", "LeftRgbobjects{}.png", "Calib_Results_left.mat", Board(10, 7, 0.03), 0.999),
    ],
)
def test_in_the_window_of_their_tool_our_corners_are_the_stored_ones(
    real_data, folder, stem, file, board, share
):
    root = real_data / "calibration" / folder
    stored = loadmat(root / file)
    window = FitParams(method=CornerMethod.GRADIENT, longest_px=5.0, square_share=np.inf)
    params = FinderParams(fit=window)
    apart_px = []
    for number in range(1, 8):
        gray = cv2.imread(str(root / stem.format(number)), cv2.IMREAD_GRAYSCALE)
        corners = find_board(gray, board, "one", params)
        ours = corners.pixels[~np.isnan(corners.sigma_px)]
        apart_px.append(KDTree(ours).query(stored[f"x_{number}"].T)[0])
    near = np.concatenate(apart_px)
    assert (near[near < 3.0] <= 0.3).mean() >= share
    assert (near < 3.0).mean() > 0.95


def test_the_window_does_not_reach_the_next_corner_of_an_oblique_board(real_data):
    path = real_data / "calibration" / "opencv_left" / "left02.jpg"
    gray, board = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), Board(9, 6, 0.025)
    corners = find_board(gray, board, path.name, BY_GRADIENTS)
    assert corners.n_seen == board.n_corners
    modelled = find_board(gray, board, path.name)
    assert np.abs(corners.pixels - modelled.pixels).max() < 1.0


def test_his_model_has_his_parameters_within_his_tolerances(real_data):
    board = Board(12, 13, 0.03)
    found = [
        find_board(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), board, path.name, BY_GRADIENTS)
        for path in sorted((real_data / "calibration" / "bouguet").glob("Image*.tif"))
    ]
    squares = RefinementParams(loss=Loss.SQUARES)
    fit = fit_camera(board, found, FittingParams(model=BROWN_4, refinement=squares))
    his = [657.463025, 657.94686, 303.136853, 242.569643, -0.254027, 0.121439, -0.000209, 0.000019]
    three_errors = [0.318189, 0.340463, 0.646821, 0.592184, 0.002483, 0.009864, 0.000134, 0.000132]
    assert fit.rms_px <= 0.17
    assert (np.abs(fit.values - his) <= three_errors).all()
