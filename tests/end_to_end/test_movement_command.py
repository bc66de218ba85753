"""A movement on the command line: a recording with markers, or a table of joints, to reports."""

import json

import numpy as np
import openpyxl
import pytest

from adibas.cli.command_line import main
from adibas.data.joints import JOINT_NAMES
from adibas.movement.joint_angles import joint_angles
from adibas.recordings import create_recording
from adibas.recordings.joints_csv import write_joints_csv
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import open_scene
from tests.unit.movement_samples import LEFT_DEG, bending

N_FRAMES = 8


@pytest.fixture(scope="module")
def led_scene():
    markers = MarkerSettings(JOINT_NAMES, kind="led", diameter_m=0.005)
    return open_scene("anterior_led", 4, markers=markers, distance_m=2.7, color_size=(480, 640))


@pytest.fixture(scope="module")
def recording(led_scene, tmp_path_factory):
    path = tmp_path_factory.mktemp("movement") / "standing.mcap"
    with create_recording(path, led_scene.info) as writer:
        for index in range(N_FRAMES):
            writer.write(led_scene.frame(index).sensor_frame)
    return path


@pytest.fixture
def joints_file(tmp_path):
    path = tmp_path / "elbows.joints.csv"
    write_joints_csv(path, [bending()])
    return path


def test_markers_of_a_recording_become_the_angles_of_the_joints(
    led_scene, recording, tmp_path, capsys
):
    out = tmp_path / "m.xlsx"
    words = ["movement", str(recording), "--markers", "led", "--view", "anterior", "--json"]
    assert main([*words, "--out", str(out)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["origin"] == "markers"
    truth = led_scene.frame(0).truth
    places = {marker.name: marker.position_m for marker in truth.markers}
    true_m = np.array([places.get(name, np.full(3, np.nan)) for name in JOINT_NAMES])
    expected = joint_angles(true_m, np.array([0.0, -1.0, 0.0]))
    found = {one["angle"]: one for one in document["ranges"]}
    assert len(found) >= 10
    for name, one in found.items():
        middle_deg = (one["least_deg"] + one["greatest_deg"]) / 2
        assert middle_deg == pytest.approx(np.degrees(expected[name]), abs=6.0), name
    assert "Ranges" in openpyxl.load_workbook(out).sheetnames


def test_a_table_of_joints_gives_several_reports_at_once(joints_file, tmp_path, capsys):
    outs = [tmp_path / f"m{kind}" for kind in (".pdf", ".c3d", ".trc")]
    words = [word for out in outs for word in ("--out", str(out))]
    assert main(["movement", str(joints_file), "--json", *words]) == 0
    document = json.loads(capsys.readouterr().out)
    left = next(one for one in document["ranges"] if one["angle"] == "left_elbow_flexion")
    assert left["greatest_deg"] == pytest.approx(LEFT_DEG[1], abs=0.5)
    assert all(out.stat().st_size > 0 for out in outs)


def test_a_recording_needs_to_know_its_markers(recording, tmp_path, capsys):
    assert main(["movement", str(recording), "--out", str(tmp_path / "m.xlsx")]) == 1
    assert "--markers led" in capsys.readouterr().err


def test_another_person_than_there_is_is_told(joints_file, tmp_path, capsys):
    words = ["movement", str(joints_file), "--person", "3", "--out", str(tmp_path / "m.pdf")]
    assert main(words) == 1
    assert "Choose one of: 1." in capsys.readouterr().err


def test_of_several_people_the_one_seen_longest_is_taken_and_it_is_said(tmp_path, capsys):
    path = tmp_path / "two.joints.csv"
    short = bending(n_frames=30)
    other = type(short)(short.timestamps_ns + 7, short.joints_m, short.confidence, 1)
    long = bending()
    write_joints_csv(
        path, [other, type(long)(long.timestamps_ns, long.joints_m, long.confidence, 2)]
    )
    assert main(["movement", str(path), "--out", str(tmp_path / "m.csv")]) == 0
    assert "of person 2" in capsys.readouterr().err


def test_a_name_that_is_no_report_is_refused_before_the_work(joints_file, tmp_path, capsys):
    assert main(["movement", str(joints_file), "--out", str(tmp_path / "m.doc")]) == 1
    assert ".c3d" in capsys.readouterr().err
    assert not (tmp_path / "m.doc").exists()


def test_a_table_that_tells_the_vertical_gives_the_angles_against_it(tmp_path, capsys):
    plain, told = tmp_path / "plain.joints.csv", tmp_path / "told.joints.csv"
    angle_rad = np.radians(12.0)
    up = np.array([0.0, -np.cos(angle_rad), -np.sin(angle_rad)])
    write_joints_csv(plain, [bending()], "markerless")
    write_joints_csv(told, [bending()], "markerless", up)
    found = {}
    for path in (plain, told):
        assert main(["movement", str(path), "--json", "--out", str(tmp_path / "m.csv")]) == 0
        said = capsys.readouterr()
        document = json.loads(said.out)
        found[path] = {one["angle"]: one["greatest_deg"] for one in document["ranges"]}
        assert document["vertical_measured"] == (path == told)
        assert ("vertical is not measured" in said.err) == (path == plain)
    assert "trunk_flexion" not in found[plain]
    straight = joint_angles(bending().joints_m[0], up)["trunk_flexion"]
    assert found[told]["trunk_flexion"] == pytest.approx(np.degrees(straight), abs=0.1)
    assert abs(found[told]["trunk_flexion"]) > 5.0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--markers", "led"], "--markers"),
        (["--markerless", "--view", "anterior"], "--markerless, --view"),
        (["--calibration", "c.json"], "--calibration"),
    ],
)
def test_what_a_table_has_no_use_for_is_refused(words, told, joints_file, tmp_path, capsys):
    out = tmp_path / "m.csv"
    assert main(["movement", str(joints_file), *words, "--out", str(out)]) == 1
    assert f"has no use for {told}." in capsys.readouterr().err
    assert not out.exists()


def test_a_person_is_not_chosen_where_markers_are_measured(recording, tmp_path, capsys):
    words = ["--markers", "led", "--person", "2", "--out", str(tmp_path / "m.csv")]
    assert main(["movement", str(recording), *words]) == 1
    assert "no use for --person" in capsys.readouterr().err


def refused(scene, words, tmp_path, capsys):
    """Record one frame; return what the command says when it measures nothing."""
    path, out = tmp_path / "one.mcap", tmp_path / "m.xlsx"
    with create_recording(path, scene.info) as writer:
        writer.write(scene.frame(0).sensor_frame)
    assert main(["movement", str(path), "--markers", "led", *words, "--out", str(out)]) == 1
    assert not out.exists()
    return capsys.readouterr().err


def test_markers_that_have_no_name_are_told_from_none_at_all(tmp_path, capsys):
    """From the side a single frame is named by the body that its depth shows, or not at all."""
    markers = MarkerSettings(JOINT_NAMES, kind="led", diameter_m=0.005)
    aside = open_scene(
        "left_lateral_led", 7, markers=markers, distance_m=2.8, color_size=(480, 640)
    )
    assert "Say with --view which side" in refused(aside, [], tmp_path, capsys)
    none = MarkerSettings((), kind="led")
    bare = open_scene("anterior_led", 7, markers=none, distance_m=2.8, color_size=(480, 640))
    assert "No marker was found" in refused(bare, ["--view", "anterior"], tmp_path, capsys)


def test_a_declared_view_in_which_no_name_is_sure_is_doubted(tmp_path, capsys):
    """One marker is too few for any name."""
    markers = MarkerSettings(("left_shoulder",), kind="led", diameter_m=0.005)
    one = open_scene("anterior_led", 7, markers=markers, distance_m=2.8, color_size=(480, 640))
    told = refused(one, ["--view", "anterior"], tmp_path, capsys)
    assert "that --view is the side that is seen" in told


def test_a_view_from_the_side_is_refused_without_markers(recording, tmp_path, capsys):
    words = ["--markerless", "--view", "right_lateral", "--out", str(tmp_path / "m.csv")]
    assert main(["movement", str(recording), *words]) == 1
    assert "leave --view out" in capsys.readouterr().err
