"""A calibration holds only numbers that a camera can have."""

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.pinhole import Intrinsics

PINHOLE = Intrinsics(500.0, 500.0, 320.0, 240.0)


@pytest.mark.parametrize("size", [(0, 480), (640, -1), (10**9, 480)])
def test_image_size_is_one_a_camera_can_have(size):
    with pytest.raises(ValueError, match="image size"):
        CameraCalibration(*size, PINHOLE)


@pytest.mark.parametrize("distortion", [(0.1,), (0.1, np.nan, 0.0, 0.0), (np.inf,) * 5])
def test_distortion_is_a_known_number_of_finite_values(distortion):
    with pytest.raises(ValueError, match="distortion must"):
        CameraCalibration(640, 480, PINHOLE, distortion)


def test_gravity_is_a_direction():
    with pytest.raises(ValueError, match="gravity must have length 1"):
        RgbdCalibration(gravity=np.array([0.0, 9.81, 0.0]))


@pytest.mark.parametrize("depth_unit_m", [0.0, -0.001, np.nan, np.inf])
def test_depth_unit_is_positive(depth_unit_m):
    with pytest.raises(ValueError, match="depth_unit_m"):
        RgbdCalibration(depth_unit_m=depth_unit_m)
