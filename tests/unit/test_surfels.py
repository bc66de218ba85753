"""The surfel map on walls whose places are known: found, fused, seen through and removed."""

import numpy as np
import pytest

from adibas.alignment import surfels
from adibas.alignment.surfels import SurfelMap, SurfelParams
from adibas.alignment.views import ViewParams, prepare_view
from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import IDENTITY, RigidTransform

CAMERA = CameraCalibration(160, 120, Intrinsics(140.0, 140.0, 79.5, 59.5))
CALIBRATION = RgbdCalibration(CAMERA, CAMERA, IDENTITY)
GREY = np.full((120, 160, 3), 90, np.uint8)


def wall(depth_m, columns=slice(None)):
    """Return what the camera sees of a wall across its look; nothing beside some columns."""
    seen_m = np.full((120, 160), np.nan, np.float32)
    seen_m[:, columns] = depth_m
    return prepare_view(seen_m, CAMERA, ViewParams())


def grown(views, params=None, *, pose=IDENTITY):
    found = SurfelMap(params)
    for view in views:
        found.add(view, GREY, CALIBRATION, pose)
    return found


def test_a_wall_lies_where_it_is_and_looks_at_the_camera():
    pose = RigidTransform(np.eye(3), np.array([0.3, -0.1, 0.5]))
    surface = grown([wall(2.0)] * 5, pose=pose).surface()
    assert len(surface.points_m) > 500
    np.testing.assert_allclose(surface.points_m[:, 2], 2.5, atol=1e-4)
    np.testing.assert_allclose(surface.normals, np.tile([0, 0, -1], (len(surface.normals), 1)),
                               atol=1e-3)  # fmt: skip


def test_the_same_wall_seen_again_adds_nothing():
    once, often = (grown([wall(2.0)] * n) for n in (1, 8))
    assert len(often) == len(once)


@pytest.mark.parametrize("share", [0.0, 0.02, 10.0])
def test_what_is_seen_through_is_gone_whenever_its_room_is_taken_back(share, monkeypatch):
    monkeypatch.setattr(surfels, "MISSED_SHARE", share)
    before = [wall(1.5)] * 4  # a door that stands before the wall, and is opened
    params = SurfelParams(most_misses=3)
    found = grown([*before, *[wall(2.5)] * 2], params)
    assert found.surface().points_m[:, 2].min() == pytest.approx(1.5, abs=1e-4)
    n_with_both = len(found)
    found.add(wall(2.5), GREY, CALIBRATION, IDENTITY)
    assert len(found) < n_with_both
    places = found.surface().points_m[:, 2]
    np.testing.assert_allclose(places, 2.5, atol=1e-4)
    assert len(places) == len(grown([wall(2.5)] * 3).surface().points_m)


def test_when_gaps_are_closed_changes_no_surfel(monkeypatch):
    rng = np.random.default_rng(0)
    views = [wall(float(rng.uniform(1.0, 3.0)), slice(*sorted(rng.integers(0, 160, 2)))) for _ in
             range(40)]  # fmt: skip
    surfaces = []
    for share in (0.0, 0.5):
        monkeypatch.setattr(surfels, "MISSED_SHARE", share)
        surfaces.append(grown(views).surface())
    at_once, later = surfaces
    assert len(at_once.points_m) > 100
    for name in ("points_m", "normals", "radii_m", "confidences"):
        np.testing.assert_array_equal(getattr(at_once, name), getattr(later, name))


def test_a_full_map_first_takes_the_room_of_what_is_gone():
    n = len(grown([wall(1.5)]))
    params = SurfelParams(capacity=2 * n + 10, most_misses=1)
    found = grown([wall(1.5), wall(2.5), wall(2.0), wall(2.5)], params)
    assert not found.was_full
