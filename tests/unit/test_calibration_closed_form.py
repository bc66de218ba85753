"""The closed form on exact homographies, and what it assumes where they do not suffice."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adibas.calibration.closed_form import Assumption, closed_forms, pose_from_homography

SIZE = (1024, 1280)
SKEWED = np.array([[1000.0, 12.0, 660.0], [0.0, 1040.0, 490.0], [0.0, 0.0, 1.0]])
STRAIGHT = np.array([[1000.0, 0.0, 660.0], [0.0, 1040.0, 490.0], [0.0, 0.0, 1.0]])


def views(matrix, vectors):
    """Homographies of boards that are turned by `vectors`."""
    found = []
    for i, vector in enumerate(vectors):
        rotation = cv2.Rodrigues(np.asarray(vector, float))[0]
        pose = np.column_stack([rotation[:, :2], [0.05 * i - 0.1, 0.02, 0.6 + 0.05 * i]])
        homography = matrix @ pose
        found.append(homography / np.linalg.norm(homography))
    return found


@given(st.integers(0, 10_000))
def test_exact_views_give_the_exact_camera_with_its_skew(seed):
    vectors = np.random.default_rng(seed).normal(0, 0.4, (6, 3))
    best = closed_forms(views(SKEWED, vectors), SIZE)[0]
    assert best.assumption is Assumption.NOTHING
    np.testing.assert_allclose(best.matrix, SKEWED, rtol=1e-6, atol=1e-5)


def test_two_views_give_a_camera_without_skew():
    best = closed_forms(views(STRAIGHT, [(0.4, 0.1, 0), (-0.1, 0.5, 0.2)]), SIZE)[0]
    assert best.assumption is Assumption.NO_SKEW
    np.testing.assert_allclose(best.matrix, STRAIGHT, rtol=1e-8, atol=1e-6)


def test_one_view_gives_the_focal_lengths_of_a_centred_camera():
    centred = STRAIGHT.copy()
    centred[:2, 2] = 639.5, 511.5
    best = closed_forms(views(centred, [(0.4, 0.3, 0)]), SIZE)[0]
    assert best.assumption is Assumption.CENTRED
    np.testing.assert_allclose(best.matrix, centred, rtol=1e-8, atol=1e-6)


def test_frontal_views_leave_everything_to_be_assumed():
    frontal = views(STRAIGHT, [(0, 0, 0.1 * i) for i in range(5)])
    noisy = [h + np.random.default_rng(i).normal(0, 1e-7, (3, 3)) for i, h in enumerate(frontal)]
    last = closed_forms(noisy, SIZE)[-1]
    assert last.assumption is Assumption.NOMINAL
    np.testing.assert_allclose(last.matrix, [[1152, 0, 639.5], [0, 1152, 511.5], [0, 0, 1]])


def test_no_view_still_gives_a_camera_to_begin_with():
    assert [form.assumption for form in closed_forms([], SIZE)] == [Assumption.NOMINAL]


@given(st.integers(0, 10_000))
def test_the_pose_of_an_exact_view_is_exact(seed):
    rng = np.random.default_rng(seed)
    rotation = cv2.Rodrigues(rng.normal(0, 0.5, 3))[0]
    shift_m = np.array([0.1, -0.2, rng.uniform(0.3, 4.0)])
    homography = SKEWED @ np.column_stack([rotation[:, :2], shift_m])
    pose = pose_from_homography(homography / np.linalg.norm(homography), SKEWED)
    np.testing.assert_allclose(pose.rotation, rotation, atol=1e-9)
    np.testing.assert_allclose(pose.translation_m, shift_m, atol=1e-9)


def test_a_homography_has_three_rows():
    with pytest.raises(ValueError, match="homography"):
        pose_from_homography(np.eye(4), STRAIGHT)
