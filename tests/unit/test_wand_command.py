"""A known length between two markers, from a recording through the command line."""

import json

import numpy as np
import pytest

from adibas.cli import main
from adibas.pipeline.learning import LearningRequest, learn_from_file
from adibas.recordings import create_recording
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import open_scene

ENDS = ("left_asis", "right_asis")


def recorded(folder, name, names):
    """Record somebody with these markers; return the file and the truth of the first frame."""
    scene = open_scene("anterior", seed=7, markers=MarkerSettings(names, diameter_m=0.015))
    path = folder / f"{name}.mcap"
    with create_recording(path, scene.info) as writer:
        frames = [scene.frame(index) for index in range(6)]
        for frame in frames:
            writer.write(frame.sensor_frame)
    return path, frames[0].truth.markers


@pytest.fixture(scope="module")
def wand(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wand")
    path, markers = recorded(folder, "wand", ENDS)
    clicks = tuple((marker.u, marker.v) for marker in markers)
    learn_from_file(LearningRequest(path, clicks), folder / "green.json")
    length_m = float(np.linalg.norm(markers[0].position_m - markers[1].position_m))
    return path, str(folder / "green.json"), 1000.0 * length_m


def told(wand, length_mm, *more):
    path, colors, _ = wand
    return ["wand", str(path), "--length-mm", f"{length_mm}", "--markers", colors, *more]


def test_a_wand_of_the_true_length_passes(wand, capsys):
    length_mm = wand[2]
    assert main(told(wand, length_mm, "--json")) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["result"] == "passed"
    assert document["measured_mm"] == pytest.approx(length_mm, abs=5.0)
    assert document["error_mm"] == pytest.approx(document["measured_mm"] - length_mm)
    low, high = document["ci95_mm"]
    assert low < document["measured_mm"] < high


def test_a_wand_of_another_length_fails_and_says_how_far_off(wand, capsys):
    length_mm = wand[2] + 30.0
    assert main(told(wand, length_mm)) == 1
    said = capsys.readouterr().out
    assert f"The wand of {length_mm:.1f} mm measures" in said
    assert "calibrate again" in said
    assert main(told(wand, length_mm, "--tolerance-mm", "40")) == 0


def test_more_than_two_markers_are_no_wand(wand, tmp_path, capsys):
    path, _ = recorded(tmp_path, "three", (*ENDS, "sternal_notch"))
    assert main(told((path, wand[1], 0.0), 200.0)) == 1
    assert "Markers that are seen: 3, and a wand has two." in capsys.readouterr().err


def test_a_wand_needs_its_length(wand, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["wand", str(wand[0]), "--markers", wand[1]])
    assert stopped.value.code == 2
    assert "--length-mm" in capsys.readouterr().err
