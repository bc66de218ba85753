"""People are found as well by a sensor on its side, and joints are in that sensor's own axes."""

import json
from dataclasses import replace

import numpy as np
import pytest

from adibas.cli.command_line import main
from adibas.data.calibration import DepthBias, RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.data.joints import JOINT_NAMES
from adibas.data.limbs import FULL_BODY, LimbParts
from adibas.geometry.quarter_turns import QuarterTurn
from adibas.geometry.rigid import RigidTransform
from adibas.limbs.training_set import LimbFolder
from adibas.measures.sight_plane import up_of_picture
from adibas.pipeline.found_joints import JointSource, find_joints
from adibas.pipeline.limb_labelling import LabellingDesk
from adibas.pipeline.limb_proposing import ProposingRequest, propose_recording
from adibas.pipeline.limb_segmenting import SegmentingRequest, segment_recording
from adibas.pipeline.live_gestures import LiveGestures
from adibas.pipeline.live_people import LivePeople
from adibas.pipeline.movement import MovementRequest, measure_moving
from adibas.pipeline.pose import PoseRequest, movement_of, pose_recording
from adibas.pipeline.posture import PostureParams, floor_below, see_person
from adibas.pipeline.upright import (
    turn_to_upright,
    turned_camera,
    turned_floor,
    turned_parts,
)
from adibas.recordings import create_recording, open_recording
from adibas.recordings.joints_csv import write_joints_csv
from adibas.reports.motion_files import upright_axes
from adibas.simulation.scenes import open_scene

N_FRAMES = 4
ON_SIDES = [QuarterTurn(1), QuarterTurn(2), QuarterTurn(3)]


def watched(scene):
    """The corrected depth of some frames, their times, and the true joints."""
    calibration = scene.info.calibration
    frames = [scene.frame(number) for number in range(N_FRAMES)]
    depths_m = [
        calibration.corrected_depth(
            depth_in_metres(frame.sensor_frame.depth_raw, scene.info.depth_unit_m)
        )
        for frame in frames
    ]
    times_ns = [frame.sensor_frame.timestamp_ns for frame in frames]
    return depths_m, times_ns, np.stack([frame.truth.joints_m for frame in frames])


def turned_sensor(calibration, turn):
    """The calibration of the same sensor, mounted so that its pictures come out turned."""
    color_from_depth = calibration.color_from_depth
    return replace(
        calibration,
        depth=turned_camera(calibration.depth, turn),
        depth_bias=DepthBias(),
        gravity=turn.points(calibration.gravity),
        floor=turned_floor(calibration.floor, turn),
        color_from_depth=RigidTransform(
            color_from_depth.rotation @ turn.rotation.T, color_from_depth.translation_m
        ),
    )


def joints_m(depths_m, times_ns, calibration, rotation_deg=0):
    """The joints of the one person in each frame, in the axes of the depth camera."""
    live = LivePeople()
    found = []
    for depth_m, time_ns in zip(depths_m, times_ns, strict=True):
        (person,) = live.look(depth_m, time_ns, calibration, rotation_deg).people
        assert person.pixels.shape == person.parts.chosen.shape == depth_m.shape
        assert person.picture.camera == calibration.depth
        assert (person.pixels[person.parts.pixels]).all()
        found.append(person.joints.joints_m)
    return np.stack(found)


@pytest.fixture(scope="module")
def upright():
    scene = open_scene("greet", seed=3, has_color=False, distance_m=2.7)
    depths_m, times_ns, truth_m = watched(scene)
    calibration = replace(scene.info.calibration, depth_bias=DepthBias())
    return calibration, depths_m, times_ns, truth_m, joints_m(depths_m, times_ns, calibration)


@pytest.mark.parametrize("turn", ON_SIDES)
def test_joints_do_not_depend_on_how_the_sensor_is_mounted(upright, turn):
    calibration, depths_m, times_ns, _truth_m, upright_m = upright
    found_m = joints_m(
        [turn.picture(depth_m) for depth_m in depths_m], times_ns, turned_sensor(calibration, turn)
    )
    np.testing.assert_allclose(turn.inverse().points(found_m), upright_m, atol=1e-6)


@pytest.mark.parametrize("turn", ON_SIDES)
def test_the_picture_shown_says_where_up_is_where_the_calibration_does_not(upright, turn):
    calibration, depths_m, times_ns, truth_m, _upright_m = upright
    blind = replace(turned_sensor(calibration, turn), gravity=None, floor=None)
    found_m = joints_m(
        *([turn.picture(depth_m) for depth_m in depths_m], times_ns, blind),
        rotation_deg=90 * turn.inverse().n_quarters,
    )
    far_m = np.linalg.norm(turn.inverse().points(found_m) - truth_m, axis=2)
    assert np.nanmedian(far_m) < 0.06
    assert (far_m[np.isfinite(far_m)] < 0.1).mean() > 0.8


@pytest.fixture(scope="module")
def on_its_side():
    return open_scene("greet", seed=3, has_color=False, distance_m=2.7, mounting="portrait")


@pytest.fixture(scope="module")
def video(on_its_side, tmp_path_factory):
    path = tmp_path_factory.mktemp("portrait") / "portrait.mcap"
    with create_recording(path, on_its_side.info) as writer:
        for number in range(N_FRAMES):
            writer.write(on_its_side.frame(number).sensor_frame)
    return path


def test_a_recording_of_a_sensor_on_its_side_has_its_joints_as_near_as_an_upright_one(
    upright, on_its_side, video
):
    posed = pose_recording(PoseRequest(video), lambda *_done: None)
    truth_m = watched(on_its_side)[2]
    far_m = np.linalg.norm(posed.tracks[0].joints_m - truth_m, axis=2)
    upright_far_m = np.linalg.norm(upright[4] - upright[3], axis=2)
    assert np.isfinite(far_m).mean() > 0.9
    assert np.nanmedian(far_m) < np.nanmedian(upright_far_m) + 0.01
    assert (far_m[np.isfinite(far_m)] < 0.1).mean() > 0.8


def test_a_movement_without_markers_is_measured_by_a_sensor_on_its_side(video):
    request = MovementRequest(video, is_markerless=True)
    movement = measure_moving(request, lambda *_done: None)
    assert movement.is_up_measured
    np.testing.assert_allclose(movement.up, [-1.0, 0.0, 0.0], atol=1e-6)
    assert np.isfinite(movement.joints_m).mean() > 0.9


@pytest.mark.parametrize(("known", "rotation_deg"), [("floor", 0), ("gravity", 0), ("neither", 90)])
def test_who_stands_before_a_sensor_on_its_side_is_seen_for_markers(
    on_its_side, known, rotation_deg
):
    whole = replace(on_its_side.info.calibration, depth_bias=DepthBias())
    calibration = {
        "floor": replace(whole, gravity=None),
        "gravity": replace(whole, floor=None),
        "neither": replace(whole, gravity=None, floor=None),
    }[known]
    depth_m = watched(on_its_side)[0][0]
    params = PostureParams(rotation_deg=rotation_deg)
    sight = see_person(depth_m, floor_below(depth_m, calibration, params), calibration, params)
    truth = on_its_side.frame(0).truth.labels > 0
    assert sight is not None
    assert (sight.body.pixels & truth).sum() > 0.9 * truth.sum()


@pytest.fixture(scope="module")
def blind_video(on_its_side, tmp_path_factory):
    """The same recording of a sensor that knows neither gravity nor the floor."""
    calibration = replace(on_its_side.info.calibration, gravity=None, floor=None)
    path = tmp_path_factory.mktemp("blind") / "portrait.mcap"
    with create_recording(path, replace(on_its_side.info, calibration=calibration)) as writer:
        for number in range(N_FRAMES):
            writer.write(on_its_side.frame(number).sensor_frame)
    return path


@pytest.fixture(scope="module")
def told_pose(blind_video):
    return pose_recording(PoseRequest(blind_video, rotation_deg=90), lambda *_done: None)


def test_a_rotation_says_where_up_is_where_the_recording_does_not(on_its_side, told_pose):
    truth_m = watched(on_its_side)[2]
    far_m = np.linalg.norm(told_pose.tracks[0].joints_m - truth_m, axis=2)
    assert np.isfinite(far_m).mean() > 0.9
    assert (far_m[np.isfinite(far_m)] < 0.1).mean() > 0.8


def test_the_rotation_is_an_option_of_the_commands(blind_video, tmp_path, capsys):
    out = tmp_path / "joints.csv"
    options = ["--out", str(out), "--json"]
    assert main(["pose", str(blind_video), "--rotation", "90", *options]) == 0
    found = json.loads(capsys.readouterr().out)
    assert min(found["people"][0]["seen_share"].values()) > 0.5
    assert found["provenance"]["parameters"]["rotation_deg"] == 90
    turned_out = tmp_path / "limbs"
    command = ["limbs", "segment", str(blind_video), "--frames", "0:1", "--out", str(turned_out)]
    assert main([*command, "--rotation", "90", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["n_with_person"] == 1
    with pytest.raises(SystemExit):
        main(["pose", str(blind_video), "--rotation", "45", *options])


def test_a_table_of_joints_of_a_sensor_on_its_side_is_exported_upright(told_pose, tmp_path):
    table = tmp_path / "joints.csv"
    write_joints_csv(table, told_pose.tracks)
    request = MovementRequest(table, posture=PostureParams(rotation_deg=90))
    np.testing.assert_allclose(measure_moving(request, lambda *_done: None).up, [-1.0, 0.0, 0.0])


def test_behaviour_is_watched_with_the_body_upright(video, blind_video, told_pose, tmp_path):
    table = tmp_path / "joints.csv"
    write_joints_csv(table, told_pose.tracks)
    for request in (
        JointSource(video),
        JointSource(blind_video, rotation_deg=90),
        JointSource(table, rotation_deg=90),
    ):
        (track,) = find_joints(request, lambda *_done: None).tracks
        head, foot = (JOINT_NAMES.index(name) for name in ("head", "left_foot"))
        down_m = track.joints_m[:, foot] - track.joints_m[:, head]
        assert np.nanmean(down_m[:, 1]) > 1.2
        assert abs(np.nanmean(down_m[:, 0])) < 0.3


def test_joints_of_a_rotated_recording_are_exported_upright(told_pose):
    movement = movement_of(told_pose, told_pose.tracks[0].person)
    assert not movement.is_up_measured
    heights_m = movement.joints_m @ upright_axes(movement.up)[2]
    head, foot = (JOINT_NAMES.index(name) for name in ("head", "left_foot"))
    assert np.nanmean(heights_m[:, head] - heights_m[:, foot]) > 1.2


def test_a_movement_of_a_rotated_recording_has_the_pictures_vertical_unmeasured(blind_video):
    request = MovementRequest(
        blind_video, is_markerless=True, posture=PostureParams(rotation_deg=90)
    )
    movement = measure_moving(request, lambda *_done: None)
    assert not movement.is_up_measured
    np.testing.assert_allclose(movement.up, [-1.0, 0.0, 0.0], atol=1e-12)
    assert np.isfinite(movement.joints_m).mean() > 0.9


def test_limbs_of_a_rotated_recording_are_segmented_and_proposed(
    on_its_side, blind_video, tmp_path
):
    segmenting = SegmentingRequest(
        blind_video, tmp_path / "segmented", frames=(0, 1), rotation_deg=90
    )
    proposing = ProposingRequest(
        blind_video, tmp_path / "proposed", frames=(0, 1), is_done=True, rotation_deg=90
    )
    assert segment_recording(segmenting, lambda *_done: None).n_people == 1
    assert propose_recording(proposing, lambda *_done: None).n_proposed == 1
    truth = on_its_side.frame(0).truth.labels
    for folder, least_right in ((segmenting.out, 0.7), (proposing.out, 0.87)):
        labels = LimbFolder(folder).read(0)[1]
        both = (truth > 0) & (labels > 0)
        assert both.sum() > 0.8 * np.count_nonzero(truth)
        assert (truth[both] == labels[both]).mean() > least_right


def test_limbs_are_segmented_and_proposed_in_the_pixels_of_the_sensor(on_its_side, video, tmp_path):
    truth = on_its_side.frame(0).truth.labels
    request = SegmentingRequest(video, tmp_path / "portrait-limbs", frames=(0, 1))
    assert segment_recording(request, lambda *_done: None).n_people == 1
    with open_recording(video) as recording:
        desk = LabellingDesk(recording, video.name, tmp_path / "others-limbs")
        proposed = desk.proposed(desk.frame(0))
    for labels, least_right in (
        (LimbFolder(request.out).read(0)[1], 0.7),
        (proposed, 0.87),
    ):
        both = (truth > 0) & (labels > 0)
        assert labels.shape == truth.shape
        assert both.sum() > 0.8 * np.count_nonzero(truth)
        assert (truth[both] == labels[both]).mean() > least_right


def test_a_gesture_is_watched_with_the_body_upright(upright):
    calibration, depths_m, times_ns, _truth_m, upright_m = upright
    turn = QuarterTurn(1)
    seen = []

    class Watcher:
        def __init__(self, *_told):
            pass

        def see(self, _timestamp_ns, joints_m):
            seen.append(joints_m)
            return []

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("adibas.pipeline.live_gestures.GestureWatcher", Watcher)
        moment = LivePeople().look(
            turn.picture(depths_m[0]), times_ns[0], turned_sensor(calibration, turn)
        )
        assert LiveGestures([]).see(moment) == []
    np.testing.assert_allclose(seen, upright_m[:1], atol=1e-6)


@pytest.mark.parametrize("rotation_deg", [0, 90, 180, 270])
def test_up_is_where_gravity_says_else_the_floor_else_the_picture_as_it_is_shown(
    upright, rotation_deg
):
    up = up_of_picture(rotation_deg)
    other_deg = (rotation_deg + 180) % 360
    leaning = up + np.array([0.3, -0.3, 0.5])
    leaning /= np.linalg.norm(leaning)
    floor = replace(upright[0].floor, normal=leaning)
    for calibration, shown_deg in (
        (RgbdCalibration(gravity=-leaning, floor=replace(floor, normal=-leaning)), other_deg),
        (RgbdCalibration(floor=floor), other_deg),
        (RgbdCalibration(), rotation_deg),
        (RgbdCalibration(gravity=np.array([0.1, 0.0, np.sqrt(0.99)])), rotation_deg),
    ):
        assert turn_to_upright(calibration, shown_deg) == QuarterTurn(rotation_deg // 90)


@pytest.mark.parametrize("turn", ON_SIDES)
def test_probabilities_of_limbs_go_with_their_pixels(turn):
    rng = np.random.default_rng(7)
    pixels = rng.random((6, 8)) > 0.5
    field = rng.random((6, 8, len(FULL_BODY))).astype(np.float32)
    chosen = rng.integers(-1, 15, (6, 8)).astype(np.int16)
    turned = turned_parts(LimbParts(FULL_BODY, pixels, field[pixels], chosen), turn)
    np.testing.assert_array_equal(turned.probabilities, turn.picture(field)[turn.picture(pixels)])
    np.testing.assert_array_equal(turned.chosen, turn.picture(chosen))
