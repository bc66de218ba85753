"""A recording from behind becomes a surface, measures of the back and reports; or a sentence."""

import contextlib
import io
import json
import math
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import openpyxl
import pypdf
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from adibas.cli.command_line import main
from adibas.data.frames import SensorFrame
from adibas.data.markers import Marker
from adibas.data.surface import BurstDisparity
from adibas.errors import BodyError
from adibas.pipeline.back import measure_back
from adibas.pipeline.body_views import person_in
from adibas.recordings import create_recording
from adibas.reports.body_pdf import PICTURE_HEIGHT
from adibas.reports.body_plots import back_figure
from adibas.reports.map_files import ROW
from adibas.reports.pdf_layout import WIDTH
from adibas.simulation.depth_noise import EXACT
from adibas.simulation.patient import SHAPES
from adibas.simulation.scenes import open_scene
from adibas.texts import speaking
from benchmarks.body_scenes import midline

SETTINGS = {
    "shape": SHAPES[1],
    "has_color": False,
    "is_swaying": False,
    "depth_noise": EXACT,
    "distance_m": 2.2,
}


@pytest.fixture(scope="module")
def scene():
    return open_scene("posterior", 3, **SETTINGS)


@pytest.fixture(scope="module")
def view(scene):
    frame = scene.frame(0)
    depth_m = np.asarray(frame.truth.depth_m, np.float32)
    surface = BurstDisparity(1.0 / depth_m, np.ones(depth_m.shape, np.int64), 1)
    return person_in("posterior", surface, scene.info.calibration, name="x")


@pytest.fixture(scope="module")
def folder(tmp_path_factory, scene):
    path = tmp_path_factory.mktemp("back")
    for name, one in (
        ("behind", scene),
        ("side", open_scene("left_lateral", 3, **SETTINGS)),
        ("empty", open_scene("empty", 3, has_color=False)),
        ("near", open_scene("posterior", 3, **(SETTINGS | {"distance_m": 1.3}))),
    ):
        with create_recording(path / f"{name}.mcap", one.info) as recording:
            for index in range(2):
                recording.write(one.frame(index).sensor_frame)
    return path


def run(*arguments):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as stop:
            code = stop.code
    return code, out.getvalue(), err.getvalue()


def test_measures_surface_and_reports_are_written(folder, scene):
    ply, pdf, xlsx = folder / "b.ply", folder / "r.pdf", folder / "r.xlsx"
    told = f"posterior={folder / 'behind.mcap'}"
    code, out, _ = run("body", told, "--out", ply, "--report", pdf, "--json")
    assert code == 0
    document = json.loads(out)
    measures = {one["id"]: one for one in document["measures"]}
    kyphosis = measures["BACK.KYPHOSIS"]
    assert 20.0 < kyphosis["value"] < 60.0
    assert kyphosis["ci95"][0] < kyphosis["value"] < kyphosis["ci95"][1]
    assert all(one["source"] for one in measures.values())
    assert measures["BACK.TRUNK.INCLINATION"]["reason"]
    stature_m = scene.person(0)[0].body.stature_m
    assert document["spine"]["highest_seen_mm"] == pytest.approx(1e3 * stature_m, abs=20.0)
    # Exact depth lacks no rim, for which 10 mm are added.
    assert document["stature_mm"] == pytest.approx(1e3 * stature_m + 10.0, abs=4.0)
    assert document["stature_mm"] > document["spine"]["highest_seen_mm"] + 5.0
    header, _, body = ply.read_bytes().partition(b"end_header\n")
    assert len(np.frombuffer(body, ROW)) == document["points"] > 3000
    assert b"ply" in header
    assert "Report on the back" in pypdf.PdfReader(pdf).pages[0].extract_text()
    code, _, _ = run("body", told, "--out", ply, "--report", xlsx)
    assert code == 0
    rows = list(openpyxl.load_workbook(xlsx)["Measures"].values)
    assert len(rows) == 1 + len(measures)
    assert rows[1][2] == pytest.approx(kyphosis["value"], abs=0.01)


def test_line_of_the_spine_lies_over_the_spinous_processes(view, scene):
    back = measure_back(view)
    patient, posed = scene.person(0)
    true_m = midline(patient.body).on(posed.vertices_m, patient.body.model.triangles)
    true_m = back.patient_from_camera.apply(scene.depth_from_world.apply(true_m))
    heights_m = np.linspace(0.60, 0.84, 30) * back.stature_m
    right_m = np.interp(heights_m, true_m[::-1, 1], true_m[::-1, 0])
    np.testing.assert_allclose(back.line.at(heights_m), right_m, atol=0.005)
    off_m = back.profile.back_m(heights_m) - np.interp(heights_m, true_m[::-1, 1], true_m[::-1, 2])
    assert np.std(off_m) < 0.004


@pytest.mark.parametrize("language", ["en", "es", "ca", "pt"])
def test_plots_of_the_back_show_heights_alike_and_their_words_whole(view, language, caplog):
    with speaking(language):
        figure = back_figure(measure_back(view), WIDTH, PICTURE_HEIGHT)
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    plots = figure.axes[:4]
    lower, upper = zip(*(axes.get_window_extent().intervaly for axes in plots), strict=True)
    assert np.ptp(lower) < 1.0
    assert np.ptp(upper) < 1.0
    assert len({axes.get_ylim() for axes in plots}) == 1
    left_mm, right_mm = plots[0].get_xlim()
    assert left_mm == pytest.approx(-right_mm)
    assert 180.0 < right_mm < 260.0
    assert not caplog.records, "nothing of it is said on the console"
    for texts in ([axes.title for axes in plots], [axes.xaxis.label for axes in plots]):
        spans = [text.get_window_extent(renderer).intervalx for text in texts if text.get_text()]
        for (_, end), (begin, _) in pairwise(spans):
            assert end < begin
        assert spans[-1][1] <= figure.bbox.x1


def test_markers_give_the_measures_of_trunk_and_pelvis(view, scene):
    landmarks = scene.person(0)[1].landmarks
    to_color = scene.info.calibration.color_from_depth @ scene.depth_from_world
    names = ("c7", "t10", "left_psis", "right_psis")
    markers = tuple(
        Marker(
            name,
            *(0.0, 0.0, 3.0, np.eye(2)),
            position_m=to_color.apply(landmarks[name]),
            covariance_m2=1e-6 * np.eye(3),
        )
        for name in names
    )
    back = measure_back(view, (*markers, Marker("m09", 0.0, 0.0, 3.0, np.eye(2))))
    found = {one.definition.measure_id: one for one in back.measures}
    vp, left, right = (landmarks[name] for name in ("c7", "left_psis", "right_psis"))
    dm = (left + right) / 2
    assert found["BACK.TRUNK.LENGTH"].value == pytest.approx(np.linalg.norm(vp - dm))
    # World axes: y down, and the sensor stands behind the patient at negative z.
    forward_rad = np.arctan2(vp[2] - dm[2], dm[1] - vp[1])
    assert found["BACK.TRUNK.INCLINATION"].value == pytest.approx(forward_rad, abs=0.002)
    assert found["BACK.PELVIS.TILT"].value == pytest.approx(0.0, abs=0.002)
    assert abs(found["BACK.DEVIATION.MAX"].value) < 0.005
    assert not back.notices


@pytest.mark.parametrize("name", ["c7", "t1", "t6", "l2", "s1"])
def test_a_marker_on_any_vertebra_from_c7_to_s1_draws_the_line(view, name):
    back = measure_back(view)
    place_m = {"c7": 0.84, "t1": 0.82, "t6": 0.74, "l2": 0.63, "s1": 0.57}[name] * back.stature_m
    before_m = float(back.line.at(np.array([place_m]))[0])
    aside_m = before_m + 0.006
    to_color = view.calibration.color_from_depth @ back.patient_from_camera.inverse()
    marker = Marker(
        name,
        *(0.0, 0.0, 3.0, np.eye(2)),
        position_m=to_color.apply(np.array([aside_m, place_m, 0.0])),
        covariance_m2=1e-6 * np.eye(3),
    )
    line = measure_back(view, (marker,)).line
    moved_m = float(line.at(np.array([place_m]))[0]) - before_m
    assert 0.002 < moved_m < 0.007


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("empty", "Nobody is seen in empty.mcap"),
        ("side", "The back is not turned to the sensor"),
        ("near", "The head is cut off"),
        ("missing", "missing.mcap"),
    ],
)
def test_what_cannot_be_measured_is_told_in_a_sentence(folder, name, words):
    code, _, err = run("body", f"posterior={folder / name}.mcap", "--out", folder / f"{name}.ply")
    assert code == 1
    assert words in err
    assert not (folder / f"{name}.ply").exists()


def test_an_arm_before_the_back_is_told(view):
    mean = view.surface.mean_per_m.copy()
    rows, columns = np.nonzero(view.body)
    top = rows.min() + int(0.30 * view.camera.intrinsics.fy * 1.75 / 2.2)
    middle = int(np.median(columns))
    mean[top : top + 25, middle - 60 : middle + 60] += 0.02
    covered = replace(view, surface=BurstDisparity(mean, np.ones(mean.shape, np.int64), 1))
    with pytest.raises(BodyError, match="before the back"):
        measure_back(covered)


def test_wrong_words_are_wrong_usage(folder):
    told = f"posterior={folder / 'behind.mcap'}"
    assert run("body", "back.mcap", "--out", folder / "x.ply")[0] == 2
    code, _, err = run("body", told, "--out", folder / "x.txt")
    assert code == 1
    assert ".ply" in err
    code, _, err = run("body", told, told, "--out", folder / "x.ply")
    assert code == 1
    assert "given twice" in err
    labels = f"anterior={folder / 'behind.mcap'}"
    code, _, err = run("body", told, "--labels", labels, "--out", folder / "x.ply")
    assert code == 1
    assert "no recording" in err


def test_a_recording_without_depth_or_calibration_is_told(folder, scene):
    picture = np.zeros((48, 64, 3), np.uint8)
    seen = SensorFrame(
        sequence=0, timestamp_ns=1, depth_raw=None, color=picture, color_timestamp_ns=1
    )
    with create_recording(folder / "colour.mcap", scene.info) as recording:
        recording.write(seen)
    code, _, err = run("body", f"posterior={folder / 'colour.mcap'}", "--out", folder / "c.ply")
    assert code == 1
    assert "colour.mcap holds no depth" in err
    lame = replace(scene.info, calibration=replace(scene.info.calibration, depth=None))
    with create_recording(folder / "lame.mcap", lame) as recording:
        recording.write(scene.frame(0).sensor_frame)
    code, _, err = run("body", f"posterior={folder / 'lame.mcap'}", "--out", folder / "c.ply")
    assert code == 1
    assert "lacks the depth camera" in err
    told = f"posterior={folder / 'behind.mcap'}"
    code, _, err = run("body", told, "--frames", "7:9", "--out", folder / "c.ply")
    assert code == 1
    assert "behind.mcap has 2 frames, so frames 7:9 cannot be read" in err


@pytest.mark.parametrize("rotation_deg", [0, 90])
def test_the_floor_before_a_sensor_on_its_side_is_found_as_its_picture_is_turned(rotation_deg):
    lying = open_scene("posterior", 3, **SETTINGS, mounting="portrait")
    calibration = replace(lying.info.calibration, floor=None, gravity=None)
    depth_m = np.asarray(lying.frame(0).truth.depth_m, np.float32)
    surface = BurstDisparity(1.0 / depth_m, np.ones(depth_m.shape, np.int64), 1)
    told = ("posterior", surface, calibration)
    if rotation_deg == 0:
        with pytest.raises(BodyError, match="No floor"):
            person_in(*told)
        return
    found = person_in(*told, rotation_deg=rotation_deg)
    truth = lying.info.calibration.floor
    assert found.floor.normal @ truth.normal > math.cos(math.radians(0.5))
    assert found.floor.offset_m == pytest.approx(truth.offset_m, abs=0.01)
    wanted = measure_back(person_in("posterior", surface, lying.info.calibration), ())
    for one, other in zip(measure_back(found, ()).measures, wanted.measures, strict=True):
        if other.value is not None:
            assert one.value == pytest.approx(other.value, abs=2.0)


def test_markers_are_looked_for_as_the_picture_is_turned(folder, tmp_path, monkeypatch):
    asked = []

    def look(request, _progress, *, may_lack):
        assert may_lack
        asked.append(request.params.rotation_deg)
        return SimpleNamespace(markers=(Marker("m01", 0.0, 0.0, 5.0, np.eye(2)),), doubts=())

    monkeypatch.setattr("adibas.pipeline.body.find_in_recording", look)
    told = f"posterior={folder / 'behind.mcap'}"
    out = tmp_path / "back.ply"
    code, _, _ = run("body", told, "--markers", "led", "--rotation", "180", "--out", out)
    assert code == 0
    assert asked == [180]


def test_heights_need_a_floor(view, scene):
    calibration = replace(scene.info.calibration, floor=None, gravity=None)
    above = view.surface.mean_per_m.copy()
    above[scene.device.depth.height // 2 :] = np.nan
    surface = BurstDisparity(above, np.ones(above.shape, np.int64), 1)
    with pytest.raises(BodyError, match="No floor"):
        person_in("posterior", surface, calibration, name="x")
