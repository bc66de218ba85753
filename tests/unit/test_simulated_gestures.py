"""Gestures begin and end at rest, are smooth, and look like what they are called."""

import functools

import numpy as np
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.simulation.body import load_body_model
from adibas.simulation.body_shape import BodyShape
from adibas.simulation.gestures import gesture_names, perform
from adibas.simulation.poses import standing

SEEDS = (0, 1, 7)
STEP_S = 1 / 40


@pytest.fixture(scope="module")
def person():
    return load_body_model().shaped(BodyShape("male", 35, 1.78, 76))


@pytest.fixture(scope="module")
def joints_over_time(person):
    return functools.cache(lambda name, seed: tracks_of(person, perform(name, seed)))


def tracks_of(person, gesture):
    times_s = np.arange(0.0, gesture.duration_s, STEP_S)
    joints_m = np.stack([person.posed(gesture.pose(t)).joints_m for t in times_s])
    return {name: joints_m[:, k] for k, name in enumerate(JOINT_NAMES)}


def test_the_thesis_gestures_and_idle_are_there():
    assert gesture_names() == ("jump", "bend", "clap", "greet", "note", "idle")


def test_unknown_gesture_is_refused():
    with pytest.raises(ValueError, match="one of jump, bend"):
        perform("somersault", 0)


@pytest.mark.parametrize("name", gesture_names())
@pytest.mark.parametrize("seed", SEEDS)
def test_gesture_begins_and_ends_standing_and_not_before(person, name, seed):
    gesture = perform(name, seed)
    rest_m = person.posed(standing()).joints_m
    for time_s in (-1.0, 0.0, gesture.duration_s, gesture.duration_s + 5.0):
        np.testing.assert_allclose(person.posed(gesture.pose(time_s)).joints_m, rest_m, atol=1e-9)
    for time_s in (0.15 * gesture.duration_s, 0.85 * gesture.duration_s):
        moved_m = np.abs(person.posed(gesture.pose(time_s)).joints_m - rest_m).max()
        assert moved_m > 0.003


@pytest.mark.parametrize("name", gesture_names())
def test_gesture_repeats_with_its_seed_and_differs_with_another(name):
    first, again, other = perform(name, 4), perform(name, 4), perform(name, 5)
    middle = 0.4 * first.duration_s
    np.testing.assert_array_equal(
        first.pose(middle).left_arm.upper, again.pose(middle).left_arm.upper
    )
    assert first.duration_s != other.duration_s


@pytest.mark.parametrize("name", gesture_names())
def test_no_joint_jumps_or_flies(joints_over_time, name):
    tracks = joints_over_time(name, 1)
    for joint, track in tracks.items():
        speed = np.linalg.norm(np.diff(track, axis=0), axis=1) / STEP_S
        assert speed.max() < 12.0, joint
        change = np.abs(np.diff(speed)).max()
        assert change < 4.0, joint


@pytest.mark.parametrize("seed", SEEDS)
def test_jump_is_a_throw(person, seed):
    gesture = perform("jump", seed)
    times_s = np.arange(0.0, gesture.duration_s, 0.02)
    lift_m = np.array([gesture.pose(t).lift_m for t in times_s])
    lowest_m = np.array([person.posed(gesture.pose(t)).vertices_m[:, 1].max() for t in times_s])
    np.testing.assert_allclose(lowest_m, -lift_m, atol=1e-12)
    assert 0.1 < lift_m.max() < 0.35
    inside = (lift_m[:-2] > 0) & (lift_m[1:-1] > 0) & (lift_m[2:] > 0)
    falling = np.diff(lift_m, 2)[inside] / 0.02**2
    np.testing.assert_allclose(falling, -9.81, rtol=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_bend_brings_the_head_to_the_height_of_the_hips(joints_over_time, seed):
    tracks = joints_over_time("bend", seed)
    assert (tracks["head"][:, 1] - tracks["left_hip"][:, 1]).max() > -0.25
    assert np.ptp(tracks["left_foot"], axis=0).max() < 0.03
    assert np.abs(tracks["left_hand"][:, 0] + tracks["right_hand"][:, 0]).max() < 0.01


@pytest.mark.parametrize("seed", SEEDS)
def test_clap_brings_the_hands_together_several_times(joints_over_time, seed):
    tracks = joints_over_time("clap", seed)
    gap_m = np.linalg.norm(tracks["left_hand"] - tracks["right_hand"], axis=1)
    closed = gap_m < 0.5 * (gap_m.min() + 0.30)
    meetings = np.count_nonzero(np.diff(closed.astype(int)) == 1)
    assert gap_m.min() < 0.16
    assert 3 <= meetings <= 5


@pytest.mark.parametrize("seed", SEEDS)
def test_greet_raises_one_hand_beside_the_head_and_waves(joints_over_time, seed):
    tracks = joints_over_time("greet", seed)
    highest = {side: -tracks[f"{side}_hand"][:, 1].min() for side in ("left", "right")}
    raised = max(highest, key=highest.get)
    low = min(highest, key=highest.get)
    assert highest[raised] > -tracks["neck"][0, 1]
    assert highest[low] < -tracks["left_hip"][0, 1] + 0.1
    up = -tracks[f"{raised}_hand"][:, 1] > -tracks["neck"][0, 1]
    assert np.ptp(tracks[f"{raised}_hand"][up, 0]) > 0.1


@pytest.mark.parametrize("seed", SEEDS)
def test_note_holds_both_hands_before_the_belly_and_bows_the_head(person, seed):
    gesture = perform("note", seed)
    posed = person.posed(gesture.pose(0.5 * gesture.duration_s))
    joints = dict(zip(JOINT_NAMES, posed.joints_m, strict=True))
    for side in ("left", "right"):
        hand = joints[f"{side}_hand"]
        assert joints["neck"][1] < hand[1] < joints["left_hip"][1]
        assert hand[2] < joints["torso"][2] - 0.2
    assert np.linalg.norm(joints["left_hand"] - joints["right_hand"]) < 0.25
    face = posed.landmarks["glabella"] - posed.landmarks["left_tragus"]
    rest = person.posed(standing()).landmarks
    assert face[1] > (rest["glabella"] - rest["left_tragus"])[1] + 0.03


def test_some_greet_with_the_left_hand(person):
    def leads_right(seed):
        gesture = perform("greet", seed)
        joints = person.posed(gesture.pose(0.5 * gesture.duration_s)).joints_m
        left, right = (joints[JOINT_NAMES.index(f"{side}_hand"), 1] for side in ("left", "right"))
        return bool(right < left)

    assert {leads_right(seed) for seed in range(12)} == {True, False}
