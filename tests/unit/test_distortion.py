"""Distortion against OpenCV, its inverse against itself, and its end where the model folds."""

import warnings

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from adibas.geometry import distortion_kernels as kernels
from adibas.geometry.distortion import (
    FoldWarning,
    distort,
    is_one_to_one,
    pixel_rays,
    project_distorted,
    undistort,
    undistort_pixels,
)
from adibas.geometry.pinhole import Intrinsics

THESIS_CAMERA = Intrinsics(530.09, 526.36, 328.22, 268.73)
THESIS_LENS = (0.26172, -0.82105, -0.00106, 0.00085)
LENSES = [
    (-0.2, 0.05, 0.00178, -0.00028),
    (-0.266, -0.0386, 0.00178, -0.00028, 0.238),
    (0.1, -0.2, 0.001, 0.002, 0.05, 0.02, 0.01, -0.003),
    (0.1, -0.2, 0.001, 0.002, 0.05, 0.02, 0.01, -0.003, 0.01, -0.02, 0.005, 0.01),
]
POLE = (0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0)  # at radius 1


def pixel_grid(height=480, width=640):
    v, u = np.indices((height, width), float)
    return np.stack([u, v], axis=-1)


@pytest.fixture
def uncompiled(monkeypatch):
    """The kernels as Python runs them, so that coverage sees their branches."""
    for name in (
        "distort_point",
        "distort_points",
        "is_regular",
        "first_fold",
        "fold_radii",
        "is_within",
        "invert_point",
        "invert_points",
        "are_one_to_one",
    ):
        monkeypatch.setattr(kernels, name, getattr(kernels, name).py_func)
    return kernels


def random_points(n=2000):
    rng = np.random.default_rng(3)
    z_m = rng.uniform(0.5, 4.0, n)
    return np.stack([*(rng.uniform(-0.5, 0.5, (2, n)) * z_m), z_m], axis=-1)


@pytest.mark.parametrize("lens", [(), *LENSES], ids=len)
def test_projection_is_that_of_opencv(lens):
    points_m = random_points()
    expected = cv2.projectPoints(
        points_m, np.zeros(3), np.zeros(3), THESIS_CAMERA.matrix(), np.array(lens)
    )[0][:, 0]
    pixels = project_distorted(points_m, THESIS_CAMERA, lens)
    np.testing.assert_allclose(pixels, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("lens", LENSES, ids=len)
def test_inverse_is_that_of_opencv_with_tight_criteria(lens):
    pixels = pixel_grid(48, 64).reshape(-1, 2) * 10.0
    expected = cv2.undistortPoints(
        pixels, THESIS_CAMERA.matrix(), np.array(lens), criteria=(3, 2000, 1e-16)
    )[:, 0]
    found = undistort_pixels(pixels, THESIS_CAMERA, lens)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)


coefficients = st.tuples(
    st.floats(-0.5, 0.5),
    st.floats(-1.0, 1.0),
    st.floats(-0.01, 0.01),
    st.floats(-0.01, 0.01),
    st.floats(-0.5, 0.5),
    st.floats(-0.3, 0.3),
    st.floats(-0.3, 0.3),
    st.floats(-0.1, 0.1),
    *[st.floats(-0.02, 0.02)] * 4,
)


@settings(max_examples=40)
@given(coefficients)
def test_pixels_come_back_wherever_the_model_is_one_to_one(lens):
    normalised = (pixel_grid(25, 33) - (16, 12)) / 20.0
    inside = normalised[is_one_to_one(normalised, lens)]
    distorted = distort(inside, lens)
    found = undistort(distorted, lens)
    assert np.isfinite(found).all()
    again = distort(found, lens)
    np.testing.assert_allclose(again, distorted, rtol=0, atol=1e-10 / 530)
    # Beside the fold the inverse itself is ill-conditioned; elsewhere the point is the same one.
    far_from_fold = is_one_to_one(inside * 1.05, lens)
    np.testing.assert_allclose(found[far_from_fold], inside[far_from_fold], rtol=0, atol=1e-9)


def test_thesis_lens_folds_in_the_corners_of_its_image_and_nowhere_else():
    with pytest.warns(FoldWarning, match="not one-to-one"):
        rays = pixel_rays((480, 640), THESIS_CAMERA, THESIS_LENS)
    is_lost = np.isnan(rays).any(axis=-1)
    # Radial terms alone: r + k1 r^3 + k2 r^5 grows until its derivative's root.
    k1, k2 = THESIS_LENS[:2]
    fold = np.sqrt((-3 * k1 - np.sqrt(9 * k1**2 - 20 * k2)) / (10 * k2))
    rim = fold + k1 * fold**3 + k2 * fold**5
    distorted = (pixel_grid() - (328.22, 268.73)) / (530.09, 526.36)
    radius = np.hypot(distorted[..., 0], distorted[..., 1])
    assert is_lost[radius > rim + 0.003].all()
    assert not is_lost[radius < rim - 0.003].any()
    assert np.hypot(rays[..., 0], rays[..., 1])[~is_lost].max() < fold * 1.01


def test_thesis_lens_gives_every_other_pixel_back():
    with pytest.warns(FoldWarning):
        rays = pixel_rays((480, 640), THESIS_CAMERA, THESIS_LENS)
    kept = ~np.isnan(rays[..., 0])
    points_m = np.concatenate([rays[kept], np.ones((kept.sum(), 1))], axis=-1)
    pixels = project_distorted(points_m, THESIS_CAMERA, THESIS_LENS)
    np.testing.assert_allclose(pixels, pixel_grid()[kept], rtol=0, atol=1e-10)


def test_points_beyond_the_fold_do_not_come_back_into_the_image():
    beyond_m = np.array([[0.9, 0.0, 1.0], [0.0, -1.2, 1.0], [0.1, 0.1, 1.0]])
    pixels = project_distorted(beyond_m, THESIS_CAMERA, THESIS_LENS)
    assert np.isnan(pixels[:2]).all()
    assert np.isfinite(pixels[2]).all()


def test_fold_of_a_tilted_lens_is_found_in_each_direction():
    """With p2 alone the Jacobian's determinant is (1 + 6 p2 x)(1 + 2 p2 x) - (2 p2 y)^2."""
    lens = (0.0, 0.0, 0.0, 0.1)
    grid = (pixel_grid(81, 81) - 40) / 10.0
    x, y = grid[..., 0], grid[..., 1]
    expected = ((1 + 0.6 * x) * (1 + 0.2 * x) - (0.2 * y) ** 2 > 0) & (1 + 0.2 * x > 0)
    np.testing.assert_array_equal(is_one_to_one(grid, lens), expected)


def test_model_ends_before_a_pole():
    inside = is_one_to_one(np.array([[0.0, 0.99], [0.0, 1.0], [0.0, 1.01], [3.0, 0.0]]), POLE)
    assert inside.tolist() == [True, False, False, False]
    np.testing.assert_allclose(undistort(distort(np.array([0.0, 0.99]), POLE), POLE), [0.0, 0.99])


def test_missing_and_infinite_coordinates_become_missing_without_a_warning_for_the_missing():
    points = np.array([[np.nan, 0.1], [0.1, np.nan], [0.1, 0.2]])
    found = undistort(points, THESIS_LENS)
    assert np.isnan(found[:2]).all()
    assert np.isfinite(found[2]).all()
    assert not is_one_to_one(points[:2], THESIS_LENS).any()
    with pytest.warns(FoldWarning, match="1 of 1"):
        assert np.isnan(undistort(np.array([np.inf, 0.0]), THESIS_LENS)).all()


def test_lens_without_distortion_changes_nothing():
    grid = pixel_grid(4, 5)
    for lens in ((), (0.0,) * 5):
        np.testing.assert_array_equal(distort(grid, lens), grid)
        np.testing.assert_array_equal(undistort(grid, lens), grid)
    behind = project_distorted(np.array([0.0, 0.0, -1.0]), THESIS_CAMERA, ())
    assert np.isnan(behind).all()


@pytest.mark.parametrize("lens", [(0.1,), (0.1,) * 14, (0.1, np.nan, 0.0, 0.0)])
def test_coefficients_must_be_a_known_number_of_finite_values(lens):
    with pytest.raises(ValueError, match="distortion must"):
        distort(np.zeros(2), lens)


@pytest.mark.parametrize("lens", [THESIS_LENS, (0.1, 0.0, 0.03, -0.05), LENSES[3], POLE])
def test_kernels_say_the_same_compiled_or_not(lens, uncompiled, monkeypatch):
    k = np.zeros(12)
    k[: len(lens)] = lens
    points = np.ascontiguousarray(((pixel_grid(9, 12) - (6, 4)) / 6.0).reshape(-1, 2))
    points = np.concatenate([points, [[np.nan, 0.0]]])
    folds = uncompiled.fold_radii(8, k)
    guesses = np.linspace(0.0, 0.7, 16)
    distorted = uncompiled.distort_points(points, k)
    found = uncompiled.invert_points(points, k, folds, guesses, 5.0)
    inside = uncompiled.are_one_to_one(points, k, folds)
    monkeypatch.undo()
    np.testing.assert_allclose(kernels.distort_points(points, k), distorted, rtol=1e-12)
    np.testing.assert_allclose(kernels.fold_radii(8, k), folds, rtol=1e-9)
    compiled = kernels.invert_points(points, k, folds, guesses, 5.0)
    np.testing.assert_allclose(compiled, found, atol=1e-12)
    np.testing.assert_array_equal(kernels.are_one_to_one(points, k, folds), inside)


def test_inversion_starts_again_from_the_axis_where_a_poor_guess_fails(uncompiled):
    k = np.zeros(12)
    k[:4] = THESIS_LENS
    folds = uncompiled.fold_radii(1, k)
    target = np.array([[0.3, 0.2]])
    for beyond_the_fold in (0.9, 1.5):
        guesses = np.full(4, beyond_the_fold)
        found = uncompiled.invert_points(target, k, folds, guesses, 0.7)
        again = uncompiled.distort_points(found, k)
        np.testing.assert_allclose(again, target, atol=1e-13)
        assert np.hypot(*found[0]) < folds[0]


def test_inversion_gives_up_after_its_steps_and_says_nothing_wrong(uncompiled, monkeypatch):
    monkeypatch.setattr(uncompiled, "MAX_STEPS", 1)
    k = np.zeros(12)
    k[:4] = THESIS_LENS
    folds = uncompiled.fold_radii(1, k)
    found = uncompiled.invert_points(np.array([[0.5, 0.2]]), k, folds, np.full(4, 0.2), 0.7)
    assert np.isnan(found).all()


def test_warnings_are_only_given_for_lost_pixels():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isfinite(pixel_rays((48, 64), THESIS_CAMERA, LENSES[0])).all()
