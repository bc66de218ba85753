"""Activity of joints: known paths, noise that is no movement, and bins that add up."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from adibas.behaviour.activity import ActivityParams, activity, per_bin, steps_of
from adibas.behaviour.bands import band_power
from adibas.behaviour.posture_changes import PostureParams, hidden_spans_s, posture_changes_s
from adibas.data.joints import JOINT_NAMES
from adibas.data.skeleton_track import track_of
from tests.unit.test_joint_angles import standing

HAND, HEAD, FOOT = (JOINT_NAMES.index(name) for name in ("left_hand", "head", "right_foot"))


def still(n_frames=600, rate_hz=30.0, noise_m=0.0, seed=0, begin_s=5.0):
    joints_m = np.repeat(standing()[None], n_frames, axis=0)
    noise = np.random.default_rng(seed).normal(0, noise_m, joints_m.shape) if noise_m else 0.0
    return begin_s + np.arange(n_frames) / rate_hz, joints_m + noise


def circling(joints_m, joint, radius_m, hz, rate_hz=30.0):
    phase = 2 * np.pi * hz * np.arange(len(joints_m)) / rate_hz
    joints_m[:, joint, 0] += radius_m * np.cos(phase)
    joints_m[:, joint, 1] += radius_m * np.sin(phase)
    return joints_m


def test_a_circle_is_as_long_as_its_circumference():
    times_s, joints_m = still()
    track = track_of(times_s, circling(joints_m, HAND, 0.1, 1.0))
    found = {one.joint: one for one in activity(steps_of(track))}
    hand, head = found["left_hand"], found["head"]
    assert hand.path_m == pytest.approx(2 * np.pi * 0.1 * hand.observed_s, rel=0.02)
    assert hand.speed_m_s == pytest.approx(2 * np.pi * 0.1, rel=0.02)
    assert hand.fast_m_s == pytest.approx(2 * np.pi * 0.1, rel=0.05)
    assert hand.active_share == pytest.approx(1.0, abs=0.01)
    assert (head.path_m, head.active_s, head.fast_m_s) == (0.0, 0.0, None)


@pytest.mark.parametrize("rate_hz", [10.0, 15.0, 30.0])
def test_noise_is_movement_in_one_of_a_hundred_steps(rate_hz):
    track = track_of(*still(6000, rate_hz, noise_m=0.01))
    steps = steps_of(track, ActivityParams(least_speed_m_s=0.0))
    assert np.median(steps.noise_m) == pytest.approx(0.01, rel=0.05)
    shares = [one.active_share for one in activity(steps)]
    assert np.mean(shares) == pytest.approx(0.01, abs=0.004)


def test_movement_is_found_above_the_noise():
    times_s, joints_m = still(1200, noise_m=0.005)
    joints_m[:600] = circling(joints_m[:600], HAND, 0.1, 1.0)
    found = activity(steps_of(track_of(times_s, joints_m)))[HAND]
    assert found.active_s == pytest.approx(20.0, abs=0.8)
    assert found.path_m == pytest.approx(2 * np.pi * 0.1 * 20.0, rel=0.05)


def test_a_still_time_says_what_wandering_joints_are():
    times_s, joints_m = still(1200, noise_m=0.002)
    rng = np.random.default_rng(3)
    wander = np.cumsum(rng.normal(0, 0.004, (1200, 3)), axis=0)
    joints_m[:, HEAD] += wander
    track = track_of(times_s, joints_m)
    without = activity(steps_of(track))[HEAD]
    told = activity(steps_of(track, ActivityParams(still_s=(5.0, 25.0))))[HEAD]
    assert without.active_share > 0.3
    assert told.active_share < 0.03


def test_a_joint_that_is_not_seen_is_not_still():
    times_s, joints_m = still(300)
    joints_m[:, FOOT] = np.nan
    joints_m[100:200, HAND] = np.nan
    found = activity(steps_of(track_of(times_s, joints_m)))
    assert found[FOOT].seen_s == 0.0
    assert (found[FOOT].speed_m_s, found[FOOT].active_share) == (None, None)
    assert found[HAND].seen_s == pytest.approx(found[HEAD].seen_s - 101 / 30, abs=0.01)
    assert found[HAND].observed_s == found[HEAD].observed_s


@settings(max_examples=15)
@given(st.integers(0, 1000), st.floats(0.3, 7.0))
def test_bins_add_up_to_the_whole(seed, length_s):
    rng = np.random.default_rng(seed)
    times_s, joints_m = still(200, noise_m=0.02, seed=seed)
    joints_m[rng.random((200, 15)) < 0.2] = np.nan
    steps = steps_of(track_of(times_s, joints_m))
    edges = np.append(np.arange(times_s[0], times_s[-1], length_s), times_s[-1])
    spans = list(pairwise(edges))
    whole = activity(steps)
    for joint, one in enumerate(whole):
        parts = [activity(steps, [span])[joint] for span in spans]
        assert sum(part.path_m for part in parts) == pytest.approx(one.path_m)
        assert sum(part.seen_s for part in parts) == pytest.approx(one.seen_s)
        assert sum(part.active_s for part in parts) == pytest.approx(one.active_s)
        assert sum(part.observed_s for part in parts) == pytest.approx(one.observed_s)
    path_m, active_s, seen_s = per_bin(steps, spans)
    np.testing.assert_allclose(path_m.sum(axis=0), [one.path_m for one in whole])
    np.testing.assert_allclose(active_s.sum(axis=0), [one.active_s for one in whole])
    np.testing.assert_allclose(seen_s.sum(axis=0), [one.seen_s for one in whole])


def test_a_track_of_one_frame_has_no_activity():
    track = track_of(*still(1))
    found = activity(steps_of(track))
    assert {one.observed_s for one in found} == {0.0}
    assert band_power(track, np.zeros(15)).power.shape == (15, 0)
    assert len(posture_changes_s(track)) == 0
    with pytest.raises(ValueError, match="noise_share"):
        ActivityParams(noise_share=0.0)


def test_power_is_in_the_band_of_the_movement():
    times_s, joints_m = still(1800)
    found = band_power(track_of(times_s, circling(joints_m, HAND, 0.05, 2.5)), np.zeros(15))
    power = found.power[HAND]
    assert found.edges_hz.tolist() == list(range(16))
    assert int(power.argmax()) == 2
    # Both axes of a circle: the square of its speed.
    assert power.sum() == pytest.approx((2 * np.pi * 2.5 * 0.05) ** 2, rel=0.1)


def test_power_of_noise_is_foretold():
    track = track_of(*still(9000, noise_m=0.01))
    found = band_power(track, np.full(15, 0.01))
    np.testing.assert_allclose(found.power.mean(axis=0)[1:], found.noise[0, 1:], rtol=0.2)


def test_slow_sensors_have_fewer_bands_and_hidden_joints_none():
    times_s, joints_m = still(300, rate_hz=15.0)
    joints_m[:, FOOT] = np.nan
    found = band_power(track_of(times_s, joints_m), np.zeros(15))
    assert found.power.shape == (15, 7)
    assert np.isnan(found.power[FOOT]).all()


def test_a_shift_of_the_seat_is_one_change_and_a_wave_of_the_hand_none():
    times_s, joints_m = still(900, noise_m=0.01)
    joints_m = circling(joints_m, HAND, 0.2, 1.0)
    ramp = np.clip((times_s - times_s[0] - 15.0) / 0.5, 0.0, 1.0)
    joints_m[:, :, 0] += 0.25 * ramp[:, None]
    changes = posture_changes_s(track_of(times_s, joints_m))
    assert changes == pytest.approx([times_s[0] + 15.25], abs=0.15)


def test_who_is_not_there_is_out_of_view():
    times_s, joints_m = still(300)
    joints_m[60:120] = np.nan
    track = track_of(times_s, joints_m)
    found = hidden_spans_s(track, (0.0, 20.0))
    expected = [(0.0, 5.0), (times_s[59], times_s[120]), (times_s[-1], 20.0)]
    np.testing.assert_allclose(found, expected)
    assert hidden_spans_s(track, (5.0, 15.0), PostureParams(hidden_s=3.0)) == []
    with pytest.raises(ValueError, match="above zero"):
        PostureParams(least_m=0.0)
