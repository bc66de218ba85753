"""Landmarks of joined views: the best mean, errors that go together, intervals that hold."""

import numpy as np
import pytest

from adibas.data.markers import Marker
from adibas.geometry.rigid import IDENTITY, rotation_from_vector
from adibas.measures.geometry_tables import all_angles, all_distances
from adibas.surface.fused_landmarks import SeenPlace, fuse_places, view_moves_m
from adibas.surface.view_joining import JoinedViews

PLACES_M = {
    "c7": np.array([0.01, 1.42, 0.06]),
    "left_acromion": np.array([-0.18, 1.38, 0.0]),
    "sternal_notch": np.array([0.0, 1.36, -0.10]),
}
SEEN_BY = {"c7": (0, 1), "left_acromion": (0, 1, 2), "sternal_notch": (1, 2)}
N_VIEWS = 3


def joined(turn_sd_rad=0.002, shift_sd_m=0.001):
    """Two further views whose places err together by half."""
    alone = np.diag([turn_sd_rad**2] * 3 + [shift_sd_m**2] * 3)
    together = np.block([[alone, 0.5 * alone], [0.5 * alone, alone]])
    return JoinedViews((IDENTITY,) * N_VIEWS, together, 0.001, 1000)


def seen(view, place_m, own_sd_m=0.0005, n_causes=0):
    depth_m2 = np.diag([1.0, 1.0, 9.0]) * own_sd_m**2
    turn = rotation_from_vector(np.array([0.0, 0.7 * view, 0.0]))
    return SeenPlace(view, place_m, turn @ depth_m2 @ turn.T, np.full((3, n_causes), 1e-4))


def test_one_view_alone_tells_its_own_place():
    one = seen(0, PLACES_M["c7"], n_causes=2)
    fused = fuse_places([one], None)
    np.testing.assert_allclose(fused.position_m, PLACES_M["c7"], atol=1e-12)
    shared = one.calibration_m @ one.calibration_m.T
    np.testing.assert_allclose(fused.covariance_m2, one.own_m2 + shared, rtol=1e-9)
    assert fused.apart_sds == 0.0


def test_two_equal_views_are_surer_by_the_root_of_two():
    one = SeenPlace(0, np.zeros(3), 4e-6 * np.eye(3), np.zeros((3, 0)))
    other = SeenPlace(0, np.array([0.002, 0.0, 0.0]), 4e-6 * np.eye(3), np.zeros((3, 0)))
    fused = fuse_places([one, other], None)
    np.testing.assert_allclose(fused.position_m, [0.001, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(fused.covariance_m2, 2e-6 * np.eye(3), rtol=1e-9)
    # Each is 1 mm off, which is half a standard deviation, in one of three directions.
    assert fused.apart_sds == pytest.approx(np.sqrt(2 * 0.25 / 3))


def test_the_surer_view_counts_more_and_a_calibration_is_not_averaged_away():
    sure = SeenPlace(0, np.zeros(3), 1e-6 * np.eye(3), np.full((3, 1), 1e-3))
    unsure = SeenPlace(0, np.full(3, 0.01), 9e-6 * np.eye(3), np.full((3, 1), 1e-3))
    fused = fuse_places([sure, unsure], None)
    assert np.all(fused.position_m < 0.005)
    assert np.all(np.diag(fused.covariance_m2) > 1e-6)
    np.testing.assert_allclose(fused.shared_m, np.full((3, 1), 1e-3), rtol=1e-9)


def test_a_view_moves_its_places_as_a_small_turn_and_shift_do():
    lies = joined()
    place_m = PLACES_M["left_acromion"]
    moves_m = view_moves_m(seen(2, place_m), lies)
    root = np.linalg.cholesky(lies.covariance)
    causes = 0.3 * np.random.default_rng(0).normal(size=12)
    twist = (root @ causes)[6:]
    moved_m = rotation_from_vector(twist[:3]) @ place_m + twist[3:]
    np.testing.assert_allclose(moves_m @ causes, moved_m - place_m, atol=2e-6)
    assert not view_moves_m(seen(0, place_m), lies).any()


def test_nobody_saw_it():
    with pytest.raises(ValueError, match="some view"):
        fuse_places([], None)


def test_intervals_of_distances_and_angles_hold_the_truth():
    """Views are laid wrong and places measured wrong by what is told, 400 times."""
    rng = np.random.default_rng(3)
    lies = joined()
    root = np.linalg.cholesky(lies.covariance)
    exact = [
        Marker(name, 0, 0, 0, np.eye(2), place_m, 1e-12 * np.eye(3))
        for name, place_m in PLACES_M.items()
    ]
    wanted_m = [one.value_m for one in all_distances(exact)]
    wanted_rad = [one.value_rad for one in all_angles(exact)]
    held = []
    for _ in range(400):
        twists = (root @ rng.normal(size=12)).reshape(2, 6)
        markers = []
        for name, place_m in PLACES_M.items():
            sights = []
            for view in SEEN_BY[name]:
                one = seen(view, place_m)
                off_m = np.linalg.cholesky(one.own_m2) @ rng.normal(size=3)
                if view:
                    turn, shift_m = twists[view - 1][:3], twists[view - 1][3:]
                    off_m = off_m + np.cross(turn, place_m) + shift_m
                sights.append(SeenPlace(view, place_m + off_m, one.own_m2, one.calibration_m))
            fused = fuse_places(sights, lies)
            markers.append(
                Marker(
                    *(name, 0, 0, 0, np.eye(2)),
                    position_m=fused.position_m,
                    covariance_m2=fused.covariance_m2,
                    shared_m=fused.shared_m,
                )
            )
        for found, value_m in zip(all_distances(markers), wanted_m, strict=True):
            held.append(found.interval_m[0] <= value_m <= found.interval_m[1])
        for found, value_rad in zip(all_angles(markers), wanted_rad, strict=True):
            held.append(found.interval_rad[0] <= value_rad <= found.interval_rad[1])
    assert len(held) == 400 * 6
    assert 0.93 < np.mean(held) < 0.97
