"""What a new calibration changes is told in millimetres of what is measured."""

import numpy as np
import pytest

from adibas.calibration.comparison import compare
from adibas.data.calibration import CameraCalibration, DepthBias, RgbdCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform, rotation_from_vector


def calibration(fx=525.0, cx=319.5, size=(640, 480), distortion=(), **changes):
    k = Intrinsics(fx, fx, cx, 239.5)
    return RgbdCalibration(color=CameraCalibration(*size, k, distortion), **changes)


def test_a_calibration_changes_nothing_against_itself():
    found = compare(calibration(), calibration())
    assert found.largest_change_m == 0
    assert all(one.before == one.now for one in found.parameters)


def test_a_focal_length_that_is_a_hundredth_longer_makes_lengths_a_hundredth_shorter():
    found = compare(calibration(fx=500.0), calibration(fx=505.0))
    assert found.largest_change_m == pytest.approx(0.5 * (1 - 500 / 505), rel=1e-9)


def test_a_shift_of_the_principal_point_changes_no_length():
    assert compare(calibration(cx=319.5), calibration(cx=329.5)).largest_change_m < 1e-12


def test_a_bent_lens_changes_lengths_at_the_border_most():
    # r = 0.5 / 2 m beside the axis: x (1 + k r^2) moves the corner inwards by about k r^3.
    change_m = compare(calibration(), calibration(distortion=(0.1, 0, 0, 0))).largest_change_m
    assert 0.01 < change_m < 0.1


def test_pixels_without_an_answer_are_left_out():
    found = compare(calibration(), calibration(distortion=(-2.0, 0, 0, 0)))
    assert np.isfinite(found.largest_change_m)


def test_a_change_stands_beside_what_both_calibrations_know_of_it():
    names = ("color.fx", "color.fy")
    before = calibration(parameter_names=names, covariance=np.diag([9.0, 1.0]))
    now = calibration(fx=530.0, parameter_names=names, covariance=np.diag([16.0, 1.0]))
    change = {one.name: one for one in compare(before, now).parameters}
    assert (change["color.fx"].before, change["color.fx"].now) == (525.0, 530.0)
    assert change["color.fx"].sigma == pytest.approx(5.0)
    assert np.isnan(change["color.cx"].sigma)


def test_what_cannot_be_compared_is_not():
    assert compare(calibration(), calibration(size=(1280, 960))) is None
    depth_only = RgbdCalibration(depth=calibration().color)
    assert compare(depth_only, calibration()) is None
    assert compare(calibration(), depth_only) is None


def test_the_depth_changes_by_what_the_bias_says_with_both_intervals():
    names = ("depth_bias.a", "depth_bias.b", "depth_bias.c")
    depth = calibration().color
    before = calibration(depth=depth, parameter_names=names, covariance=np.diag([9e-6, 0.0, 0.0]))
    turned = RigidTransform(
        rotation_from_vector(np.array([0.0, 0.002, 0.0])), np.array([0.0, 3.0, 4.0]) * 1e-3
    )
    now = calibration(
        depth=depth,
        depth_bias=DepthBias(0.001, 1.002, -0.001),
        color_from_depth=turned,
        parameter_names=names,
        covariance=np.diag([16e-6, 0.0, 0.0]),
    )
    found = compare(before, now)
    assert [one.measured_m for one in found.depths] == [1.0, 2.0, 3.0]
    moved_mm = [1000 * (one.now_m - one.before_m) for one in found.depths]
    np.testing.assert_allclose(moved_mm, [2.0, 1.0, -2.0], atol=1e-9)
    assert [one.sigma_m for one in found.depths] == pytest.approx([0.005] * 3)
    assert (found.turn_rad, found.shift_m) == pytest.approx((0.002, 0.005))


def test_a_depth_of_unknown_error_has_no_interval_and_another_depth_camera_no_change():
    depth = calibration().color
    found = compare(calibration(depth=depth), calibration(depth=depth))
    assert np.isnan([one.sigma_m for one in found.depths]).all()
    assert [one.before_m for one in found.depths] == [one.now_m for one in found.depths]
    for other in (None, calibration(size=(320, 240)).color):
        found = compare(calibration(depth=depth), calibration(depth=other))
        assert found.depths == ()
        assert np.isnan(found.shift_m)
