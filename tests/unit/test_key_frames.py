"""A camera on a line: who is aligned with whom, what is lost, and what loops do."""

import numpy as np

from adibas.alignment.camera_track import KeyFrameParams
from adibas.alignment.joint_fit import JointFit
from adibas.alignment.key_frames import Tracker
from adibas.alignment.pairing import Unaligned
from adibas.geometry.rigid import RigidTransform

DRIFT_M = 0.004
PARAMS = KeyFrameParams(largest_shift_m=0.25, loop_gap=2)


class Line:
    """Cameras at places along x, with pictures that are alike up to a reach."""

    def __init__(self, places_m, reach_m=0.5, before=0.0):
        self.places_m, self.reach_m, self.before = places_m, reach_m, before
        self.asked = []
        self.wrong = {}

    def near(self, target, source, _guess):
        return self.anywhere(target, source)

    def anywhere(self, target, source):
        self.asked.append((target, source))
        apart_m = self.places_m[source] - self.places_m[target]
        if abs(apart_m) > self.reach_m:
            return Unaligned.TOO_LITTLE_OVERLAP
        drift_m = self.wrong.get((target, source), DRIFT_M * np.sign(apart_m))
        motion = RigidTransform(np.eye(3), np.array([apart_m + drift_m, 0.0, 0.0]))
        return JointFit(motion, np.eye(6) / 0.005**2, 0.001, 0.8, self.before, 100, 80)

    def follow(self, params=PARAMS):
        tracker = Tracker(lambda number: number, params, aligner=self)
        for number in range(len(self.places_m)):
            tracker.add(number)
        return tracker

    def found_m(self, tracker):
        return [
            None if pose is None else pose.translation_m[0] for pose in tracker.track().world_from
        ]


def on_line(line, params=PARAMS):
    return line.follow(params)


def test_where_the_key_frame_is_out_of_reach_the_moment_before_becomes_one():
    line = Line([0.0, 0.2, 0.4, 0.6], reach_m=0.25)
    tracker = on_line(line, KeyFrameParams(largest_shift_m=9.0, least_overlap=0.0))
    np.testing.assert_allclose(line.found_m(tracker), line.places_m, atol=0.02)
    assert tracker.keys == (0, 1, 2)


def test_a_world_in_which_nothing_was_placed_is_given_up():
    line = Line([9.0, 0.0, 0.1, 0.2])
    tracker = on_line(line)
    assert line.found_m(tracker)[0] is None
    np.testing.assert_allclose(line.found_m(tracker)[1:], [0.0, 0.1, 0.2], atol=0.01)
    assert tracker.track().problems == {0: Unaligned.TOO_LITTLE_OVERLAP}


def test_a_camera_that_comes_back_is_found_in_an_old_key_frame():
    out = list(np.arange(0.0, 4.0, 0.2))
    line = Line([*out, 50.0, 50.1, 50.2, 50.3, 50.4, 50.5, 0.1, 0.15, 0.1, 0.2])
    tracker = on_line(line, KeyFrameParams(n_recovered=2, n_revisited=3, n_loops=0))
    found = line.found_m(tracker)
    assert found[len(out) : len(out) + 6] == [None] * 6
    np.testing.assert_allclose(found[-1:], [0.2], atol=0.02)


def test_loops_take_the_drift_away_and_wrong_ones_are_told_apart():
    way = [*np.arange(0.0, 2.4, 0.3), *np.arange(2.4, -0.1, -0.3)]
    plain = on_line(Line(way), KeyFrameParams(n_loops=0))
    looped_line = Line(way)
    looped = on_line(looped_line, PARAMS)
    assert looped.track().n_loops > 5
    assert looped.track().n_wrong_loops == 0
    assert len(plain.keys) == len(looped.keys)
    wrong_line = Line(way)
    wrong_line.wrong = {(1, 14): 0.4}
    wrong = on_line(wrong_line, PARAMS).track()
    assert (wrong.n_wrong_loops, wrong.n_loops) == (1, looped.track().n_loops - 1)
    off_m = np.abs(np.array(wrong_line.found_m(on_line(wrong_line))) - way)
    assert off_m.max() < 0.05


def test_key_frames_that_are_not_at_hand_are_asked_for_again():
    way = [*np.arange(0.0, 2.4, 0.3), *np.arange(2.4, -0.1, -0.3)]
    few = on_line(Line(way), KeyFrameParams(largest_shift_m=0.25, loop_gap=2, n_kept=1))
    many = on_line(Line(way), KeyFrameParams(largest_shift_m=0.25, loop_gap=2, n_kept=99))
    for one, other in zip(few.track().world_from, many.track().world_from, strict=True):
        np.testing.assert_array_equal(one.translation_m, other.translation_m)


def test_what_moves_is_counted():
    assert on_line(Line([0.0, 0.1, 0.2], before=0.05)).track().n_moving == 2
    assert on_line(Line([0.0, 0.1, 0.2], before=0.005)).track().n_moving == 0


def test_a_tracker_goes_on_from_where_another_stood():
    way = [*np.arange(0.0, 1.5, 0.1), *np.arange(1.5, -0.1, -0.1)]
    line = Line(way)
    whole = on_line(line)
    for stop in (1, 2, 7, len(way) - 1):
        begun = Tracker(lambda number: number, PARAMS, aligner=line)
        for number in range(stop):
            begun.add(number)
        gone_on = Tracker(lambda number: number, PARAMS, begun.following, line)
        for number in range(stop, len(way)):
            gone_on.add(number)
        for one, other in zip(whole.track().world_from, gone_on.track().world_from, strict=True):
            np.testing.assert_array_equal(one.translation_m, other.translation_m)
