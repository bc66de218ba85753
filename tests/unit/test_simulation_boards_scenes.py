"""The scenes to calibrate with: what they show is what their truth says, in any order."""

import cv2
import numpy as np
import pytest

from adibas.data.frames import depth_in_metres
from adibas.geometry.pinhole import back_project
from adibas.sensors import SensorOptions, open_source
from adibas.simulation.boards_scenes import BoardScene
from adibas.simulation.boards_wall import WallScene
from adibas.simulation.device import draw_device
from adibas.simulation.frame_times import FRAME_RATE_HZ
from adibas.simulation.scenes import open_scene, scene_names

SMALL = (480, 640)


@pytest.fixture(scope="module")
def board():
    return open_scene("board", 7, color_size=SMALL)


@pytest.fixture(scope="module")
def wall():
    return open_scene("wall", 7, color_size=SMALL, distances_m=(0.9, 2.6), frames_each=4)


def frames_of(scene, wanted):
    """Return for each stop a frame in its middle, or for each way."""
    time_s = np.arange(0.0, scene.walk.duration_s, 1.0 / FRAME_RATE_HZ)
    stations = [scene.walk.station_at(t) for t in time_s]
    if wanted == "moving":
        return [index for index, station in enumerate(stations) if station is None]
    return [int(np.median(np.flatnonzero([s == n for s in stations]))) for n in wanted]


def test_both_scenes_are_named_and_their_names_open_them():
    assert {"board", "wall"} <= set(scene_names())
    assert isinstance(open_scene("board", 1, color_size=SMALL), BoardScene)
    assert isinstance(open_scene("wall", 1, color_size=SMALL), WallScene)


def test_opencv_finds_the_board_where_the_truth_says(board):
    (index,) = frames_of(board, [1])
    frame = board.frame(index)
    truth = frame.truth.board
    assert truth.station == 1
    assert not np.isnan(truth.corners_px).any()
    gray = cv2.cvtColor(frame.sensor_frame.color, cv2.COLOR_RGB2GRAY)
    found, corners = cv2.findChessboardCornersSB(gray, (truth.board.columns, truth.board.rows))
    assert found
    stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 60, 1e-4)
    corners = cv2.cornerSubPix(gray, corners, (4, 4), (-1, -1), stop).reshape(-1, 2)
    way = min((corners, corners[::-1]), key=lambda c: np.abs(c[0] - truth.corners_px[0]).sum())
    error_px = way - truth.corners_px
    # Each corner suffers from noise and the colour filter; a common offset would be ours.
    assert np.sqrt((error_px**2).sum(axis=1).mean()) < 0.2
    assert np.abs(error_px.mean(axis=0)).max() < 0.04


def test_the_board_is_in_depth_where_the_pose_says(board):
    (index,) = frames_of(board, [1])
    frame = board.frame(index)
    truth = frame.truth
    depth_from_board = truth.calibration.color_from_depth.inverse() @ truth.board.camera_from_board
    measured_m = depth_in_metres(frame.sensor_frame.depth_raw, board.info.depth_unit_m)
    k = truth.calibration.depth.intrinsics
    corners_m = depth_from_board.apply(truth.board.board.points_m())
    u = np.rint(k.fx * corners_m[:, 0] / corners_m[:, 2] + k.cx).astype(int)
    v = np.rint(k.fy * corners_m[:, 1] / corners_m[:, 2] + k.cy).astype(int)
    inside = (u >= 0) & (u < 640) & (v >= 0) & (v < 480)
    assert inside.sum() > 40
    np.testing.assert_allclose(
        truth.depth_m[v[inside], u[inside]], corners_m[inside, 2], atol=0.004
    )
    for depth_m, largest_m in ((truth.calibration.corrected_depth(measured_m), 0.003),):
        points_m = back_project(depth_m.astype(float), k)[v[inside], u[inside]]
        away_m = (points_m - depth_from_board.translation_m) @ depth_from_board.rotation[:, 2]
        assert abs(np.nanmean(away_m)) < largest_m


def test_the_board_stops_at_more_than_twenty_places_for_a_second_and_a_half(board):
    time_s = np.arange(0.0, board.walk.duration_s, 0.01)
    stations = np.array([-1 if (s := board.walk.station_at(t)) is None else s for t in time_s])
    assert set(stations) == set(range(-1, 22))
    for station in range(22):
        held_s = 0.01 * (stations == station).sum()
        assert held_s == pytest.approx(1.5, abs=0.02)
    assert 45 < board.walk.duration_s < 90


def test_the_walk_is_continuous_and_begins_anew(board):
    walk = board.walk
    middle_m = board.settings.board.points_m().mean(axis=0)
    time_s = np.arange(0.0, walk.duration_s + 1.0, 1.0 / 60.0)
    places_m = np.array([walk.pose_at(t).apply(middle_m) for t in time_s])
    speed_m_s = np.linalg.norm(np.diff(places_m, axis=0), axis=1) * 60.0
    assert speed_m_s.max() < 2.5
    still = np.array([walk.station_at(t) is not None for t in time_s])
    # Only a tremor is left where the board is held.
    assert speed_m_s[still[:-1] & still[1:]].max() < 0.02
    later = walk.pose_at(2.0 + walk.duration_s).apply(middle_m)
    np.testing.assert_allclose(later, walk.pose_at(2.0).apply(middle_m), atol=0.005)


def test_the_stations_cover_the_image_at_many_distances_and_tilts(board):
    stops = [board.walk.pose_at(0.5 + t) for t in board.walk._arrivals_s[:-1]]
    points_m = np.array([pose.apply(board.settings.board.points_m()) for pose in stops])
    k = board.device.color.intrinsics
    u = k.fx * points_m[..., 0] / points_m[..., 2] + k.cx
    v = k.fy * points_m[..., 1] / points_m[..., 2] + k.cy
    counts, _, _ = np.histogram2d(u.ravel(), v.ravel(), bins=(4, 3), range=((0, 640), (0, 480)))
    assert (counts > 20).all()
    assert np.ptp(points_m[..., 2].mean(axis=1)) > 1.0
    tilts_deg = np.degrees(np.arccos([pose.rotation[2, 2] for pose in stops]))
    assert (tilts_deg > 25).sum() >= 6


def test_a_moving_board_is_smeared_and_a_held_one_is_not(board):
    moving = frames_of(board, "moving")
    fastest = max(moving, key=lambda i: np.hypot(*board._motion_px(board._view(i / 30), i / 30)))
    assert np.hypot(*board._motion_px(board._view(fastest / 30), fastest / 30)) > 3
    instant = open_scene("board", 7, color_size=SMALL, exposure_s=0.0)
    changed = []
    for index in (fastest, frames_of(board, [1])[0]):
        one, other = (
            scene.frame(index).sensor_frame.color.astype(int) for scene in (board, instant)
        )
        changed.append((np.abs(one - other).max(axis=2) > 20).sum())
    assert changed[0] > 1000
    assert changed[1] == 0
    assert board.frame(fastest).truth.board.station is None


def test_thumbs_hide_corners_at_some_stops(board):
    careless, careful = frames_of(board, [4, 2])
    hidden = [
        np.isnan(board.frame(index).truth.board.corners_px).any(axis=1).sum()
        for index in (careless, careful)
    ]
    assert 1 <= hidden[0] <= 8
    assert hidden[1] == 0


def test_frames_are_the_same_in_any_order_and_for_the_same_seed(board):
    again = open_scene("board", 7, color_size=SMALL)
    expected = again.frame(31).sensor_frame
    again.frame(3)
    for frame in (again.frame(31).sensor_frame, board.frame(31).sensor_frame):
        np.testing.assert_array_equal(frame.color, expected.color)
        np.testing.assert_array_equal(frame.depth_raw, expected.depth_raw)
        assert frame.timestamp_ns == expected.timestamp_ns
    other = open_scene("board", 8, color_size=SMALL).frame(31).sensor_frame
    assert (other.depth_raw != expected.depth_raw).mean() > 0.3


@pytest.mark.parametrize("name", ["board", "wall"])
def test_the_header_has_the_makers_calibration_and_the_truth_the_exact_one(name, request):
    scene = request.getfixturevalue(name)
    told, truth = scene.info.calibration, scene.frame(0).truth.calibration
    clinic = draw_device(7, SMALL).calibration
    assert truth.color == clinic.color
    assert truth.depth == clinic.depth
    assert truth.sensor_serial == told.sensor_serial == clinic.sensor_serial
    assert told.color.distortion == ()
    assert 0.0 < abs(told.color.intrinsics.fx / truth.color.intrinsics.fx - 1.0) < 0.01
    assert told.depth_bias.correct(np.float32([[2.0]])) == 2.0
    assert told.gravity is None
    assert len(truth.depth_bias.image_term) == 5
    np.testing.assert_allclose(truth.gravity @ truth.floor.normal, -1.0)


def test_the_wall_is_flat_at_every_distance_in_truth_and_in_corrected_depth(wall):
    distances_m = []
    for index in (0, 5):
        frame = wall.frame(index)
        truth = frame.truth
        raw_m = depth_in_metres(frame.sensor_frame.depth_raw, 0.001)
        middle = (slice(60, 200), slice(150, 490))
        k = truth.calibration.depth.intrinsics
        away = [
            truth.wall.signed_distance_m(back_project(depth_m.astype(float), k))[middle]
            for depth_m in (truth.depth_m, truth.calibration.corrected_depth(raw_m), raw_m)
        ]
        np.testing.assert_allclose(away[0], 0.0, atol=1e-5)
        assert abs(np.nanmean(away[1])) < 0.003
        distances_m.append(truth.wall.offset_m)
    assert distances_m == [0.9, 2.6]
    assert abs(np.nanmean(away[2])) > 0.008


def test_the_floor_before_the_wall_is_the_floor_of_the_truth(wall):
    truth = wall.frame(4).truth
    points_m = back_project(truth.depth_m.astype(float), truth.calibration.depth.intrinsics)
    height_m = truth.calibration.floor.signed_distance_m(points_m)
    on_floor = np.abs(height_m) < 1e-4
    assert on_floor.sum() > 30_000
    assert height_m.min() > -1e-4
    assert truth.calibration.floor.offset_m == pytest.approx(0.75)


def test_the_wall_scene_jumps_in_time_while_the_sensor_is_moved(wall):
    times_ns = [wall.frame(index).sensor_frame.timestamp_ns for index in (3, 4, 8)]
    steps_s = np.diff(times_ns) * 1e-9
    assert steps_s[0] == pytest.approx(5.0 + 1 / 30, abs=0.01)
    assert steps_s[1] == pytest.approx(5.0 + 4 / 30, abs=0.01)


@pytest.mark.parametrize("name", ["board", "wall"])
def test_they_are_sources_like_any_sensor(name):
    options = SensorOptions(color_size=(640, 480), seed=7)
    with open_source(f"simulator:{name}", options) as camera:
        frames = [camera.read() for _ in range(2)]
        assert camera.info.calibration.color.width == 640
    assert [frame.sequence for frame in frames] == [0, 1]
    assert frames[0].color.shape == (480, 640, 3)
    assert frames[0].depth_raw.shape == (480, 640)


@pytest.mark.parametrize("name", ["board", "wall"])
def test_a_finite_scene_ends(name):
    scene = open_scene(name, 1, color_size=SMALL, n_frames=2)
    assert scene.n_frames == 2
    for index in (-1, 2):
        with pytest.raises(IndexError):
            scene.frame(index)
