"""The surface as coloured discs: on the surface, along it, and of the colour seen there."""

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.surface import BurstDisparity
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.pipeline.surface_discs import surface_discs

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
    discs = surface_discs(surface(np.full((60, 80), 0.5)), CALIBRATION, picture())
    in_depth = MOVED.inverse().apply(discs.points_m.astype(float))
    np.testing.assert_allclose(in_depth[:, 2], 2.0, rtol=1e-6)
    u = 150.0 * discs.points_m[:, 0] / discs.points_m[:, 2] + 80.0
    v = 150.0 * discs.points_m[:, 1] / discs.points_m[:, 2] + 60.0
    np.testing.assert_allclose(discs.colors_rgb[:, 0], u, atol=0.5001)
    np.testing.assert_allclose(discs.colors_rgb[:, 1], v, atol=0.5001)


def test_pixels_without_depth_and_beside_the_picture_give_no_point():
    per_m = np.full((60, 80), np.nan)
    assert len(surface_discs(surface(per_m), CALIBRATION, picture()).points_m) == 0
    per_m[30, 40] = 0.5
    assert len(surface_discs(surface(per_m), CALIBRATION, picture()).points_m) == 1
    assert len(surface_discs(surface(per_m), CALIBRATION, picture()[:40]).points_m) == 0


@pytest.mark.parametrize("most", [4800, 1200, 100])
def test_there_are_no_more_points_than_asked_for(most):
    discs = surface_discs(surface(np.full((60, 80), 0.6)), CALIBRATION, picture(), most)
    assert most / 4 < len(discs.points_m) <= most


def test_discs_lie_along_a_slanted_wall_and_leave_no_gap_when_seen_from_the_camera():
    normal = np.array([0.5, -0.2, -0.85])
    normal /= np.linalg.norm(normal)
    columns, rows = np.meshgrid(np.arange(80), np.arange(60))
    rays = np.stack([(columns - 39.0) / 70.0, (rows - 30.5) / 71.0, np.ones((60, 80))], axis=-1)
    per_m = rays @ normal / (normal @ [0.0, 0.0, 2.0])
    discs = surface_discs(surface(per_m), CALIBRATION, picture())
    in_depth = discs.normals @ MOVED.rotation
    known = np.isfinite(in_depth).all(axis=1)
    assert known.mean() > 0.8
    np.testing.assert_allclose(in_depth[known], np.tile(normal, (known.sum(), 1)), atol=1e-4)
    points_m = MOVED.inverse().apply(discs.points_m.astype(float))
    inner = rays[5:-5, 5:-15].reshape(-1, 3)  # the colour picture ends before the depth
    reached_m = inner * (normal @ [0.0, 0.0, 2.0] / (inner @ normal))[:, None]
    apart_m = np.linalg.norm(reached_m[::7, None] - points_m[None, known], axis=2)
    assert (apart_m <= discs.radii_m[known]).any(axis=1).all()
