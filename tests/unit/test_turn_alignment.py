"""Images after a motion, and motions out of images, against surfaces in closed form."""

import numpy as np
import pytest

from adibas.alignment.turn import TurnParams, TurnTracker, fit_turn, seen_after, turn_rad
from adibas.alignment.views import prepare_view
from adibas.data.calibration import CameraCalibration, Intrinsics
from adibas.geometry.distortion import pixel_rays
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import IDENTITY, RigidTransform, rotation_from_vector

CAMERA = CameraCalibration(
    width=480,
    height=360,
    intrinsics=Intrinsics(450.0, 450.0, 239.5, 179.5),
    distortion=(0.05, 0.01, 0.0, 0.0),
)
FLOOR = Plane(np.array([0.0, -1.0, 0.0]), 0.9)
MIDDLE_M = np.array([0.0, 0.1, 1.6])
AXES_M = np.array([0.25, 0.55, 0.14])
"""Of an ellipsoid, as flat as a trunk."""


def rays():
    flat = pixel_rays((CAMERA.height, CAMERA.width), CAMERA.intrinsics, CAMERA.distortion)
    return np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1)


def plane_image(plane):
    """1/z of n . P = 1 is n . ray."""
    return (rays() @ plane).astype(np.float32)


def ellipsoid_image(pose):
    """1/z of the ellipsoid after a motion, by the quadratic along each ray; NaN beside it."""
    back = pose.inverse()
    ways = rays() @ back.rotation.T / AXES_M
    origin = (back.translation_m - MIDDLE_M) / AXES_M
    a, b, c = (ways**2).sum(-1), ways @ origin, origin @ origin - 1.0
    with np.errstate(invalid="ignore"):
        depth_m = (-b - np.sqrt(b**2 - a * c)) / a
    return (1.0 / depth_m).astype(np.float32)


def view_of(inverse_per_m):
    return prepare_view(np.asarray(1.0 / inverse_per_m, np.float32), CAMERA)


def about_the_body(turn_rad_, lean_rad=0.0, shift_m=(0.0, 0.0, 0.0)):
    """A turn about the vertical through the ellipsoid's middle, a lean and a shift."""
    turn = rotation_from_vector(np.array([lean_rad, 0.0, 0.0])) @ rotation_from_vector(
        np.array([0.0, turn_rad_, 0.0])
    )
    return RigidTransform(turn, MIDDLE_M - turn @ MIDDLE_M + np.array(shift_m))


def test_a_plane_is_seen_where_it_has_moved_to():
    plane = np.array([0.2, -0.1, 0.6])
    motion = RigidTransform(
        rotation_from_vector(np.array([0.05, -0.2, 0.1])), np.array([0.03, 0.05, -0.1])
    )
    found = seen_after(view_of(plane_image(plane)), motion)
    # n . P = 1 and P' = R P + t give (R n) . P' = 1 + (R n) . t.
    turned = motion.rotation @ plane
    wanted = plane_image(turned / (1.0 + turned @ motion.translation_m))
    seen = np.isfinite(found)
    assert seen.mean() > 0.5
    np.testing.assert_allclose(found[seen], wanted[seen], atol=2e-6)


def test_without_a_motion_the_image_stays():
    image = ellipsoid_image(IDENTITY)
    found = seen_after(view_of(image), IDENTITY)
    seen = np.isfinite(found)
    np.testing.assert_allclose(found[seen], image[seen], rtol=1e-6)
    assert seen.sum() > 0.99 * np.isfinite(image).sum()


def test_the_nearer_of_two_surfaces_hides_the_other():
    image = np.full((CAMERA.height, CAMERA.width), 0.5, np.float32)
    image[:, :240] = 1.0
    sideways = RigidTransform(np.eye(3), np.array([0.2, 0.0, 0.0]))
    found = seen_after(view_of(image), sideways)
    # By 0.2 m the near one (1 m) moves by 90 pixels over the far one (2 m), which moves by 45.
    for columns, wanted in ((slice(255, 312), 1.0), (slice(345, 450), 0.5)):
        row = found[180, columns]
        assert np.isfinite(row).mean() > 0.9
        np.testing.assert_allclose(row[np.isfinite(row)], wanted, atol=1e-4)


def test_what_turns_away_or_leaves_the_picture_is_not_drawn():
    wall = view_of(np.full((CAMERA.height, CAMERA.width), 0.5, np.float32))
    behind = RigidTransform(np.eye(3), np.array([0.0, 0.0, -3.0]))
    beside = RigidTransform(np.eye(3), np.array([9.0, 0.0, 0.0]))
    turned = about_the_body(np.pi)
    for motion in (behind, beside, turned):
        assert not np.isfinite(seen_after(wall, motion)).any()


@pytest.mark.parametrize("turn_deg", [2.0, -8.0, 12.0])
def test_the_turn_of_a_flat_body_is_found(turn_deg):
    motion = about_the_body(np.radians(turn_deg), 0.01, (0.01, 0.0, -0.015))
    target, source = view_of(ellipsoid_image(motion)), view_of(ellipsoid_image(IDENTITY))
    found = fit_turn(target, source, IDENTITY, FLOOR).target_from_source
    error = found @ motion.inverse()
    assert np.degrees(turn_rad(error)) < 0.1 + 0.02 * abs(turn_deg)
    np.testing.assert_allclose(error.apply(MIDDLE_M), MIDDLE_M, atol=0.001)


def test_the_floor_holds_a_body_whose_height_nothing_tells():
    """A wall tells neither how far somebody rose nor how far somebody went aside."""
    wall = view_of(plane_image(np.array([0.0, 0.0, 0.5])))
    guess = RigidTransform(np.eye(3), np.array([0.0, -0.004, 0.01]))
    params = TurnParams(lift_sd_m=1e-5)
    found = fit_turn(wall, wall, guess, FLOOR, params).target_from_source
    assert abs(found.translation_m[1]) < 1e-4
    assert abs(found.translation_m[2]) < 1e-4


def test_what_does_not_fit_is_not_fitted():
    target = view_of(ellipsoid_image(RigidTransform(np.eye(3), np.array([0.0, 0.0, 0.8]))))
    source = view_of(ellipsoid_image(IDENTITY))
    assert fit_turn(target, source, IDENTITY, FLOOR) is None
    nothing = view_of(np.full((CAMERA.height, CAMERA.width), np.nan, np.float32))
    assert fit_turn(nothing, source, IDENTITY, FLOOR) is None


def test_a_body_is_followed_around_and_found_again_after_a_gap():
    turns_rad = np.radians(np.arange(0.0, 60.0, 3.0))
    tracker = TurnTracker(FLOOR)
    gone = view_of(np.full((CAMERA.height, CAMERA.width), np.nan, np.float32))
    for number, turn in enumerate(turns_rad):
        if number == 10:
            assert tracker.follow(gone) is None
        pose = tracker.follow(view_of(ellipsoid_image(about_the_body(turn))))
        error = pose @ about_the_body(turn)
        assert np.degrees(turn_rad(error)) < 1.0
