"""A gesture is learned from what an observer marked, tested on what was left out, and kept."""

import json
from dataclasses import replace

import numpy as np
import pytest

from adibas.behaviour.editing import Draft, with_detected
from adibas.cli.command_line import main
from adibas.data.coding import Coding, Occurrence
from adibas.data.ethogram import Behaviour, Ethogram
from adibas.data.joints import JOINT_NAMES, mirror_order
from adibas.data.skeleton_track import track_of
from adibas.errors import FileError, GestureError
from adibas.gestures.descriptor import DESCRIBED_JOINTS
from adibas.gestures.model_file import read_model
from adibas.gestures.segments import Examples
from adibas.gestures.training import TrainingParams
from adibas.pipeline.gesture_learning import learn, marked_lesson
from adibas.pipeline.gesture_work import detected_events
from adibas.pipeline.own_gestures import forget_gesture, keep_gesture, own_gestures
from adibas.recordings.events_csv import write_events_csv
from adibas.recordings.joints_csv import write_joints_csv
from tests.unit.gesture_examples import recording, streams

QUICK = TrainingParams(method="dtw")


def no_progress(_done, _total):
    pass


def marked(label, events, subject="person 1"):
    return [
        Occurrence(label, round(1000 * begin), round(1000 * end), subject)
        for name, begin, end in events
        if name == label
    ]


@pytest.fixture(scope="module")
def watched():
    """One person who waves four times, stands longer, and bends once."""
    return recording(3, (*("wave", "stand", "stand") * 4, "bend"))


@pytest.fixture(scope="module")
def waving(watched):
    track, events = watched
    lesson = marked_lesson("hello", marked("wave", events), [track], "child")
    return learn(lesson, TrainingParams(), no_progress, is_tested=True)


@pytest.fixture
def folder(monkeypatch, tmp_path):
    monkeypatch.setattr("platformdirs.user_data_path", lambda *_told, **_more: tmp_path)
    return tmp_path


def test_what_was_marked_is_known_when_it_is_left_out(waving):
    assert waving.n_examples == 4
    assert waving.rule == "example"
    assert waving.tested.accuracy == 1.0
    assert waving.tested.false_alarms == 0
    assert waving.model.provenance["left_out"]["accuracy"] == 1.0


def test_the_joints_that_move_tell_the_gesture(waving):
    (row,) = waving.weights
    assert row.sum() == pytest.approx(1.0)
    best = {DESCRIBED_JOINTS[place] for place in np.argsort(row)[-2:]}
    assert best == {"left_hand", "left_elbow"}
    assert waving.model.provenance["joint_weights"]["hello"]["left_hand"] > 0.3


def test_what_was_learned_finds_the_gesture_in_somebody_else(waving):
    track, events = recording(8, ("bend", "wave", "bend", "wave"), size=1.2)
    found = detected_events("other", track, [waving.model])
    waves = [(begin, end) for name, begin, end in events if name == "wave"]
    assert len(found) == len(waves)
    for one, (begin, end) in zip(found, waves, strict=True):
        assert abs(one.begin_s - begin) < 0.7
        assert abs(one.end_s - end) < 0.7


def test_one_example_is_refused_in_words(watched):
    track, events = watched
    with pytest.raises(GestureError, match="only one example of hello"):
        marked_lesson("hello", marked("wave", events)[:1], [track], "child")


def test_two_examples_are_learned_and_it_is_said_that_nothing_is_left_to_test_with(watched):
    track, events = watched
    lesson = marked_lesson("hello", marked("wave", events)[:2], [track], "child")
    trained = learn(lesson, QUICK, no_progress, is_tested=True)
    assert trained.tested is None
    assert any("three of each gesture" in one.text for one in trained.notices)


def test_moments_are_no_examples(watched):
    with pytest.raises(GestureError, match="begin and an end"):
        marked_lesson("nod", [Occurrence("nod", 500, 500)], [watched[0]], "child")


def test_examples_of_very_different_lengths_are_told(watched):
    track, events = watched
    waves = marked("wave", events)
    long = Occurrence("wave", waves[0].begin_ms, waves[0].begin_ms + 5000, "person 1")
    lesson = marked_lesson("hello", [long, *waves[2:4]], [track], "child")
    trained = learn(lesson, QUICK, no_progress, is_tested=False)
    (told,) = [one.text for one in trained.notices if "twice as long" in one.text]
    assert "hello" in told
    assert "5." in told


def test_examples_of_both_sides_are_told(watched):
    track, events = watched
    waves = marked("wave", events)
    joints_m = track.joints_m.copy()
    last = (track.times_s > waves[-1].begin_ms / 1000) & (track.times_s < waves[-1].end_ms / 1000)
    middle_m = joints_m[:, JOINT_NAMES.index("neck"), 0].mean()
    exchanged_m = joints_m[last][:, mirror_order(JOINT_NAMES)]
    exchanged_m[..., 0] = 2 * middle_m - exchanged_m[..., 0]
    joints_m[last] = exchanged_m
    for moves_m, n_told in ((track.joints_m, 0), (joints_m, 1)):
        lesson = marked_lesson("hello", waves, [track_of(track.times_s, moves_m)], "child")
        trained = learn(lesson, QUICK, no_progress, is_tested=False)
        told = [one.text for one in trained.notices if "mirror image" in one.text]
        assert len(told) == n_told


def test_who_is_meant_is_the_person_of_the_event_or_who_is_seen_longest(watched):
    track, events = watched
    other = track_of(track.times_s, track.joints_m[::-1].copy(), 2)
    waves = marked("wave", events)
    lesson = marked_lesson("hello", waves, [other, track], "child")
    assert [one.begin for one in lesson.examples.gestures] == [
        one.begin for one in marked_lesson("hello", waves, [track], "child").examples.gestures
    ]
    unnamed = [Occurrence("wave", one.begin_ms, one.end_ms, "child") for one in waves]
    told = marked_lesson("hello", unnamed, [track, other], "child").notices
    (notice,) = told
    assert "do not say which person of the recording they are of: 4." in notice.text


def test_examples_without_joints_are_left_out_and_told(watched):
    track, events = watched
    waves = marked("wave", events)
    beyond = Occurrence("wave", 900_000, 901_000, "person 1")
    lesson = marked_lesson("hello", [*waves, beyond], [track], "child")
    assert len(lesson.examples.gestures) == 4
    assert "are left out: 1." in lesson.notices[0].text
    with pytest.raises(GestureError, match="Nobody's joints"):
        marked_lesson("hello", [beyond], [track], "child")


def test_a_recording_without_a_neck_teaches_nothing(watched):
    track, events = watched
    joints_m = track.joints_m.copy()
    joints_m[:, JOINT_NAMES.index("neck")] = np.nan
    with pytest.raises(GestureError, match="no neck"):
        marked_lesson("hello", marked("wave", events), [track_of(track.times_s, joints_m)], "a")


def test_a_gesture_that_fills_its_recording_is_told_by_no_joint(watched):
    track, events = watched
    first = marked("wave", events)[0]
    cut = track.between(first.begin_ms / 1000, first.end_ms / 1000)
    halves = [
        Occurrence("wave", first.begin_ms, first.begin_ms + 700, "person 1"),
        Occurrence("wave", first.begin_ms + 700, first.end_ms, "person 1"),
    ]
    lesson = marked_lesson("hello", halves, [cut], "child")
    trained = learn(lesson, QUICK, no_progress, is_tested=False)
    np.testing.assert_allclose(trained.weights, 1 / 14)
    assert any("No joint tells hello" in one.text for one in trained.notices)


def test_many_examples_are_left_out_in_parts(monkeypatch):
    monkeypatch.setattr("adibas.pipeline.gesture_learning.MOST_PARTS", 3)
    track, events = recording(1, ("wave",) * 5)
    lesson = marked_lesson("hello", marked("wave", events), [track], "child")
    trained = learn(lesson, QUICK, no_progress, is_tested=True)
    assert trained.rule == "part"
    assert trained.tested.n_done.sum() == 5


def test_an_example_that_is_left_out_leaves_those_at_the_same_time_whole(watched):
    track, events = watched
    lesson = marked_lesson("hello", marked("wave", events), [track], "child")
    first = lesson.examples.gestures[0]
    twice = Examples(
        lesson.examples.labels,
        lesson.examples.streams,
        [*lesson.examples.gestures, replace(first, begin=first.begin + 3, end=first.end + 3)],
        np.arange(5),
        is_isolated=False,
    )
    left = twice.without(np.arange(5) == 0)
    before, after = (one.streams[first.stream].frames for one in (twice, left))
    assert np.isnan(after[first.begin : first.begin + 3]).all()
    np.testing.assert_array_equal(after[first.begin + 3 :], before[first.begin + 3 :])
    np.testing.assert_array_equal(after[: first.begin], before[: first.begin])


def test_a_gesture_is_kept_found_again_and_forgotten(waving, folder):
    assert own_gestures() == ()
    kept = keep_gesture("hello: *both*", waving.model)
    assert kept.path.parent == folder / "models" / "gestures"
    assert own_gestures() == (kept,)
    assert read_model(kept.path).labels == ("hello",)
    forget_gesture(kept)
    forget_gesture(kept)
    assert own_gestures() == ()


@pytest.mark.parametrize(
    "name",
    ["hand/head", "hand_head", "hand%2Fhead", "..", "CON", "lpt¹", "saluda així", "手"],
)
def test_every_name_has_a_file_of_its_own_that_any_system_takes(waving, folder, name):
    others = [keep_gesture(one, waving.model) for one in ("hand:head", "con fusion")]
    kept = keep_gesture(f" {name} ", waving.model)
    assert kept.name == name
    assert sorted(own_gestures(), key=str) == sorted([*others, kept], key=str)
    stem = kept.path.stem
    assert kept.path.parent == folder / "models" / "gestures"
    assert not set(stem) & set('<>:"/\\|?*.')
    assert stem.upper() not in {"CON", "LPT¹"}


@pytest.mark.usefixtures("folder")
def test_what_cannot_be_forgotten_is_told(waving):
    kept = keep_gesture("hello", waving.model)
    kept.path.unlink()
    kept.path.mkdir()
    with pytest.raises(FileError, match="cannot be removed"):
        forget_gesture(kept)


def test_what_is_coded_is_not_proposed_again():
    scheme = Ethogram("", (Behaviour("wave"), Behaviour("nod", "point")))
    coded = Coding("a", scheme, 0, 9000, (Occurrence("wave", 1000, 2000), Occurrence("nod", 5, 5)))
    seen = (
        Occurrence("nod", 5, 5), Occurrence("nod", 6, 6), Occurrence("wave", 1200, 1850),
        Occurrence("wave", 1900, 2900),
    )  # fmt: skip
    draft = with_detected(Draft(coded), Coding("a", scheme, 0, 9000, seen))
    assert draft.proposed == (seen[1], seen[3])


def test_the_command_says_how_well_those_left_out_are_known(tmp_path, capsys):
    tracks, events = streams(3, ("wave", "bend"))
    for (name, _person), track in tracks.items():
        write_joints_csv(tmp_path / f"{name}.joints.csv", [track])
    write_events_csv(tmp_path / "events.csv", events)
    out = tmp_path / "model.json"
    told = ["gestures", "train", str(tmp_path), "--method", "dtw", "--test", "--out", str(out)]
    assert main(told) == 0
    said = capsys.readouterr().out
    assert "wave is told by: " in said
    assert "Left out in turn" in said
    assert json.loads(out.read_text())["provenance"]["left_out"]["rule"] == "subject"


def test_joints_that_are_weighed_alike_are_told(watched):
    track, events = watched
    lesson = marked_lesson("hello", marked("wave", events), [track], "child")
    trained = learn(lesson, TrainingParams(method="weighted-dtw"), no_progress, is_tested=False)
    assert np.ptp(trained.model.weights) == 0
    assert any("weighed alike" in one.text for one in trained.notices)
