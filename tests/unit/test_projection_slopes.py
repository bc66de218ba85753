"""Projection and its derivatives against OpenCV and against differences."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.geometry import projection_kernels as kernels
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.projection import CAMERA_PARAMETERS, camera_numbers, project_with_slopes

LENS = (0.1, -0.2, 1e-3, -2e-3, 0.05, 0.03, -0.02, 0.01, 2e-3, -1e-3, 3e-3, 5e-4)


def camera(skew=3.0):
    numbers = camera_numbers(Intrinsics(1050.0, 1040.0, 640.0, 510.0), LENS)
    numbers[CAMERA_PARAMETERS.index("skew")] = skew
    return numbers


def points(seed):
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(-0.6, 0.6, (5, 2)), rng.uniform(0.8, 3.0, 5)])


def test_pixels_are_opencvs():
    matrix = np.array([[1050.0, 0, 640], [0, 1040, 510], [0, 0, 1]])
    theirs = cv2.projectPoints(points(1), np.zeros(3), np.zeros(3), matrix, np.array(LENS))[0][:, 0]
    np.testing.assert_allclose(
        project_with_slopes(points(1), camera(0.0)).pixels, theirs, atol=1e-9
    )


@given(st.integers(0, 1000))
def test_derivatives_are_those_of_small_steps(seed):
    at, numbers = points(seed), camera()
    slopes = project_with_slopes(at, numbers)
    for i in range(len(numbers)):
        step = np.zeros(17)
        step[i] = 1e-6 * max(1.0, abs(numbers[i]))
        up, down = (project_with_slopes(at, numbers + s).pixels for s in (step, -step))
        np.testing.assert_allclose(
            slopes.by_camera[:, :, i], (up - down) / (2 * step[i]), rtol=1e-5, atol=1e-4
        )
    for axis in range(3):
        step = np.eye(3)[axis] * 1e-6
        up, down = (project_with_slopes(at + s, numbers).pixels for s in (step, -step))
        np.testing.assert_allclose(
            slopes.by_point[:, :, axis], (up - down) / 2e-6, rtol=1e-5, atol=1e-3
        )


def test_points_behind_the_camera_have_no_pixel():
    slopes = project_with_slopes(np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]), camera())
    assert np.isnan(slopes.pixels[0]).all()
    assert np.isfinite(slopes.pixels[1]).all()


def test_a_pole_of_the_rational_model_gives_nan():
    numbers = camera_numbers(Intrinsics(1000, 1000, 0, 0), (0, 0, 0, 0, 0, -1.0, 0, 0))
    assert np.isnan(project_with_slopes(np.array([[1.0, 0.0, 1.0]]), numbers).pixels).all()


def test_a_camera_has_seventeen_numbers():
    with pytest.raises(ValueError, match="camera"):
        project_with_slopes(points(0), np.zeros(4))


def test_the_compiled_loop_is_the_written_one(monkeypatch):
    compiled = project_with_slopes(points(2), camera())
    for name in (
        "lens_slopes",
        "distorted_with_slopes",
        "project_with_slopes",
        "project_all_with_slopes",
    ):
        monkeypatch.setattr(kernels, name, getattr(kernels, name).py_func)
    written = project_with_slopes(points(2), camera())
    for ours, theirs in zip(compiled, written, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12)
    pole = camera_numbers(Intrinsics(1000, 1000, 0, 0), (0, 0, 0, 0, 0, -1.0, 0, 0))
    assert np.isnan(project_with_slopes(np.array([[1.0, 0.0, 1.0]]), pole).pixels).all()
