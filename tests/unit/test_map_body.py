"""A person who is mapped alone: nothing else takes part, and it is told how rigid they were."""

import json
from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adibas.alignment.surfels import Distances
from adibas.cli.command_line import main
from adibas.geometry.planes import Plane
from adibas.geometry.rigid import RigidTransform, fit_rigid, rotation_vector
from adibas.pipeline.map_body import body_motion
from adibas.pipeline.map_frames import MapFrames
from adibas.pipeline.mapping import MapRequest, map_recording
from adibas.recordings import create_recording
from adibas.reports.map_files import ROW, motion_sentence
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import open_scene

FLOOR = Plane(np.array([0.0, -1.0, 0.0]), 1.2)
"""The camera looks ahead from 1.2 m."""
N_FRAMES = 6


def turned(angle_deg, shift_m):
    """Return the camera, from a body that turns about the vertical and moves."""
    turn = Rotation.from_euler("y", angle_deg, degrees=True).as_matrix()
    return RigidTransform(turn, np.asarray(shift_m, float)).inverse()


def points_of_a_body(rng):
    """Return points between the floor and 1.7 m, about an axis 2 m before the camera."""
    high_m = rng.uniform(0.0, 1.7, 6000)
    around = rng.uniform(0.0, 2 * np.pi, 6000)
    return np.column_stack([0.15 * np.cos(around), 1.2 - high_m, 0.15 * np.sin(around)])


def deepest_m(path):
    """Return how far from the camera a surface goes."""
    _, body = path.read_bytes().split(b"end_header\n", 1)
    return np.frombuffer(body, ROW)["z"].max()


def test_what_frames_differ_by_is_told_by_height():
    rng = np.random.default_rng(1)
    points_m = points_of_a_body(rng)
    share = (1.2 - points_m[:, 1]) / 1.7
    sd_m = np.where(share > 0.85, 0.006, np.where(share > 0.5, 0.003, 0.001))
    poses = [turned(angle, (0.0, 0.0, 2.0)) for angle in range(0, 360, 30)]
    told = body_motion(
        [Distances(points_m, rng.normal(0.0, sd_m)) for _ in poses], poses, FLOOR, is_floor=True
    )
    assert told.bands_mm["legs"] == pytest.approx(1.0, rel=0.1)
    assert told.bands_mm["trunk"] == pytest.approx(3.0, rel=0.1)
    assert told.bands_mm["head"] == pytest.approx(6.0, rel=0.1)
    assert told.residual_mm == pytest.approx(1e3 * np.sqrt(np.mean(sd_m**2)), rel=0.05)
    assert told.residual_mm <= told.largest_mm < 1.1 * told.residual_mm
    assert told.wandered_mm == pytest.approx(0.0, abs=5.0)


def test_arms_that_swing_are_told_apart_from_a_trunk_that_stands_still():
    rng = np.random.default_rng(2)
    n = 40_000
    around, high_m = rng.uniform(0.0, 2 * np.pi, n), rng.uniform(0.0, 1.7, n)
    body_m = np.column_stack([0.15 * np.cos(around), 1.2 - high_m, 0.1 * np.sin(around)])
    around, high_m = rng.uniform(0.0, 2 * np.pi, n), rng.uniform(0.9, 1.4, n)
    side = np.where(rng.random(n) < 0.5, 0.27, -0.27)
    arms_m = np.column_stack([side + 0.04 * np.cos(around), 1.2 - high_m, 0.04 * np.sin(around)])
    points_m = np.concatenate([body_m, arms_m])
    sd_m = np.where(np.arange(2 * n) < n, 0.001, 0.02)
    poses = [turned(angle, (0.0, 0.0, 2.0)) for angle in range(0, 360, 60)]
    told = body_motion(
        [Distances(points_m, rng.normal(0.0, sd_m)) for _ in poses], poses, FLOOR, is_floor=True
    )
    assert told.bands_mm["trunk"] == pytest.approx(1.0, rel=0.05)
    assert told.bands_mm["arms"] == pytest.approx(20.0, rel=0.05)


@pytest.mark.parametrize(
    ("last_deg", "is_told"), [(2.0, True), (90.0, False), (180.0, False), (360.0, True)]
)
def test_who_turns_on_the_spot_is_not_said_to_move_over_the_floor(last_deg, is_told):
    """Each frame shows the half that faces the camera, and the axis stands still."""
    whole_m = points_of_a_body(np.random.default_rng(4))
    poses = [turned(angle, (0.0, 0.0, 2.0)) for angle in np.linspace(0.0, last_deg, 30)]
    seen = [
        Distances(half_m, np.zeros(len(half_m)))
        for half_m in (whole_m[pose.inverse().apply(whole_m)[:, 2] < 2.0] for pose in poses)
    ]
    told = body_motion(seen, poses, FLOOR, is_floor=True)
    if is_told:
        assert told.wandered_mm < 5.0
        assert "moved" in motion_sentence(told).text
    else:
        assert told.wandered_mm is None
        assert "not seen from all around" in motion_sentence(told).text


def test_somebody_seen_from_the_waist_up_has_no_legs():
    points_m = points_of_a_body(np.random.default_rng(3))
    upper = points_m[points_m[:, 1] < 1.2 - 0.9]
    poses = [turned(angle, (0.0, 0.0, 2.0)) for angle in (0, 5, 10)]
    seen = [Distances(upper, np.full(len(upper), 0.002))] * 3
    told = body_motion(seen, poses, FLOOR, is_floor=True)
    assert set(told.bands_mm) == {"trunk", "head"}
    level = Plane(FLOOR.normal, 0.0)
    unknown = body_motion(seen, poses, level, is_floor=False)
    assert unknown.bands_mm == {}
    assert unknown.residual_mm == pytest.approx(told.residual_mm)


def test_steps_over_the_floor_are_told_and_a_bob_is_none():
    points_m = points_of_a_body(np.random.default_rng(2))
    still = Distances(points_m, np.zeros(len(points_m)))
    steps_m = [(0.02 * sign, 0.05 * sign, 2.0) for sign in (-1, 1, -1, 1)]
    told = body_motion([still] * 4, [turned(0.0, step) for step in steps_m], FLOOR, is_floor=True)
    assert told.wandered_mm == pytest.approx(20.0, rel=1e-6)
    assert told.residual_mm == 0.0


def test_where_hardly_anything_is_seen_nothing_is_told():
    few = Distances(np.zeros((3, 3)), np.zeros(3))
    assert body_motion([few], [turned(0.0, (0.0, 0.0, 2.0))], FLOOR, is_floor=True) is None


def test_the_person_alone_becomes_the_surface(tmp_path, capsys):
    scene = open_scene("anterior", seed=3, color_size=(480, 640))
    path, out = tmp_path / "standing.mcap", tmp_path / "body.ply"
    frames = [scene.frame(index) for index in range(N_FRAMES)]
    with create_recording(path, scene.info) as recording:
        for one in frames:
            recording.write(one.sensor_frame)
    assert main(["map", str(path), "--out", str(out), "--body", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["placed"] == N_FRAMES
    assert 0.3 < said["body"]["residual_mm"] < 6.0
    assert said["body"]["wandered_mm"] < 3.0
    assert set(said["body"]["bands_mm"]) == {"legs", "trunk", "head", "arms"}
    assert deepest_m(out) < 2.4
    assert main(["map", str(path), "--out", str(out), "--json"]) == 0
    whole = json.loads(capsys.readouterr().out)
    assert whole["body"] is None
    assert deepest_m(out) > 2.9, "the wall"


def test_bare_skin_is_followed_through_a_turn_by_its_shape(tmp_path):
    """Every sixth of a second of a turn by 36 degrees a second; no stickers, the camera stands."""
    scene = open_scene(
        "turn", seed=3, color_size=(480, 640), markers=MarkerSettings(), is_swaying=False
    )
    path = tmp_path / "turn.mcap"
    numbers = range(30, 110, 5)
    with create_recording(path, scene.info) as recording:
        for number in numbers:
            recording.write(scene.frame(number).sensor_frame)
    mapped = map_recording(MapRequest(path, is_body=True), lambda _done, _total: None)
    assert len(mapped.world_from_camera) == len(numbers)
    bodies_m = [
        scene.depth_from_world.apply(scene.person(number)[1].joints_m) for number in numbers
    ]
    for pose, body_m in zip(mapped.world_from_camera, bodies_m, strict=True):
        true = fit_rigid(bodies_m[0], body_m)
        turn_rad = np.linalg.norm(rotation_vector((pose @ true.inverse()).rotation))
        assert np.degrees(turn_rad) < 4.0
        assert np.linalg.norm(pose.apply(body_m) - bodies_m[0], axis=1).mean() < 0.03


def test_level_is_against_gravity_where_no_floor_is_seen():
    scene = open_scene("empty", mounting="portrait")
    calibration = replace(scene.info.calibration, floor=None)
    frames = MapFrames(Mock(), range(1), calibration, is_body=True)
    np.testing.assert_allclose(frames.level.normal, [-1.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize("is_gravity_known", [True, False])
def test_a_camera_is_said_to_be_taken_as_upright_only_where_nothing_tells_up(
    tmp_path, is_gravity_known
):
    scene = open_scene("anterior", seed=3, color_size=(480, 640))
    known = scene.info.calibration
    gravity = known.gravity if is_gravity_known else None
    info = replace(scene.info, calibration=replace(known, floor=None, gravity=gravity))
    path = tmp_path / "knees.mcap"
    with create_recording(path, info) as recording:
        for number in range(2):
            frame = scene.frame(number).sensor_frame
            depth_raw = frame.depth_raw.copy()
            depth_raw[2 * len(depth_raw) // 3 :] = 0
            recording.write(replace(frame, depth_raw=depth_raw))
    mapped = map_recording(MapRequest(path, is_body=True), lambda _done, _total: None)
    told = any("No floor is seen" in notice.text for notice in mapped.notices)
    assert told == (not is_gravity_known)
