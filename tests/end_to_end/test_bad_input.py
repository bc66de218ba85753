"""Bad input: one sentence on stderr, exit code 1, no half-written file and no lost recording."""

import contextlib
import json
import math
import os
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from adibas.body.mask import find_body
from adibas.calibration.files import write_calibration
from adibas.cli import main
from adibas.data.calibration import CameraCalibration
from adibas.data.frames import depth_in_metres
from adibas.geometry.pinhole import project
from adibas.recordings import RecordingOptions, create_recording, open_recording
from adibas.recordings.decoding import to_rgbd
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import open_scene

PROJECT = Path(__file__).parents[2]
OLDER = b"an older report"


def fails(capsys, *argv):
    """Run a command that must fail, in a sentence of its own, and return the sentence."""
    capsys.readouterr()
    assert main([str(word) for word in argv]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1, captured.err
    assert captured.err.endswith(".\n")
    assert "{" not in captured.err
    return captured.err.strip()


@pytest.fixture
def refused(demo, capsys, tmp_path):
    """Analyse something bad; an older report must stay, and no file must come or go."""

    def run(recording=demo.recording, markers=demo.colors, *arguments):
        folder = tmp_path / "reports"
        folder.mkdir()
        (folder / "report.xlsx").write_bytes(OLDER)
        words = ["posture", recording, "--markers", markers, "--out", folder / "report.xlsx"]
        sentence = fails(capsys, *words, *arguments)
        assert [path.read_bytes() for path in folder.iterdir()] == [OLDER]
        return sentence

    return run


@pytest.fixture
def changed(demo, tmp_path):
    """Write the demo's recording again with other frames or another header."""

    def rewrite(change=lambda frame: frame, change_info=lambda info: info):
        path = tmp_path / "changed.mcap"
        options = RecordingOptions(is_live=False)
        with open_recording(demo.recording) as recording:
            info = change_info(recording.info)
            with create_recording(path, info, options) as writer:
                for frame in recording:
                    writer.write(change(frame))
        return path

    return rewrite


@pytest.fixture
def calibration(demo):
    with open_recording(demo.recording) as recording:
        return recording.info.calibration


def no_recording(kind, demo, folder):
    path = folder / f"{kind}.mcap"
    if kind == "text":
        path.write_text("no recording")
    elif kind == "picture":
        shutil.copy(demo.folder / "colours.preview.png", path)
    elif kind == "empty":
        path.touch()
    elif kind == "folder":
        path.mkdir()
    elif kind == "beginning":
        path.write_bytes(demo.recording.read_bytes()[:300])
    return path


@pytest.mark.parametrize("command", ["posture", "convert", "record", "markers learn"])
@pytest.mark.parametrize("kind", ["missing", "text", "picture", "empty", "folder", "beginning"])
def test_what_is_no_recording_is_refused_by_every_command(kind, command, demo, tmp_path, capsys):
    path = no_recording(kind, demo, tmp_path)
    before = sorted(tmp_path.iterdir())
    argv = {
        "posture": ["--markers", demo.colors, "--out", tmp_path / "r.xlsx"],
        "convert": [tmp_path / "b.mcap"],
        "record": ["--out", tmp_path / "b.mcap"],
        "markers learn": ["--seed", "3,3", "--out", tmp_path / "c.json"],
    }
    assert path.name in fails(capsys, *command.split(), path, *argv[command])
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("name", [".", "..", "a" * 300])
def test_strange_names_are_refused_in_words(name, demo, refused):
    assert name in refused(name, demo.colors)


def test_a_cut_recording_gives_its_whole_frames_and_a_notice(demo, tmp_path, capsys):
    path = tmp_path / "cut.mcap"
    path.write_bytes(demo.recording.read_bytes()[:-500_000])
    out = tmp_path / "r.csv"
    argv = ["posture", path, "--markers", demo.colors, "--out", out, "--json"]
    assert main([str(word) for word in argv]) == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert 1 <= document["n_frames"] < demo.n_frames
    assert document["notices"][0] in captured.err
    assert "is cut" in captured.err


def test_markers_where_the_depth_gives_no_position_are_named(
    changed, calibration, demo, tmp_path, capsys
):
    argv = ["--markers", str(demo.colors), "--out", str(tmp_path / "r.csv"), "--json"]
    assert main(["posture", str(demo.recording), *argv]) == 0
    captured = capsys.readouterr()
    first = json.loads(captured.out)["markers"][0]
    assert "The depth gives no position" not in captured.err
    place_m = calibration.color_from_depth.inverse().apply(np.array(first["position_m"]))
    column, row = project(place_m, calibration.depth.intrinsics)

    def with_hole(frame):
        depth_raw = frame.depth_raw.copy()
        cv2.circle(depth_raw, (round(float(column)), round(float(row))), 14, 0, -1)
        return replace(frame, depth_raw=depth_raw)

    assert main(["posture", str(changed(with_hole)), *argv]) == 0
    captured = capsys.readouterr()
    unplaced = [one for one in json.loads(captured.out)["markers"] if one["position_m"] is None]
    assert [one["label"] for one in unplaced] == [first["label"]]
    assert f"The depth gives no position of {first['label']}: no distance" in captured.err


@pytest.mark.parametrize("command", ["posture", "pose", "limbs segment", "map", "body", "movement"])
def test_a_recording_cut_within_its_first_frame_is_told_by_its_name(
    command, demo, tmp_path, capsys
):
    path = tmp_path / "cut.mcap"
    path.write_bytes(demo.recording.read_bytes()[:4096])
    given = {"body": f"posterior={path}"}.get(command, path)
    markers = ["--markers", demo.colors] if command in ("posture", "movement") else []
    out = tmp_path / {"map": "b.ply", "body": "b.ply", "limbs segment": "b"}.get(command, "b.csv")
    told = fails(capsys, *command.split(), given, *markers, "--out", out)
    assert told == "cut.mcap holds no whole frame. Record the session again."
    assert sorted(tmp_path.iterdir()) == [path]


def test_frames_that_a_recording_has_not_are_told_with_those_it_has(demo, tmp_path, capsys):
    out = tmp_path / "joints.csv"
    told = fails(capsys, "pose", demo.recording, "--frames", "5000:", "--out", out)
    assert f"recording.mcap has {demo.n_frames} frames, so frames 5000: cannot be read" in told
    assert not out.exists()


@pytest.mark.parametrize(
    ("lost", "word"),
    [
        ({"depth_raw": None}, "no depth"),
        ({"color": None, "color_timestamp_ns": None}, "no colour"),
    ],
)
def test_a_recording_without_one_kind_of_image(lost, word, changed, demo, refused):
    assert word in refused(changed(lambda frame: replace(frame, **lost)), demo.colors)


def test_a_recording_without_calibration(changed, demo, refused):
    path = changed(change_info=lambda info: replace(info, calibration=None))
    assert "--calibration" in refused(path, demo.colors)


def other_size(camera):
    return CameraCalibration(camera.width // 2, camera.height // 2, camera.intrinsics)


@pytest.mark.parametrize("camera", ["color", "depth"])
def test_a_calibration_for_another_resolution(camera, calibration, demo, refused, tmp_path):
    other = replace(calibration, **{camera: other_size(getattr(calibration, camera))})
    write_calibration(tmp_path / "other.json", other)
    said = refused(demo.recording, demo.colors, "--calibration", tmp_path / "other.json")
    assert "resolution" in said
    assert f"{calibration.color.width if camera == 'color' else calibration.depth.width}x" in said


@pytest.mark.parametrize("camera", ["color", "depth"])
def test_a_calibration_of_one_camera(camera, calibration, demo, refused, tmp_path):
    write_calibration(tmp_path / "one.json", replace(calibration, **{camera: None}))
    said = refused(demo.recording, demo.colors, "--calibration", tmp_path / "one.json")
    assert "need both cameras" in said


@pytest.mark.parametrize("content", [b"", b"{", b"\xff\x00", b"{}", b"[]", b"fx: 500"])
def test_a_file_that_is_no_calibration(content, demo, refused, tmp_path):
    (tmp_path / "bad.json").write_bytes(content)
    assert "bad.json" in refused(
        demo.recording, demo.colors, "--calibration", tmp_path / "bad.json"
    )


def colors_file(path, centroid, threshold):
    document = {"format": "adibas-colours", "version": 1, "centroids_lab": [centroid]}
    path.write_text(json.dumps({**document, "threshold": threshold, "source": {}}))
    return path


@pytest.mark.parametrize(
    ("centroid", "threshold", "word"),
    [
        ([50, 0, 0], 300, "fits too much of the body"),
        ([50, 100, -100], 1, "No marker was found"),
    ],
)
def test_colours_of_everything_and_of_nothing(centroid, threshold, word, demo, refused, tmp_path):
    colors = colors_file(tmp_path / "colours.json", centroid, threshold)
    assert word in refused(demo.recording, colors)


@pytest.mark.parametrize(
    "content", ["", "{}", "[1]", "null", '{"format": "adibas-colours", "version": 1}']
)
def test_a_file_without_colours(content, demo, refused, tmp_path):
    (tmp_path / "bad.json").write_text(content)
    assert "adibas markers learn" in refused(demo.recording, tmp_path / "bad.json")


def test_led_markers_in_a_bright_picture(demo, refused):
    assert "too bright" in refused(demo.recording, "led")


@pytest.mark.parametrize("frames", ["1:9", "5:", "7:9"])
def test_frames_that_the_recording_has_not(frames, demo, refused):
    said = refused(demo.recording, demo.colors, "--frames", frames)
    assert f"frames {frames} " in said
    assert "0:3" in said


def record_scene(path, name, **changes):
    scene = open_scene(name, seed=7, jpeg_quality=95, **changes)
    with create_recording(path, scene.info) as writer:
        writer.write(scene.frame(0).sensor_frame)
    return path


def test_nobody_in_the_room(demo, refused, tmp_path):
    path = record_scene(tmp_path / "empty.mcap", "empty")
    assert "Nobody is seen" in refused(path, demo.colors)


def test_a_single_marker(demo, refused, tmp_path):
    markers = MarkerSettings(("sternal_notch",))
    path = record_scene(tmp_path / "one.mcap", "anterior", markers=markers)
    assert "Only one marker" in refused(path, demo.colors)


def test_a_patient_out_of_the_depth_range(changed, demo, refused):
    path = changed(lambda frame: replace(frame, depth_raw=np.zeros_like(frame.depth_raw)))
    assert "Nobody is seen" in refused(path, demo.colors)


def beyond_a_column(place):
    """Return the pixels left of a place of the depth image, and the place itself."""
    blind = np.zeros((480, 640), bool)
    blind[:, : int(place[0]) + 2] = True
    return blind


def around(place):
    """Return the pixels within 13 of a place, 45 mm at 2 m."""
    rows, columns = np.indices((480, 640))
    return (rows - place[1]) ** 2 + (columns - place[0]) ** 2 < 13**2


@pytest.mark.parametrize("blind_marker", [(beyond_a_column, 7), (around, 1)])
def test_a_marker_that_the_depth_camera_does_not_see_is_listed_without_a_position(
    blind_marker, demo, changed, calibration, tmp_path, capsys
):
    blind, which = blind_marker
    marker = demo.said["posture"]["markers"][which]
    depth_from_color = calibration.color_from_depth.inverse()
    place_m = depth_from_color.apply(np.array(marker["position_m"]))
    is_blind = blind(project(place_m, calibration.depth.intrinsics))

    def blinded(frame):
        return replace(frame, depth_raw=np.where(is_blind, np.uint16(0), frame.depth_raw))

    argv = ["posture", changed(blinded), "--markers", demo.colors, "--out", tmp_path / "r.xlsx"]
    assert main([*map(str, argv), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    there = (marker["u"], marker["v"])
    (listed,) = (m for m in document["markers"] if math.dist((m["u"], m["v"]), there) < 1)
    assert listed["position_m"] is None
    assert listed["covariance_m2"] is None
    named = {name for d in document["distances"] for name in (d["a"], d["b"])}
    assert listed["label"] not in named


def test_two_markers_of_which_one_has_a_position(demo, changed, calibration, refused):
    markers = demo.said["posture"]["markers"]
    depth_from_color = calibration.color_from_depth.inverse()
    places = [
        project(depth_from_color.apply(np.array(m["position_m"])), calibration.depth.intrinsics)
        for m in markers[1:]
    ]
    is_blind = np.logical_or.reduce([around(place) for place in places])
    path = changed(
        lambda frame: replace(frame, depth_raw=np.where(is_blind, np.uint16(0), frame.depth_raw))
    )
    said = refused(path, demo.colors)
    assert "gives a position to" in said
    assert "Only one" not in said


@pytest.fixture
def measured(demo, tmp_path, capsys):
    """Analyse a recording; return the document, and what was told beside it."""

    def run(path):
        argv = ["posture", path, "--markers", demo.colors, "--out", tmp_path / "r.xlsx", "--json"]
        capsys.readouterr()
        assert main([str(word) for word in argv]) == 0
        captured = capsys.readouterr()
        return json.loads(captured.out), captured.err

    return run


@pytest.fixture
def with_a_second_one(calibration):
    """Show the patient twice in a frame, side by side."""

    def twice(frame):
        depth_m = calibration.corrected_depth(depth_in_metres(frame.depth_raw, 0.001))
        pixels = find_body(depth_m, calibration.depth, calibration.floor).pixels
        rows, columns = np.nonzero(pixels)
        whole = (columns + 200 < 640) & (rows < 440)
        depth_raw = frame.depth_raw.copy()
        rows, columns = rows[whole], columns[whole]
        depth_raw[rows, columns + 200] = frame.depth_raw[rows, columns]
        return replace(frame, depth_raw=depth_raw)

    return twice


def test_of_two_people_the_larger_one_is_measured_and_that_is_told(
    demo, changed, with_a_second_one, measured
):
    document, told = measured(changed(with_a_second_one))
    assert any("Several people are seen" in notice for notice in document["notices"])
    assert "Several people are seen" in told
    assert len(document["markers"]) == len(demo.said["posture"]["markers"])
    assert not demo.said["posture"]["notices"]


def painted(frame, info, *places):
    """Return the frame with stickers of the markers' colour at pixels (u, v)."""
    color_rgb = np.ascontiguousarray(to_rgbd(frame, info).color_rgb).copy()
    for u, v in places:
        place = (round(16 * u), round(16 * v))
        cv2.circle(color_rgb, place, 35, (40, 95, 40), -1, cv2.LINE_AA, 4)
    return replace(frame, color=color_rgb)


def refusals(document):
    return [(one["reason"], round(one["u"]), round(one["v"])) for one in document["rejected"]]


def test_a_sticker_on_the_wall_is_no_marker_and_that_is_told(demo, changed, measured):
    with open_recording(demo.recording) as recording:
        info = recording.info
    document, told = measured(changed(lambda frame: painted(frame, info, (200, 200))))
    assert "Not counted as a marker (1): not on the patient." in told
    assert ("not on the patient", 200, 200) in refusals(document)
    assert len(document["markers"]) == len(demo.said["posture"]["markers"])


def test_two_stickers_that_overlap_are_no_marker_between_them(demo, changed, measured):
    with open_recording(demo.recording) as recording:
        info = recording.info
    marker = demo.said["posture"]["markers"][5]
    u, v = marker["u"], marker["v"]
    two = changed(lambda frame: painted(frame, info, (u, v), (u + 4, v)))
    document, _told = measured(two)
    ((reason, found_u, found_v),) = refusals(document)
    assert reason == "as long as two markers side by side"
    assert math.dist((found_u, found_v), (u + 2, v)) < 2
    labels = [one["label"] for one in document["markers"]]
    assert len(labels) == len(demo.said["posture"]["markers"]) - 1
    assert labels == [f"m{number:02d}" for number in range(1, len(labels) + 1)]


@pytest.fixture
def notices_of_movement(demo, tmp_path, capsys):
    """Measure the movement of a recording; return what is told of it."""

    def run(recording):
        words = ["movement", recording, "--markers", demo.colors, "--view", "anterior", "--json"]
        capsys.readouterr()
        assert main([str(word) for word in (*words, "--out", tmp_path / "m.csv")]) == 0
        return " ".join(json.loads(capsys.readouterr().out)["notices"])

    return run


def test_a_movement_says_in_how_many_frames_several_people_are_seen(
    demo, changed, with_a_second_one, notices_of_movement
):
    assert "Several people" not in notices_of_movement(demo.recording)
    told = notices_of_movement(changed(with_a_second_one))
    assert "Several people are seen" in told
    assert f"(In {demo.n_frames} of {demo.n_frames} frames.)" in told


def test_a_movement_is_not_measured_on_two_stickers_that_overlap(
    demo, changed, notices_of_movement
):
    with open_recording(demo.recording) as recording:
        info = recording.info
    marker = demo.said["posture"]["markers"][5]
    u, v = marker["u"], marker["v"]
    told = notices_of_movement(changed(lambda frame: painted(frame, info, (u, v), (u + 4, v))))
    assert "as long as two markers side by side" in told
    assert "as long as two" not in notices_of_movement(demo.recording)


@pytest.mark.parametrize("how", [("--markers", "led"), ("--markerless",)])
def test_a_movement_refuses_a_calibration_that_is_too_old(how, calibration, demo, tmp_path, capsys):
    write_calibration(tmp_path / "old.json", replace(calibration, created_utc="2020-01-01"))
    words = ["movement", demo.recording, *how, "--calibration", tmp_path / "old.json"]
    words += ["--oldest-calibration", 30, "--out", tmp_path / "m.csv"]
    assert "at most 30 are allowed" in fails(capsys, *words)


def test_the_age_of_a_calibration_is_not_asked_of_a_table(tmp_path, capsys):
    words = ["movement", tmp_path / "joints.csv", "--oldest-calibration", 30]
    said = fails(capsys, *words, "--out", tmp_path / "m.csv")
    assert "does not say when the sensor was calibrated" in said


@pytest.mark.parametrize("name", ["report.txt", "report", "report.docx", "."])
def test_a_report_of_another_kind(name, demo, tmp_path, capsys):
    argv = ["posture", demo.recording, "--markers", demo.colors, "--out", tmp_path / name]
    assert ".xlsx" in fails(capsys, *argv)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["file as folder", "folder as file", "read-only"])
def test_a_place_that_cannot_be_written(kind, demo, tmp_path, capsys, monkeypatch):
    place = tmp_path / "place"
    out = place / "r.xlsx"
    if kind == "file as folder":
        place.write_bytes(OLDER)
    elif kind == "folder as file":
        out.mkdir(parents=True)
    else:
        place.mkdir()
        monkeypatch.setattr(os, "access", lambda *_: False)
    learn = ["markers", "learn", demo.recording, "--seed", "3,3", "--out"]
    for command in (
        ["posture", demo.recording, "--markers", demo.colors, "--out", out],
        ["record", demo.recording, "--out", out.with_suffix(".mcap")],
        [*learn, out.with_suffix(".json")],
    ):
        if kind == "folder as file":
            Path(command[-1]).mkdir(exist_ok=True)
        before = sorted(tmp_path.rglob("*"))
        assert out.stem in fails(capsys, *command)
        assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(("image", "out"), [("a.png", "a.png"), ("c.preview.png", "c.json")])
def test_learning_does_not_overwrite_its_picture(image, out, demo, tmp_path, capsys):
    shutil.copy(demo.folder / "colours.preview.png", tmp_path / image)
    before = (tmp_path / image).read_bytes()
    fails(capsys, "markers", "learn", tmp_path / image, "--seed", "3,3", "--out", tmp_path / out)
    assert (tmp_path / image).read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == [image]


def test_learning_from_half_the_picture_is_quick_and_told(demo, tmp_path, capsys):
    argv = ["markers", "learn", demo.recording, "--seed", "3,3", "--sensitivity", "300"]
    assert main([*map(str, argv), "--out", str(tmp_path / "c.json")]) == 0
    assert "cover 100 % of the picture" in capsys.readouterr().err


def test_a_recording_is_not_replaced_by_a_conversion_unless_asked(demo, tmp_path, capsys):
    target = tmp_path / "earlier.mcap"
    target.write_bytes(b"an earlier recording")
    assert "--overwrite" in fails(capsys, "convert", demo.recording, target)
    assert target.read_bytes() == b"an earlier recording"
    assert main(["convert", str(demo.recording), str(target), "--overwrite"]) == 0
    with open_recording(target) as recording:
        assert len(recording) > 0


def test_a_recording_is_not_converted_into_itself(demo, tmp_path, capsys):
    path = tmp_path / "a.mcap"
    shutil.copy(demo.recording, path)
    (tmp_path / "b.mcap").symlink_to(path)
    for target in (path, tmp_path / "b.mcap", tmp_path / ".." / tmp_path.name / "a.mcap"):
        assert "into itself" in fails(capsys, "convert", path, target, "--overwrite")
    assert path.read_bytes() == demo.recording.read_bytes()


# The command line in a process of its own, which tells its progress and then waits for its fate.
COMMAND_LINE = """
import resource, sys, time
from contextlib import contextmanager
from adibas import files
from adibas.cli import console, main

at, most_bytes = sys.argv[1], int(sys.argv[2])

def limit():
    if most_bytes:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

def flush(path):
    if at == "writing":
        print("now", flush=True)
        time.sleep(60)

@contextmanager
def progress(self, label):
    def advance(done, total):
        if at == "working" and done >= 2:
            print("now", flush=True)
            time.sleep(60)
        elif at == "recording" and done >= 2:
            print("now", flush=True)
    if label in ("Recording", "Converting"):
        limit()
    yield advance
    limit()

files._flush_to_disk = flush
console.Console.progress = progress
sys.exit(main(sys.argv[3:]))
"""


@contextlib.contextmanager
def command_line(*argv, at="nowhere", most_bytes=0):
    words = [sys.executable, "-c", COMMAND_LINE, at, str(most_bytes), *map(str, argv)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    # Under the limit of a full disk byte code would be cut, and stay so for everybody.
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    with subprocess.Popen(words, cwd=PROJECT, env=environment, **pipes) as process:
        try:
            yield process
        finally:
            process.kill()


@pytest.mark.parametrize(
    ("number", "at"), [(signal.SIGINT, "working"), (signal.SIGTERM, "writing")]
)
def test_an_analysis_that_is_stopped_leaves_the_older_report(number, at, demo, tmp_path):
    out = tmp_path / "report.xlsx"
    out.write_bytes(OLDER)
    argv = ["posture", demo.recording, "--markers", demo.colors, "--out", out]
    with command_line(*argv, at=at) as process:
        assert process.stdout.readline() == "now\n"
        process.send_signal(number)
        _, complaints = process.communicate(timeout=30)
    assert (process.returncode, complaints) == (
        1,
        "Stopped. No unfinished file was left behind.\n",
    )
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [OLDER]


@pytest.mark.parametrize(("number", "seconds"), [(signal.SIGINT, None), (signal.SIGTERM, 60)])
def test_a_recording_that_is_stopped_is_whole(number, seconds, tmp_path):
    path = tmp_path / "a.mcap"
    limits = [] if seconds is None else ["--seconds", seconds]
    argv = ["record", "simulator", "--jpeg", "--out", path, *limits]
    with command_line(*argv, at="recording") as process:
        assert process.stdout.readline() == "now\n"
        process.send_signal(number)
        process.send_signal(number)
        _, complaints = process.communicate(timeout=30)
    if seconds is None:
        assert (process.returncode, complaints) == (0, "")
    else:
        assert process.returncode == 1
        assert "what came until then is kept" in complaints
        assert complaints.count("\n") == 1
    assert list(tmp_path.iterdir()) == [path]
    with open_recording(path) as recording:
        assert len(recording) >= 2
        assert recording.notice is None


@pytest.mark.parametrize("suffix", [".xlsx", ".pdf", ".csv", ".json"])
def test_a_full_disk_leaves_the_older_report(suffix, demo, tmp_path):
    out = tmp_path / f"report{suffix}"
    out.write_bytes(OLDER)
    argv = ["posture", demo.recording, "--markers", demo.colors, "--out", out]
    with command_line(*argv, most_bytes=4000) as process:
        _, complaints = process.communicate(timeout=60)
    assert process.returncode == 1
    assert complaints == (
        f"{out.name} cannot be written: the disk is full. Free some space and try again.\n"
    )
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [OLDER]


def test_a_full_disk_keeps_what_was_recorded(tmp_path):
    argv = ["record", "simulator", "--jpeg", "--out", tmp_path / "a.mcap", "--seconds", "60"]
    with command_line(*argv, most_bytes=1_500_000) as process:
        _, complaints = process.communicate(timeout=60)
    assert process.returncode == 1
    assert complaints.count("\n") == 1
    assert "the disk is full" in complaints
    (kept,) = tmp_path.iterdir()
    assert f"are in {kept.name}." in complaints
    with open_recording(kept) as recording:
        assert [frame.sequence for frame in recording] == list(range(len(recording)))
        assert len(recording) >= 2


def test_a_reader_that_went_away_is_no_traceback(demo, tmp_path):
    argv = ["posture", demo.recording, "--markers", demo.colors, "--out", tmp_path / "r.csv"]
    with command_line(*argv, "--json") as process:
        process.stdout.close()
        process.stdout = None
        _, complaints = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "Traceback" not in complaints
    assert "BrokenPipe" not in complaints
    assert (tmp_path / "r.csv").stat().st_size > 1000


def test_a_full_stdout_is_told(demo, tmp_path):
    words = ["posture", demo.recording, "--markers", demo.colors, "--out", tmp_path / "r.csv"]
    script = [sys.executable, "-c", COMMAND_LINE, "nowhere", "0", *map(str, words), "--json"]
    settings = {"cwd": PROJECT, "text": True, "timeout": 60}
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(script, stdout=full, stderr=subprocess.PIPE, check=False, **settings)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith("The output cannot be written")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("target", ["a.mcap", "a.oni", "a"])
def test_a_full_disk_leaves_nothing_of_a_conversion(target, demo, tmp_path):
    words = ["convert", demo.recording, tmp_path / target]
    with command_line(*words, most_bytes=20_000) as process:
        _, complaints = process.communicate(timeout=60)
    assert process.returncode == 1
    assert complaints == (
        f"{target} cannot be recorded: the disk is full. Free some space and try again.\n"
    )
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_is_full_from_the_start_promises_no_frames(demo, tmp_path):
    words = ["record", demo.recording, "--out", tmp_path / "a.mcap"]
    with command_line(*words, most_bytes=20_000) as process:
        _, complaints = process.communicate(timeout=60)
    assert complaints == (
        "a.mcap cannot be recorded: the disk is full. Free some space and try again.\n"
    )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("size", "is_doubted"), [((480, 640), True), ((1024, 1280), False)])
def test_markers_of_two_pixels_are_doubted_in_the_report(size, is_doubted, demo, tmp_path, capsys):
    path = record_scene(tmp_path / "small.mcap", "anterior", color_size=size)
    argv = ["posture", path, "--markers", demo.colors, "--out", tmp_path / "report.xlsx"]
    assert main([str(word) for word in argv]) == 0
    assert ("fewer than three pixels wide" in capsys.readouterr().err) == is_doubted
