"""A careful user's views cover the image and tilt; each novice's set has its own mistake only."""

import cv2
import numpy as np
import pytest

from adibas.data.board import Board
from adibas.simulation.boards import corner_pixels
from adibas.simulation.boards_novice import MISTAKES, WRONG_SQUARE, novice_set
from adibas.simulation.boards_poses import Holding, distances_m, outline_m, random_board_poses
from adibas.simulation.device import draw_device

BOARD = Board(9, 6, 0.035)
CAMERA = draw_device(4, (480, 640)).color
N = 20


@pytest.fixture(scope="module")
def poses():
    return [
        pose
        for seed in range(10)
        for pose in random_board_poses(np.random.default_rng(seed), BOARD, CAMERA, N)
    ]


def tilts_deg(poses):
    """Return the angle of each board's normal from the line of sight."""
    cosines = []
    for pose in poses:
        middle = pose.apply(BOARD.points_m()).mean(axis=0)
        cosines.append(pose.rotation[:, 2] @ middle / np.linalg.norm(middle))
    return np.degrees(np.arccos(cosines))


def corners(poses, board=BOARD):
    return np.array([corner_pixels(board, pose, CAMERA) for pose in poses])


def test_a_careful_user_shows_the_whole_pattern(poses):
    for pose in poses:
        vector, _ = cv2.Rodrigues(pose.rotation)
        matrix, lens = CAMERA.intrinsics.matrix(), np.array(CAMERA.distortion)
        pixels, _ = cv2.projectPoints(outline_m(BOARD), vector, pose.translation_m, matrix, lens)
        assert pixels.min() > 3.5
        assert (pixels < (639 - 3.5, 479 - 3.5)).all()
    pixels = corners(poses)
    assert (pixels > 0).all()
    assert (pixels < (639, 479)).all()


def test_a_careful_user_covers_the_image_near_and_far_and_tilts(poses):
    for first in range(0, len(poses), N):
        pixels = corners(poses[first : first + N]).reshape(-1, 2)
        counts, _, _ = np.histogram2d(*pixels.T, bins=(4, 3), range=((0, 640), (0, 480)))
        assert (counts > 10).sum() >= 10
        assert np.ptp(pixels[:, 0]) > 0.8 * 640
        tilt = tilts_deg(poses[first : first + N])
        assert (tilt > 20).sum() >= 8
    assert np.quantile(tilts_deg(poses), 0.9) < 65
    distances = np.array([pose.apply(BOARD.points_m())[:, 2].mean() for pose in poses])
    near_m, far_m = distances_m(BOARD, CAMERA, Holding())
    assert near_m == 0.5
    assert np.quantile(distances, 0.05) < near_m * 1.15
    assert np.quantile(distances, 0.95) > far_m * 0.87


def test_views_tilt_to_every_side(poses):
    normals = np.array([pose.rotation[:, 2] for pose in poses])
    turned = np.degrees(np.arctan2(normals[:, 1], normals[:, 0]))
    counts, _ = np.histogram(turned, bins=8, range=(-180, 180))
    assert counts.min() > 0.4 * len(poses) / 8


def test_the_same_luck_holds_the_board_the_same_way():
    one, two, other = (
        random_board_poses(np.random.default_rng(seed), BOARD, CAMERA, 3) for seed in (1, 1, 2)
    )
    for a, b, c in zip(one, two, other, strict=True):
        np.testing.assert_array_equal(a.translation_m, b.translation_m)
        assert np.abs(a.translation_m - c.translation_m).max() > 1e-3


def test_a_board_that_cannot_fit_is_refused():
    holding = Holding(border_px=250.0)
    with pytest.raises(ValueError, match="does not fit"):
        random_board_poses(np.random.default_rng(0), BOARD, CAMERA, 1, holding)


def attempt(mistake, n=8):
    made = novice_set(mistake, np.random.default_rng(3), BOARD, CAMERA, n)
    assert made.told_board == BOARD
    return made


def views_of(made):
    return [view for views, _ in made.shots for view in views]


@pytest.mark.parametrize("mistake", MISTAKES)
def test_every_set_of_a_novice_can_be_rendered(mistake):
    made = attempt(mistake, n=2)
    pictures = list(made.pictures(CAMERA, np.random.default_rng(0)))
    assert len(pictures) == (3 if mistake == "three_boards" else 2)
    assert all(picture.image.shape == (480, 640) for picture in pictures)


def test_a_novice_without_mistakes_is_a_careful_user():
    made = attempt("none", N)
    pixels = corners([view.camera_from_board for view in views_of(made)])
    assert (pixels > 0).all()
    assert np.ptp(pixels[..., 0]) > 400
    assert {view.board for view in views_of(made)} == {BOARD}


def test_all_frontal_means_parallel_to_the_image():
    normals = [view.camera_from_board.rotation[2, 2] for view in views_of(attempt("all_frontal"))]
    assert np.degrees(np.arccos(normals)).max() < 2.0


def test_one_place_means_hardly_any_motion():
    pixels = corners([view.camera_from_board for view in views_of(attempt("one_place"))])
    assert pixels.std(axis=0).max() < 20


def test_half_outside_hides_a_good_part_of_every_board():
    made = attempt("half_outside")
    for picture in made.pictures(CAMERA, np.random.default_rng(0)):
        hidden = np.isnan(picture.corners_px[0]).any(axis=1).mean()
        assert 0.1 < hidden < 0.95


def test_the_wrong_board_differs_from_what_is_told():
    larger = {view.board for view in views_of(attempt("wrong_square_size"))}
    assert larger == {Board(9, 6, 0.035 * WRONG_SQUARE)}
    assert {view.board for view in views_of(attempt("wrong_board_size"))} == {Board(8, 6, 0.035)}


def test_two_boards_do_not_hide_each_other():
    for views, _ in attempt("two_boards").shots:
        left, right = (corner_pixels(view.board, view.camera_from_board, CAMERA) for view in views)
        assert left[:, 0].max() < right[:, 0].min() - 10


def test_blur_darkness_and_mirror_are_in_the_look():
    sharp = attempt("none").shots[0][1]
    assert all(
        look.camera.blur_px > 4 * sharp.camera.blur_px for _, look in attempt("blurred").shots
    )
    assert all(np.hypot(*look.motion_px) > 7 for _, look in attempt("shaken").shots)
    assert all(look.is_mirrored for _, look in attempt("mirrored").shots)
    assert all(look.exposure < 0.1 * sharp.exposure for _, look in attempt("too_dark").shots)
    assert not views_of(attempt("no_board"))
