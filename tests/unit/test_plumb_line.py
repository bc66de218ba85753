"""The vertical and the horizon in a picture, against points projected one by one."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.data.calibration import CameraCalibration
from adibas.geometry.pinhole import Intrinsics, project
from adibas.pipeline.plumb import plumb_line
from adibas.simulation.rotations import about

CAMERA = CameraCalibration(1280, 1024, Intrinsics(1060.0, 1055.0, 651.0, 500.0))
CENTRE = np.array([639.5, 511.5])
X, Z = np.eye(3)[0], np.eye(3)[2]
angles = st.floats(-0.35, 0.35)


def up_of(pitch_rad, roll_rad):
    """Up in the axes of a camera that looks `pitch_rad` upwards and then rolls about its axis."""
    return about(Z, roll_rad) @ about(X, -pitch_rad) @ np.array([0.0, -1.0, 0.0])


def distance_to(segment, points):
    """Return the distance of (N, 2) pixels from the line through a segment."""
    (u1, v1), (u2, v2) = segment
    along = np.array([u2 - u1, v2 - v1]) / math.dist(*segment)
    across = np.array([-along[1], along[0]])
    return (np.asarray(points) - [u1, v1]) @ across


@given(angles, angles)
def test_points_over_one_another_lie_on_the_vertical_through_the_centre(pitch_rad, roll_rad):
    up = up_of(pitch_rad, roll_rad)
    k = CAMERA.intrinsics
    ray = np.array([(CENTRE[0] - k.cx) / k.fx, (CENTRE[1] - k.cy) / k.fy, 1.0])
    points_m = 3.0 * ray + np.linspace(-0.8, 0.8, 7)[:, None] * up
    line = plumb_line(up, CAMERA)
    pixels = project(points_m, k)
    np.testing.assert_allclose(distance_to(line.vertical, pixels), 0, atol=1e-6)
    heights = points_m @ up
    ends = np.array(line.vertical)
    assert heights[-1] > heights[0]
    assert (pixels[-1] - pixels[0]) @ (ends[0] - ends[1]) > 0, "the first end is the upper one"


@given(angles, angles, st.floats(-0.3, 0.3))
def test_far_points_at_the_cameras_height_lie_on_the_horizon(pitch_rad, roll_rad, bearing_rad):
    up = up_of(pitch_rad, roll_rad)
    ahead = Z - (Z @ up) * up
    point_m = 1e6 * (about(up, bearing_rad) @ ahead)
    line = plumb_line(up, CAMERA)
    if line.horizon is not None:
        pixel = project(point_m, CAMERA.intrinsics)
        np.testing.assert_allclose(distance_to(line.horizon, [pixel]), 0, atol=1e-6)


@given(angles, angles)
def test_pitch_and_roll_are_those_of_the_camera(pitch_rad, roll_rad):
    centred = CameraCalibration(1280, 1024, Intrinsics(1060.0, 1060.0, 639.5, 511.5))
    line = plumb_line(up_of(pitch_rad, roll_rad), centred)
    # A camera that rolls against the clock shows the vertical turned with it.
    assert line.roll_rad == pytest.approx(roll_rad, abs=1e-9)
    assert line.pitch_rad == pytest.approx(pitch_rad, abs=1e-9)


@given(angles, angles)
def test_the_lines_end_at_the_border_of_the_picture(pitch_rad, roll_rad):
    line = plumb_line(up_of(pitch_rad, roll_rad), CAMERA)
    for segment in filter(None, (line.vertical, line.horizon)):
        for u, v in segment:
            assert -0.5 <= u <= 1279.5
            assert -0.5 <= v <= 1023.5
            border = min(abs(u + 0.5), abs(u - 1279.5), abs(v + 0.5), abs(v - 1023.5))
            assert border == pytest.approx(0.0, abs=1e-9)


def test_a_sensor_on_its_side_leans_by_nothing():
    line = plumb_line(np.array([-1.0, 0.0, 0.0]), CAMERA)
    assert line.roll_rad == pytest.approx(0.0)
    assert line.vertical[0][0] == pytest.approx(-0.5), "up is at the picture's left"
    assert line.horizon[0][0] == pytest.approx(line.horizon[1][0])


def test_a_camera_that_looks_straight_down_has_no_horizon():
    assert plumb_line(np.array([0.0, 0.0, -1.0]), CAMERA).horizon is None
