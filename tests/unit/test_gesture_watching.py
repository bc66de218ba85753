"""Gestures are recognised while somebody is watched: each once, soon after its end."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from adibas.data.calibration import CameraCalibration, RgbdCalibration
from adibas.data.frames import depth_in_metres
from adibas.data.joints import JOINT_NAMES
from adibas.geometry.pinhole import Intrinsics
from adibas.gestures.descriptor import DescriptorParams
from adibas.gestures.model import described_for
from adibas.gestures.training import TrainingParams, train
from adibas.gestures.watching import GestureWatcher, WatchParams
from adibas.limbs.judging import NOBODY, SOMETHING_CUT
from adibas.pipeline.gesture_examples import examples_of
from adibas.pipeline.live_gestures import MOST_PEOPLE, LiveGestures
from adibas.pipeline.live_people import LivePeople
from adibas.simulation.crowds import CrowdScene
from adibas.simulation.odd_plans import ODD_PLANS
from tests.unit.gesture_examples import recording, streams

CAMERA = CameraCalibration(4, 4, Intrinsics(4.0, 4.0, 1.5, 1.5))


@pytest.fixture(scope="module")
def model():
    tracks, events = streams(2, ("wave", "bend", "wave"))
    examples = examples_of(tracks, events, DescriptorParams())[0]
    return train(examples, DescriptorParams(), TrainingParams(method="dtw"))


@pytest.fixture(scope="module")
def moves():
    return recording(9, ("wave", "stand", "bend", "wave"))


def watched(watcher, track, shift_ns=0):
    """Return what was told, and when."""
    told = []
    for time_ns, joints_m in zip(track.timestamps_ns, track.joints_m, strict=True):
        now_ns = int(time_ns) + shift_ns
        told += [(one, now_ns / 1e9) for one in watcher.see(now_ns, joints_m)]
    return told


def test_each_gesture_is_told_once_within_a_second_of_its_end(model, moves):
    track, events = moves
    told = watched(GestureWatcher([model]), track)
    done = [one for one in events if one[0] != "stand"]
    assert [one.label for one, _at in told] == [label for label, _begin, _end in done]
    for (one, at_s), (_label, begin, end) in zip(told, done, strict=True):
        assert abs(one.begin_s - begin) < 0.7
        assert abs(one.end_s - end) < 0.7
        assert 0 < at_s - end < 1.5


def test_no_more_than_the_last_seconds_are_kept(model, moves):
    watcher = GestureWatcher([model], WatchParams(keep_s=2.0))
    watched(watcher, moves[0])
    assert len(watcher._frames) <= 2.0 * 30 + 1


def test_frames_that_repeat_a_time_count_once_and_a_jump_begins_anew(model, moves):
    track, events = moves
    watcher = GestureWatcher([model])
    twice = []
    for time_ns, joints_m in zip(track.timestamps_ns, track.joints_m, strict=True):
        for _time in range(2):
            twice += watcher.see(int(time_ns), joints_m)
    n_done = sum(label != "stand" for label, _begin, _end in events)
    assert len(twice) == n_done
    assert len(watched(watcher, track, shift_ns=10**12)) == n_done
    assert len(watched(watcher, track)) == n_done


def test_who_shows_no_neck_is_not_judged(model, moves):
    track, _events = moves
    watcher = GestureWatcher([model])
    hidden_m = track.joints_m.copy()
    hidden_m[:, JOINT_NAMES.index("neck")] = np.nan
    for time_ns, joints_m in zip(track.timestamps_ns, hidden_m, strict=True):
        assert watcher.see(int(time_ns), joints_m) == []


def test_what_is_watched_for_several_gestures_is_described_once(model, moves):
    other = replace(model, descriptor=DescriptorParams(velocity_s=0.0))
    found = described_for([model, other, model], moves[0])
    assert [one for one, _described in found] == [model, other, model]
    first, second, third = (described for _one, described in found)
    assert first is third
    assert first.frames[:].shape[1] == 2 * second.frames[:].shape[1]


@pytest.fixture
def posed(moves, monkeypatch):
    """Let the chain from depth to joints, which is tested elsewhere, give the joints of `moves`."""
    track, _events = moves
    place = {int(time_ns): number for number, time_ns in enumerate(track.timestamps_ns)}

    class Estimator:
        def __init__(self, *_told, joints, judge):
            pass

        def look(self, _depth_m, time_s):
            joints_m = track.joints_m[place[round(time_s * 1e9)]]
            joints = SimpleNamespace(joints_m=joints_m)
            people = (1, 2) if time_s < 4 else (1, *range(3, 3 + MOST_PEOPLE))
            return SimpleNamespace(
                people=[SimpleNamespace(person=one, joints=joints) for one in people],
                notices=(),
            )

    monkeypatch.setattr("adibas.pipeline.live_people.PoseEstimator", Estimator)
    monkeypatch.setattr("adibas.pipeline.live_people.forest_segmenter", lambda *_told: None)
    monkeypatch.setattr("adibas.pipeline.live_people.shipped_model", lambda: None)
    monkeypatch.setattr("adibas.pipeline.live_people.person_judge", lambda *_told: None)
    monkeypatch.setattr("adibas.pipeline.live_people.joint_model_for", lambda *_told: None)
    return track


DEPTH_M = np.ones((4, 4), np.float32)
CALIBRATION = RgbdCalibration(depth=CAMERA)


def test_live_frames_are_watched_person_by_person(model, moves, posed):
    people, live = LivePeople(), LiveGestures([model])
    assert people.look(DEPTH_M, 5, RgbdCalibration()) is None
    told = []
    for time_ns in posed.timestamps_ns.tolist()[:150]:
        told += live.see(people.look(DEPTH_M, time_ns, CALIBRATION))
        assert people.look(DEPTH_M, time_ns, CALIBRATION) is None
    assert {one.person for one in told} == {1, 2}
    assert {one.seen.label for one in told} == {moves[1][0][0]}
    assert len(live._watchers) == MOST_PEOPLE


def test_a_sensor_that_is_opened_anew_is_watched_from_its_begin(model, posed):
    people, live = LivePeople(), LiveGestures([model])
    times_ns = posed.timestamps_ns.tolist()[:120]
    first, again = (
        [
            one
            for time_ns in times_ns
            for one in live.see(people.look(DEPTH_M, time_ns, CALIBRATION))
        ]
        for _opened in range(2)
    )
    assert first
    assert again == first


@pytest.mark.parametrize(("name", "expected"), [("empty", NOBODY), ("legs", SOMETHING_CUT)])
def test_why_nobody_is_followed_is_known(name, expected):
    scene = CrowdScene(ODD_PLANS[name], 3)
    frame = scene.frame(0).sensor_frame
    depth_m = depth_in_metres(frame.depth_raw, scene.info.depth_unit_m)
    moment = LivePeople().look(depth_m, 1, scene.info.calibration)
    assert moment.people == ()
    assert moment.unseen.message == expected
