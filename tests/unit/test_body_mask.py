"""The person and the floor in a depth image, against scenes whose truth is known."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from adibas.body.floor import find_floor
from adibas.body.mask import find_body
from adibas.body.rays import viewing_rays
from adibas.data.calibration import CameraCalibration
from adibas.data.frames import depth_in_metres
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.planes import Plane
from adibas.simulation.layouts import analysis_settings
from adibas.simulation.scenes import SimulatedScene, open_scene

CAMERA = CameraCalibration(640, 480, Intrinsics(580, 580, 319.5, 239.5))
FLOOR = Plane(np.array([0.0, -1.0, 0.0]), 1.0)
WALL_M = 3.5


def overlap(a, b):
    return (a & b).sum() / (a | b).sum()


def simulated(name, seed, index=3, **changes):
    scene = open_scene(name, seed=seed, **changes)
    frame = scene.frame(index)
    calibration = scene.info.calibration
    depth_m = depth_in_metres(frame.sensor_frame.depth_raw, scene.info.depth_unit_m)
    return calibration.corrected_depth(depth_m), calibration, frame.truth


def room(floor=FLOOR, wall_m=WALL_M):
    """Depth of an empty room: floor and wall."""
    rays = viewing_rays(CAMERA).astype(float)
    slope = rays @ floor.normal
    with np.errstate(divide="ignore"):
        to_floor_m = np.where(slope < 0, -floor.offset_m / slope, np.inf)
    return np.minimum(to_floor_m, wall_m).astype(np.float32)


def with_ball(depth_m, centre_m, radius_m):
    """Put an ellipsoid, three times as high as wide, before what is there."""
    rays = viewing_rays(CAMERA).astype(float) * (1, 1 / 3, 1)
    centre = np.array(centre_m) * (1, 1 / 3, 1)
    a, b = (rays**2).sum(-1), rays @ centre
    root = b**2 - a * (centre @ centre - radius_m**2)
    with np.errstate(invalid="ignore"):
        z_m = (b - np.sqrt(root)) / a
    return np.where(root > 0, np.fmin(z_m, depth_m), depth_m).astype(np.float32)


@pytest.mark.parametrize(
    ("name", "seed"), [("anterior", 301), ("right_lateral", 103), ("bend", 302), ("note", 304)]
)
def test_simulated_people_are_found_with_their_outline(name, seed):
    depth_m, calibration, truth = simulated(name, seed)
    body = find_body(depth_m, calibration.depth, calibration.floor)
    assert overlap(body.pixels, truth.body_mask) > 0.95


@pytest.mark.parametrize("seed", [800, 803, 809])
def test_a_person_is_found_in_a_room_whose_end_is_too_far_away_to_be_measured(seed):
    # 800, 809: ceiling and side wall are one large surface; 803: nothing is seen behind the person.
    depth_m, calibration, truth = simulated("anterior", seed, distance_m=3.5)
    body = find_body(depth_m, calibration.depth, calibration.floor)
    assert overlap(body.pixels, truth.body_mask) > 0.85


def test_a_leg_that_noise_tears_from_the_trunk_does_not_stand_before_it():
    depth_m, calibration, truth = simulated("posterior", 7000, index=0, distance_m=3.9)
    body = find_body(depth_m, calibration.depth, calibration.floor)
    assert overlap(body.pixels, truth.body_mask) > 0.85


def test_a_chair_in_an_empty_room_is_nobody():
    depth_m, calibration, _ = simulated("empty", 110)
    assert find_body(depth_m, calibration.depth, calibration.floor) is None


def test_head_and_chest_over_raised_forearms_belong_to_the_legs_below():
    scene = open_scene("note", seed=303)
    frame, calibration = scene.frame(25), scene.info.calibration
    depth_m = depth_in_metres(frame.sensor_frame.depth_raw, scene.info.depth_unit_m)
    depth_m = calibration.corrected_depth(depth_m)
    body = find_body(depth_m, calibration.depth, calibration.floor)
    assert overlap(body.pixels, frame.truth.body_mask) > 0.93


@pytest.mark.parametrize(
    ("settings", "least"),
    [
        # Between arm and chair; and far away at the picture's side, as rough as the noise.
        (analysis_settings(7)[14], 0.95),
        (replace(analysis_settings(0)[175], distance_m=3.5), 0.85),
    ],
    ids=["inside", "far"],
)
def test_a_piece_of_wall_is_nobody_however_large(settings, least):
    scene = SimulatedScene(settings)
    frame, calibration = scene.frame(0), scene.info.calibration
    depth_m = depth_in_metres(frame.sensor_frame.depth_raw, scene.info.depth_unit_m)
    depth_m = calibration.corrected_depth(depth_m)
    body = find_body(depth_m, calibration.depth, calibration.floor)
    assert overlap(body.pixels, frame.truth.body_mask) > least


def test_legs_before_a_camera_that_looks_down_are_a_person_and_the_chair_is_not():
    tilted = {"distance_m": 1.91, "camera_height_m": 0.84, "tilt_rad": 0.24}
    depth_m, calibration, truth = simulated("left_lateral", 8010, **tilted)
    body = find_body(depth_m, calibration.depth, calibration.floor)
    assert (body.pixels & truth.body_mask).sum() > 0.97 * body.pixels.sum()


def test_an_image_without_depth_shows_nobody():
    nothing = np.full((480, 640), np.nan, np.float32)
    assert find_body(nothing, CAMERA) is None
    assert find_floor(nothing, CAMERA) is None


def test_neither_floor_nor_wall_belongs_to_the_body():
    depth_m = with_ball(room(), (0.0, 0.15, 2.2), 0.28)
    body = find_body(depth_m, CAMERA, FLOOR)
    is_room = depth_m >= room() - 1e-4
    assert body.pixels.sum() > 20_000
    assert not (body.pixels & is_room).any()


def test_of_two_people_the_larger_one_is_taken():
    depth_m = with_ball(with_ball(room(), (-0.5, 0.1, 2.2), 0.2), (0.5, 0.1, 2.2), 0.28)
    body = find_body(depth_m, CAMERA, FLOOR)
    assert body.pixels[:, 320:].sum() > 20_000
    assert not body.pixels[:, :280].any()


def test_a_board_behind_the_patient_is_no_part_of_the_body():
    depth_m = room()
    depth_m[100:300, 200:500] = 2.7
    depth_m = with_ball(depth_m, (0.0, 0.15, 2.2), 0.28)
    body = find_body(depth_m, CAMERA, FLOOR)
    assert body.pixels.any()
    assert not (body.pixels & (np.abs(depth_m - 2.7) < 1e-4)).any()


def test_a_hole_without_depth_inside_the_body_is_filled_but_a_view_past_it_is_not():
    depth_m = with_ball(room(), (0.0, 0.15, 2.2), 0.28)
    depth_m[200:210, 310:320] = np.nan
    depth_m[260:270, 310:320] = WALL_M
    body = find_body(depth_m, CAMERA, FLOOR)
    assert body.pixels[200:210, 310:320].all()
    assert not body.pixels[260:270, 310:320].any()


@pytest.mark.parametrize("tilt_deg", [0, 20])
def test_the_floor_is_found_under_noise(tilt_deg):
    turn = cv2.Rodrigues(np.array([np.deg2rad(tilt_deg), 0.0, 0.0]))[0]
    floor = Plane(turn @ FLOOR.normal, 1.3)
    depth_m = room(floor)
    noise = np.random.default_rng(5).normal(0, 1.4e-3, depth_m.shape) * depth_m**2
    found = find_floor((depth_m + noise).astype(np.float32), CAMERA)
    assert found.normal @ floor.normal > np.cos(np.deg2rad(0.7))
    assert abs(found.offset_m - 1.3) < 0.03


def test_a_table_is_not_taken_for_the_floor():
    table = Plane(np.array([0.0, -1.0, 0.0]), 0.4)
    depth_m = room()
    above = room(table)
    depth_m[:, 200:440] = np.where(above < 2.5, above, depth_m)[:, 200:440]
    found = find_floor(depth_m, CAMERA)
    assert abs(found.offset_m - 1.0) < 0.01


def test_a_wall_alone_is_no_floor():
    wall_m = np.full((480, 640), 2.0, np.float32)
    assert find_floor(wall_m, CAMERA) is None


@pytest.mark.parametrize("number", [0, 20, 33, 46])
def test_a_real_person_seen_from_the_waist_up_is_found(real_data, number):
    stem = str(real_data / "person_turntable" / f"{number:010d}")
    depth_mm = cv2.imread(f"{stem}_depth.png", cv2.IMREAD_UNCHANGED)
    truth = cv2.imread(f"{stem}_mask.jpg", cv2.IMREAD_GRAYSCALE) > 127
    camera = CameraCalibration(640, 480, Intrinsics(525, 525, 320, 240))
    body = find_body(depth_in_metres(depth_mm, 0.001), camera)
    assert overlap(body.pixels, truth) > 0.93


def test_a_wall_behind_someone_near_is_no_floor():
    depth_m, calibration, _truth = simulated("anterior", 422, distance_m=1.5, has_color=False)
    found = find_floor(depth_m, calibration.depth)
    assert found is None or found.tilt_rad(np.array([0.0, -1.0, 0.0])) < 0.1
