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
from adibas.pipeline.person_facts import facts_of
from adibas.pipeline.pose_model import shipped_joint_model
from adibas.pipeline.provenance import identity_of
from adibas.recordings import create_recording, open_recording
from adibas.recordings.joints_csv import read_joints_csv
from adibas.resources import resource_path
from adibas.simulation.crowds import open_crowd
from adibas.simulation.scenes import open_scene
from adibas.skeleton.following import ChosenJoints, PersonFollower
from adibas.skeleton.sides import SideParams

N_FRAMES = 6


def record(path, scene):
    with create_recording(path, scene.info) as writer:
        for index in range(N_FRAMES):
            writer.write(scene.frame(index).sensor_frame)


def scene_of(name):
    return open_scene(name, seed=2, has_color=False)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("pose") / "idle.mcap"
    scene = scene_of("idle")
    record(path, scene)
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


def test_whether_a_back_is_seen_is_said_to_be_unsure_and_can_be_declared(tmp_path, capsys):
    path, out = tmp_path / "back.mcap", tmp_path / "joints.csv"
    scene = scene_of("posterior")
    record(path, scene)
    assert main(["pose", str(path), "--out", str(out)]) == 0
    told = capsys.readouterr()
    assert "Left and right of person 1 may be exchanged" in told.err
    assert "with a confidence of" in told.out
    assert main(["pose", str(path), "--view", "posterior", "--out", str(out)]) == 0
    told = capsys.readouterr()
    assert "may be exchanged" not in told.err
    assert "with a confidence of" not in told.out
    found_m = read_joints_csv(out).tracks[0].joints_m
    truth_m = np.stack([scene.frame(k).truth.joints_m for k in range(N_FRAMES)])
    left, right = (JOINT_NAMES.index(f"{side}_shoulder") for side in ("left", "right"))
    to_own_m = np.linalg.norm(found_m[:, left] - truth_m[:, left], axis=1)
    assert (to_own_m < np.linalg.norm(found_m[:, left] - truth_m[:, right], axis=1)).all()


@pytest.mark.parametrize(
    ("front", "is_shown_from_front", "is_sure"),
    [(0.98, True, True), (0.02, False, True), (0.84, True, False), (0.05, True, False)],
)
def test_sides_are_sure_where_the_view_is_and_they_are_as_of_that_view(
    front, is_shown_from_front, is_sure
):
    joints_m = np.full((len(JOINT_NAMES), 3), np.nan)
    left, right = (JOINT_NAMES.index(f"{side}_shoulder") for side in ("left", "right"))
    joints_m[left] = 0.2 if is_shown_from_front else -0.2, 0.0, 2.0
    joints_m[right] = -joints_m[left, 0], 0.0, 2.0
    confidence = np.where(np.isfinite(joints_m[:, 0]), 0.9, np.nan)
    frames = [ChosenJoints(joints_m, confidence, front) for _k in range(5)]
    follower = PersonFollower(shipped_joint_model().proportions)
    facts = facts_of(follower, frames, SideParams())
    assert facts.view_confidence == pytest.approx(max(front, 1 - front))
    assert facts.is_view_sure == is_sure


def test_a_file_of_one_person_says_whose_joints_it_holds_of_those_who_were_seen(tmp_path, capsys):
    path = tmp_path / "children.mcap"
    record(path, open_crowd("two_children_cross"))
    table, one = tmp_path / "joints.csv", tmp_path / "joints.trc"
    arguments = ["--person", "2", "--out", str(table), "--out", str(one)]
    assert main(["pose", str(path), *arguments]) == 0
    told = capsys.readouterr().out
    assert f"{table}: joints of 2 people in {N_FRAMES} frames" in told
    assert f"{one}: joints of person 2 in {N_FRAMES} frames" in told
    assert "2 people were seen: --person chooses one." in told
    across_mm = float(one.read_text().splitlines()[6].split("\t")[4])
    head_m = read_joints_csv(table).tracks[1].joints_m[0, JOINT_NAMES.index("head")]
    assert across_mm == pytest.approx(1000 * head_m[0], abs=0.01)


def test_an_empty_room_gives_a_sentence_and_no_file(tmp_path, capsys):
    path, out = tmp_path / "empty.mcap", tmp_path / "joints.csv"
    record(path, scene_of("empty"))
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
        (["--out", "joints.csv", "--frames", "90:"], "so frames 90: cannot be read"),
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
