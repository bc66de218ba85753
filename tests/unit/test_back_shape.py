"""Symmetry line, profile and angles of backs whose shape is known in closed form."""

import numpy as np
import pytest
from scipy.special import erf

from adibas.geometry.planes import Plane
from adibas.surface.back_grid import BackGrid, grid_of
from adibas.surface.patient_axes import axes_of_back, turned
from adibas.surface.sagittal import SagittalParams, sagittal_shape
from adibas.surface.spine_profile import ProfileParams, fit_profile
from adibas.surface.symmetry_line import find_symmetry_line
from tests.unit.back_surfaces import (
    BOTTOM_M,
    CROSSING_M,
    STATURE_M,
    STEEPEST_RAD,
    SWING_M,
    TOP_M,
    WAVE_M,
    back_points,
    line_m,
    profile_m,
)

WINDOW = ProfileParams(window_m2=0.003**2)
"""Noise that no pixel shares with another."""


@pytest.fixture(scope="module")
def still():
    points_m = back_points()
    line = find_symmetry_line(grid_of(points_m))
    return points_m, line, fit_profile(points_m, line, WINDOW)


def test_symmetry_line_follows_the_furrow(still):
    line = still[1]
    inside = slice(8, -8)
    np.testing.assert_allclose(line.x_m[inside], line_m(line.y_m[inside]), atol=0.0015)


def test_symmetry_line_and_rotation_of_a_turned_back():
    turn_rad = np.radians(3.0)
    points_m = back_points(rotation_rad=turn_rad)
    line = find_symmetry_line(grid_of(points_m))
    inside = slice(10, -10)
    # A round trunk that is turned looks like one that is shifted: the line gives in by millimetres.
    np.testing.assert_allclose(line.x_m[inside], line_m(line.y_m[inside]), atol=0.006)
    np.testing.assert_allclose(line.rotation_rad[inside], turn_rad, atol=np.radians(1.0))
    profile = fit_profile(points_m, line, WINDOW)
    heights_m = np.linspace(0.95, 1.4, 20)
    np.testing.assert_allclose(profile.rotation_rad(heights_m), turn_rad, atol=np.radians(0.7))


def test_slopes_to_the_side_scatter_as_their_covariance_says(still):
    points_m, line, profile = still
    rng, heights_m = np.random.default_rng(8), np.linspace(0.95, 1.4, 20)
    noise_m = rng.normal(0.0, 0.003, (60, len(points_m)))
    up = np.array([0.0, 0.0, 1.0])
    noisy = [fit_profile(points_m + one[:, None] * up, line, WINDOW) for one in noise_m]
    scatter = np.std([one.side_slope(heights_m) for one in noisy], axis=0)
    weights = profile.weights(heights_m)
    stated = np.sqrt(np.diag(weights @ noisy[0].side_covariance @ weights.T))
    assert np.mean(scatter / stated) == pytest.approx(1.0, abs=0.1)


def test_markers_pull_the_line_to_themselves():
    flat = np.zeros((40, 60))
    grid = BackGrid(np.arange(60) * 0.004 - 0.12, 1.0 - 0.004 * np.arange(40), flat)
    markers_m = np.array([[0.02, 0.98, 0.0], [0.02, 0.92, 0.0], [0.02, 0.86, 0.0]])
    line = find_symmetry_line(grid, markers_m)
    assert abs(float(np.median(line.x_m)) - 0.02) < 0.003


def test_nothing_known_gives_no_line():
    grid = BackGrid(np.arange(60) * 0.004, 1.0 - 0.004 * np.arange(40), np.full((40, 60), np.nan))
    assert find_symmetry_line(grid) is None


def test_profile_is_that_of_the_furrow(still):
    profile = still[2]
    heights_m = np.linspace(BOTTOM_M + 0.06, TOP_M - 0.06, 50)
    found_m = profile.back_m(heights_m) - profile_m(heights_m)
    assert np.ptp(found_m) < 0.0012
    slope = SWING_M * 2 * np.pi / WAVE_M * np.cos(2 * np.pi * (heights_m - CROSSING_M) / WAVE_M)
    np.testing.assert_allclose(profile.inclination(heights_m), slope, atol=0.012)


def test_angles_and_fleches_are_those_of_the_sine(still):
    shape = sagittal_shape(still[2], STATURE_M)
    assert shape.itl_m == pytest.approx(CROSSING_M, abs=0.01)
    assert shape.ka_m == pytest.approx(CROSSING_M + WAVE_M / 4, abs=0.012)
    assert shape.la_m == pytest.approx(CROSSING_M - WAVE_M / 4, abs=0.012)
    assert shape.kyphosis_rad.value == pytest.approx(2 * STEEPEST_RAD, abs=np.radians(0.5))
    assert shape.lordosis_rad.value == pytest.approx(2 * STEEPEST_RAD, abs=np.radians(0.8))
    assert shape.fleche_lombaire_m.value == pytest.approx(2 * SWING_M, abs=0.001)


def test_a_slope_that_rises_beyond_the_border_is_no_inflection():
    points_m = back_points()
    away = (points_m[:, 1] - 0.95) / 0.04
    points_m[:, 2] += 0.04 * np.sqrt(np.pi) / 2 * erf(away)
    line = find_symmetry_line(grid_of(points_m))
    profile = fit_profile(points_m, line, WINDOW)
    border_m = SagittalParams().thoracolumbar[0] * STATURE_M
    steeper = profile.inclination(np.array([border_m, CROSSING_M]))
    assert steeper[0] > steeper[1]
    assert sagittal_shape(profile, STATURE_M).itl_m == pytest.approx(CROSSING_M, abs=0.02)


def test_intervals_hold_the_truth_as_often_as_they_say():
    held, n = 0, 24
    step_m = 0.006
    window = ProfileParams(window_m2=step_m**2)
    points_m = back_points(step_m=step_m)
    line = find_symmetry_line(grid_of(points_m))
    exact = sagittal_shape(fit_profile(points_m, line, window), STATURE_M).kyphosis_rad.value
    for seed in range(n):
        noisy_m = back_points(np.random.default_rng(seed), 0.006, step_m=step_m)
        low, high = sagittal_shape(
            fit_profile(noisy_m, line, window), STATURE_M
        ).kyphosis_rad.interval
        held += low <= exact <= high
    assert held >= 0.85 * n


def test_a_profile_that_ends_early_has_no_angles(still):
    points_m, line, _ = still
    upper = points_m[points_m[:, 1] > 1.2]
    short = find_symmetry_line(grid_of(upper))
    assert sagittal_shape(fit_profile(upper, short, WINDOW), STATURE_M) is None
    with pytest.raises(ValueError, match="no points"):
        fit_profile(points_m + 5.0, line)


def test_a_grid_without_points_is_refused():
    with pytest.raises(ValueError, match="points"):
        grid_of(np.zeros((0, 3)))


def test_axes_stand_on_the_floor_and_face_the_camera():
    floor = Plane(np.array([0.0, -1.0, 0.0]), 1.1)
    points_m = np.array([[0.2, 0.1, 2.0], [0.2, -0.3, 2.2], [0.2, 0.3, 2.1]])
    axes = axes_of_back(points_m, floor)
    placed = axes.apply(points_m)
    np.testing.assert_allclose(placed[:, 1], [1.0, 1.4, 0.8])
    np.testing.assert_allclose(placed[:, 0], 0.0, atol=1e-12)
    assert placed[0, 2] > placed[1, 2]  # nearer to the camera is further to the back
    right = axes.apply(np.array([[0.3, 0.1, 2.1]]))
    assert right[0, 0] == pytest.approx(0.1)


def test_turning_levels_a_slanted_surface():
    axes = axes_of_back(np.array([[0.0, 0.0, 2.0]] * 3), Plane(np.array([0.0, -1.0, 0.0]), 1.0))
    turn_rad = 0.2
    slanted = np.array([[1.0, 0.0, np.tan(turn_rad)]])
    level = turned(axes, turn_rad).apply(axes.inverse().apply(slanted))
    assert level[0, 2] == pytest.approx(0.0, abs=1e-12)
