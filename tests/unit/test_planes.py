"""Planes: fitted to noisy points, and found in a room with other things."""

import numpy as np
import pytest

from adibas.geometry.planes import Plane, PlaneSearch, find_plane, fit_plane

UP = np.array([0.0, -1.0, 0.0])


def floor_points(rng, n, noise_m=0.0, tilt_rad=0.1):
    """Points of a floor 1 m below a camera that looks down by `tilt_rad`."""
    truth = Plane(np.array([0.0, -np.cos(tilt_rad), -np.sin(tilt_rad)]), 1.0)
    points_m = np.stack([rng.uniform(-2, 2, n), np.zeros(n), rng.uniform(1, 4, n)], axis=-1)
    points_m = truth.project(points_m) + noise_m * rng.normal(size=(n, 1)) * truth.normal
    return truth, points_m


def test_exact_points_give_their_plane_and_missing_ones_do_not_count():
    truth, points_m = floor_points(np.random.default_rng(0), 20)
    points_m[3, 2] = np.nan
    for up in (None, UP):
        plane = fit_plane(points_m, up=up)
        np.testing.assert_allclose(plane.normal, truth.normal, atol=1e-12)
        assert plane.offset_m == pytest.approx(1.0)
    np.testing.assert_allclose(fit_plane(points_m, up=-UP).normal, -truth.normal, atol=1e-12)


def test_normal_turns_to_the_camera_unless_told_otherwise():
    wall_m = np.array([[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]])
    plane = fit_plane(wall_m)
    np.testing.assert_allclose(plane.normal, [0.0, 0.0, -1.0], atol=1e-12)
    assert plane.signed_distance_m(np.zeros(3)) == pytest.approx(2.0)


def test_least_squares_plane_beats_its_neighbours_with_weights():
    rng = np.random.default_rng(1)
    _, points_m = floor_points(rng, 60, noise_m=0.02)
    weights = rng.uniform(0.1, 3.0, 60)
    plane = fit_plane(points_m, weights, up=UP)

    def cost(candidate):
        return weights @ candidate.signed_distance_m(points_m) ** 2

    for change in rng.normal(scale=1e-3, size=(50, 4)):
        normal = plane.normal + change[:3]
        other = Plane(normal / np.linalg.norm(normal), plane.offset_m + change[3])
        assert cost(other) >= cost(plane)


@pytest.mark.parametrize(
    ("points_m", "weights", "message"),
    [
        (np.eye(3)[:2], None, "three points"),
        (np.eye(3), np.array([1.0, 1.0, 0.0]), "three points"),
        (np.full((5, 3), np.nan), None, "three points"),
        (np.outer(np.arange(9.0), [1.0, 2.0, 3.0]), None, "one line"),
        (np.ones((9, 3)), None, "one line"),
        (np.eye(3), np.array([1.0, -1.0, 1.0]), "weights"),
        (np.eye(3), np.array([1.0, np.nan, 1.0]), "weights"),
    ],
)
def test_points_that_fix_no_plane_are_refused(points_m, weights, message):
    with pytest.raises(ValueError, match=message):
        fit_plane(points_m, weights)


def test_floor_is_found_below_a_person_and_before_a_larger_wall():
    rng = np.random.default_rng(2)
    truth, floor_m = floor_points(rng, 3000, noise_m=0.005)
    wall_m = np.stack(
        [rng.uniform(-2, 2, 6000), rng.uniform(-1.5, 0.9, 6000), np.full(6000, 4.0)], axis=-1
    )
    person_m = rng.normal((0.0, 0.0, 2.0), (0.2, 0.4, 0.1), size=(5000, 3))
    missing = np.full((1000, 3), np.nan)
    points_m = np.concatenate([floor_m, wall_m, person_m, missing])
    found = find_plane(points_m, rng, up=UP)
    assert found is not None
    assert np.arccos(found.plane.normal @ truth.normal) < np.radians(0.2)
    assert found.plane.offset_m == pytest.approx(1.0, abs=0.003)
    assert found.is_on_plane[:3000].mean() > 0.999
    assert found.is_on_plane[3000:].mean() < 0.1
    wall = find_plane(points_m, rng)
    assert wall is not None
    np.testing.assert_allclose(wall.plane.normal, [0.0, 0.0, -1.0], atol=0.01)


def test_same_seed_finds_the_same_plane():
    _, points_m = floor_points(np.random.default_rng(3), 500, noise_m=0.01)
    planes = [find_plane(points_m, np.random.default_rng(9)) for _ in range(2)]
    np.testing.assert_array_equal(planes[0].plane.normal, planes[1].plane.normal)


@pytest.mark.parametrize(
    "points_m",
    [
        np.zeros((0, 3)),
        np.full((50, 3), np.nan),
        np.ones((50, 3)),
        np.outer(np.linspace(1, 2, 50), [1.0, 2.0, 3.0]),
    ],
    ids=["empty", "missing", "one point", "one line"],
)
def test_no_plane_is_found_where_there_is_none(points_m):
    assert find_plane(points_m, np.random.default_rng(4)) is None


def test_too_few_points_on_the_best_plane_are_no_floor():
    rng = np.random.default_rng(5)
    cloud_m = rng.uniform(-1, 1, (400, 3))
    search = PlaneSearch(tolerance_m=0.01, smallest_share=0.3, n_trials=100)
    assert find_plane(cloud_m, rng, search=search) is None


def test_wall_is_no_floor():
    rng = np.random.default_rng(6)
    wall_m = np.stack([*rng.uniform(-1, 1, (2, 300)), np.full(300, 3.0)], axis=-1)
    assert find_plane(wall_m, rng, up=UP) is None


def test_height_projection_and_tilt_follow_the_definition():
    plane = Plane(UP, 1.2)
    points_m = np.array([[0.3, 0.0, 2.0], [np.nan, 0.0, 1.0]])
    np.testing.assert_allclose(plane.signed_distance_m(points_m), [1.2, np.nan])
    np.testing.assert_allclose(plane.project(points_m)[0], [0.3, 1.2, 2.0])
    assert plane.tilt_rad(np.array([0.0, -5.0, 0.0])) == 0.0
    assert plane.tilt_rad(np.array([2.0, 0.0, 0.0])) == pytest.approx(np.pi / 2)
    assert plane.tilt_rad(-UP) == pytest.approx(np.pi)


def test_normal_must_have_unit_length():
    with pytest.raises(ValueError, match="length 1"):
        Plane(np.array([0.0, 2.0, 0.0]), 0.0)
