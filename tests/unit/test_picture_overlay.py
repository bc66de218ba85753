"""A picture laid over another: the same body lands on itself, however the camera stood."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.posture import Provenance
from adibas.data.sessions import Capture
from adibas.geometry.pinhole import Intrinsics, project
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import rotation_from_vector
from adibas.pipeline.picture_overlay import OverlayWay, PlacedMarkers
from adibas.pipeline.picture_overlay import lay_over as lay_over_placed
from tests.unit.standing_points import seen_from, standing
from tests.unit.store_samples import START

K = Intrinsics(1050.0, 1050.0, 639.5, 511.5)
CAMERA = CameraCalibration(1280, 1024, K)


def capture(
    *, metres=2.0, roll_rad=0.0, camera=CAMERA, has_floor=False, has_gravity=True, names=()
):
    """The standing points from the front, from a level camera one metre above the floor."""
    roll = rotation_from_vector(np.array([0.0, 0.0, roll_rad]))
    nearer = np.array([0.0, 0.0, metres - 2.0])
    markers = []
    for one in seen_from("anterior", standing()):
        position_m = roll @ (one.position_m + nearer)
        u, v = project(position_m, camera.intrinsics)
        if not names or one.label in names:
            markers.append(replace(one, u=u, v=v, position_m=position_m))
    up = roll @ np.array([0.0, -1.0, 0.0])
    calibration = RgbdCalibration(
        color=camera,
        floor=Plane(up, 1.0) if has_floor else None,
        gravity=-up if has_gravity else None,
    )
    provenance = Provenance("", "", "1", "2026-01-01T00:00:00+00:00", {})
    return Capture(
        "c", "s", "anterior", START, "", 0, 1, calibration, tuple(markers), (), provenance
    )


def lay_over(earlier, later):
    """Lay one capture over another."""
    return lay_over_placed(
        *(PlacedMarkers(one.markers(), one.calibration) for one in (earlier, later))
    )


def distances_px(earlier, later):
    """How far apart the same markers lie, those in the frontal plane of the body."""
    found = lay_over(earlier, later)
    now = {one.label: (one.u, one.v) for one in later.markers()}
    moved = {one.label: found.moved(one.u, one.v) for one in earlier.markers()}
    flat = [name for name in now if "acromion" in name or "trochanter" in name]
    return found.way, [float(np.hypot(*np.subtract(now[name], moved[name]))) for name in flat]


@pytest.mark.parametrize("has_floor", [True, False])
@pytest.mark.parametrize("roll_rad", [0.0, 0.05, np.pi / 2])
def test_the_same_body_lands_on_itself(has_floor, roll_rad):
    earlier = capture(metres=2.4, has_floor=has_floor)
    later = capture(metres=2.0, roll_rad=roll_rad, has_floor=has_floor)
    way, apart = distances_px(earlier, later)
    assert way is (OverlayWay.FLOOR if has_floor else OverlayWay.MIDDLE)
    assert max(apart) < 8.0  # half a body's thickness in front of its middle


def test_on_the_floor_a_body_that_became_shorter_stays_shorter():
    later = capture(has_floor=True)
    shorter = tuple(
        replace(one, v=one.v + 20.0, position_m=one.position_m + np.array([0.0, 0.03, 0.0]))
        for one in later.detected
    )
    earlier = later
    now = replace(later, detected=shorter)
    way, apart = distances_px(earlier, now)
    assert way is OverlayWay.FLOOR
    assert np.mean(apart) == pytest.approx(20.0, abs=1.0)
    without = [replace(one, calibration=capture().calibration) for one in (earlier, now)]
    assert np.mean(distances_px(*without)[1]) < 6.0


def test_a_floor_that_one_session_lacks_is_not_used():
    way, _apart = distances_px(capture(has_floor=True), capture())
    assert way is OverlayWay.MIDDLE


def test_too_few_shared_markers_leave_the_pictures_as_they_were_taken():
    half = CameraCalibration(640, 512, Intrinsics(525.0, 525.0, 319.5, 255.5))
    few = capture(names=("c7",), camera=half)
    found = lay_over(few, capture())
    assert found.way is OverlayWay.PICTURE
    assert found.moved(319.5, 255.5) == pytest.approx((639.5, 511.5))
    assert found.moved(0.0, 0.0) == pytest.approx((0.5, 0.5))


def test_pictures_without_a_colour_camera_stay_as_they_are():
    bare = replace(capture(), calibration=RgbdCalibration(depth=CAMERA))
    found = lay_over(bare, capture())
    assert (found.way, found.moved(3.0, 4.0)) == (OverlayWay.PICTURE, (3.0, 4.0))
