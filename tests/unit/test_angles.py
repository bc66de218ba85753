"""Distances and angles: closed forms, numerical derivatives, and both ends of the angle."""

import numpy as np
import pytest

from adibas.geometry.angles import (
    angle,
    angle_derivatives,
    arm_derivatives,
    distance,
    distance_derivatives,
)


def numerical_derivatives(function, points_m, step_m=1e-6):
    """Central differences of a function of a list of points by every coordinate."""
    slopes = np.empty(np.shape(points_m))
    for place in np.ndindex(slopes.shape):
        change = np.zeros(slopes.shape)
        change[place] = step_m
        slopes[place] = (function(*(points_m + change)) - function(*(points_m - change))) / (
            2 * step_m
        )
    return slopes


@pytest.mark.parametrize("degrees", [0.0, 1e-7, 1.0, 45.0, 90.0, 179.0, 180.0 - 1e-7, 180.0])
def test_angle_is_exact_from_zero_to_straight(degrees):
    angle_rad = np.radians(degrees)
    vertex_m = np.array([0.3, -0.2, 2.0])
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    a_m = vertex_m + 0.4 * turn[0]
    c_m = vertex_m + 0.7 * (np.cos(angle_rad) * turn[0] + np.sin(angle_rad) * turn[1])
    assert angle(a_m, vertex_m, c_m) == pytest.approx(angle_rad, abs=3e-15)


def test_angle_and_distance_of_many_points_at_once():
    rng = np.random.default_rng(2)
    a_m, vertex_m, c_m = rng.normal(size=(3, 2, 5, 3))
    cosine = np.einsum("ijk,ijk->ij", a_m - vertex_m, c_m - vertex_m)
    cosine /= distance(a_m, vertex_m) * distance(c_m, vertex_m)
    np.testing.assert_allclose(angle(a_m, vertex_m, c_m), np.arccos(cosine), atol=1e-12)


def test_derivatives_are_those_of_small_steps():
    for points_m in np.random.default_rng(3).normal(size=(20, 3, 3)):
        expected = numerical_derivatives(angle, points_m)
        np.testing.assert_allclose(angle_derivatives(*points_m), expected, rtol=1e-5, atol=1e-6)
        expected = numerical_derivatives(distance, points_m[:2])
        np.testing.assert_allclose(distance_derivatives(*points_m[:2]), expected, atol=1e-8)


def test_lift_is_the_elevation_of_each_direction_above_the_plane():
    a_m, vertex_m, c_m = np.random.default_rng(4).normal(size=(3, 3))
    normal = np.cross(a_m - vertex_m, c_m - vertex_m)
    normal /= np.linalg.norm(normal)

    def elevation_a(a_m, vertex_m, _c_m):
        return np.arcsin((a_m - vertex_m) @ normal / np.linalg.norm(a_m - vertex_m))

    def elevation_c(_a_m, vertex_m, c_m):
        return np.arcsin((c_m - vertex_m) @ normal / np.linalg.norm(c_m - vertex_m))

    points_m = np.stack([a_m, vertex_m, c_m])
    arms = arm_derivatives(*points_m)
    found = numerical_derivatives(elevation_a, points_m)
    np.testing.assert_allclose(arms.lift_a, found, atol=1e-8)
    found = numerical_derivatives(elevation_c, points_m)
    np.testing.assert_allclose(arms.lift_c, found, atol=1e-8)


def test_stretch_is_the_growth_of_an_arm_and_turn_what_remains_of_the_angle():
    points_m = np.random.default_rng(5).normal(size=(3, 3))
    arms = arm_derivatives(*points_m)
    for stretch, end in ((arms.stretch_a, 0), (arms.stretch_c, 2)):

        def log_length(*corners, end=end):
            return np.log(np.linalg.norm(corners[end] - corners[1]))

        np.testing.assert_allclose(stretch, numerical_derivatives(log_length, points_m), atol=1e-8)
    assert (arms.turn_a[2] == 0).all()
    assert (arms.turn_c[0] == 0).all()


@pytest.mark.parametrize("axis", range(3))
def test_exactly_straight_angle_has_derivatives_across_its_line(axis):
    line = np.eye(3)[axis]
    arms = arm_derivatives(line, np.zeros(3), -2.0 * line)
    for moves in (arms.turn_a, arms.turn_c, arms.lift_a, arms.lift_c):
        np.testing.assert_allclose(moves @ line, 0.0, atol=1e-15)
    assert abs(arms.turn_a[0] @ arms.lift_a[0]) < 1e-15
    assert np.linalg.norm(arms.turn_c[2]) == pytest.approx(0.5)


def test_point_on_the_vertex_or_missing_gives_no_angle():
    here, there, missing = np.zeros(3), np.ones(3), np.full(3, np.nan)
    for corners in ((here, here, there), (there, here, here), (missing, here, there)):
        assert np.isnan(angle(*corners))
        assert np.isnan(angle_derivatives(*corners)).any()
    assert distance(here, here) == 0.0
    assert np.isnan(distance_derivatives(here, here)).all()
    assert np.isnan(distance(missing, here))
