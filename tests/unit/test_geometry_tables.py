"""Every distance and angle of a set of markers, in a fixed order."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from adibas.data.markers import Marker
from adibas.measures.geometry_tables import all_angles, all_distances


def markers_at(positions_m, sigma_m=0.001):
    return [
        Marker(
            label=f"m{i + 1:02}",
            u=0.0,
            v=0.0,
            radius_px=5.0,
            covariance_px2=np.eye(2),
            position_m=np.array(position_m, float),
            covariance_m2=sigma_m**2 * np.eye(3),
        )
        for i, position_m in enumerate(positions_m)
    ]


def random_markers(n):
    return markers_at(np.random.default_rng(1).uniform(-1, 1, (n, 3)))


def test_fifteen_markers_give_every_pair_and_every_vertex_of_every_triplet_once():
    markers = random_markers(15)
    distances, angles = all_distances(markers), all_angles(markers)
    labels = [marker.label for marker in markers]
    assert [(d.a, d.b) for d in distances] == list(combinations(labels, 2))
    assert len(distances) == 105
    assert len(angles) == 1365
    assert len({(frozenset((a.a, a.c)), a.vertex) for a in angles}) == 1365
    triplets = [(angle.a, angle.vertex, angle.c) for angle in angles[:4]]
    assert triplets == [
        ("m02", "m01", "m03"),
        ("m01", "m02", "m03"),
        ("m01", "m03", "m02"),
        ("m02", "m01", "m04"),
    ]


def test_values_are_those_of_plain_geometry():
    markers = random_markers(6)
    place_m = {marker.label: marker.position_m for marker in markers}
    for distance in all_distances(markers):
        expected_m = np.linalg.norm(place_m[distance.a] - place_m[distance.b])
        assert distance.value_m == pytest.approx(expected_m)
        assert distance.interval_m[0] < distance.value_m < distance.interval_m[1]
    angles = all_angles(markers)
    for angle in angles:
        arm_a = place_m[angle.a] - place_m[angle.vertex]
        arm_c = place_m[angle.c] - place_m[angle.vertex]
        cosine = arm_a @ arm_c / np.linalg.norm(arm_a) / np.linalg.norm(arm_c)
        assert angle.value_rad == pytest.approx(np.arccos(cosine))
        assert angle.interval_rad[0] < angle.value_rad < angle.interval_rad[1]
    for i in range(0, len(angles), 3):
        assert sum(angle.value_rad for angle in angles[i : i + 3]) == pytest.approx(np.pi)


def test_distance_interval_is_that_of_two_independent_markers():
    near, far = markers_at([(0, 0, 2), (0, 0.5, 2)], sigma_m=0.001)
    far = replace(far, covariance_m2=np.diag([0.0, 0.003**2, 0.0]))
    (distance,) = all_distances([near, far])
    half_m = 1.959964 * np.hypot(0.001, 0.003)
    assert distance.interval_m == pytest.approx((0.5 - half_m, 0.5 + half_m), abs=1e-5)


def test_straight_leg_has_an_interval_that_ends_at_straight_and_a_bias_away_from_it():
    hip, knee, ankle = markers_at([(0, -0.4, 2), (0, 0, 2), (0, 0.4, 2)], sigma_m=0.002)
    angle = next(angle for angle in all_angles([hip, knee, ankle]) if angle.vertex == "m02")
    assert angle.value_rad == pytest.approx(np.pi)
    assert angle.interval_rad[1] == np.pi
    assert np.radians(175) < angle.interval_rad[0] < np.radians(179)
    assert angle.bias_rad < 0


def test_markers_without_a_position_have_no_distances_and_no_angles():
    markers = random_markers(4)
    markers[1] = replace(markers[1], position_m=None, covariance_m2=None)
    assert len(all_distances(markers)) == 3
    assert len(all_angles(markers)) == 3
    labels = {label for angle in all_angles(markers) for label in (angle.a, angle.vertex, angle.c)}
    assert labels == {"m01", "m03", "m04"}


@pytest.mark.parametrize(("n_markers", "n_distances"), [(0, 0), (1, 0), (2, 1)])
def test_too_few_markers_give_empty_tables(n_markers, n_distances):
    markers = random_markers(n_markers)
    assert len(all_distances(markers)) == n_distances
    assert all_angles(markers) == ()


def test_coincident_markers_have_a_distance_but_no_angle_at_each_other():
    markers = markers_at([(0, 0, 2), (0, 0, 2), (0, 0.4, 2)])
    distances, angles = all_distances(markers), all_angles(markers)
    assert distances[0].value_m == 0.0
    assert distances[0].interval_m[0] == 0.0
    assert distances[0].interval_m[1] > 0.001
    assert [angle.vertex for angle in angles] == ["m03"]
