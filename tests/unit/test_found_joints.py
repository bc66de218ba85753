"""A recording where a table of joints would do: joints, gestures and exercises are the same."""

import json

import numpy as np
import pytest

from adibas.cli import main
from adibas.pipeline.found_joints import JointSource, find_joints
from adibas.recordings import create_recording
from adibas.simulation.scenes import open_scene

N_FRAMES = 75


@pytest.fixture(scope="module")
def jumper(tmp_path_factory):
    """A recording of one jump and the table of its joints."""
    folder = tmp_path_factory.mktemp("jumper")
    scene = open_scene("jump", seed=2, has_color=False)
    video, table = folder / "jump.mcap", folder / "jump.csv"
    with create_recording(video, scene.info) as writer:
        for index in range(N_FRAMES):
            writer.write(scene.frame(index).sensor_frame)
    assert main(["pose", str(video), "--out", str(table)]) == 0
    return video, table


def test_joints_of_a_recording_are_those_of_its_table_and_are_known_to_be_estimated(jumper):
    found, read = (find_joints(JointSource(path), lambda *_done: None) for path in jumper)
    (found_track,), (read_track,) = found.tracks, read.tracks
    np.testing.assert_allclose(found_track.joints_m, read_track.joints_m, atol=1e-5)
    assert len(found_track) == N_FRAMES
    assert (found.is_estimated, read.is_estimated) == (True, False)


def test_gestures_are_found_in_a_recording_with_the_model_that_comes_with_the_program(
    jumper, tmp_path, capsys
):
    found = []
    for path in jumper:
        out = tmp_path / "events.csv"
        assert main(["gestures", "detect", str(path), "--out", str(out), "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out)["events"])
    from_video, from_table = found
    assert [event["label"] for event in from_video] == ["jump"]
    assert [event["label"] for event in from_table] == ["jump"]
    assert from_video[0]["begin_s"] == pytest.approx(from_table[0]["begin_s"], abs=1e-3)
    assert from_video[0]["end_s"] == pytest.approx(from_table[0]["end_s"], abs=1e-3)


def test_an_exercise_is_checked_in_a_recording(jumper, capsys):
    video, table = map(str, jumper)
    shown = ["--repetition", "0:2.1", "--json"]
    repetitions = []
    for patient, therapist in ((video, table), (table, video), (table, table)):
        assert main(["gestures", "check", patient, "--therapist", therapist, *shown]) == 0
        told = json.loads(capsys.readouterr().out)
        repetitions.append(told["repetitions"])
        assert told["origin"] == told["therapist"]["origin"] == "markerless"
    assert len(repetitions[-1]) >= 1
    for found in repetitions[:-1]:
        assert [one["begin_s"] for one in found] == [one["begin_s"] for one in repetitions[-1]]
        assert [one["end_s"] for one in found] == [one["end_s"] for one in repetitions[-1]]
