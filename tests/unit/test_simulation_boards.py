"""Simulated boards stand where an independent projection puts them, ink and paper to the pixel."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.stats import norm

from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.simulation.boards import corner_pixels, render_board, render_boards, visible_corners
from adibas.simulation.boards_background import Background, paint_background
from adibas.simulation.boards_camera import fineness, gathered
from adibas.simulation.boards_look import BoardLook, BoardView, Hand
from adibas.simulation.boards_painting import corner_rays, lay_board, motion_kernel
from adibas.simulation.color_noise import EXACT_COLOR, ColorNoise
from adibas.simulation.looks import linear_from_srgb

BOARD = Board(9, 6, 0.04)
CAMERA = CameraCalibration(
    640, 480, Intrinsics(525.0, 521.0, 311.3, 246.8), (0.08, -0.2, 0.002, -0.001, 0.05)
)
PLAIN = BoardLook(camera=EXACT_COLOR, light_gradient=0.0, background=Background(0.5))


def pose(turn=(0.3, -0.4, 0.15), at_m=(0.03, -0.02, 0.8), board=BOARD):
    rotation = rotation_from_vector(np.array(turn))
    return RigidTransform(rotation, np.array(at_m) - rotation @ board.points_m().mean(axis=0))


def referee_pixels(points_board_m, camera_from_board, camera=CAMERA):
    vector, _ = cv2.Rodrigues(camera_from_board.rotation)
    pixels, _ = cv2.projectPoints(
        points_board_m,
        vector,
        camera_from_board.translation_m,
        camera.intrinsics.matrix(),
        np.array(camera.distortion) if camera.distortion else None,
    )
    return pixels.reshape(-1, 2)


def ink_of(view, camera=CAMERA, look=PLAIN):
    """Return how dark each pixel of a picture without camera faults is, 1 = all ink."""
    canvas = np.full((camera.height, camera.width, 1), look.exposure, np.float32)
    lay_board(canvas, view, camera, look)
    dark = look.exposure * look.ink / look.paper
    return (look.exposure - canvas[..., 0].astype(float)) / (look.exposure - dark)


@pytest.mark.parametrize(
    "distortion",
    [
        (),
        CAMERA.distortion,
        (0.1, -0.1, 0.001, 0.002, 0.02, 0.05, -0.02, 0.01, 0.001, -0.002, 0.002, 0.001),
    ],
)
def test_corners_are_where_opencv_projects_them(distortion):
    camera = replace(CAMERA, distortion=distortion)
    expected = referee_pixels(BOARD.points_m(), pose(), camera)
    np.testing.assert_allclose(corner_pixels(BOARD, pose(), camera), expected, atol=1e-9)
    np.testing.assert_allclose(
        visible_corners(BoardView(BOARD, pose()), camera), expected, atol=1e-9
    )


def test_rays_of_the_pixels_corners_lead_back_to_them():
    rays = corner_rays(CAMERA)
    v, u = np.array([(0, 0), (480, 640), (0, 640), (233, 401), (17, 5)]).T
    points = np.column_stack([rays[v, u], np.ones(5)])
    nowhere = RigidTransform(np.eye(3), np.zeros(3))
    expected = np.stack([u, v], axis=1) - 0.5
    np.testing.assert_allclose(referee_pixels(points, nowhere), expected, atol=1e-5)


def test_every_pixel_shows_the_share_of_ink_that_many_samples_find():
    view = BoardView(BOARD, pose())
    ink = ink_of(view)
    rng = np.random.default_rng(1)
    mixed = np.argwhere((ink > 0.01) & (ink < 0.99))
    anywhere = rng.integers((80, 150), (340, 490), (60, 2))
    v, u = np.concatenate([rng.choice(mixed, 300), anywhere]).T
    n = 40
    fraction = (np.arange(n) + 0.5) / n - 0.5
    samples = np.stack(
        [
            u[:, None, None] + fraction + np.zeros((n, 1)),
            v[:, None, None] + fraction[:, None] + np.zeros(n),
        ],
        axis=-1,
    )
    rays = cv2.undistortPoints(
        samples.reshape(-1, 1, 2),
        CAMERA.intrinsics.matrix(),
        np.array(CAMERA.distortion),
        criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 60, 1e-12),
    ).reshape(-1, 2)
    expected = ink_of_rays(rays, view).reshape(len(u), -1).mean(axis=1)
    assert ((expected > 0.02) & (expected < 0.98)).sum() > 250
    np.testing.assert_allclose(ink[v, u], expected, atol=0.02)
    assert abs((ink[v, u] - expected).mean()) < 1e-3


def ink_of_rays(rays, view):
    """Say square by square whether rays meet ink."""
    rotation, origin_m = view.camera_from_board.rotation, view.camera_from_board.translation_m
    rays = np.column_stack([rays, np.ones(len(rays))])
    scale = (rotation[:, 2] @ origin_m) / (rays @ rotation[:, 2])
    points = (rays * scale[:, None] - origin_m) @ rotation / view.board.square_m
    column, row = np.floor(points[:, 0]).astype(int) + 1, np.floor(points[:, 1]).astype(int) + 1
    board = view.board
    inside = (column >= 0) & (column <= board.columns) & (row >= 0) & (row <= board.rows)
    ink = inside & ((column + row) % 2 == 0)
    for marked_row, marked_column in board.marked_squares():
        center = np.array([marked_column - 0.5, marked_row - 0.5])
        ink ^= np.linalg.norm(points[:, :2] - center, axis=1) < 0.2
    return ink


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.0, 0.0, 0.003), (0.5, -0.6, 0.4)])
def test_an_edge_lies_within_a_thousandth_of_a_pixel_of_the_truth(turn):
    camera = replace(CAMERA, distortion=(0.08, -0.2, 0.001, 0.0, 0.0))
    view = BoardView(BOARD, pose(turn), has_marks=False)
    ink = ink_of(view, camera)
    for column in range(1, 8):
        # The edge between two squares of the fourth row, over the middle half of its length.
        along = np.linspace(2.25, 2.75, 400)
        edge_m = np.column_stack([np.full(400, column), along, np.zeros(400)]) * BOARD.square_m
        u, v = referee_pixels(edge_m, view.camera_from_board, camera).T
        for row in range(int(v.min()) + 2, int(v.max()) - 1):
            # The mean place of the edge over the height of the row of pixels.
            rows = np.linspace(row - 0.5, row + 0.5, 101)
            expected = np.interp(rows, v, u).mean()
            first, last = int(expected) - 6, int(expected) + 7
            shares = ink[row, first:last]
            share_of_ink = shares.sum()
            begins_dark = shares[0] > 0.5
            measured = first - 0.5 + share_of_ink if begins_dark else last - 0.5 - share_of_ink
            assert abs(measured - expected) < 1e-3


def test_dots_are_in_the_marked_squares_and_nowhere_else():
    flat = pose((0, 0, 0))
    with_marks, without = (ink_of(BoardView(BOARD, flat, has_marks=marks)) for marks in (1, 0))
    difference = with_marks - without
    area_px = (525.0 * 521.0) * (BOARD.square_m / 0.8) ** 2 * np.pi * 0.2**2
    for row, column in BOARD.marked_squares():
        middle_m = np.array([[column - 0.5, row - 0.5, 0.0]]) * BOARD.square_m
        u, v = np.rint(referee_pixels(middle_m, flat)[0]).astype(int)
        part = difference[v - 8 : v + 9, u - 8 : u + 9]
        sign = -1.0 if BOARD.is_dark(row, column) else 1.0
        assert sign * part.sum() == pytest.approx(area_px, rel=0.03)
        assert part[8, 8] == pytest.approx(sign)
        difference[v - 8 : v + 9, u - 8 : u + 9] = 0.0
    np.testing.assert_allclose(difference, 0.0, atol=1e-6)


def test_white_paper_surrounds_the_pattern_as_far_as_said():
    view = BoardView(BOARD, pose((0, 0, 0)), margin_squares=0.6)
    image = render_board_linear(view)
    row, column = 2.5, -1.0
    for out, expected in ((0.5, PLAIN.exposure), (0.7, PLAIN.background.level)):
        place_m = np.array([[column - out, row, 0.0]]) * BOARD.square_m
        u, v = np.rint(referee_pixels(place_m, view.camera_from_board)[0]).astype(int)
        assert image[v, u] == pytest.approx(expected)


def render_board_linear(*views):
    canvas = paint_background(PLAIN.background, (480, 640), 1)
    for view in views:
        lay_board(canvas, view, CAMERA, PLAIN)
    return canvas[..., 0]


def test_a_mirrored_picture_is_the_picture_from_right_to_left():
    view = BoardView(BOARD, pose())
    straight, mirrored = (
        render_boards((view,), CAMERA, np.random.default_rng(5), BoardLook(is_mirrored=is_mirrored))
        for is_mirrored in (False, True)
    )
    np.testing.assert_array_equal(mirrored.image, straight.image[:, ::-1])
    expected = straight.corners_px[0] * (-1, 1) + (639, 0)
    np.testing.assert_allclose(mirrored.corners_px[0], expected)


def test_a_hand_hides_corners_and_the_truth_says_which():
    hand = Hand((-0.1, 0.08), (0.04, 0.08), 0.01)
    view = BoardView(BOARD, pose(), hands=(hand,))
    pixels = visible_corners(view, CAMERA).reshape(6, 9, 2)
    hidden = np.isnan(pixels).any(axis=-1)
    expected = np.zeros((6, 9), bool)
    expected[2, :2] = True
    np.testing.assert_array_equal(hidden, expected)
    bare = replace(view, hands=())
    picture, free = (
        render_boards((one,), CAMERA, np.random.default_rng(0), PLAIN, in_color=True).image
        for one in (view, bare)
    )
    covered = corner_pixels(BOARD, view.camera_from_board, CAMERA).reshape(6, 9, 2)
    u, v = np.rint(covered[2, 0]).astype(int)
    red, _green, blue = picture[v, u].astype(int)
    assert red > blue + 30
    for u, v in np.rint(pixels[~hidden]).astype(int):
        near = (slice(v - 1, v + 2), slice(u - 1, u + 2))
        np.testing.assert_array_equal(picture[near], free[near])


def test_corners_outside_the_image_are_not_visible():
    away = pose((0, 0, 0), (-0.45, 0.0, 0.8))
    pixels = corner_pixels(BOARD, away, CAMERA)
    visible = visible_corners(BoardView(BOARD, away), CAMERA)
    inside = pixels[:, 0] > -0.5
    assert 0 < inside.sum() < 54
    np.testing.assert_array_equal(~np.isnan(visible).any(axis=1), inside)


def test_the_board_named_last_stands_before_the_others():
    front = BoardView(Board(4, 3, 0.04), pose((0, 0, 0), board=Board(4, 3, 0.04)))
    behind = BoardView(BOARD, pose((0, 0, 0), (0.03, -0.02, 0.8)))
    both, alone = render_board_linear(behind, front), render_board_linear(front)
    corners = corner_pixels(front.board, front.camera_from_board, CAMERA)
    low, high = np.rint(corners.min(axis=0)).astype(int), np.rint(corners.max(axis=0)).astype(int)
    part = (slice(low[1], high[1]), slice(low[0], high[0]))
    np.testing.assert_array_equal(both[part], alone[part])
    assert (both != alone).any()


def test_motion_smears_the_board_evenly_about_its_place():
    kernel = motion_kernel((7.0, -3.0)).astype(float)
    v, u = np.indices(kernel.shape) - kernel.shape[0] // 2
    assert kernel.sum() == pytest.approx(1.0, abs=1e-6)
    assert (kernel * u).sum() == pytest.approx(0.0, abs=1e-6)
    # An even motion over a length has a variance of its square / 12, pixels add a little.
    assert (kernel * u * u).sum() == pytest.approx(49 / 12, abs=0.26)
    assert (kernel * u * v).sum() == pytest.approx(-21 / 12, abs=0.05)
    view = BoardView(BOARD, pose())
    still, moved = (
        ink_of(view, look=replace(PLAIN, motion_px=motion)) for motion in ((0, 0), (8.0, 4.0))
    )
    assert moved.sum() == pytest.approx(still.sum(), rel=1e-4)
    rows, columns = np.indices(still.shape)
    for places in (rows, columns):
        middle = (still * places).sum() / still.sum()
        assert (moved * places).sum() / moved.sum() == pytest.approx(middle, abs=1e-3)
    assert np.abs(moved - still).max() > 0.3


@pytest.mark.parametrize("blur_px", [0.7, 1.4])
@pytest.mark.parametrize("edge_px", np.linspace(300.0, 301.0, 5))
def test_a_lens_blurs_before_the_pixels_sample(edge_px, blur_px):
    camera = ColorNoise(blur_px=blur_px)
    n, sd_px = fineness(camera, 640), 0.5 * blur_px
    assert n * sd_px >= 1.4
    ends_px = (np.arange(640 * n + 1) - 0.5 * n) / n
    fine = np.diff(np.maximum(ends_px - edge_px, 0.0)) * n
    fine = np.tile(fine.astype(np.float32), (n * 20, 1))[..., None]
    seen = gathered(fine, camera, n)[10, :, 0]
    away = (np.arange(641) - 0.5 - edge_px) / sd_px
    integral_px = sd_px * (away * norm.cdf(away) + norm.pdf(away))
    np.testing.assert_allclose(seen[250:350], np.diff(integral_px)[250:350], atol=0.012)


def test_noise_grows_with_the_light_as_photons_do():
    camera = ColorNoise(blur_px=0.0, full_well=4000.0, read_noise=8.0, corner_loss=0.0)
    for level in (0.1, 0.6):
        look = BoardLook(camera=camera, light_gradient=0.0, background=Background(level))
        image = render_boards((), CAMERA, np.random.default_rng(3), look).image
        light = linear_from_srgb(image.astype(float))
        expected = np.sqrt(4000.0 * level + 64.0) / 4000.0
        assert light.mean() == pytest.approx(level, abs=0.002)
        assert light.std() == pytest.approx(expected, rel=0.04)


def test_light_falls_from_one_side():
    look = replace(PLAIN, light_gradient=0.3, light_from_rad=0.0)
    light = linear_from_srgb(
        render_boards((), CAMERA, np.random.default_rng(3), look).image.astype(float)
    )
    slope_per_px = 0.5 * 0.3 / (0.5 * np.hypot(640, 480))
    assert (light[:, -1] - light[:, 0]).mean() == pytest.approx(slope_per_px * 639, rel=0.02)
    assert np.ptp(light.mean(axis=1)) < 0.002


def test_the_same_luck_gives_the_same_picture_in_grey_and_colour():
    look = BoardLook(background=Background(is_cluttered=True, seed=3))
    for in_color in (False, True):
        one, two, other = (
            render_board(
                BOARD, pose(), CAMERA, np.random.default_rng(seed), look, in_color=in_color
            ).image
            for seed in (1, 1, 2)
        )
        np.testing.assert_array_equal(one, two)
        assert (one != other).mean() > 0.3
    assert one.shape == (480, 640, 3)


def test_opencv_finds_the_corners_of_a_usual_picture():
    picture = render_board(BOARD, pose(), CAMERA, np.random.default_rng(1))
    is_found, corners = cv2.findChessboardCornersSB(picture.image, (9, 6))
    assert is_found
    # It begins at the other end.
    difference = corners.reshape(-1, 2)[::-1] - picture.corners_px[0]
    # Its own error; half a pixel off in origin or order would show.
    assert np.sqrt((difference**2).sum(axis=1).mean()) < 0.1
    assert np.abs(difference.mean(axis=0)).max() < 0.02


def test_a_board_seen_from_behind_is_a_mistake():
    turned = RigidTransform(np.diag([-1.0, 1.0, -1.0]), np.array([0.1, 0.0, 0.8]))
    with pytest.raises(ValueError, match="back"):
        render_board(BOARD, turned, CAMERA, np.random.default_rng(0))
