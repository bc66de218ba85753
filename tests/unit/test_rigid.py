"""Rigid transforms: fitted, chained, and turned into vectors and back."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from adibas.geometry.rigid import (
    RigidTransform,
    fit_rigid,
    rotation_from_vector,
    rotation_vector,
)

vectors = arrays(np.float64, 3, elements=st.floats(-4.0, 4.0))


def random_transform(rng):
    return RigidTransform(Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3))


@given(vectors)
def test_rotation_of_a_vector_is_that_of_opencv(vector_rad):
    expected = cv2.Rodrigues(vector_rad)[0]
    np.testing.assert_allclose(rotation_from_vector(vector_rad), expected, atol=1e-12)


@given(vectors)
def test_rotation_vector_gives_the_same_rotation_again(vector_rad):
    rotation = rotation_from_vector(vector_rad)
    found_rad = rotation_vector(rotation)
    assert np.linalg.norm(found_rad) <= np.pi + 1e-12
    np.testing.assert_allclose(rotation_from_vector(found_rad), rotation, atol=1e-9)


@pytest.mark.parametrize("angle_rad", [0.0, 1e-12, 1e-6, 0.3, np.pi / 2, 3.0, np.pi - 1e-9, np.pi])
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, -0.6, 0.8), (-0.48, 0.64, 0.6)])
def test_small_and_half_turns_keep_their_axis(axis, angle_rad):
    vector_rad = angle_rad * np.array(axis)
    found_rad = rotation_vector(rotation_from_vector(vector_rad))
    is_half_turn = angle_rad == np.pi  # then the axis' sign is free
    candidates = [vector_rad, -vector_rad] if is_half_turn else [vector_rad]
    assert min(np.abs(found_rad - candidate).max() for candidate in candidates) < 1e-9


@pytest.mark.parametrize("n_points", [3, 4, 50])
def test_moved_points_give_their_transform_back(n_points):
    rng = np.random.default_rng(n_points)
    truth = random_transform(rng)
    points_m = rng.normal(size=(n_points, 3))
    found = fit_rigid(truth.apply(points_m), points_m)
    np.testing.assert_allclose(found.rotation, truth.rotation, atol=1e-12)
    np.testing.assert_allclose(found.translation_m, truth.translation_m, atol=1e-12)


def test_fit_of_noisy_points_is_that_of_scipy_with_weights():
    rng = np.random.default_rng(5)
    truth = random_transform(rng)
    points_m = rng.normal(size=(20, 3))
    moved_m = truth.apply(points_m) + rng.normal(scale=0.05, size=(20, 3))
    weights = rng.uniform(0.1, 2.0, 20)
    found = fit_rigid(moved_m, points_m, weights)
    to_mean = np.average(moved_m, axis=0, weights=weights)
    from_mean = np.average(points_m, axis=0, weights=weights)
    expected, _ = Rotation.align_vectors(moved_m - to_mean, points_m - from_mean, weights)
    np.testing.assert_allclose(found.rotation, expected.as_matrix(), atol=1e-7)
    np.testing.assert_allclose(found.apply(from_mean), to_mean, atol=1e-12)


def test_mirrored_points_are_fitted_by_a_rotation_not_a_reflection():
    rng = np.random.default_rng(6)
    points_m = rng.normal(size=(10, 3))
    found = fit_rigid(points_m * (-1, 1, 1), points_m)
    assert np.linalg.det(found.rotation) == pytest.approx(1.0)


def test_missing_points_and_zero_weights_do_not_count():
    rng = np.random.default_rng(7)
    truth = random_transform(rng)
    points_m = rng.normal(size=(6, 3))
    moved_m = truth.apply(points_m)
    points_m[0, 1] = np.nan
    moved_m[1] += 100.0
    found = fit_rigid(moved_m, points_m, np.array([1.0, 0.0, 1.0, 1.0, 1.0, 1.0]))
    np.testing.assert_allclose(found.rotation, truth.rotation, atol=1e-12)


@pytest.mark.parametrize(
    ("points_m", "weights", "message"),
    [
        (np.eye(3)[:2], None, "one line"),
        (np.eye(3)[:1], None, "one line"),
        (np.outer(np.arange(5.0), [1.0, 2.0, 3.0]), None, "one line"),
        (np.zeros((4, 3)), None, "one line"),
        (np.full((4, 3), np.nan), None, "no pair"),
        (np.zeros((0, 3)), None, "no pair"),
        (np.eye(3), np.array([1.0, -1.0, 1.0]), "weights"),
        (np.eye(3), np.array([1.0, np.nan, 1.0]), "weights"),
        (np.eye(3), np.ones(2), "weights"),
    ],
)
def test_points_that_fix_no_rotation_are_refused(points_m, weights, message):
    with pytest.raises(ValueError, match=message):
        fit_rigid(points_m, points_m, weights)


def test_chain_and_inverse_follow_their_names():
    rng = np.random.default_rng(8)
    a_from_b, b_from_c = random_transform(rng), random_transform(rng)
    points_m = rng.normal(size=(4, 3))
    chained = (a_from_b @ b_from_c).apply(points_m)
    np.testing.assert_allclose(chained, a_from_b.apply(b_from_c.apply(points_m)), atol=1e-12)
    np.testing.assert_allclose(
        a_from_b.inverse().apply(a_from_b.apply(points_m)), points_m, atol=1e-12
    )


@pytest.mark.parametrize(
    "rotation", [np.diag([1.0, 1.0, -1.0]), np.eye(3) * 1.1, np.eye(3) * np.nan]
)
def test_only_proper_rotations_are_taken(rotation):
    with pytest.raises(ValueError, match="orthonormal"):
        RigidTransform(rotation, np.zeros(3))


def test_translation_must_be_finite():
    with pytest.raises(ValueError, match="finite"):
        RigidTransform(np.eye(3), np.array([0.0, np.inf, 0.0]))
