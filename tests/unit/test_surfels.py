"""The surfel map on walls whose places are known: found, fused, seen through and removed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adibas.alignment import surfels
from adibas.alignment.surfel_blocks import CUBE_M, NOTHING, boxes_of, order_by_place
from adibas.alignment.surfel_kernels import BLOCK
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


def rows_of(surface):
    """Return all surfels of a surface as rows, in an order that does not depend on theirs."""
    columns = (surface.points_m, surface.normals, surface.radii_m[:, None],
               surface.confidences[:, None])  # fmt: skip
    rows = np.hstack(columns)
    return rows[np.lexsort(rows.T)]


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
    np.testing.assert_array_equal(rows_of(at_once), rows_of(later))


def test_a_full_map_first_takes_the_room_of_what_is_gone():
    n = len(grown([wall(1.5)]))
    params = SurfelParams(capacity=2 * n + 10, most_misses=1)
    found = grown([wall(1.5), wall(2.5), wall(2.0), wall(2.5)], params)
    assert not found.was_full


def poses(n, seed=2):
    """Return poses in a room of 6 m: any turn, heights of 0.5 m."""
    rng = np.random.default_rng(seed)
    for _ in range(n):
        turn = Rotation.from_euler("yx", rng.uniform([-180, -30], [180, 30]), degrees=True)
        yield RigidTransform(turn.as_matrix(), rng.uniform([-2, -0.5, -2], [2, 0.5, 2]))


@pytest.mark.parametrize("distortion", [(), (-0.25, 0.1, 0.002, -0.001, 0.0)])
def test_blocks_that_are_passed_over_are_beside_the_picture(distortion, monkeypatch):
    """As when every block is asked, through sixty frames that grow, confirm and remove."""
    camera = replace(CAMERA, distortion=distortion)
    rng = np.random.default_rng(5)
    views = [
        prepare_view(np.full((120, 160), rng.uniform(0.8, 3.5), np.float32), camera, ViewParams())
        for _ in range(60)
    ]
    surfaces = []
    for is_every_block_asked in (False, True):
        if is_every_block_asked:
            everywhere = np.repeat([-1e3, 1e3], 3)
            monkeypatch.setattr(
                surfels,
                "boxes_of",
                lambda _places_m, n_rows, box=everywhere: np.tile(box.astype(np.float32),
                                                                  (n_rows // BLOCK + 1, 1)),
            )  # fmt: skip
        found = SurfelMap()
        for view, pose in zip(views, poses(60), strict=True):
            found.add(view, GREY, CALIBRATION, pose)
        surfaces.append(rows_of(found.surface()))
    assert len(surfaces[0]) > 20_000
    np.testing.assert_array_equal(*surfaces)


def test_boxes_hold_the_surfels_of_their_blocks_and_are_small_in_order():
    found = SurfelMap()
    for pose in poses(30):
        found.add(wall(2.0), GREY, CALIBRATION, pose)
    places_m = found.surface().points_m
    shuffled = np.random.default_rng(0).permutation(places_m)
    order = order_by_place(shuffled)
    assert sorted(order) == list(range(len(shuffled)))
    boxes = boxes_of(shuffled[order], len(shuffled) + 1000)
    for number, box in enumerate(boxes):
        block = shuffled[order][number * BLOCK : (number + 1) * BLOCK]
        if len(block):
            np.testing.assert_array_equal(box, [*block.min(axis=0), *block.max(axis=0)])
        else:
            assert (box == NOTHING).all()
    sizes_m = (boxes[:, 3:] - boxes[:, :3]).max(axis=1)
    assert np.median(sizes_m[np.isfinite(sizes_m)]) < 4 * CUBE_M
    assert len(order_by_place(np.empty((0, 3), np.float32))) == 0
