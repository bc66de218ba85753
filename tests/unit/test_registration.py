"""Depth in the colour image: against OpenCV, and against scenes whose answer is a formula."""

import cv2
import numpy as np
import pytest

from adibas.alignment.registration import (
    register_depth,
    register_depth_nearest,
    register_pixels,
)
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform

DEPTH_CAMERA = CameraCalibration(640, 480, Intrinsics(580, 580, 319.5, 239.5))
TURN = RigidTransform(cv2.Rodrigues(np.array([0.01, -0.008, 0.012]))[0], [-0.025, 0.001, 0.002])
SHIFT = RigidTransform(np.eye(3), [-0.025, 0.0, 0.0])
BENT = (0.1, -0.2, 0.001, 0.002, 0.05)


def rgbd(height, width, focal, distortion=(), color_from_depth=TURN, depth_camera=DEPTH_CAMERA):
    lens = Intrinsics(focal, focal, width / 2 - 0.5, height / 2 - 0.5)
    color = CameraCalibration(width, height, lens, distortion)
    return RgbdCalibration(color, depth_camera, color_from_depth)


def wall_with_box(wall_m=3.0, box_m=1.8):
    depth_m = np.full((480, 640), wall_m, np.float32)
    depth_m[140:340, 220:420] = box_m
    return depth_m


def opencv_registered(depth_m, calibration):
    transform = np.eye(4)
    transform[:3, :3] = calibration.color_from_depth.rotation
    transform[:3, 3] = calibration.color_from_depth.translation_m
    registered = cv2.registerDepth(
        calibration.depth.intrinsics.matrix(),
        calibration.color.intrinsics.matrix(),
        None,
        transform,
        depth_m,
        (calibration.color.width, calibration.color.height),
    )
    return np.where(registered > 0, registered, np.nan)


def test_nearest_pixels_agree_with_opencv_up_to_rounding():
    rng = np.random.default_rng(3)
    depth_m = wall_with_box() + rng.normal(0, 0.005, (480, 640)).astype(np.float32)
    depth_m[rng.random(depth_m.shape) < 0.02] = np.nan
    calibration = rgbd(480, 640, 525)
    ours, theirs = (
        register_depth_nearest(depth_m, calibration),
        opencv_registered(depth_m, calibration),
    )
    different = ~np.isclose(ours, theirs, atol=1e-5, equal_nan=True)
    assert np.isfinite(theirs).sum() > 200_000
    assert different.sum() < 1e-3 * different.size


def test_nearest_pixels_refuse_a_bent_colour_camera():
    with pytest.raises(ValueError, match="without distortion"):
        register_depth_nearest(wall_with_box(), rgbd(480, 640, 525, BENT))


def test_registration_needs_both_cameras():
    with pytest.raises(ValueError, match="both cameras"):
        register_depth(wall_with_box(), RgbdCalibration(depth=DEPTH_CAMERA))


@pytest.mark.parametrize("distortion", [(), BENT])
@pytest.mark.parametrize("depth_distortion", [(), (-0.08, 0.05, 0.0, 0.001)])
def test_a_tilted_plane_has_no_holes_and_the_depth_of_the_formula(distortion, depth_distortion):
    depth_camera = CameraCalibration(640, 480, DEPTH_CAMERA.intrinsics, depth_distortion)
    calibration = rgbd(1024, 1280, 1050, distortion, depth_camera=depth_camera)
    normal, offset_m = np.array([0.5, 0.2, -1.0]), 2.2
    depth_m = -offset_m / (rays(depth_camera) @ normal)
    registered_m = register_depth(depth_m.astype(np.float32), calibration)
    normal_color = TURN.rotation @ normal
    offset_color_m = offset_m - normal_color @ TURN.translation_m
    expected_m = -offset_color_m / (rays(calibration.color) @ normal_color)
    inside = np.s_[120:900, 140:1140]
    assert np.isfinite(registered_m[inside]).all()
    np.testing.assert_allclose(registered_m[inside], expected_m[inside], atol=4e-4)


def rays(camera):
    v, u = np.indices((camera.height, camera.width), dtype=float)
    points = cv2.undistortPoints(
        np.stack([u, v], -1).reshape(-1, 1, 2),
        camera.intrinsics.matrix(),
        np.array(camera.distortion or (0, 0, 0, 0), float),
        criteria=(3, 200, 1e-14),
    )
    flat = np.concatenate([points[:, 0], np.ones((len(points), 1))], axis=1)
    return flat.reshape(camera.height, camera.width, 3)


def test_no_depth_is_invented_between_two_surfaces():
    registered_m = register_depth(wall_with_box(), rgbd(1024, 1280, 1050, color_from_depth=SHIFT))
    seen = registered_m[np.isfinite(registered_m)]
    assert set(np.unique(seen)) == {np.float32(1.8), np.float32(3.0)}


def test_a_surface_hidden_from_the_colour_camera_does_not_shine_through():
    calibration = rgbd(1024, 1280, 1050, color_from_depth=SHIFT)
    registered_m = register_depth(wall_with_box(), calibration)
    left = (220 - 0.5 - 319.5) / 580 * 1.8 - 0.025
    right = (420 - 0.5 - 319.5) / 580 * 1.8 - 0.025
    columns = np.arange(
        int(np.ceil(left / 1.8 * 1050 + 639.5)) + 1, int(right / 1.8 * 1050 + 639.5) - 1
    )
    assert (registered_m[360:660, columns] == np.float32(1.8)).all()
    shadow = int(right / 1.8 * 1050 + 639.5) + 2
    assert np.isnan(registered_m[360:660, shadow]).all()


def test_an_image_of_the_depth_camera_moves_along_with_the_depth():
    depth_m = wall_with_box()
    registration = register_pixels(depth_m, rgbd(1024, 1280, 1050))
    moved = registration.moved(depth_m < 2)
    near = registration.depth_m < 2
    assert near.sum() > 100_000
    np.testing.assert_array_equal(moved, near)


def test_nothing_measured_gives_nothing_registered():
    nothing = np.full((480, 640), np.nan, np.float32)
    assert np.isnan(register_depth(nothing, rgbd(480, 640, 525))).all()
