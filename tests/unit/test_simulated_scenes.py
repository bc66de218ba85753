"""Simulated frames agree with the truth that they carry, and come out the same every time."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from adibas.data.calibration import DepthBias
from adibas.data.frames import EncodedImage
from adibas.data.joints import BODY_PART_NAMES, JOINT_NAMES
from adibas.geometry.pinhole import project
from adibas.simulation.color_noise import EXACT_COLOR
from adibas.simulation.depth_noise import EXACT
from adibas.simulation.frame_times import frame_time_ns
from adibas.simulation.layouts import analysis_settings, marker_layouts
from adibas.simulation.light import Illumination
from adibas.simulation.looks import Look, linear_from_srgb
from adibas.simulation.patient import RED, MarkerSettings
from adibas.simulation.room import Room
from adibas.simulation.scenes import (
    VIEW_MARKERS,
    SceneSettings,
    SimulatedScene,
    open_scene,
    scene_names,
)

SMALL = (480, 640)
PLAIN = {
    "room": Room(),
    "illumination": Illumination(temperature_k=6500.0, level=0.9),
    "look": Look("shorts"),
    "color_noise": EXACT_COLOR,
    "depth_noise": EXACT,
}
NAMES = VIEW_MARKERS["anterior"]


@pytest.fixture(scope="module")
def plain():
    """Return a scene without noise, with large stickers, at full resolution."""
    markers = MarkerSettings((*NAMES, "c7"), diameter_m=0.016, color=RED)
    return open_scene("anterior", 4, markers=markers, **PLAIN)


@pytest.fixture(scope="module")
def plain_frame(plain):
    return plain.frame(0)


def visible(frame):
    found = [marker for marker in frame.truth.markers if marker.is_visible]
    assert len(found) >= 9
    return found


def test_centre_of_a_painted_sticker_is_where_the_truth_says(plain, plain_frame):
    bare = SimulatedScene(replace(plain.settings, markers=MarkerSettings())).frame(0)
    with_stickers, without = (
        linear_from_srgb(frame.sensor_frame.color.astype(float)) for frame in (plain_frame, bare)
    )
    # Red paper takes green and blue away from skin and cloth: by as much as it covers the pixel.
    for marker in visible(plain_frame):
        u, v, reach = round(marker.u), round(marker.v), 12
        window = (slice(v - reach, v + reach + 1), slice(u - reach, u + reach + 1))
        paper = with_stickers[v, u]
        skin = without[window]
        taken = ((skin - with_stickers[window]) * (skin - paper)).sum(-1)
        covered = taken / ((skin - paper) ** 2).sum(-1)
        rows, columns = np.mgrid[window]
        center = [(covered * grid).sum() / covered.sum() for grid in (columns, rows)]
        np.testing.assert_allclose(center, (marker.u, marker.v), atol=0.05, err_msg=marker.name)


def test_stickers_lie_on_the_surface_that_the_depth_shows(plain_frame):
    calibration = plain_frame.truth.calibration
    depth_from_color = calibration.color_from_depth.inverse()
    n_checked = 0
    for marker in visible(plain_frame):
        position_m = depth_from_color.apply(marker.position_m)
        u, v = np.rint(project(position_m, calibration.depth.intrinsics)).astype(int)
        if marker.view_angle_rad < 0.8 and 0 <= v < 480:
            n_checked += 1
            assert plain_frame.truth.depth_m[v, u] == pytest.approx(position_m[2], abs=0.003)
    assert n_checked >= 5


def test_depth_without_noise_is_the_truth_to_half_a_step(plain_frame):
    raw_m = plain_frame.sensor_frame.depth_raw.astype(np.float32) / 1000
    calibration = plain_frame.truth.calibration
    corrected_m = calibration.corrected_depth(raw_m)
    depth_m = plain_frame.truth.depth_m
    half_step_m = 0.5 * depth_m**2 / (8 * 0.075 * 570) + 0.0006
    is_read = raw_m > 0
    assert is_read.mean() > 0.8
    assert (np.abs(corrected_m - depth_m)[is_read] <= 1.1 * half_step_m[is_read]).all()


def test_what_faces_away_or_is_cut_is_not_visible(plain_frame):
    assert plain_frame.truth.marker("c7").visible_fraction == 0.0
    assert not plain_frame.truth.marker("c7").is_visible
    assert plain_frame.truth.marker("sternal_notch").is_visible
    near = open_scene(
        "anterior",
        4,
        distance_m=1.0,
        markers=MarkerSettings(("left_metatarsals", "torso")),
        color_size=SMALL,
        **PLAIN,
    )
    markers = near.frame(0).truth.markers
    assert markers[0].visible_fraction == 0.0
    assert markers[1].is_visible


def test_a_frame_is_the_same_in_any_order_and_differs_with_the_seed():
    scene = open_scene("anterior", 2, color_size=SMALL)
    for index in (0, 1):
        scene.frame(index)
    after_others = scene.frame(2)
    alone = open_scene("anterior", 2, color_size=SMALL).frame(2)
    other = open_scene("anterior", 3, color_size=SMALL).frame(2)
    for name in ("depth_raw", "color"):
        image = getattr(after_others.sensor_frame, name)
        np.testing.assert_array_equal(image, getattr(alone.sensor_frame, name))
        assert (image != getattr(other.sensor_frame, name)).any()
    assert after_others.sensor_frame.timestamp_ns == alone.sensor_frame.timestamp_ns
    assert after_others.truth.markers[0].u == alone.truth.markers[0].u


def test_the_patient_sways_by_millimetres():
    scene = open_scene("anterior", 2, has_color=False)
    heads = np.array([scene.frame(index).truth.joints_m[0] for index in (0, 30, 60, 90)])
    moved_m = np.linalg.norm(heads - heads[0], axis=1)[1:]
    assert (moved_m > 1e-4).all()
    assert (moved_m < 0.06).all()


def test_every_part_is_labelled_and_left_is_the_patients(plain_frame):
    labels = open_scene("anterior", 4, distance_m=2.8, has_color=False).frame(0).truth.labels
    assert set(np.unique(labels)) == set(range(16))
    columns = {
        side: np.nonzero(labels == BODY_PART_NAMES.index(f"{side}_hand") + 1)[1].mean()
        for side in ("left", "right")
    }
    assert columns["left"] > columns["right"] + 50
    frame = open_scene("posterior", 4, has_color=False).frame(0)
    left, right = (JOINT_NAMES.index(f"{side}_hand") for side in ("left", "right"))
    assert frame.truth.joints_m[left, 0] < frame.truth.joints_m[right, 0]
    assert plain_frame.truth.joints_m[left, 0] > plain_frame.truth.joints_m[right, 0]


def test_the_body_mask_is_where_the_person_stands_before_the_wall(plain_frame):
    mask = plain_frame.truth.body_mask
    depth_m = plain_frame.truth.depth_m
    assert 0.08 < mask.mean() < 0.25
    assert depth_m[mask].max() < 2.4
    assert depth_m[:300][~mask[:300]].min() > 2.6


def test_leds_shine_in_the_dark_and_leave_holes_in_the_depth():
    exact = {"depth_noise": EXACT, "color_noise": EXACT_COLOR}
    scene = open_scene("anterior_led", 4, color_size=SMALL, **exact)
    frame = scene.frame(0)
    color = frame.sensor_frame.color
    assert np.median(color) < 60
    calibration = frame.truth.calibration
    for marker in visible(frame):
        assert color[round(marker.v), round(marker.u)].min() == 255
        position_m = calibration.color_from_depth.inverse().apply(marker.position_m)
        u, v = np.rint(project(position_m, calibration.depth.intrinsics)).astype(int)
        if 2 <= v < 478:
            assert frame.sensor_frame.depth_raw[v - 1 : v + 2, u - 1 : u + 2].max() == 0
            assert frame.truth.labels[v, u] > 0


def test_the_shadow_falls_away_from_the_lamp():
    for azimuth_rad, sign in ((0.7, -1), (-0.7, 1)):
        light = Illumination(azimuth_rad=azimuth_rad, elevation_rad=0.6)
        settings = PLAIN | {"illumination": light}
        scene = open_scene("anterior", 4, color_size=SMALL, **settings)
        empty = open_scene("empty", 4, color_size=SMALL, **settings)
        with_patient, without = (s.frame(0).sensor_frame.color for s in (scene, empty))
        change = with_patient.astype(int) - without
        # On the wall all channels darken by the same share; the patient changes them otherwise.
        is_shadow = (change.max(-1) < -8) & (np.abs(with_patient / without - 0.6).max(-1) < 0.35)
        is_shadow &= np.ptp(with_patient / np.maximum(without, 1), axis=-1) < 0.03
        joints_u = project(scene.frame(0).truth.joints_color_m, scene.device.color.intrinsics)[:, 0]
        assert sign * (np.nonzero(is_shadow)[1].mean() - joints_u.mean()) > 20


def test_balls_stand_out_of_the_skin_and_are_seen_in_the_depth():
    markers = MarkerSettings(("sternal_notch", "left_patella"), "ball", 0.03)
    scene = open_scene("anterior", 4, markers=markers, color_size=SMALL, **PLAIN)
    frame = scene.frame(0)
    flat = SimulatedScene(replace(scene.settings, markers=replace(markers, kind="sticker")))
    for ball, disc in zip(frame.truth.markers, flat.frame(0).truth.markers, strict=True):
        np.testing.assert_allclose(ball.position_m - disc.position_m, 0.015 * disc.normal)
        position_m = frame.truth.calibration.color_from_depth.inverse().apply(ball.position_m)
        u, v = np.rint(project(position_m, frame.truth.calibration.depth.intrinsics)).astype(int)
        assert frame.truth.depth_m[v, u] == pytest.approx(position_m[2] - 0.015, abs=0.002)


def test_the_calibration_handed_out_is_exact_unless_the_bias_is_unknown(plain):
    handed_out = plain.info.calibration
    assert handed_out.depth_bias == plain.device.calibration.depth_bias
    assert handed_out.color == plain.device.color
    unknowing = open_scene("anterior", 4, knows_bias=False, has_color=False)
    assert unknowing.info.calibration.depth_bias == DepthBias()
    assert unknowing.device.calibration.depth_bias != DepthBias()


@pytest.mark.parametrize("mounting", ["landscape", "portrait"])
def test_gravity_and_floor_fit_the_standing_patient(mounting):
    scene = open_scene("anterior", 4, mounting=mounting, tilt_rad=0.05, has_color=False)
    calibration, truth = scene.info.calibration, scene.frame(0).truth
    feet_m = truth.joints_m[[JOINT_NAMES.index(f"{side}_foot") for side in ("left", "right")]]
    upward = truth.joints_m[0] - feet_m.mean(axis=0)
    assert upward @ calibration.gravity < -0.99 * np.linalg.norm(upward)
    assert (np.abs(calibration.floor.signed_distance_m(feet_m) - 0.08) < 0.05).all()
    down = 0 if mounting == "portrait" else 1
    assert calibration.gravity[down] > 0.99


def test_an_empty_room_has_no_person():
    frame = open_scene("empty", 1, color_size=SMALL).frame(0)
    assert not frame.truth.body_mask.any()
    assert np.isnan(frame.truth.joints_m).all()
    assert frame.truth.markers == ()
    assert (frame.sensor_frame.depth_raw > 0).mean() > 0.8


def test_jpeg_shows_the_same_picture():
    settings = SceneSettings(color_size=SMALL, **PLAIN)
    picture = SimulatedScene(settings).frame(0).sensor_frame.color
    encoded = SimulatedScene(replace(settings, jpeg_quality=95)).frame(0).sensor_frame.color
    assert isinstance(encoded, EncodedImage)
    decoded = cv2.imdecode(np.frombuffer(encoded.payload, np.uint8), cv2.IMREAD_COLOR_RGB)
    assert np.abs(decoded.astype(int) - picture).mean() < 2


def test_frames_are_numbered_and_timed_like_a_sensors():
    scene = open_scene("jump", 1, has_color=False, n_frames=5)
    frames = [scene.frame(index).sensor_frame for index in range(5)]
    assert [frame.sequence for frame in frames] == list(range(5))
    gaps_ns = np.diff([frame.timestamp_ns for frame in frames])
    np.testing.assert_allclose(gaps_ns, 1e9 / 30, atol=1.5e6)
    assert len(set(gaps_ns)) > 1
    with pytest.raises(IndexError, match="frame 5 of 5"):
        scene.frame(5)


def test_colour_taken_later_shows_a_later_moment():
    settings = {"color_size": SMALL, "markers": MarkerSettings(("left_wrist",)), **PLAIN}
    late = open_scene("clap", 3, color_delay_s=0.2, **settings).frame(30)
    in_time = open_scene("clap", 3, **settings)
    assert late.sensor_frame.color_timestamp_ns - late.sensor_frame.timestamp_ns == 200_000_000
    expected = in_time.frame(36).truth.markers[0].position_m
    earlier = in_time.frame(30).truth.markers[0].position_m
    np.testing.assert_allclose(late.truth.markers[0].position_m, expected, atol=0.004)
    assert np.linalg.norm(expected - earlier) > 0.02


def test_gestures_move_the_hands():
    scene = open_scene("greet", 1, has_color=False)
    hands_y = [scene.frame(index).truth.joints_m[[6, 7], 1] for index in range(0, 60, 10)]
    assert np.ptp(hands_y, axis=0).max() > 0.4


def test_all_scenes_of_the_clinic_are_named():
    names = set(scene_names())
    assert {"standing", "anterior", "posterior", "left_lateral", "right_lateral"} <= names
    assert {"jump", "bend", "clap", "greet", "note", "idle", "anterior_led", "empty"} <= names
    with pytest.raises(KeyError):
        open_scene("no_such_scene")


def test_the_200_analyses_differ_and_spread_the_markers_over_the_body():
    settings = analysis_settings()
    assert len(settings) == len(set(settings)) == 200
    assert all(one.distance_m == 2.0 and one.markers.diameter_m == 0.008 for one in settings)
    layouts = marker_layouts()
    assert len(set(layouts)) == 10
    legs = {"patella", "knee", "tibial_tuberosity", "foot", "metatarsals", "lateral_malleolus"}
    for names in layouts:
        assert 10 <= len(set(names)) <= 15
        assert {"glabella", "head", "menton", "sternal_notch", "neck"} & set(names)
        assert legs & {name.partition("_")[2] for name in names}
    assert SceneSettings().markers.diameter_m == 0.008


def test_a_turning_patient_shows_one_side_after_the_other():
    scene = open_scene("turn", seed=3, has_color=False, is_swaying=False)
    start = scene.person(0)[1].joints_m
    for index in (0, 40, 100, 255):
        time_s = frame_time_ns(3, index) / 1e9
        turn_rad = 2.0 * np.pi * max(time_s - 1.0, 0.0) / 10.0
        # The axis points down: to the patient's right.
        cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
        wanted = start @ np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]]).T
        np.testing.assert_allclose(scene.person(index)[1].joints_m, wanted, atol=1e-3)


def test_who_turns_to_the_right_shows_the_right_side_next():
    scene = open_scene("turn", seed=3, has_color=False, is_swaying=False)
    begin, quarter = (scene.person(index)[1].joints_m for index in (0, 75))
    left, right = JOINT_NAMES.index("left_shoulder"), JOINT_NAMES.index("right_shoulder")
    assert begin[left, 0] < begin[right, 0]  # the back to the sensor
    assert quarter[right, 2] < quarter[left, 2] - 0.2  # the right one is nearer
