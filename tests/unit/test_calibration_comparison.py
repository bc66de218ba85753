"""What a new calibration changes is told in millimetres of what is measured."""

import numpy as np
import pytest

from adibas.calibration.comparison import compare
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.pinhole import Intrinsics


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
