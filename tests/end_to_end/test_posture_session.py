"""A whole posture session through the command line: the files, and the same numbers in each."""

import csv
import itertools
import json
from dataclasses import replace
from zipfile import ZipFile

import cv2
import numpy as np
import openpyxl
import pytest
from pypdf import PdfReader
from scipy.stats import chi2

from adibas.calibration.files import write_calibration
from adibas.cli import main
from adibas.data.calibration import DepthBias
from adibas.pipeline import demo as demo_session
from adibas.recordings import create_recording, open_recording
from adibas.simulation.scenes import open_scene

SHEETS = ["Summary", "Markers", "Distances", "Angles", "Provenance"]
TRUTH_TOLERANCE_M = 0.004
RMS_TOLERANCE_M = 0.0035
"""Three frames at 2 m: the depth of a marker is sure to 2.5 to 3 mm."""
ONCE_IN = 1e-3
LIMITS = ("ci95_low_instrument_only", "ci95_high_instrument_only")


@pytest.fixture
def posture(demo, capsys):
    """Run `adibas posture --json` on the demo's recording; give the document."""

    def run(out, *arguments):
        argv = ["posture", str(demo.recording), "--markers", str(demo.colors), "--out", str(out)]
        assert main([*argv, "--json", *map(str, arguments)]) == 0
        return json.loads(capsys.readouterr().out)

    return run


def numbers(document):
    """What was measured: everything but the time of day."""
    return {key: document[key] for key in ("markers", "distances", "angles", "measures")}


def table(workbook, sheet):
    rows = workbook[sheet].iter_rows(values_only=True)
    next(rows)
    return list(rows)


def test_the_demo_leaves_recording_colours_and_report(demo):
    assert {path.name for path in demo.folder.iterdir()} == {
        "recording.mcap",
        "colours.json",
        "colours.preview.png",
        "report.xlsx",
        "report.pdf",
        "store",
    }
    assert demo.said["report"] == str(demo.report)
    assert openpyxl.load_workbook(demo.report).sheetnames == SHEETS
    printed = PdfReader(demo.said["report_pdf"])
    assert "demo-patient" in printed.pages[0].extract_text()
    assert "m01" in printed.pages[1].extract_text()
    with open_recording(demo.recording) as recording:
        assert len(recording) == demo.said["posture"]["n_frames"] == demo.n_frames


def test_the_demo_may_be_run_again_but_replaces_no_other_recording(demo, tmp_path, capsys):
    other = tmp_path / "recording.mcap"
    other.write_bytes(b"a session")
    assert main(["demo", "--out", str(tmp_path)]) == 1
    assert "no demo" in capsys.readouterr().err
    assert other.read_bytes() == b"a session"
    other.write_bytes(demo.recording.read_bytes())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(demo_session, "N_FRAMES", 1)
        assert main(["demo", "--out", str(tmp_path)]) == 0


def test_the_same_numbers_stand_in_json_csv_and_excel(posture, tmp_path):
    document = posture(tmp_path / "report.csv", "--out", tmp_path / "report.xlsx")
    workbook = openpyxl.load_workbook(tmp_path / "report.xlsx")
    with (tmp_path / "report.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))

    in_json = [(d["a"], d["b"], d["mm"], *d["ci95_mm"]) for d in document["distances"]]
    in_csv = [
        (row["a"], row["b"], *(float(row[key]) for key in ("value", *LIMITS)))
        for row in rows
        if row["quantity"] == "distance"
    ]
    assert in_csv == in_json
    # Excel keeps 15-17 digits.
    for (*names, mm, low, high), row in zip(in_json, table(workbook, "Distances"), strict=True):
        assert list(row[:2]) == names
        assert row[2:5] == pytest.approx((mm, low, high), rel=1e-12)

    in_json = [(a["a"], a["vertex"], a["c"], a["deg"]) for a in document["angles"]]
    in_csv = [
        (row["a"], row["vertex"], row["b"], float(row["value"]))
        for row in rows
        if row["quantity"] == "angle"
    ]
    assert in_csv == in_json
    for (*names, deg), row in zip(in_json, table(workbook, "Angles"), strict=True):
        assert list(row[:3]) == names
        assert row[3] == pytest.approx(deg, rel=1e-12)

    depths_m = [marker["position_m"] and marker["position_m"][2] for marker in document["markers"]]
    in_csv = [float(row["value"]) / 1000 if row["value"] else None for row in rows if is_depth(row)]
    assert in_csv == pytest.approx(depths_m, rel=1e-12)


def is_depth(row):
    return (row["quantity"], row["unit"]) == ("z", "mm")


def test_every_pair_and_triplet_of_measured_markers_is_there(demo):
    posture = demo.said["posture"]
    labels = [marker["label"] for marker in posture["markers"] if marker["position_m"]]
    pairs = {frozenset((d["a"], d["b"])) for d in posture["distances"]}
    corners = {(frozenset((a["a"], a["c"])), a["vertex"]) for a in posture["angles"]}
    assert len(labels) >= 10
    assert pairs == set(map(frozenset, itertools.combinations(labels, 2)))
    assert len(corners) == len(posture["angles"]) == len(pairs) * (len(labels) - 2)


def test_the_markers_lie_where_the_simulator_put_them_as_surely_as_is_stated(demo):
    scene = open_scene(demo_session.SCENE, seed=demo_session.SEED)
    truth = scene.frame(demo.n_frames // 2).truth.markers
    true_m = np.array([marker.position_m for marker in truth])
    errors_m, deviations = [], []
    for marker in demo.said["posture"]["markers"]:
        if marker["position_m"] is not None:
            off_m = true_m - marker["position_m"]
            error_m = off_m[np.linalg.norm(off_m, axis=1).argmin()]
            errors_m.append(error_m)
            deviations.append(error_m @ np.linalg.solve(marker["covariance_m2"], error_m))
    assert np.sqrt(np.mean(np.sum(np.square(errors_m), axis=1))) < RMS_TOLERANCE_M
    assert max(deviations) < chi2.isf(ONCE_IN, df=3)


def test_each_marker_of_the_demo_as_it_is_run_lies_where_the_simulator_put_it(tmp_path):
    found = demo_session.run_demo(tmp_path, lambda _done, _all: None).analysis.markers
    scene = open_scene(demo_session.SCENE, seed=demo_session.SEED)
    truth = scene.frame(demo_session.N_FRAMES // 2).truth.markers
    true_m = np.array([marker.position_m for marker in truth])
    placed_m = [marker.position_m for marker in found if marker.position_m is not None]
    assert len(placed_m) >= 10
    for place_m in placed_m:
        assert np.linalg.norm(true_m - place_m, axis=1).min() < TRUTH_TOLERANCE_M


def test_the_same_recording_gives_the_same_numbers(demo, posture, tmp_path):
    document = posture(tmp_path / "report.xlsx")
    assert numbers(document) == numbers(demo.said["posture"])
    said, again = demo.said["posture"]["provenance"], document["provenance"]
    assert again["recording_sha256"] == said["recording_sha256"]
    assert again["calibration"] == said["calibration"]
    assert again["parameters"] == said["parameters"]


def test_frames_and_view_are_those_asked_for(posture, tmp_path):
    document = posture(tmp_path / "report.xlsx", "--frames", "0:1", "--view", "left_lateral")
    assert (document["n_frames"], document["view"]) == (1, "left_lateral")
    summary = dict(
        row[:2]
        for row in openpyxl.load_workbook(tmp_path / "report.xlsx")["Summary"].iter_rows(
            values_only=True
        )
    )
    assert summary["View"] == "left lateral"
    assert summary["Frames in the burst"] == 1


def test_another_calibration_takes_the_place_of_the_recordings_own(demo, posture, tmp_path):
    with open_recording(demo.recording) as recording:
        own = recording.info.calibration
    bias = own.depth_bias
    moved = replace(own, depth_bias=DepthBias(bias.a + 0.1, bias.b, bias.c))
    write_calibration(tmp_path / "own.json", own)
    write_calibration(tmp_path / "moved.json", moved)
    said = demo.said["posture"]

    document = posture(tmp_path / "a.csv", "--calibration", tmp_path / "own.json")
    assert numbers(document) == numbers(said)
    assert document["provenance"]["calibration"] == said["provenance"]["calibration"]

    document = posture(tmp_path / "b.csv", "--calibration", tmp_path / "moved.json")
    assert document["provenance"]["calibration"] != said["provenance"]["calibration"]
    depth_m, moved_m = (
        np.median([m["position_m"][2] for m in found["markers"] if m["position_m"]])
        for found in (said, document)
    )
    assert moved_m - depth_m == pytest.approx(0.1, abs=0.02)


def test_a_rotation_says_where_up_is_for_a_sensor_on_its_side_that_does_not(demo, tmp_path, capsys):
    scene = open_scene("anterior", mounting="portrait")
    calibration = replace(scene.info.calibration, gravity=None, floor=None)
    recording, report = tmp_path / "portrait.mcap", tmp_path / "report.xlsx"
    with create_recording(recording, replace(scene.info, calibration=calibration)) as writer:
        for number in range(2):
            writer.write(scene.frame(number).sensor_frame)
    command = ["posture", str(recording), "--markers", str(demo.colors), "--view", "anterior"]
    command += ["--protocol", "joints-15", "--out", str(report), "--json"]
    assert main(command) == 1
    assert "Nobody is seen" in capsys.readouterr().err
    assert main([*command, "--rotation", "90"]) == 0
    document = json.loads(capsys.readouterr().out)
    right_m = {one["label"]: one["position_m"] for one in document["markers"]}
    # The camera's x points down and its y to the left of who looks.
    assert right_m["head"][0] < right_m["neck"][0] < right_m["left_hip"][0]
    assert right_m["right_shoulder"][1] > right_m["left_shoulder"][1]
    with ZipFile(report) as parts:
        (name,) = (one for one in parts.namelist() if one.startswith("xl/media/"))
        height, width = cv2.imdecode(np.frombuffer(parts.read(name), np.uint8), 1).shape[:2]
    assert height > width
