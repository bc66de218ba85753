"""Ranges of movement beside what the simulated patient did."""

import numpy as np
import pytest

from adibas.data.movement import AngleCurve, AngleRange, Movement
from adibas.data.sentence import Sentence
from adibas.data.skeleton_track import track_of
from adibas.movement.joint_angles import ANGLES, INDEX
from adibas.movement.measuring import (
    NO_VERTICAL,
    OFTEN_HIDDEN,
    SLOW,
    MovementParams,
    measure_movement,
    range_of,
    symmetries,
    unwrapped,
)
from adibas.texts import message
from tests.unit.movement_samples import (
    LEFT_DEG,
    PERIOD_S,
    PROVENANCE,
    RIGHT_DEG,
    bending,
    elbow_deg,
    source,
)
from tests.unit.test_joint_angles import standing

UP = np.array([0.0, -1.0, 0.0])


def by_name(found):
    return {one.name: one for one in found}


def test_the_extremes_and_their_times_are_those_of_the_patient():
    movement = measure_movement(bending(), source())
    left = by_name(movement.ranges)["left_elbow_flexion"]
    assert left.least_deg == pytest.approx(LEFT_DEG[0], abs=0.3)
    assert left.greatest_deg == pytest.approx(LEFT_DEG[1], abs=0.3)
    assert left.range_deg == left.greatest_deg - left.least_deg
    assert left.greatest_at_s % PERIOD_S == pytest.approx(PERIOD_S / 2, abs=0.04)
    fastest_deg_s = np.pi / PERIOD_S * (LEFT_DEG[1] - LEFT_DEG[0])
    assert left.fastest_deg_s == pytest.approx(fastest_deg_s, rel=0.01)
    assert left.seen_share == 1.0
    assert by_name(movement.curves)["left_elbow_flexion"].sd_deg < 0.1
    assert movement.rate_hz == pytest.approx(30.0)


def test_every_angle_has_a_curve_and_what_does_not_move_no_range():
    movement = measure_movement(bending(), source())
    assert [curve.name for curve in movement.curves] == list(ANGLES)
    still = by_name(movement.ranges)["right_knee_flexion"]
    assert still.range_deg < 1e-3


def test_noise_is_smoothed_and_its_rest_is_known():
    track = bending(n_frames=900, noise_m=0.004, seed=3)
    movement = measure_movement(track, source())
    curve = by_name(movement.curves)["right_elbow_flexion"]
    errors_deg = curve.deg - elbow_deg(movement.times_s, RIGHT_DEG)
    assert errors_deg.std() == pytest.approx(curve.sd_deg, rel=0.25)
    assert 0.1 < curve.sd_deg < 2.0


def test_the_noise_of_speeds_is_known():
    track = bending(n_frames=900, noise_m=0.004, seed=3)
    movement = measure_movement(track, source())
    curve = by_name(movement.curves)["right_elbow_flexion"]
    true_deg_s = np.gradient(elbow_deg(movement.times_s, RIGHT_DEG), movement.times_s)
    errors_deg_s = (curve.speed_deg_s - true_deg_s)[np.isfinite(curve.speed_deg_s)]
    assert errors_deg_s.std() == pytest.approx(curve.speed_sd_deg_s, rel=0.25)
    assert not by_name(movement.ranges)["right_elbow_flexion"].is_speed_noise


def test_what_stands_still_seldom_looks_faster_than_noise():
    n_runs, n_frames = 40, 150
    still_m = np.repeat(standing()[None], n_frames, axis=0)
    told = []
    for seed in range(n_runs):
        noise_m = np.random.default_rng(seed).normal(scale=0.003, size=still_m.shape)
        track = track_of(np.arange(n_frames) / 30.0, still_m + noise_m)
        ranges = by_name(measure_movement(track, source(up=UP)).ranges)
        told += [not ranges[name].is_speed_noise for name in ("neck_flexion", "left_hip_flexion")]
    assert ranges["neck_flexion"].fastest_deg_s > 30, "it looks fast"
    assert np.mean(told) < 0.05


def test_a_speed_next_to_the_beginning_or_a_gap_is_not_given():
    track = bending()
    joints_m = track.joints_m.copy()
    joints_m[60:90, INDEX["left_hand"]] = np.nan
    movement = measure_movement(track_of(track.times_s, joints_m), source())
    is_known = np.isfinite(by_name(movement.curves)["left_elbow_flexion"].speed_deg_s)
    assert np.flatnonzero(np.diff(is_known.astype(int))).tolist() == [2, 56, 92, 146]


def test_the_symmetry_index_is_the_difference_over_the_mean():
    movement = measure_movement(bending(), source())
    elbows = by_name(movement.symmetries)["elbow_flexion"]
    assert elbows.left_deg == pytest.approx(120, abs=0.5)
    assert elbows.right_deg == pytest.approx(90, abs=0.5)
    assert elbows.index_percent == pytest.approx(100 * -30 / 105, abs=0.5)
    assert by_name(movement.symmetries)["knee_flexion"].index_percent is None


def test_a_side_that_was_never_seen_has_no_symmetry():
    found = AngleRange("left_elbow_flexion", 0.0, 90.0, 0.0, 1.0, 100.0, 1.0, 0.1)
    assert list(symmetries((found,), 5.0)) == []


def test_a_hidden_hand_leaves_a_gap_and_a_share():
    track = bending()
    joints_m = track.joints_m.copy()
    joints_m[60:90, INDEX["left_hand"]] = np.nan
    movement = measure_movement(track_of(track.times_s, joints_m), source())
    left = by_name(movement.ranges)["left_elbow_flexion"]
    assert left.seen_share == pytest.approx(0.8)
    curve = by_name(movement.curves)["left_elbow_flexion"]
    assert np.isnan(curve.deg[60:90]).all()
    assert by_name(movement.ranges)["right_elbow_flexion"].seen_share == 1.0


def test_a_blink_is_bridged():
    track = bending()
    joints_m = track.joints_m.copy()
    joints_m[60:63] = np.nan
    movement = measure_movement(track_of(track.times_s, joints_m), source())
    curve = by_name(movement.curves)["left_elbow_flexion"]
    assert np.isfinite(curve.deg).all()
    np.testing.assert_allclose(curve.deg, elbow_deg(movement.times_s, LEFT_DEG), atol=1.5)


def test_what_was_never_seen_has_no_range():
    track = bending()
    joints_m = track.joints_m.copy()
    joints_m[:, INDEX["head"]] = np.nan
    movement = measure_movement(track_of(track.times_s, joints_m), source())
    assert "neck_flexion" not in by_name(movement.ranges)
    assert np.isnan(by_name(movement.curves)["neck_flexion"].sd_deg)


def test_up_is_the_measured_one_where_there_is_one():
    tilted = np.array([0.0, -np.cos(0.1), -np.sin(0.1)])
    movement = measure_movement(bending(), source(up=tilted))
    assert movement.is_up_measured
    leaning = by_name(movement.ranges)["trunk_flexion"].greatest_deg
    assert leaning == pytest.approx(-np.degrees(0.1))


def test_without_a_vertical_the_trunks_angles_against_it_are_left_out_and_the_reader_is_told():
    movement = measure_movement(bending(), source())
    assert not movement.is_up_measured
    given = by_name(movement.ranges)
    assert not {"trunk_flexion", "trunk_side_bending"} & set(given)
    assert set(given) == set(ANGLES) - {"trunk_flexion", "trunk_side_bending"}
    assert [notice.message for notice in movement.notices] == [NO_VERTICAL]
    assert not measure_movement(bending(), source(up=UP)).notices


def test_movements_before_one_camera_are_compared_by_its_upper_side():
    movement = measure_movement(bending(), source(), MovementParams(takes_upright=True))
    assert "trunk_flexion" in by_name(movement.ranges)
    assert not movement.notices
    tilted = source(up=np.array([0.0, -0.8, -0.6]))
    told = measure_movement(bending(), tilted, MovementParams(takes_upright=True))
    assert told.ranges == movement.ranges  # of one the vertical is known, of the other not
    assert not told.is_up_measured


def test_a_slow_recording_is_not_smoothed_and_says_so():
    times_s = np.arange(40) / 8.0
    track = track_of(times_s, np.repeat(standing()[None], 40, axis=0))
    movement = measure_movement(track, source(up=UP))
    assert [notice.message for notice in movement.notices] == [SLOW]
    assert np.isnan(movement.curves[0].sd_deg)


def test_a_patient_who_is_hardly_seen_is_told():
    track = bending()
    joints_m = track.joints_m.copy()
    joints_m[50:] = np.nan
    before = Sentence(message("Before."))
    movement = measure_movement(track_of(track.times_s, joints_m), source(up=UP, notices=(before,)))
    assert [notice.message for notice in movement.notices] == ["Before.", OFTEN_HIDDEN]


def test_a_single_frame_has_angles_and_no_speed():
    movement = measure_movement(bending(n_frames=1), source())
    assert np.isnan(movement.rate_hz)
    assert movement.ranges == () or np.isnan(movement.ranges[0].fastest_deg_s)
    assert np.isnan(movement.curves[0].speed_deg_s).all()


def test_an_angle_goes_on_beyond_half_a_turn():
    angles = np.radians([170.0, 179.0, np.nan, -175.0, -160.0])
    np.testing.assert_allclose(np.degrees(unwrapped(angles)), [170, 179, np.nan, 185, 200])


def test_a_curve_that_is_known_nowhere_has_no_range():
    nowhere = AngleCurve("x", np.full(3, np.nan), np.full(3, np.nan), float("nan"))
    assert range_of(nowhere, np.arange(3.0)) is None


def test_a_curve_known_at_one_time_has_no_speed():
    once = AngleCurve("x", np.array([np.nan, 4.0]), np.full(2, np.nan), float("nan"))
    found = range_of(once, np.arange(2.0))
    assert found.greatest_at_s == 1.0
    assert np.isnan(found.fastest_deg_s)


def movement_of(**changes):
    """Return the parts of a small movement, some of them changed."""
    parts = {
        "times_s": np.arange(4.0),
        "joints_m": np.zeros((4, 15, 3)),
        "up": np.array([0.0, -1.0, 0.0]),
        "is_up_measured": False,
        "curves": (AngleCurve("x", np.zeros(4), np.zeros(4), 0.1),),
        "ranges": (),
        "symmetries": (),
        "origin": "unknown",
        "patient": "",
        "provenance": PROVENANCE,
    }
    return Movement(**{**parts, **changes})


def test_what_is_measured_cannot_be_changed():
    movement = movement_of()
    assert movement.rate_hz == 1.0
    for array in (movement.times_s, movement.joints_m, movement.up, movement.curves[0].deg):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"joints_m": np.zeros((3, 15, 3))}, "joints_m"),
        ({"up": np.zeros(2)}, "up"),
        ({"curves": (AngleCurve("knee", np.zeros(3), np.zeros(3), 0.1),)}, "knee"),
    ],
)
def test_parts_of_other_lengths_are_refused(changes, told):
    with pytest.raises(ValueError, match=told):
        movement_of(**changes)


def test_a_curve_has_a_speed_for_every_angle():
    with pytest.raises(ValueError, match="speed_deg_s"):
        AngleCurve("x", np.zeros(3), np.zeros(2), 0.1)
