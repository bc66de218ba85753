"""Gestures: described alike wherever and whoever, found in streams, counted honestly."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

from adibas.cli.command_line import main
from adibas.data.events import TimedEvent
from adibas.data.joints import JOINT_NAMES, mirror_order
from adibas.data.skeleton_track import track_of
from adibas.errors import GestureError
from adibas.geometry.quarter_turns import QuarterTurn
from adibas.gestures.described_track import describe
from adibas.gestures.descriptor import (
    DESCRIBED_JOINTS,
    LONGEST_HIDDEN_S,
    N_POSITIONS,
    NECK,
    SHOULDERS,
    DescriptorParams,
    body_size,
    mirrored,
)
from adibas.gestures.evaluation import compare, leave_one_out
from adibas.gestures.model import METHODS
from adibas.gestures.model_file import read_model, write_model
from adibas.gestures.segments import Segment, at_one_length
from adibas.gestures.thresholds import best_threshold
from adibas.gestures.training import TrainingParams, train
from adibas.gestures.weighting import joint_weights
from adibas.pipeline.gesture_examples import examples_of
from adibas.recordings.events_csv import read_events_csv, write_events_csv
from adibas.recordings.joints_csv import write_joints_csv
from adibas.resources import resource_path
from tests.unit.gesture_examples import STANDING_M, body, clips, recording, streams

PARAMS = DescriptorParams()


@pytest.fixture(scope="module")
def watched():
    tracks, events = streams()
    return examples_of(tracks, events, PARAMS)[0]


@pytest.fixture(scope="module")
def trained(watched):
    return train(watched, PARAMS)


def turned_about_y(joints, angle):
    turn = np.array(
        [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    )
    return joints @ turn.T


def test_the_descriptor_does_not_depend_on_place_size_and_facing():
    joints = np.array([body(phase, 0) for phase in np.linspace(0, 1, 40)])
    times_s = np.arange(40) / 30
    here = describe(track_of(times_s, joints), PARAMS).frames
    moved = turned_about_y(joints, 0.7) * 1.3 + [1.0, -0.4, 3.0]
    there = describe(track_of(times_s, moved), PARAMS).frames
    assert here.shape == (20, PARAMS.n_numbers)
    np.testing.assert_allclose(there, here, atol=1e-9)


def test_without_facing_a_turned_person_differs():
    params = DescriptorParams(facing_s=0, velocity_s=0)
    joints = np.array([body(0, 0)] * 10)
    times_s = np.arange(10) / 30
    here = describe(track_of(times_s, joints), params).frames
    there = describe(track_of(times_s, turned_about_y(joints, 0.7)), params).frames
    assert here.shape[1] == 42
    assert abs(there - here).max() > 0.1


def test_a_joint_missing_briefly_is_interpolated_and_missing_long_stays_missing():
    joints = np.array([body(0, 0)] * 90)
    hand = JOINT_NAMES.index("left_hand")
    joints[10:16, hand] = np.nan
    joints[40:80, hand] = np.nan
    frames = describe(track_of(np.arange(90) / 30, joints), PARAMS).frames
    column = 3 * DESCRIBED_JOINTS.index("left_hand")
    assert np.isfinite(frames[:19, column]).all()
    assert np.isnan(frames[21:38, column]).all()
    assert np.isfinite(np.delete(frames, [column, column + 1, column + 2, column + 42,
                                          column + 43, column + 44], axis=1)).all()  # fmt: skip


def test_size_is_that_of_the_limbs_and_survives_a_wrong_joint():
    joints = np.array([body(0, 0)] * 5)
    size = body_size(joints)
    assert body_size(1.2 * joints) == pytest.approx(1.2 * size)
    joints[:, JOINT_NAMES.index("left_foot")] += 0.5
    assert body_size(joints) == pytest.approx(size, rel=0.03)
    assert np.isnan(body_size(np.full((3, 15, 3), np.nan)))


def test_weights_go_to_the_joints_that_tell_gestures_apart():
    rng = np.random.default_rng(0)
    segments, labels = [], []
    for number in range(8):
        frames = rng.normal(0, 1, (12, 42))
        column = 3 * DESCRIBED_JOINTS.index("left_hand")
        frames[:, column : column + 3] = 5 * (number % 2) + rng.normal(0, 0.1, (12, 3))
        segments.append(frames)
        labels.append(number % 2)
    weights = joint_weights(segments, np.array(labels))
    assert weights.sum() == pytest.approx(1.0)
    assert weights[DESCRIBED_JOINTS.index("left_hand")] > 0.6


def test_weights_are_alike_where_no_joint_tells_anything():
    same = np.ones((6, 42))
    np.testing.assert_allclose(joint_weights([same] * 4, np.array([0, 0, 1, 1])), 1 / 14)


def test_segments_of_one_length_keep_their_ends():
    frames = np.arange(10.0)[:, None]
    short = at_one_length(frames, 4)
    np.testing.assert_allclose(short[:, 0], [0, 3, 6, 9])
    np.testing.assert_allclose(at_one_length(frames[:1], 3), 0)


@pytest.mark.parametrize(
    ("costs", "right", "wanted", "between"),
    [
        ([1.0, 2.0, 3.0, 9.0], [True, True, True, False], 3, (3.0, 9.0)),
        ([1.0, 2.0, 3.0], [False, False, False], 2, (0.0, 1.0)),
        ([1.0, 2.0, 8.0], [True, False, False], 1, (1.0, 2.0)),
    ],
)
def test_the_threshold_finds_most_with_fewest_false_alarms(costs, right, wanted, between):
    threshold = best_threshold(np.array(costs), np.array(right), wanted)
    assert between[0] < threshold < between[1]


@pytest.mark.parametrize("method", METHODS)
def test_every_method_beats_chance_on_strangers(watched, method):
    result = leave_one_out(watched, PARAMS, TrainingParams(method=method))
    assert result.n_done.sum() == 16
    least = {"table-7.1": 0.0, "hmm": 0.8}.get(method, 0.9)
    assert result.rates_of([0, 1])[2] >= least
    assert result.confusion.sum() + result.missed.sum() >= 16


def test_gestures_of_a_stranger_are_found_once_with_begin_and_end(trained):
    track, done = recording(77, ("bend", "wave", "wave", "bend"), size=1.1)
    described = describe(track, PARAMS)
    found = trained.detect(described)
    assert [trained.labels[one.label] for one in found] == [label for label, _, _ in done]
    for one, (_, begin_s, end_s) in zip(found, done, strict=True):
        assert abs(described.time_s(one.begin) - begin_s) < 0.4
        assert abs(described.time_s(one.end) - end_s) < 0.4
        assert one.cost <= 1.0


@pytest.mark.parametrize("method", ["likeness", "hmm", "dtw"])
def test_examples_of_one_person_in_one_recording_suffice(method):
    tracks, events = streams(1, ("wave", "bend", "wave", "bend", "bend", "wave"))
    model = train(examples_of(tracks, events, PARAMS)[0], PARAMS, TrainingParams(method=method))
    two = examples_of(*streams(2), PARAMS)[0]
    result = leave_one_out(two, PARAMS, TrainingParams(method=method))
    track, done = recording(60, ("wave", "bend"))
    found = model.detect(describe(track, PARAMS))
    assert [model.labels[one.label] for one in found] == [label for label, _, _ in done]
    assert result.hits.sum() >= 4


def test_who_only_stands_does_nothing(trained):
    joints = np.array([body(0, 0)] * 300) + np.random.default_rng(1).normal(0, 0.008, (300, 15, 3))
    assert trained.detect(describe(track_of(np.arange(300) / 30, joints), PARAMS)) == []


def test_isolated_gestures_are_classified():
    tracks, events = clips()
    examples = examples_of(tracks, events, PARAMS)[0]
    assert examples.is_isolated
    result = leave_one_out(examples, PARAMS, TrainingParams())
    assert result.accuracy == 1.0
    assert result.accuracy_of(0) <= 100.0


def test_reports_are_counted_by_7_7_and_at_half_overlap(watched, trained):
    done = watched.in_stream(0)
    first = done[0]
    reports = [
        Segment(0, first.label, first.begin, first.end),
        Segment(0, 1 - first.label, first.begin, first.end, 0.5),
        Segment(0, first.label, 0, 3, 0.7),
    ]
    silent = type("Silent", (), {"detect": lambda _self, _track: reports})()
    one_stream = watched.picked(np.array([g.stream == 0 for g in watched.gestures]))
    result = compare(silent, one_stream)
    assert result.missed.sum() == len(done) - 1
    assert result.confusion.sum() == 2
    assert result.hits.sum() == 1
    assert result.false_alarms == 2
    assert result.accuracy_7_7 == pytest.approx(100 * 1 / (len(done) - 1 + 2))
    assert compare(trained, one_stream).hits.sum() == 4


@pytest.mark.parametrize("method", METHODS)
def test_a_model_file_gives_the_same_model(tmp_path, watched, method):
    path = tmp_path / "model.json"
    trained = train(watched, PARAMS, TrainingParams(method=method))
    write_model(path, trained)
    again = read_model(path)
    track, _ = recording(5, ("wave", "bend"))
    described = describe(track, again.descriptor)
    assert [(s.label, s.begin, s.end) for s in again.detect(described)] == [
        (s.label, s.begin, s.end) for s in trained.detect(described)
    ]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"format": "x"}, "no model"),
        ({"version": 99}, "another version"),
        ({"joints": ["head"]}, "another descriptor"),
        ({"labels": []}, "damaged"),
        ({"thresholds": [1.0]}, "damaged"),
        ({"descriptor": {"velocity_s": 0.0}}, "other numbers than here"),
        ({"descriptor": asdict(DescriptorParams(velocity_s=0.0))}, "other numbers than here"),
        ({"descriptor": asdict(DescriptorParams()) | {"bones": 3}}, "other numbers than here"),
        ({"descriptor": asdict(DescriptorParams()) | {"rate_hz": -1.0}}, "damaged"),
        ({"descriptor": None}, "damaged"),
        ({"examples": [{"label": "wave", "frames": [[0.0], [0.0, 1.0]]}]}, "damaged"),
    ],
)
def test_a_model_that_does_not_fit_is_refused_in_words(tmp_path, trained, change, words):
    path = tmp_path / "model.json"
    write_model(path, trained)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(GestureError, match=words):
        read_model(path)


def test_a_file_that_is_no_model_is_refused_in_words(tmp_path):
    with pytest.raises(GestureError, match="cannot be read"):
        read_model(tmp_path / "gone.json")
    (tmp_path / "text.json").write_text("no json")
    with pytest.raises(GestureError, match="cannot be read"):
        read_model(tmp_path / "text.json")


def test_unusable_examples_are_refused_in_words():
    tracks, events = streams(2, ("wave", "bend"))
    lonely = [event for event in events if event.label == "wave"] + events[1:2]
    with pytest.raises(GestureError, match="only one example of bend"):
        train(examples_of(tracks, lonely, PARAMS)[0], PARAMS)
    blink = [*events, TimedEvent("r0", "wave", 0.5, 0.52, "s0")]
    with pytest.raises(GestureError, match="shorter than 4 frames"):
        train(examples_of(tracks, blink, PARAMS)[0], PARAMS)
    with pytest.raises(GestureError, match="not in the folder"):
        examples_of(tracks, [TimedEvent("other", "wave", 0, 1)], PARAMS)
    with pytest.raises(GestureError, match="lies outside"):
        examples_of(tracks, [TimedEvent("r0", "wave", 900, 901)], PARAMS)
    with pytest.raises(GestureError, match="no examples"):
        examples_of(tracks, [], PARAMS)


def written(folder, tracks, events):
    for (name, _), track in tracks.items():
        write_joints_csv(folder / f"{name}.joints.csv", [track])
    write_events_csv(folder / "events.csv", events)
    return folder


def test_the_command_trains_detects_and_evaluates(tmp_path, capsys):
    tracks, events = streams(3)
    folder = written(tmp_path / "set", tracks, events)
    model, found = tmp_path / "model.json", tmp_path / "events.csv"
    assert main(["gestures", "train", str(folder), "--out", str(model), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["labels"] == ["bend", "wave"]
    assert said["provenance"]["split_by"] == "subject"
    joints = tmp_path / "new.joints.csv"
    track, done = recording(50, ("wave", "bend"))
    write_joints_csv(joints, [track])
    detect = ["gestures", "detect", str(joints), "--model", str(model), "--out", str(found)]
    assert main(detect) == 0
    upright = read_events_csv(found)
    assert [event.label for event in upright] == [label for label, _, _ in done]
    lying_m = QuarterTurn(1).points(track.joints_m)  # what the camera on its side would have seen
    write_joints_csv(joints, [track_of(track.times_s, lying_m)])
    assert main([*detect, "--rotation", "270"]) == 0
    assert [event.label for event in read_events_csv(found)] == [one.label for one in upright]
    capsys.readouterr()
    assert main(["gestures", "evaluate", str(folder), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["protocol"] == "leave-one-subject-out"
    assert document["seed"] == 0
    assert document["accuracy"] >= 0.8
    assert set(document["per_class"]["wave"]) == {"precision", "recall", "f1", "accuracy_7_7"}
    assert np.sum(document["confusion"]) + document["not_classified"] >= 12
    assert main(["gestures", "evaluate", str(folder), "--test", str(folder)]) == 0
    assert "Best class right" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("n_people", "words"),
    [
        (3, "bend cannot be evaluated: without one person there are 0 of its 2 examples"),
        (1, "bend cannot be evaluated: without one of them there are 1 of its 2 examples"),
    ],
)
def test_it_is_said_of_which_gesture_too_little_is_left_to_evaluate_it(
    tmp_path, capsys, n_people, words
):
    tracks, events = streams(n_people)
    alone = [one for one in events if one.label == "wave" or one.subject == "s0"]
    assert main(["gestures", "evaluate", str(written(tmp_path, tracks, alone))]) == 1
    said = capsys.readouterr().err
    assert words in said
    assert "only one example" not in said


def test_gaps_and_joints_that_never_appear_are_said(tmp_path, capsys, trained):
    model = tmp_path / "model.json"
    write_model(model, trained)
    track, _ = recording(51, ("wave",))
    joints = np.array(track.joints_m)
    joints[:, JOINT_NAMES.index("right_foot")] = np.nan
    times_s = track.times_s + np.where(np.arange(len(track)) > 20, 9.0, 0.0)
    path = tmp_path / "gap.joints.csv"
    write_joints_csv(path, [track_of(times_s, joints)])
    out = tmp_path / "events.csv"
    assert main(["gestures", "detect", str(path), "--model", str(model), "--out", str(out)]) == 0
    said = capsys.readouterr().err
    assert "right foot never appear" in said
    assert "gaps of more than 0.5 s in the joints: 1 (the longest 9.0 s)" in said
    joints[:, JOINT_NAMES.index("neck")] = np.nan
    write_joints_csv(path, [track_of(times_s, joints)])
    assert main(["gestures", "detect", str(path), "--model", str(model), "--out", str(out)]) == 1
    assert "the neck never appears" in capsys.readouterr().err


def test_an_empty_folder_is_named(tmp_path, capsys):
    assert main(["gestures", "evaluate", str(tmp_path)]) == 1
    assert "holds no joints" in capsys.readouterr().err
    assert len(STANDING_M) == len(JOINT_NAMES)


def test_the_shipped_model_knows_the_five_gestures_and_keeps_quiet_while_nothing_happens():
    model = read_model(resource_path("models", "gestures.json"))
    assert model.labels == ("bend", "clap", "greet", "jump", "note")
    assert "simulated" in str(model.provenance["source"])
    joints = np.array([body(0, 0)] * 90)
    assert model.detect(describe(track_of(np.arange(90) / 30, joints), model.descriptor)) == []


def test_a_neck_that_the_head_hides_is_where_it_was_from_the_shoulders():
    track, _events = recording(5, ("bend",))
    hidden_m = track.joints_m.copy()
    span = slice(50, 75)  # 0.8 s: longer than gaps that are interpolated
    hidden_m[span, NECK] = np.nan
    told = describe(track_of(track.times_s, hidden_m), DescriptorParams())
    true = describe(track, DescriptorParams())
    assert np.isfinite(told.frames).all()
    assert np.abs(told.frames - true.frames)[:, :N_POSITIONS].max() < 0.15


def test_a_neck_is_not_made_up_for_long_nor_without_shoulders():
    track, _events = recording(5, ("bend", "wave"))
    lonely_m, long_m = track.joints_m.copy(), track.joints_m.copy()
    lonely_m[40:70, [NECK, *SHOULDERS]] = np.nan
    long_m[10:, NECK] = np.nan
    lonely, long = (
        describe(track_of(track.times_s, one), DescriptorParams(facing_s=0.0)).frames
        for one in (lonely_m, long_m)
    )
    assert np.isnan(lonely[22:33]).all()
    n_held = 5 + round(LONGEST_HIDDEN_S * 15)
    assert np.isfinite(long[: n_held - 2, 0]).all()
    assert np.isnan(long[n_held + 2 :]).all()


def of_other_side(track):
    """Return the same movement with the sides exchanged."""
    exchanged_m = track.joints_m[:, mirror_order(JOINT_NAMES)] * [-1.0, 1.0, 1.0]
    return track_of(track.times_s, exchanged_m)


@pytest.mark.parametrize(("n_wrong", "is_known"), [(1, True), (0, False)])
def test_the_other_side_is_the_same_gesture_unless_all_are_known_without(n_wrong, is_known):
    """An example that is marked wrongly is one that nobody else's tell."""
    tracks, events = streams(3)
    still = [replace(one, begin_s=0.0, end_s=0.6) for one in events[1::4]]
    examples = examples_of(tracks, [*events, *still * n_wrong], PARAMS)[0]
    other_hand = mirrored(examples.frames_of(examples.gestures[0]))
    wave = examples.labels.index("wave")
    with_copies, without = (
        train(examples, PARAMS, TrainingParams(most_mirrored=most)) for most in (400, 0)
    )
    told, alone = (float(one.classify(other_hand)[wave]) for one in (with_copies, without))
    assert (told < 0.7 * alone) == is_known
    assert (told == alone) == (not is_known)


def test_sides_that_make_the_gesture_are_told_apart():
    tracks, events = streams(4, ("wave",) * 4)
    for number in range(4):
        tracks[f"o{number}", 1] = of_other_side(tracks[f"r{number}", 1])
    events = [
        *(replace(one, label="wave left") for one in events),
        *(
            replace(one, label="wave right", recording=one.recording.replace("r", "o"))
            for one in events
        ),
    ]
    examples = examples_of(tracks, events, PARAMS)[0]
    found = leave_one_out(examples, PARAMS, TrainingParams())
    np.testing.assert_array_equal(found.confusion, np.diag(np.diag(found.confusion)))
    assert found.missed.sum() <= 2


def test_joints_are_weighed_where_that_recognises_those_left_out_better():
    """Feet that jump about tell nothing; without them all is clear."""
    tracks, events = streams(3)
    examples = {}
    for jump_m in (0.0, 1.5):
        rng = np.random.default_rng(0)
        moved = {}
        for name, track in tracks.items():
            joints_m = track.joints_m.copy()
            feet = [JOINT_NAMES.index(f"{side}_{part}") for side in ("left", "right")
                    for part in ("foot", "knee")]  # fmt: skip
            joints_m[:, feet] += rng.normal(0.0, jump_m, (len(joints_m), len(feet), 3))
            moved[name] = track_of(track.times_s, joints_m)
        examples[jump_m] = examples_of(moved, events, PARAMS)[0]
    weights = {
        jump_m: train(some, PARAMS, TrainingParams(method="weighted-dtw")).weights
        for jump_m, some in examples.items()
    }
    assert np.ptp(weights[0.0]) == 0
    hand, foot = (
        weights[1.5][:, DESCRIBED_JOINTS.index(joint)] for joint in ("left_hand", "left_foot")
    )
    assert (hand > 1.5 * foot).all()
