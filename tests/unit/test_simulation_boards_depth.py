"""Boards and walls in depth are the planes that the poses say, with the device's own faults."""

import cv2
import numpy as np
import pytest

from adibas.data.board import Board
from adibas.data.frames import depth_in_metres
from adibas.geometry.pinhole import back_project
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.simulation.boards_depth import flat_wall, see_boards, seen_from
from adibas.simulation.boards_look import BoardView, Hand
from adibas.simulation.depth_noise import EXACT, DepthNoise, DepthSensor
from adibas.simulation.device import DeviceSpread, draw_device

BOARD = Board(11, 8, 0.08)
BIASED = DeviceSpread(bias_of_border_m=0.003)
DEVICE = draw_device(6, (480, 640), BIASED)
CAMERA = DEVICE.depth


def unit(vector):
    return np.array(vector, float) / np.linalg.norm(vector)


def pose(turn=(0.2, -0.35, 0.1), z_m=1.6):
    rotation = rotation_from_vector(np.array(turn))
    middle = BOARD.points_m().mean(axis=0)
    return RigidTransform(rotation, np.array([0.1, -0.05, z_m]) - rotation @ middle)


def points_of(inverse_depth):
    with np.errstate(divide="ignore"):
        z_m = np.where(inverse_depth > 0, 1.0 / inverse_depth.astype(float), np.nan)
    return back_project(z_m, CAMERA.intrinsics)


def test_a_wall_has_the_depth_of_its_plane_everywhere():
    wall = Plane(unit((0.1, -0.2, -1.0)), 1.8)
    points_m = points_of(flat_wall(wall, CAMERA).inverse_depth)
    np.testing.assert_allclose(wall.signed_distance_m(points_m), 0.0, atol=1e-6)
    frontal = 1.0 / flat_wall(Plane(np.array([0.0, 0.0, -1.0]), 2.5), CAMERA).inverse_depth
    np.testing.assert_allclose(frontal, 2.5, rtol=1e-6)


def test_what_is_behind_a_wall_leaning_back_is_nothing():
    floor = Plane(np.array([0.0, -1.0, 0.0]), 0.9)
    inverse_depth = flat_wall(floor, CAMERA).inverse_depth
    v, _ = np.indices(inverse_depth.shape)
    above = v < CAMERA.intrinsics.cy
    assert (inverse_depth[above] == 0).all()
    assert (inverse_depth[~above] >= 0).all()
    assert 1 / inverse_depth[-1, 0] == pytest.approx(
        0.9 * CAMERA.intrinsics.fy / (479 - CAMERA.intrinsics.cy), rel=1e-5
    )


def test_a_board_is_a_plane_with_the_outline_of_its_paper():
    view = BoardView(BOARD, pose(), margin_squares=0.5)
    wall = flat_wall(Plane(np.array([0.0, 0.0, -1.0]), 3.0), CAMERA)
    seen = see_boards((view,), CAMERA, behind=Wall(wall))
    on_board = seen.inverse_depth > 1 / 2.9
    points_m = points_of(seen.inverse_depth)[on_board]
    normal = view.camera_from_board.rotation[:, 2]
    away_m = (points_m - view.camera_from_board.translation_m) @ normal
    np.testing.assert_allclose(away_m, 0.0, atol=2e-6)
    np.testing.assert_allclose(seen.inverse_depth[~on_board], 1 / 3.0, rtol=1e-6)
    low, high = -1.5 * 0.08, np.array([11.5, 8.5]) * 0.08
    corners_m = np.array([(low, low, 0), (high[0], low, 0), (*high, 0), (low, high[1], 0)])
    vector, _ = cv2.Rodrigues(view.camera_from_board.rotation)
    outline, _ = cv2.projectPoints(
        corners_m, vector, view.camera_from_board.translation_m, CAMERA.intrinsics.matrix(), None
    )
    area_px = cv2.contourArea(outline.astype(np.float32))
    assert on_board.sum() == pytest.approx(area_px, rel=1e-3)


class Wall:
    """What stands behind."""

    def __init__(self, seen):
        self.inverse_depth, self.infrared = seen.inverse_depth, seen.reflectance


def test_ink_gives_back_less_of_the_pattern_than_paper():
    view = BoardView(BOARD, pose((0, 0, 0)))
    seen = see_boards((view,), CAMERA)
    for row, column in ((0, 0), (0, 1), (3, 4), (8, 11)):
        middle_m = np.array([column - 0.5, row - 0.5, 0.0]) * 0.08
        x, y, z = view.camera_from_board.apply(middle_m)
        k = CAMERA.intrinsics
        u, v = round(k.fx * x / z + k.cx), round(k.fy * y / z + k.cy)
        assert (seen.reflectance[v, u] < 0.5) == BOARD.is_dark(row, column)


def test_hands_stand_out_before_the_board():
    hand = Hand((0.1, 0.1), (0.3, 0.1), 0.03)
    bare, held = (
        see_boards((BoardView(BOARD, pose((0, 0, 0)), hands=hands),), CAMERA)
        for hands in ((), (hand,))
    )
    changed = held.inverse_depth != bare.inverse_depth
    assert changed.sum() > 500
    np.testing.assert_allclose(1 / held.inverse_depth[changed], 1.58, atol=1e-5)


def test_a_board_moves_with_the_camera_that_sees_it():
    view = BoardView(BOARD, pose())
    other = DEVICE.calibration.color_from_depth
    there = seen_from(seen_from(view, other), other.inverse())
    np.testing.assert_allclose(
        there.camera_from_board.translation_m, view.camera_from_board.translation_m, atol=1e-12
    )


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_an_uncorrected_device_is_one_to_three_centimetres_off_and_the_truth_corrects_it(seed):
    device = draw_device(seed, (480, 640), BIASED)
    sensor = DepthSensor(device, EXACT, seed)
    wall = Plane(np.array([0.0, 0.0, -1.0]), 2.4)
    view = flat_wall(wall, device.depth)
    raw = sensor.measure(view.inverse_depth, view.reflectance, 0)
    measured_m = depth_in_metres(raw, 0.001)
    corrected_m = device.calibration.corrected_depth(measured_m)
    is_known = ~np.isnan(measured_m)
    assert is_known.mean() > 0.9
    error_m = np.median(measured_m[is_known]) - 2.4
    assert 0.006 < abs(error_m) < 0.035
    # Steps of the disparity stay: 17 mm at this distance.
    assert abs(np.nanmean(corrected_m) - 2.4) < 0.004
    assert np.nanmax(np.abs(corrected_m - 2.4)) < 0.013
    across_m = [
        np.nanmean((measured_m - 2.4)[v : v + 160, u : u + 160]) for v in (0, 320) for u in (8, 480)
    ]
    assert np.ptp(across_m) > 0.002


def test_noise_leaves_the_plane_where_it_is():
    wall = Plane(unit((0.05, 0.1, -1.0)), 1.5)
    view = flat_wall(wall, CAMERA)
    sensor = DepthSensor(DEVICE, DepthNoise(), 3)
    depths_m = np.array(
        [
            DEVICE.calibration.corrected_depth(
                depth_in_metres(sensor.measure(view.inverse_depth, view.reflectance, i), 0.001)
            )
            for i in range(10)
        ]
    )
    n_seen = (~np.isnan(depths_m)).sum(axis=0)
    assert (n_seen > 0).mean() > 0.97
    mean_m = np.full(n_seen.shape, np.nan)
    np.divide(np.nansum(depths_m, axis=0), n_seen, out=mean_m, where=n_seen > 0)
    away_m = wall.signed_distance_m(back_project(mean_m, CAMERA.intrinsics))
    assert abs(np.nanmean(away_m)) < 0.001
    assert 0.0005 < np.nanstd(away_m) < 0.004
