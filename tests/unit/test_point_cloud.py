"""The surface as coloured points: on the surface, and of the colour seen there."""

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.surface import BurstDisparity
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.pipeline.point_cloud import surface_points

COLOR = CameraCalibration(160, 120, Intrinsics(150.0, 150.0, 80.0, 60.0))
DEPTH = CameraCalibration(80, 60, Intrinsics(70.0, 71.0, 39.0, 30.5))
MOVED = RigidTransform(rotation_from_vector(np.array([0.01, -0.02, 0.03])), np.array([0.03, 0, 0]))
CALIBRATION = RgbdCalibration(COLOR, DEPTH, MOVED)


def surface(per_m):
    return BurstDisparity(per_m.astype(np.float32), np.full(per_m.shape, 5, np.int64), 5)


def picture():
    """Red tells the column, green the row."""
    rgb = np.zeros((120, 160, 3), np.uint8)
    rgb[..., 0], rgb[..., 1] = np.arange(160), np.arange(120)[:, None]
    return rgb


def test_points_of_a_wall_lie_on_it_and_have_the_colour_of_their_pixel():
    cloud = surface_points(surface(np.full((60, 80), 0.5)), CALIBRATION, picture())
    in_depth = MOVED.inverse().apply(cloud.points_m)
    np.testing.assert_allclose(in_depth[:, 2], 2.0, rtol=1e-6)
    u = 150.0 * cloud.points_m[:, 0] / cloud.points_m[:, 2] + 80.0
    v = 150.0 * cloud.points_m[:, 1] / cloud.points_m[:, 2] + 60.0
    np.testing.assert_allclose(cloud.colors_rgb[:, 0], u, atol=0.5001)
    np.testing.assert_allclose(cloud.colors_rgb[:, 1], v, atol=0.5001)


def test_pixels_without_depth_and_beside_the_picture_give_no_point():
    per_m = np.full((60, 80), np.nan)
    assert len(surface_points(surface(per_m), CALIBRATION, picture()).points_m) == 0
    per_m[30, 40] = 0.5
    assert len(surface_points(surface(per_m), CALIBRATION, picture()).points_m) == 1
    assert len(surface_points(surface(per_m), CALIBRATION, picture()[:40]).points_m) == 0


@pytest.mark.parametrize("most", [4800, 1200, 100])
def test_there_are_no_more_points_than_asked_for(most):
    cloud = surface_points(surface(np.full((60, 80), 0.6)), CALIBRATION, picture(), most)
    assert most / 4 < len(cloud.points_m) <= most
