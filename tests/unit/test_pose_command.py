"""`adibas pose` on simulated recordings, and what it says where there is nothing to find."""

import csv
import json

import ezc3d
import numpy as np
import pytest

from adibas.cli.command_line import main
from adibas.data.joints import JOINT_NAMES
from adibas.measures.sight_plane import vertical_of
from adibas.pipeline.limb_training import merge_model
from adibas.pipeline.provenance import identity_of
from adibas.recordings import create_recording, open_recording
from adibas.recordings.joints_csv import read_joints_csv
from adibas.resources import resource_path
from adibas.simulation.scenes import open_scene

N_FRAMES = 6


def record(path, name):
    scene = open_scene(name, seed=2, has_color=False)
    with create_recording(path, scene.info) as writer:
        for index in range(N_FRAMES):
            writer.write(scene.frame(index).sensor_frame)
    return scene


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("pose") / "idle.mcap"
    scene = record(path, "idle")
    return path, np.stack([scene.frame(k).truth.joints_m for k in range(N_FRAMES)])


def test_joints_of_a_simulated_person_are_found_and_marked_as_markerless(
    recorded, tmp_path, capsys
):
    path, truth_m = recorded
    outs = [tmp_path / f"joints{ending}" for ending in (".csv", ".trc", ".c3d")]
    arguments = [part for out in outs for part in ("--out", str(out))]
    assert main(["pose", str(path), *arguments, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["origin"] == "markerless"
    assert told["lag_frames"] == 2
    assert told["lag_s"] == pytest.approx(2 / 30, abs=0.002)
    assert [person["frames"] for person in told["people"]] == [N_FRAMES]

    read = read_joints_csv(outs[0])
    assert read.origin == "markerless"
    with open_recording(path) as recording:
        calibration = recording.info.calibration
    up = calibration.color_from_depth.rotation.T @ vertical_of(calibration).up
    np.testing.assert_allclose(read.up, up, atol=1e-5)
    track = read.tracks[0]
    far_m = np.linalg.norm(track.joints_m - truth_m, axis=2)
    assert np.nanmedian(far_m) < 0.06
    assert (far_m[np.isfinite(far_m)] < 0.1).mean() > 0.8
    assert (track.confidence[track.seen] > 0).all()
    with outs[0].open() as file:
        assert next(csv.reader(file))[-1] == "origin"

    assert "(markerless)" in outs[1].read_text().splitlines()[0]
    parameters = ezc3d.c3d(str(outs[2]))["parameters"]["POINT"]
    assert parameters["LABELS"]["value"] == list(JOINT_NAMES)
    assert set(parameters["DESCRIPTIONS"]["value"]) == {"markerless"}


def test_an_empty_room_gives_a_sentence_and_no_file(tmp_path, capsys):
    path, out = tmp_path / "empty.mcap", tmp_path / "joints.csv"
    record(path, "empty")
    assert main(["pose", str(path), "--out", str(out)]) == 1
    assert "Nobody was found in empty.mcap. Nobody is seen." in capsys.readouterr().err
    assert not out.exists()


def test_a_model_for_other_limbs_is_refused_in_words(recorded, tmp_path, capsys):
    path, _ = recorded
    model = tmp_path / "limbs-7.npz"
    merge_model(resource_path("models", "limbs-15.npz"), model)
    out = tmp_path / "joints.csv"
    assert main(["pose", str(path), "--model", str(model), "--out", str(out)]) == 1
    assert "The model is for other limbs (upper-body-7)" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--out", "joints.txt"], "is no file of joints"),
        (["--out", "joints.csv", "--person", "7"], "There is no person 7. Choose one of: 1."),
        (["--out", "joints.csv", "--frames", "90:"], "no such frames"),
    ],
)
def test_what_cannot_be_done_is_told(recorded, tmp_path, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert main(["pose", str(recorded[0]), *arguments]) == 1
    assert words in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_movement_is_measured_without_markers(recorded, tmp_path, capsys):
    out = tmp_path / "movement.csv"
    assert main(["movement", str(recorded[0]), "--markerless", "--out", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["origin"] == "markerless"
    assert told["vertical_measured"]
    with open_recording(recorded[0]) as recording:
        assert told["provenance"]["calibration"] == identity_of(recording.info.calibration)
    knees = [one for one in told["ranges"] if one["angle"] == "left_knee_flexion"]
    assert abs(knees[0]["greatest_deg"]) < 30
    assert out.exists()


def test_markers_and_markerless_exclude_one_another(recorded, tmp_path, capsys):
    arguments = ["--markerless", "--markers", "led", "--out", str(tmp_path / "m.csv")]
    assert main(["movement", str(recorded[0]), *arguments]) == 1
    assert "not both" in capsys.readouterr().err
