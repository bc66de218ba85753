"""Projection and back-projection must undo each other, for any camera and depth."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from adibas.geometry.pinhole import Intrinsics, back_project, denormalise, normalise, project

cameras = st.builds(
    Intrinsics,
    fx=st.floats(100, 2000),
    fy=st.floats(100, 2000),
    cx=st.floats(-50, 700),
    cy=st.floats(-50, 500),
)
depths_m = arrays(np.float64, (3, 4), elements=st.floats(0.3, 8.0))


@given(depths_m, cameras)
def test_back_projected_pixels_project_onto_themselves(depth_m, camera):
    v, u = np.indices(depth_m.shape)
    points_m = back_project(depth_m, camera)
    pixels = project(points_m, camera)
    np.testing.assert_allclose(pixels, np.stack([u, v], axis=-1), atol=1e-9)
    np.testing.assert_array_equal(points_m[..., 2], depth_m)
    normalised = normalise(pixels, camera)
    np.testing.assert_allclose(denormalise(normalised, camera), pixels, atol=1e-9)


def test_projection_is_the_matrix_of_the_textbook():
    camera = Intrinsics(500.0, 510.0, 320.0, 240.0)
    point_m = np.array([0.2, -0.1, 2.0])
    homogeneous = camera.matrix() @ point_m
    np.testing.assert_allclose(project(point_m, camera), homogeneous[:2] / homogeneous[2])


def test_unmeasured_depth_stays_unmeasured():
    points_m = back_project(np.array([[1.0, np.nan]]), Intrinsics(500, 500, 0, 0))
    assert np.isfinite(points_m[0, 0]).all()
    assert np.isnan(points_m[0, 1]).all()


def test_points_not_in_front_of_the_camera_have_no_pixel():
    points_m = np.array([[0.1, 0.1, 0.0], [0.1, 0.1, -1.0], [0.1, 0.1, np.nan]])
    assert np.isnan(project(points_m, Intrinsics(500, 500, 0, 0))).all()


@pytest.mark.parametrize(("fx", "fy"), [(0, 500), (500, -1), (np.nan, 500), (np.inf, 500)])
def test_focal_lengths_must_be_positive(fx, fy):
    with pytest.raises(ValueError, match="focal lengths"):
        Intrinsics(fx=fx, fy=fy, cx=320, cy=240)


@pytest.mark.parametrize("cx", [np.nan, np.inf])
def test_principal_point_must_be_finite(cx):
    with pytest.raises(ValueError, match="principal point"):
        Intrinsics(fx=500, fy=500, cx=cx, cy=240)
