"""The plane's homography against OpenCV, itself, and what makes it impossible."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.calibration.homography import fit_homography, map_plane

PLANE = np.stack(np.meshgrid(np.arange(7.0), np.arange(5.0)), axis=-1).reshape(-1, 2) * 0.03


def seen(rng):
    """A homography of a real view, and the pixels without noise."""
    rotation = cv2.Rodrigues(rng.normal(0, 0.4, 3))[0]
    pose = np.column_stack([rotation[:, :2], [rng.uniform(-0.1, 0.1), 0.05, 0.6]])
    matrix = np.array([[900.0, 2.0, 640.0], [0.0, 910.0, 500.0], [0.0, 0.0, 1.0]]) @ pose
    return matrix, map_plane(matrix, PLANE)


def at_unit_length(homography):
    return homography / np.linalg.norm(homography)


@given(st.integers(0, 10_000), st.booleans())
def test_exact_corners_give_the_exact_homography(seed, is_refined):
    matrix, pixels = seen(np.random.default_rng(seed))
    found = fit_homography(PLANE, pixels, is_refined=is_refined)
    np.testing.assert_allclose(found, at_unit_length(matrix), atol=1e-9)


def test_the_refined_homography_is_as_close_as_opencvs():
    rng = np.random.default_rng(3)
    _, pixels = seen(rng)
    pixels = pixels + rng.normal(0, 0.5, pixels.shape)
    ours = fit_homography(PLANE, pixels)
    theirs, _ = cv2.findHomography(PLANE, pixels, method=0)
    errors = [((map_plane(h, PLANE) - pixels) ** 2).sum() for h in (ours, theirs)]
    assert errors[0] <= errors[1] * (1 + 1e-9)
    np.testing.assert_allclose(map_plane(ours, PLANE), map_plane(theirs, PLANE), atol=2e-3)


def test_refining_lowers_the_error_in_the_image():
    rng = np.random.default_rng(4)
    _, pixels = seen(rng)
    pixels = pixels + rng.normal(0, 2.0, pixels.shape)
    linear, refined = (fit_homography(PLANE, pixels, is_refined=is_on) for is_on in (False, True))
    errors = [((map_plane(h, PLANE) - pixels) ** 2).sum() for h in (linear, refined)]
    assert errors[1] < errors[0]


def test_hidden_corners_are_left_out():
    matrix, pixels = seen(np.random.default_rng(5))
    pixels[3:20] = np.nan
    np.testing.assert_allclose(fit_homography(PLANE, pixels), at_unit_length(matrix), atol=1e-9)


def test_the_last_row_is_positive_at_the_points():
    matrix, pixels = seen(np.random.default_rng(6))
    found = fit_homography(PLANE - 0.5, pixels)
    assert ((PLANE - 0.5) @ found[2, :2] + found[2, 2] > 0).all()
    assert matrix.shape == found.shape


@pytest.mark.parametrize("kept", [slice(0, 3), slice(0, 7), slice(0, 0)])
def test_three_points_or_a_line_give_none(kept):
    _, pixels = seen(np.random.default_rng(7))
    assert fit_homography(PLANE[kept], pixels[kept]) is None


def test_one_point_seen_many_times_gives_none():
    assert fit_homography(PLANE, np.full_like(PLANE, 100.0)) is None


def test_four_points_are_enough():
    matrix, pixels = seen(np.random.default_rng(8))
    corners = [0, 6, 28, 34]
    found = fit_homography(PLANE[corners], pixels[corners])
    np.testing.assert_allclose(found, at_unit_length(matrix), atol=1e-9)


def test_unequal_lists_are_refused():
    with pytest.raises(ValueError, match="pixels"):
        fit_homography(PLANE, PLANE[:-1])
