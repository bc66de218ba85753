"""Depth that the sensor moved into the colour image itself is moved there once."""

import math
from dataclasses import replace

import numpy as np
import pytest

from adibas.alignment.registration import register_pixels
from adibas.calibration.files import write_calibration
from adibas.calibration.registered import in_color_image
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import CalibrationError
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.pipeline.session import calibration_of
from adibas.recordings import create_recording, open_recording
from adibas.sensors import open_source
from adibas.sensors.openni2_description import describe_source
from adibas.sensors.openni2_streams import OpenStream
from adibas.sensors.ports import SensorDescription, VideoMode

COLOR = CameraCalibration(640, 480, Intrinsics(532.6, 532.6, 319.5, 239.5))
DEPTH = CameraCalibration(640, 480, Intrinsics(570.3, 570.3, 314.5, 235.5))
SHIFTED = RigidTransform(np.eye(3), np.array([-0.025, 0.0, 0.0]))
WHOLE = RgbdCalibration(color=COLOR, depth=DEPTH, color_from_depth=SHIFTED)
MADE_EARLIER = RgbdCalibration(color=COLOR, depth=DEPTH)
"""As programs before wrote it beside registered depth: with the depth stream's field of view."""


class Stream:
    """The library's stream, as far as it is asked for its field of view."""

    def __init__(self, horizontal_fov_rad):
        self._fov_rad = horizontal_fov_rad

    def get_horizontal_fov(self):
        return self._fov_rad


def described(*, is_registered, color_size=(640, 480), vendor="PrimeSense"):
    """What the program tells of a sensor with PrimeSense's fields of view."""
    depth = VideoMode("depth", 640, 480, 30.0, "DEPTH_1_MM")
    streams = {"depth": OpenStream(Stream(1.0225999), depth, is_mirrored=False)}
    if color_size is not None:
        color = VideoMode("color", *color_size, 30.0, "RGB888")
        streams["color"] = OpenStream(Stream(1.0821041), color, is_mirrored=False)
    sensor = SensorDescription("Carmine", vendor, "S1", "usb")
    return describe_source(sensor, streams, is_registered=is_registered).calibration


def recorded(path, calibration, *, is_registered=True):
    """Write a frame whose depth is of a wall."""
    info = SourceInfo(is_depth_registered=is_registered, calibration=calibration)
    color = np.zeros((480, 640, 3), np.uint8)
    with create_recording(path, info) as writer:
        writer.write(SensorFrame(0, 0, np.full((480, 640), 2000, np.uint16), color, 0))
    return path


def sources_of(calibration):
    """The depth pixels that some colour pixels of a wall take."""
    source = register_pixels(np.full((480, 640), 2.0, np.float32), calibration).source
    return [(k % 640, k // 640) for k in (int(source[v, u]) for u, v in PIXELS)]


PIXELS = [(60, 40), (320, 240), (580, 440)]


def test_a_colour_pixel_takes_the_registered_depth_of_its_own_place():
    assert sources_of(described(is_registered=True)) == PIXELS


def test_registered_depth_has_the_points_of_the_upper_rows_of_a_larger_colour_image():
    """PrimeSense reads its 4:3 images out of the top of the 5:4 chip."""
    calibration = described(is_registered=True, color_size=(1280, 1024))
    for point_m in np.array([[0.0, 0.0, 2.0], [-0.8, 0.5, 2.0], [0.9, -0.6, 2.5]]):
        k, d = calibration.color.intrinsics, calibration.depth.intrinsics
        u = k.fx * point_m[0] / point_m[2] + k.cx
        v = k.fy * point_m[1] / point_m[2] + k.cy
        # Borders of pixels halve; their centres lie half a pixel from them.
        in_depth = (u + 0.5) / 2 - 0.5, (v + 0.5) / 2 - 0.5
        seen = (in_depth[0] - d.cx) / d.fx, (in_depth[1] - d.cy) / d.fy
        np.testing.assert_allclose(seen, point_m[:2] / point_m[2], atol=1e-12)
    assert (calibration.depth.width, calibration.depth.height) == (640, 480)
    assert not calibration.color_from_depth.translation_m.any()


def test_registered_depth_without_the_colour_camera_has_no_calibration():
    assert described(is_registered=True, color_size=None) is None
    assert described(is_registered=False, color_size=None).depth is not None


def test_the_depth_image_of_primesense_lacks_half_a_window_of_the_infrared_image():
    """ROS openni2_camera, getDepthCameraInfo: 5 columns and 4 rows of 640."""
    focal_px = 320.0 / math.tan(1.0225999 / 2)
    for vendor, centre in (("PrimeSense", (314.5, 235.5)), ("Orbbec", (319.5, 239.5))):
        k = described(is_registered=False, vendor=vendor).depth.intrinsics
        assert (k.fx, k.fy, k.cx, k.cy) == pytest.approx((focal_px, focal_px, *centre))


def test_a_calibration_that_would_move_registered_depth_again_is_refused(tmp_path):
    path = recorded(tmp_path / "a.mcap", MADE_EARLIER)
    write_calibration(tmp_path / "sensor.json", WHOLE)
    with open_recording(path) as recording, pytest.raises(CalibrationError) as caught:
        calibration_of(recording, tmp_path / "sensor.json")
    assert "colour image itself, and sensor.json would move it a second time" in str(caught.value)


def test_a_calibration_of_the_colour_camera_alone_serves_for_both_images(tmp_path):
    path = recorded(tmp_path / "a.mcap", MADE_EARLIER)
    better = replace(COLOR, intrinsics=replace(COLOR.intrinsics, fx=528.0))
    write_calibration(tmp_path / "color.json", RgbdCalibration(color=better))
    with open_recording(path) as recording:
        calibration = calibration_of(recording, tmp_path / "color.json")
    assert calibration.depth == calibration.color == better


def test_depth_that_is_not_registered_is_moved_by_the_calibration_that_is_given(tmp_path):
    path = recorded(tmp_path / "a.mcap", MADE_EARLIER, is_registered=False)
    write_calibration(tmp_path / "sensor.json", WHOLE)
    with open_recording(path) as recording:
        assert calibration_of(recording, None).depth == DEPTH
        given = calibration_of(recording, tmp_path / "sensor.json")
    assert given.depth == DEPTH
    np.testing.assert_array_equal(given.color_from_depth.translation_m, SHIFTED.translation_m)


@pytest.mark.parametrize("own", [MADE_EARLIER, WHOLE, described(is_registered=True)])
def test_registered_recordings_are_measured_and_shown_without_another_shift(tmp_path, own):
    path = recorded(tmp_path / "a.mcap", own)
    with open_recording(path) as recording:
        assert sources_of(calibration_of(recording, None)) == PIXELS
    with open_source(str(path)) as camera:
        assert sources_of(camera.info.calibration) == PIXELS
        assert camera.info.is_depth_registered


def test_vertical_and_floor_go_into_the_axes_of_the_colour_camera():
    pose = RigidTransform(rotation_from_vector(np.array([0.02, -0.01, 0.03])), [-0.025, 0.01, 0.0])
    up = np.array([0.0, -math.cos(0.2), -math.sin(0.2)])
    whole = replace(WHOLE, color_from_depth=pose, gravity=-up, floor=Plane(up, 1.1))
    moved = in_color_image(whole)
    point_m = np.array([0.3, 0.4, 2.0])
    assert moved.floor.signed_distance_m(pose.apply(point_m)) == pytest.approx(
        whole.floor.signed_distance_m(point_m)
    )
    np.testing.assert_allclose(moved.gravity, -moved.floor.normal)
    assert moved.gravity @ (pose.rotation @ up) == pytest.approx(-1.0)


def test_the_error_of_a_depth_camera_that_is_not_used_is_in_no_interval():
    names = ("color.fx", "depth.fx", "color_from_depth.tx", "depth_bias.a")
    moved = in_color_image(
        replace(WHOLE, parameter_names=names, covariance=np.diag([1.0, 2.0, 3.0, 4.0]))
    )
    assert moved.parameter_names == ("color.fx", "depth_bias.a")
    np.testing.assert_array_equal(moved.covariance, np.diag([1.0, 4.0]))
    assert in_color_image(moved) is moved


def test_the_recordings_own_calibration_may_be_given_as_a_file(tmp_path):
    own = described(is_registered=True)
    path = recorded(tmp_path / "a.mcap", own)
    write_calibration(tmp_path / "own.json", own)
    with open_recording(path) as recording:
        assert calibration_of(recording, tmp_path / "own.json").depth == own.depth
