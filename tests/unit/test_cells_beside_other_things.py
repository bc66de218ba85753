"""Where a wall meets the floor, neither lends its pixels to the other."""

import numpy as np

from adibas.calibration.shots import cells_near_plane, cells_on_wall
from adibas.data.surface import BurstDisparity
from adibas.geometry.planes import Plane
from tests.unit.board_recordings import DEVICE, HEIGHT_M, room

UP = np.array([0.0, -1.0, 0.0])


def burst(distance_m):
    mean = room(distance_m).inverse_depth.astype(np.float32)
    return BurstDisparity(mean, np.full(mean.shape, 30, np.int64), 30)


def test_cells_of_a_wall_have_nothing_of_the_floor():
    for distance_m in (2.6, 2.7, 2.8, 3.0):
        cells = cells_on_wall(burst(distance_m), DEVICE.depth)
        np.testing.assert_allclose(cells.inverse_m, 1.0 / distance_m, atol=1e-6)
        assert len(cells) > 700


def test_blocks_of_a_floor_have_nothing_of_the_wall():
    for distance_m in (3.0, 3.3, 3.6):
        depth_m = (1.0 / burst(distance_m).mean_per_m).astype(np.float32)
        blocks_m = cells_near_plane(depth_m, DEVICE.depth, Plane(UP, HEIGHT_M))
        heights_m = HEIGHT_M - blocks_m[:, 1]
        assert np.abs(heights_m).max() < 0.001
        assert np.ptp(blocks_m[:, 2]) > 0.3


def test_where_no_floor_is_there_are_no_blocks():
    depth_m = np.full((480, 640), 1.0, np.float32)
    assert cells_near_plane(depth_m, DEVICE.depth, Plane(UP, 9.0)).shape == (0, 3)
