"""What `adibas pose` and `adibas limbs` say where there is nobody, half of somebody, or a bad file.

Recordings are made by the simulator; a skeleton out of nothing is what must never come.
"""

import json

import numpy as np
import pytest

from adibas.cli.command_line import main
from adibas.data.limbs import HAND
from adibas.limbs.training_set import FolderHeader, write_header, write_image
from adibas.pipeline.limb_training import merge_model
from adibas.recordings import create_recording
from adibas.recordings.joints_csv import read_joints_csv
from adibas.resources import resource_path
from adibas.simulation.crowd_sensors import CrowdSensor
from adibas.simulation.crowds import CrowdScene
from adibas.simulation.odd_plans import ODD_PLANS, pinhole

SEED, HALF_SEED, DARK_SEED = 11, 13, 5
N_FRAMES, STEP = 6, 4
NEAR_M = 0.1
SENSORS = ((320, 240, 57.0), (512, 424, 70.0), (848, 480, 87.0), (1280, 720, 70.0))


def record(path, name, sensor=None, seed=SEED):
    """Write a scene; return the truth of each frame."""
    scene = CrowdScene(ODD_PLANS[name], seed, sensor)
    frames = [scene.frame(STEP * number) for number in range(N_FRAMES)]
    with create_recording(path, scene.info) as writer:
        for frame in frames:
            writer.write(frame.sensor_frame)
    return scene, frames


def posed(path, capsys):
    """Run `adibas pose`; return its code, what it said, and the file that it was to write."""
    out = path.with_suffix(".csv")
    code = main(["pose", str(path), "--out", str(out)])
    return code, capsys.readouterr().err, out


@pytest.mark.parametrize(
    ("name", "holes", "words"),
    [
        ("empty", 0.0, "Nobody is seen."),
        ("legs", 0.0, "is cut off by the edge of the picture"),
        ("near", 0.0, "too near"),
        ("sitting_dog", 0.0, "for a person"),
        ("armchair", 0.0, "does not look like a person"),
        ("person", 0.8, "Too much of the picture has no depth"),
        ("person", 1.0, "Hardly any depth is measured"),
    ],
)
def test_where_nobody_can_be_measured_the_reason_is_said_and_nothing_is_written(
    tmp_path, capsys, name, holes, words
):
    path = tmp_path / f"{name}.mcap"
    record(path, name, CrowdSensor(None, holes))
    code, told, out = posed(path, capsys)
    assert code == 1
    assert f"Nobody was found in {name}.mcap" in told
    assert words in told
    assert not out.exists()
    folder = tmp_path / "limbs"
    assert main(["limbs", "segment", str(path), "--out", str(folder), "--json"]) == 0
    segmented = json.loads(capsys.readouterr().out)
    assert segmented["n_with_person"] == 0
    assert any(words in notice["text"] for notice in segmented["notices"])


def test_somebody_nearer_than_the_sensor_measures_is_told_to_keep_away(tmp_path, capsys):
    path = tmp_path / "dark.mcap"
    record(path, "near", seed=DARK_SEED)
    code, told, out = posed(path, capsys)
    assert code == 1
    assert "a large part of the picture has no depth" in told
    assert "keep 1.5 to 4 m from the camera" in told
    assert not out.exists()


def test_somebody_who_is_too_near_is_told_where_nobody_was_there_most_of_the_time(tmp_path, capsys):
    empty = CrowdScene(ODD_PLANS["empty"], SEED)
    near = CrowdScene(ODD_PLANS["near"], SEED)
    path = tmp_path / "late.mcap"
    with create_recording(path, empty.info) as writer:
        for index in range(10):
            writer.write((empty if index < 7 else near).frame(index).sensor_frame)
    code, told, _ = posed(path, capsys)
    assert code == 1
    assert "Nobody is seen. Let the person step in front of the camera. (In 7 of 10" in told
    assert "too near" in told


@pytest.mark.parametrize("name", ["cut_left", "cut_right", "upper_body"])
def test_half_a_person_is_told_and_joints_beyond_the_picture_are_not_seen(tmp_path, capsys, name):
    path = tmp_path / "half.mcap"
    scene, frames = record(path, name, seed=HALF_SEED)
    _code, told, out = posed(path, capsys)
    assert "part of the person is in the picture" in told or "cut off by the edge" in told
    if out.exists():
        k = scene.info.calibration.depth.intrinsics
        n_hidden = n_invented = 0
        for joints_m, truth in zip(read_joints_csv(out).tracks[0].joints_m, frames, strict=False):
            seen = np.isfinite(joints_m[:, 0])
            x, y, z = joints_m[seen].T
            u, v = k.fx * x / z + k.cx, k.fy * y / z + k.cy
            assert ((u >= 0) & (u < 640) & (v >= 0) & (v < 480)).all()
            n_hidden += np.count_nonzero(~truth.people[0].in_view)
            n_invented += np.count_nonzero(seen & ~truth.people[0].in_view)
        assert n_invented < 0.5 * n_hidden


@pytest.mark.parametrize(("width", "height", "across_deg"), SENSORS)
def test_other_sensors_show_the_same_joints(tmp_path, capsys, width, height, across_deg):
    path = tmp_path / "sensor.mcap"
    _, frames = record(path, "person", CrowdSensor(pinhole(width, height, across_deg)))
    code, _, out = posed(path, capsys)
    assert code == 0
    found_m = read_joints_csv(out).tracks[0].joints_m
    truth_m = np.stack([frame.people[0].joints_m for frame in frames[-len(found_m) :]])
    far_m = np.linalg.norm(found_m - truth_m, axis=2)
    assert np.isfinite(far_m).mean() > 0.8
    assert (far_m[np.isfinite(far_m)] < NEAR_M).mean() > 0.85


@pytest.mark.parametrize("share", [0.2, 0.5])
def test_holes_are_told_and_joints_are_found_all_the_same(tmp_path, capsys, share):
    path = tmp_path / "holes.mcap"
    _, frames = record(path, "person", CrowdSensor(None, share))
    code, told, out = posed(path, capsys)
    assert code == 0
    assert "of the picture has no depth: joints are less exact" in told
    found_m = read_joints_csv(out).tracks[0].joints_m
    truth_m = np.stack([frame.people[0].joints_m for frame in frames[-len(found_m) :]])
    far_m = np.linalg.norm(found_m - truth_m, axis=2)
    assert (far_m[np.isfinite(far_m)] < NEAR_M).mean() > 0.8


@pytest.fixture
def other_labels(tmp_path):
    path = tmp_path / "limbs-7.npz"
    merge_model(resource_path("models", "limbs-15.npz"), path)
    return path


@pytest.fixture
def labelled(tmp_path):
    """One labelled image of two labels that no shipped model has."""
    folder = tmp_path / "labelled"
    write_header(folder, FolderHeader(("trunk", "tail"), 0.001, 300.0, 300.0, 20.0, 15.0))
    labels = np.zeros((30, 40), np.uint8)
    labels[5:25, 5:20], labels[5:25, 20:30] = 1, 2
    write_image(folder, "00000", np.full((30, 40), 2000, np.uint16), labels)
    return folder


def test_a_model_of_another_label_set_is_told_by_each_command(
    tmp_path, capsys, other_labels, labelled
):
    path = tmp_path / "person.mcap"
    record(path, "person")
    out = tmp_path / "out"
    for arguments, words in (
        (["pose", str(path), "--out", f"{out}.csv"], "The model is for other limbs (upper-body-7)"),
        (
            ["limbs", "segment", str(path), "--labels", "full-body-15", "--out", str(out)],
            "The model is for other limbs (upper-body-7)",
        ),
        (["limbs", "evaluate", str(labelled)], "labels"),
    ):
        assert main([*arguments, "--model", str(other_labels)]) == 1
        assert words in capsys.readouterr().err
    assert not out.exists()
    assert not out.with_suffix(".csv").exists()


def test_a_model_of_a_hand_labels_nobody(tmp_path, capsys):
    folder = tmp_path / "hands"
    write_header(folder, FolderHeader(HAND.names, 0.001, 300.0, 300.0, 20.0, 15.0))
    labels = np.zeros((30, 40), np.uint8)
    for value in range(1, len(HAND.names) + 1):
        labels[5:25, 5 * value : 5 * value + 5] = value
    write_image(folder, "00000", np.full((30, 40), 2000, np.uint16), labels)
    model, out = tmp_path / "hand.npz", tmp_path / "out"
    assert main(["limbs", "train", str(folder), "--trees", "1", "--out", str(model)]) == 0
    path = tmp_path / "person.mcap"
    record(path, "person")
    command = ["limbs", "segment", str(path), "--model", str(model), "--out", str(out)]
    assert main(command) == 1
    assert "The model is for other limbs (hand-6)" in capsys.readouterr().err
    assert not out.exists()


def test_a_model_file_that_is_cut_or_changed_is_told_by_each_command(tmp_path, capsys, labelled):
    path = tmp_path / "person.mcap"
    record(path, "empty")
    whole = resource_path("models", "limbs-15.npz").read_bytes()
    middle = len(whole) // 2
    flipped = bytes(255 - byte for byte in whole[middle : middle + 200])
    out = tmp_path / "out"
    for content in (
        b"",
        whole[:1000],
        whole[:-1000],
        whole[:middle] + flipped + whole[middle + 200 :],
    ):
        model = tmp_path / "broken.npz"
        model.write_bytes(content)
        for arguments in (
            ["pose", str(path), "--out", f"{out}.csv"],
            ["limbs", "segment", str(path), "--out", str(out)],
            ["limbs", "evaluate", str(labelled)],
        ):
            assert main([*arguments, "--model", str(model)]) == 1
            assert "broken.npz is no forest of ADiBAS, or it is damaged" in capsys.readouterr().err
    assert not out.exists()
    assert not out.with_suffix(".csv").exists()
