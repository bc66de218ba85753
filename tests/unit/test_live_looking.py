"""What is seen in a live frame, against the simulator's truth."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.alignment.registration import register_depth
from adibas.calibration.finder import BoardProblem
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.data.frames import EncodedImage, SensorFrame
from adibas.data.joints import JOINT_NAMES
from adibas.geometry.pinhole import Intrinsics
from adibas.geometry.rigid import RigidTransform, rotation_from_vector
from adibas.markers.color_model import LearningParams, grow_region, learn_colors
from adibas.markers.lab import rgb_to_lab
from adibas.markers.led import LedParams
from adibas.pipeline import hints, live_joints
from adibas.pipeline.acquisition import Arrival
from adibas.pipeline.live_frames import Naming
from adibas.pipeline.looking import Look, Looker
from adibas.pipeline.posture import PostureParams
from adibas.pipeline.view_check import LOOKS_ASIDE, LOOKS_OTHERWISE
from adibas.simulation.boards import render_board
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import open_scene
from adibas.skeleton.labelling import nothing_told
from adibas.skeleton.namer import Namer
from tests.unit.films import BENT, patient_with_leds


def arrival_of(scene, sensor_frame=None):
    sensor_frame = sensor_frame or scene.frame(0).sensor_frame
    return Arrival(sensor_frame, scene.info, 29.5, 3)


def learned(simulated):
    """The colour of the two markers that face the camera most."""
    lab = rgb_to_lab(simulated.sensor_frame.color)
    facing = sorted(simulated.truth.markers, key=lambda marker: marker.view_angle_rad)[:2]
    taken = sum(grow_region(lab, (one.u, one.v), 20.0) for one in facing) > 0
    rng = np.random.default_rng(0)
    return learn_colors(lab[taken].astype(float), rng, LearningParams(), {})


@pytest.fixture(scope="module")
def whole():
    """A patient who is seen from head to foot."""
    return open_scene("anterior", seed=7, distance_m=2.7, tilt_rad=0.05)


def test_a_patient_is_outlined_and_the_markers_are_found(whole):
    simulated = whole.frame(0)
    live = Looker().look(arrival_of(whole), Look(target=learned(simulated)))
    visible = [one for one in simulated.truth.markers if one.is_visible]
    found = np.array([[blob.u, blob.v] for blob in live.detections.blobs])
    distances = [np.hypot(*(found - [one.u, one.v]).T).min() for one in visible]
    assert np.median(distances) < 0.5
    rows, columns = np.array([[round(one.v), round(one.u)] for one in visible]).T
    assert live.outline[rows, columns].all()
    assert 0.03 < live.outline.mean() < 0.3
    assert (live.frame_rate_hz, live.n_dropped, live.hints) == (29.5, 3, ())


def test_the_depth_is_shown_in_both_pictures(whole):
    live = Looker().look(arrival_of(whole), Look())
    assert live.detections is None
    expected_m = register_depth(live.depth_m, whole.info.calibration)
    np.testing.assert_array_equal(live.depth_in_color_m, expected_m)
    truth_m = whole.frame(0).truth.depth_m
    # A step of the sensor's disparity.
    assert np.nanmedian(np.abs(1 / live.depth_m - 1 / truth_m)) < 2.9e-3


@pytest.mark.parametrize("knows", ["floor", "gravity", "nothing"])
def test_the_camera_looks_down_as_it_was_put_up(whole, knows):
    given = whole.info.calibration
    known = {
        "floor": given,
        "gravity": replace(given, floor=None),
        "nothing": replace(given, floor=None, gravity=None),
    }[knows]
    live = Looker().look(arrival_of(whole), Look(calibration=known))
    # The colour camera is turned against the depth camera by some milliradians.
    up_color = -given.color_from_depth.rotation @ given.gravity
    assert live.plumb.pitch_rad == pytest.approx(np.arcsin(up_color[2]), abs=0.01)
    assert live.plumb.pitch_rad < -0.03


def test_without_floor_and_gravity_there_is_no_plumb_line():
    scene = open_scene("empty", color_size=(480, 640), tilt_rad=-0.5)
    bare = replace(scene.info.calibration, floor=None, gravity=None)
    live = Looker().look(arrival_of(scene), Look(calibration=bare))
    assert live.plumb is None
    assert live.outline is None
    assert hints.NOBODY in live.hints


def test_a_sensor_on_its_side_finds_the_floor_by_its_mounting():
    scene = open_scene("anterior", seed=2, mounting="portrait", color_size=(480, 640))
    bare = replace(scene.info.calibration, floor=None, gravity=None)
    turned = Look(calibration=bare, params=PostureParams(rotation_deg=90))
    live = Looker().look(arrival_of(scene), turned)
    assert abs(live.plumb.roll_rad) < 0.02
    assert live.plumb.vertical[0][0] < live.plumb.vertical[1][0], "up is at the picture's left"
    assert live.outline is not None
    assert live.rotation_deg == 90


def test_leds_are_found(whole):
    scene = open_scene("anterior_led", seed=7, distance_m=2.7)
    live = Looker().look(arrival_of(scene), Look(target=LedParams()))
    visible = [one for one in scene.frame(0).truth.markers if one.is_visible]
    assert len(live.detections.blobs) >= len(visible) - 1
    bright = Looker().look(arrival_of(whole), Look(target=LedParams(rim_share=0.01)))
    assert bright.detections is None
    assert hints.TOO_BRIGHT in bright.hints


def test_a_colour_that_fits_everything_is_told(whole):
    lab = rgb_to_lab(whole.frame(0).sensor_frame.color)
    outline = Looker().look(arrival_of(whole), Look()).outline
    skin = learn_colors(
        lab[outline][::50].astype(float), np.random.default_rng(0), LearningParams(), {}
    )
    live = Looker().look(arrival_of(whole), Look(target=skin))
    assert live.detections is None
    assert hints.COLOR_FITS_ALL in live.hints
    assert live.outline is not None


def test_what_cannot_be_measured_is_shown_and_told(whole):
    frame = whole.frame(0).sensor_frame
    bare = replace(whole.info, calibration=None)
    live = Looker().look(Arrival(frame, bare, 0.0, 0), Look())
    assert live.hints == (hints.NO_CALIBRATION,)
    assert live.depth_in_color_m is None
    small = SensorFrame(0, 0, frame.depth_raw[:-1], frame.color, 0)
    assert Looker().look(arrival_of(whole, small), Look()).hints == (hints.NO_CALIBRATION,)


@pytest.mark.parametrize("color", [None, EncodedImage("jpeg", b"no picture")])
def test_a_frame_without_a_whole_colour_picture_shows_its_depth(whole, color):
    frame = replace(
        whole.frame(0).sensor_frame, color=color, color_timestamp_ns=None if color is None else 5
    )
    live = Looker().look(arrival_of(whole, frame), Look())
    assert live.color_rgb is None
    assert live.hints == (hints.NO_COLOR,)
    assert np.isfinite(live.depth_m).any()


def board_frame(whole, board):
    """A frame of the sensor with a board in the colour picture, and its true corners."""
    camera = CameraCalibration(640, 480, Intrinsics(525.0, 525.0, 319.5, 239.5))
    pose = RigidTransform(rotation_from_vector(np.array([0.2, 0.1, 0.0])), np.array([-0.1, 0, 0.7]))
    shown = render_board(board, pose, camera, np.random.default_rng(3), in_color=True)
    depth_raw = whole.frame(0).sensor_frame.depth_raw
    return SensorFrame(7, 70, depth_raw, shown.image, 70), shown.corners_px[0]


def test_a_board_is_found_in_place_of_a_person(whole):
    board = Board(9, 6, 0.025)
    sensor_frame, truth_px = board_frame(whole, board)
    live = Looker().look(arrival_of(whole, sensor_frame), Look(board=board))
    assert np.abs(live.board.corners.pixels - truth_px).max() < 0.2
    assert (live.outline, live.plumb, live.hints) == (None, None, ())
    measured_m = sensor_frame.depth_raw * np.float32(whole.info.depth_unit_m)
    np.testing.assert_array_equal(np.nan_to_num(live.depth_m), measured_m)


def test_why_no_board_is_found_is_told(whole):
    sensor_frame, _truth_px = board_frame(whole, Board(9, 6, 0.025))
    live = Looker().look(arrival_of(whole, sensor_frame), Look(board=Board(8, 5, 0.025)))
    assert live.board.corners is None
    assert live.board.problem is BoardProblem.ANOTHER_SIZE
    without_color = replace(sensor_frame, color=None, color_timestamp_ns=None)
    blind = Looker().look(arrival_of(whole, without_color), Look(board=Board(8, 5, 0.025)))
    assert blind.board is None
    assert hints.NO_COLOR in blind.hints


@pytest.fixture(scope="module")
def joints_marked():
    """A patient with a sticker before each joint."""
    return open_scene("anterior", seed=7, distance_m=3.0, markers=MarkerSettings(JOINT_NAMES))


def test_markers_on_joints_are_named_in_the_live_picture(joints_marked):
    simulated = joints_marked.frame(0)
    look = Look(target=learned(simulated), naming=Naming("joints-15", "anterior"))
    joints = Looker().look(arrival_of(joints_marked), look).joints
    truth = {one.name: (one.u, one.v) for one in simulated.truth.markers}
    assert len(joints) >= 12
    for name, place in joints.items():
        assert place == pytest.approx(truth[name], abs=2.0)


def test_few_markers_from_the_side_are_named_by_the_body_in_the_depth(monkeypatch):
    markers = MarkerSettings(JOINT_NAMES, kind="led", diameter_m=0.005)
    scene = open_scene("left_lateral_led", seed=7, distance_m=2.8, markers=markers)
    look = Look(target=LedParams(), naming=Naming("joints-15", "left_lateral"))
    arrival = arrival_of(scene, scene.frame(15).sensor_frame)
    truth = {one.name: (one.u, one.v) for one in scene.frame(15).truth.markers}
    joints = Looker().look(arrival, look).joints
    assert len(joints) >= 5
    for name, place in joints.items():
        assert place == pytest.approx(truth[name], abs=3.0)
    monkeypatch.setattr(live_joints, "with_body", lambda namer, *_known: namer)
    assert Looker().look(arrival, look).joints == {}


@pytest.mark.parametrize("naming", [None, Naming("sapo-1", "anterior"), Naming("lost", "anterior")])
def test_nothing_is_named_without_a_protocol_of_joints(joints_marked, naming):
    look = Look(target=learned(joints_marked.frame(0)), naming=naming)
    assert Looker().look(arrival_of(joints_marked), look).joints == {}


@pytest.fixture(scope="module")
def bending():
    """Frames of a patient with LEDs who bends down, and an arrival of each."""
    scene = patient_with_leds(seed=7, gesture="bend")
    frames = [scene.frame(index) for index in BENT[::2]]
    return [(one, arrival_of(scene, one.sensor_frame)) for one in frames]


LEDS_ON_JOINTS = Look(target=LedParams(), naming=Naming("joints-15", "anterior"))


def counted(lives, bending):
    """Return how many joints are drawn at their marker, elsewhere, and have one in view."""
    n_right = n_wrong = n_visible = 0
    for live, (simulated, _arrival) in zip(lives, bending, strict=True):
        truth = {one.name: (one.u, one.v) for one in simulated.truth.markers}
        n_visible += sum(one.is_visible for one in simulated.truth.markers)
        is_right = [
            place == pytest.approx(truth[name], abs=3.0) for name, place in live.joints.items()
        ]
        n_right += sum(is_right)
        n_wrong += len(is_right) - sum(is_right)
    return n_right, n_wrong, n_visible


def test_who_bends_down_is_still_seen_and_named(bending):
    looker = Looker()
    lives = [looker.look(arrival, LEDS_ON_JOINTS) for _frame, arrival in bending]
    n_right, n_wrong, n_visible = counted(lives, bending)
    assert n_wrong == 0
    assert n_right >= n_visible
    assert all(hints.NOBODY not in live.hints and live.outline is not None for live in lives)


def test_who_is_in_the_newest_frame_is_known(bending):
    looker = Looker()
    assert looker.person is None
    for simulated, arrival in bending:
        looker.look(arrival, LEDS_ON_JOINTS)
        (pixels,) = looker.person.people
        seen = (simulated.truth.labels > 0) & (simulated.sensor_frame.depth_raw > 0)
        assert np.count_nonzero(pixels & seen) > 0.85 * np.count_nonzero(seen)
    empty = open_scene("empty", seed=7, color_size=(480, 640), distance_m=2.8)
    looker.look(arrival_of(empty), LEDS_ON_JOINTS)
    assert looker.person is None


def test_each_frame_of_a_bend_by_itself_shows_nobody(bending):
    """Head, arms and legs fall apart in the depth, and nobody is tall."""
    lives = [Looker().look(arrival, LEDS_ON_JOINTS) for _frame, arrival in bending]
    assert [live.outline is not None for live in lives] == [True] + [False] * 8


def test_with_other_things_to_look_for_the_frame_before_is_forgotten(bending):
    upright, bent = bending[0][1], bending[1][1]
    for other in (replace(LEDS_ON_JOINTS), replace(LEDS_ON_JOINTS, naming=None)):
        looker = Looker()
        assert looker.look(upright, LEDS_ON_JOINTS).outline is not None
        assert looker.look(bent, other).outline is None


def test_a_clock_that_is_set_back_begins_anew(bending):
    upright, bent = bending[0][1], bending[1][1]
    earlier = replace(upright.frame, timestamp_ns=bent.frame.timestamp_ns)
    looker = Looker()
    assert looker.look(replace(upright, frame=earlier), LEDS_ON_JOINTS).outline is not None
    assert looker.look(bent, LEDS_ON_JOINTS).outline is None


def test_a_name_is_carried_over_a_frame_that_does_not_tell_it(joints_marked, monkeypatch):
    """The second frame alone is sure of nothing: its markers are where those of the first were."""
    look = Look(target=learned(joints_marked.frame(0)), naming=Naming("joints-15", "anterior"))
    first, second = (
        arrival_of(joints_marked, joints_marked.frame(index).sensor_frame) for index in (0, 1)
    )
    looker = Looker()
    named = looker.look(first, look).joints

    def unsure(_namer, points_m, *_told, **_more):
        return nothing_told(len(points_m), len(JOINT_NAMES))

    monkeypatch.setattr(Namer, "label", unsure)
    carried = looker.look(second, look).joints
    assert len(named) >= 12
    assert carried.keys() == named.keys()
    for name, place in carried.items():
        assert place == pytest.approx(named[name], abs=2.0)
    assert Looker().look(second, look).joints == {}


@pytest.mark.parametrize(
    ("view", "doubts"),
    [
        ("anterior", set()),
        ("posterior", {LOOKS_OTHERWISE}),
        ("left_lateral", {LOOKS_ASIDE}),
        ("right_lateral", {LOOKS_ASIDE}),
    ],
)
def test_a_view_that_the_markers_contradict_is_told_live(joints_marked, view, doubts):
    look = Look(target=learned(joints_marked.frame(0)), naming=Naming("joints-15", view))
    looker = Looker()
    for index in (0, 1):
        arrival = arrival_of(joints_marked, joints_marked.frame(index).sensor_frame)
        told = looker.look(arrival, look).hints
        assert {one for one in told if one in {LOOKS_ASIDE, LOOKS_OTHERWISE}} == doubts


def test_the_view_is_checked_every_two_seconds(joints_marked, monkeypatch):
    asked = []

    def doubt(_untold, view):
        asked.append(view)
        return LOOKS_ASIDE if len(asked) == 1 else None

    monkeypatch.setattr(live_joints, "doubt_by_heading", doubt)
    look = Look(target=learned(joints_marked.frame(0)), naming=Naming("joints-15", "anterior"))
    looker, frame = Looker(), joints_marked.frame(0).sensor_frame
    doubted = []
    for time_s in (1.0, 2.0, 2.9, 3.1):
        later = replace(frame, timestamp_ns=round(time_s * 1e9))
        doubted.append(LOOKS_ASIDE in looker.look(arrival_of(joints_marked, later), look).hints)
    assert doubted == [True, True, True, False]
    assert asked == ["anterior"] * 2
