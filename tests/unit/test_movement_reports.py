"""A movement in Excel, PDF, CSV, C3D and TRC."""

import csv
import json
import math
import os
import sys

import ezc3d
import numpy as np
import openpyxl
import pypdf
import pytest

from adibas.data.joints import JOINT_NAMES
from adibas.data.protocol_measures import INSTRUMENT_ONLY
from adibas.data.skeleton_track import track_of
from adibas.errors import FileError, ReportError
from adibas.movement.joint_angles import INDEX
from adibas.movement.measuring import measure_movement
from adibas.reports.motion_files import upright_axes, write_c3d
from adibas.reports.movement import MOVEMENT_KINDS, write_movement
from adibas.reports.movement_facts import movement_facts
from adibas.reports.movement_json import movement_to_json
from adibas.reports.movement_plots import ANGLE, SPEED, movement_figure
from tests.unit.movement_samples import bending, source


@pytest.fixture(scope="module")
def movement():
    track = bending(noise_m=0.002)
    joints_m = track.joints_m.copy()
    joints_m[40:70, INDEX["left_hand"]] = np.nan
    return measure_movement(track_of(track.times_s, joints_m), source(patient="P-7"))


def curve_of(movement, name):
    return next(curve for curve in movement.curves if curve.name == name)


def test_the_workbook_holds_ranges_symmetry_and_curves_as_numbers(movement, tmp_path):
    file = tmp_path / "m.xlsx"
    write_movement(movement, file, "en")
    book = openpyxl.load_workbook(file)
    assert book.sheetnames == ["Summary", "Ranges", "Symmetry", "Angles over time"]
    ranges = {row[0]: row[1:] for row in book["Ranges"].iter_rows(min_row=2, values_only=True)}
    elbow = next(one for one in movement.ranges if one.name == "right_elbow_flexion")
    least, greatest, span, sure, *_times, fastest, sure_speed, seen, remark = ranges[
        "Elbow: flexion, right side"
    ]
    expected = (elbow.least_deg, elbow.greatest_deg, elbow.range_deg)
    assert (least, greatest, span) == pytest.approx(expected)
    assert sure == pytest.approx(1.96 * elbow.sd_deg)
    assert seen == 100.0
    assert (fastest, sure_speed) == pytest.approx(
        (elbow.fastest_deg_s, 1.96 * elbow.speed_sd_deg_s)
    )
    assert remark is None
    *_numbers, still, _sure, _seen, remark = ranges["Neck: flexion"]
    assert (still, remark) == (None, "fastest: not told from noise")
    sides = {row[0]: row for row in book["Symmetry"].iter_rows(min_row=2, values_only=True)}
    assert sides["Elbow: flexion"][4] == pytest.approx(-28.6, abs=4)
    assert sides["Knee: flexion"][4] is None
    assert sides["Knee: flexion"][5] == "neither side moved enough to compare"
    rows = list(book["Angles over time"].iter_rows(min_row=2, values_only=True))
    assert len(rows) == len(movement.times_s)
    at = [cell.value for cell in book["Angles over time"][1]].index("Elbow: flexion, left side [°]")
    assert rows[50][at] is None
    left = curve_of(movement, "left_elbow_flexion")
    assert rows[10][at : at + 2] == pytest.approx((left.deg[10], left.speed_deg_s[10]))
    assert book["Angles over time"][1][at + 1].value == "Elbow: flexion, left side [°/s]"
    words = {cell.value for row in book["Summary"].iter_rows() for cell in row}
    assert {"P-7", "5.0"} <= words
    assert any("markers on the skin" in str(word) for word in words)
    assert len(book["Summary"]._images) == 2


def test_the_pdf_says_it_in_the_readers_language(movement, tmp_path):
    file = tmp_path / "m.pdf"
    write_movement(movement, file, "es")
    text = "".join(page.extract_text() for page in pypdf.PdfReader(file).pages)
    elbow = next(one for one in movement.ranges if one.name == "right_elbow_flexion")
    assert f"{elbow.greatest_deg:.1f}".replace(".", ",") in text
    assert f"{elbow.fastest_deg_s:.0f} ± {1.96 * elbow.speed_sd_deg_s:.0f}" in text
    assert "Movement report" not in text


@pytest.mark.parametrize(("quantity", "unit"), [(ANGLE, "[°]"), (SPEED, "[°/s]")])
def test_plots_show_each_curve_of_angle_and_of_speed(movement, quantity, unit):
    axes = movement_figure(movement, 500.0, 600.0, quantity).axes
    elbow = next(one for one in axes if one.get_title() == f"Elbow: flexion {unit}")
    drawn = {line.get_label(): line.get_ydata() for line in elbow.get_lines()}
    left = curve_of(movement, "left_elbow_flexion")
    np.testing.assert_array_equal(drawn["left side"], quantity.of_curve(left))


def test_the_speed_of_what_stands_still_lies_in_the_band_of_noise(movement):
    neck = next(one for one in movement.ranges if one.name == "neck_flexion")
    axes = movement_figure(movement, 500.0, 600.0, SPEED).axes
    (plot,) = [one for one in axes if one.get_title() == "Neck: flexion [°/s]"]
    (band,) = plot.patches
    low, high = band.get_window_extent().transformed(plot.transData.inverted()).intervaly
    assert (low, high) == pytest.approx((-neck.noise_deg_s, neck.noise_deg_s))
    assert neck.fastest_deg_s < high


def test_csv_has_every_angle_at_every_time(movement, tmp_path):
    file = tmp_path / "m.csv"
    write_movement(movement, file, "en")
    with file.open(newline="") as opened:
        header, *rows = csv.reader(opened)
    at = header.index("left_elbow_flexion_deg")
    assert rows[50][at] == ""
    left = curve_of(movement, "left_elbow_flexion")
    assert float(rows[10][at]) == pytest.approx(left.deg[10], abs=1e-4)
    assert header[at + 1] == "left_elbow_flexion_deg_s"
    assert float(rows[10][at + 1]) == pytest.approx(left.speed_deg_s[10], abs=1e-4)
    assert rows[0][at + 1] == "", "no speed at the very beginning"
    assert len(rows) == len(movement.times_s)


@pytest.mark.parametrize("origin", ["markers", "markerless", "unknown"])
def test_csv_says_in_every_row_where_the_joints_come_from(origin, tmp_path):
    file = tmp_path / "m.csv"
    write_movement(measure_movement(bending(), source(origin=origin)), file, "en")
    with file.open(newline="") as opened:
        rows = list(csv.DictReader(opened))
    assert {row["origin"] for row in rows} == {origin}


@pytest.mark.parametrize(
    ("origin", "intervals"), [("markers", INSTRUMENT_ONLY), ("markerless", None)]
)
def test_intervals_are_said_to_be_of_the_instrument_only_where_markers_are_placed(
    origin, intervals
):
    movement = measure_movement(bending(), source(origin=origin))
    assert movement_to_json(movement)["intervals"] == intervals
    told = dict(movement_facts(movement)).get("Intervals of measures")
    assert told == intervals


def test_what_rests_on_no_vertical_does_not_say_that_it_does(movement):
    assert dict(movement_facts(movement))["Vertical"] == "not measured"


def test_c3d_gives_the_joints_back_upright_and_in_millimetres(movement, tmp_path):
    file = tmp_path / "m.c3d"
    write_movement(movement, file, "en")
    read = ezc3d.c3d(str(file))
    assert read["parameters"]["POINT"]["LABELS"]["value"] == list(JOINT_NAMES)
    assert read["parameters"]["POINT"]["RATE"]["value"][0] == pytest.approx(30.0)
    points = read["data"]["points"]
    head, foot = points[:3, INDEX["head"], 0], points[:3, INDEX["left_foot"], 0]
    assert 1400 < head[2] - foot[2] < 1800, "z is up"
    assert head[1] == pytest.approx(2500, abs=20), "y is away from the camera"
    right, left = points[:3, INDEX["right_hip"], 0], points[:3, INDEX["left_hip"], 0]
    assert right[0] < left[0], "x is to the right of the picture: the patient faces the camera"
    assert np.isnan(points[:3, INDEX["left_hand"], 50]).all()
    assert read["data"]["meta_points"]["residuals"][0, INDEX["left_hand"], 50] == -1
    lengths = np.linalg.norm(points[:3, INDEX["left_hip"]] - points[:3, INDEX["left_knee"]], axis=0)
    expected_m = np.linalg.norm(
        movement.joints_m[:, INDEX["left_hip"]] - movement.joints_m[:, INDEX["left_knee"]], axis=1
    )
    np.testing.assert_allclose(lengths, 1000 * expected_m, atol=1e-2)


def test_trc_has_one_line_a_frame_and_y_up(movement, tmp_path):
    file = tmp_path / "m.trc"
    write_movement(movement, file, "en")
    lines = file.read_text("utf-8").splitlines()
    assert lines[2].split("\t")[2:5] == [str(len(movement.times_s)), "15", "mm"]
    names = [name for name in lines[3].split("\t")[2:] if name]
    assert names == list(JOINT_NAMES)
    rows = [line.split("\t") for line in lines[6:]]
    assert len(rows) == len(movement.times_s)
    assert {len(row) for row in rows} == {2 + 45}
    head, foot = (
        np.array(rows[0][2 + 3 * INDEX[name] :][:3], float) for name in ("head", "left_foot")
    )
    assert 1400 < (head - foot)[1] < 1800
    assert rows[50][2 + 3 * INDEX["left_hand"]] == "NaN"


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere every name is text")
@pytest.mark.parametrize("kind", MOVEMENT_KINDS)
def test_a_name_that_is_no_text_is_written_to_all_the_same(movement, tmp_path, kind):
    path = tmp_path / os.fsdecode(b"Jos\xe9" + kind.encode())
    write_movement(movement, path, "en")
    assert path.stat().st_size


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere every name is text")
def test_c3d_says_that_the_name_of_its_folder_is_no_text(movement, tmp_path):
    with pytest.raises(FileError, match="it is no text"):
        write_movement(movement, tmp_path / os.fsdecode(b"Jos\xe9") / "m.c3d", "en")


def test_upright_axes_are_a_right_handed_turn():
    up = np.array([0.1, -0.9, -0.3])
    axes = upright_axes(up)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_allclose(axes @ (up / np.linalg.norm(up)), [0, 0, 1], atol=1e-12)


@pytest.mark.parametrize(("up", "right"), [([1, 0, 0], [0, 1, 0]), ([-1, 0, 0], [0, -1, 0])])
def test_a_camera_on_its_side_has_a_right_all_the_same(up, right):
    np.testing.assert_allclose(upright_axes(np.array(up)), [right, [0, 0, 1], up], atol=1e-12)


def tilted(roll_deg, pitch_deg):
    """Up in the axes of a camera that looks down by `pitch_deg` and is rolled about its axis."""
    roll_rad, pitch_rad = math.radians(roll_deg), math.radians(pitch_deg)
    across = math.cos(pitch_rad)
    return np.array(
        [across * math.sin(roll_rad), -across * math.cos(roll_rad), -math.sin(pitch_rad)]
    )


@pytest.mark.parametrize("pitch_deg", [-20.0, 0.0, 25.0, 70.0])
@pytest.mark.parametrize("roll_deg", [0.0, 30.0, 59.0, 61.0, 90.0, -120.0, 180.0])
def test_what_is_straight_ahead_of_a_rolled_and_tilted_camera_is_neither_left_nor_right(
    roll_deg, pitch_deg
):
    axes = upright_axes(tilted(roll_deg, pitch_deg))
    across, away, _up = axes @ [0.0, 0.0, 1.0]
    assert across == pytest.approx(0.0, abs=1e-12)
    assert away == pytest.approx(math.cos(math.radians(pitch_deg)))
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_camera_that_looks_straight_down_or_up_has_axes_all_the_same(sign):
    axes = upright_axes(np.array([0.0, 0.0, sign]))
    np.testing.assert_allclose(axes, [[1, 0, 0], [0, sign, 0], [0, 0, sign]], atol=1e-12)


def test_upright_axes_do_not_jump_where_a_camera_is_turned_on_its_side():
    axes = [
        upright_axes(np.array([math.sin(roll_rad), -math.cos(roll_rad), 0.0]))
        for roll_rad in np.radians(np.arange(0.0, 91.0))
    ]
    assert np.abs(np.diff(axes, axis=0)).max() < 0.02


def test_json_says_no_number_where_there_is_none(movement):
    document = json.loads(json.dumps(movement_to_json(movement), allow_nan=False))
    by_name = {one["angle"]: one for one in document["ranges"]}
    assert by_name["left_elbow_flexion"]["seen_percent"] == pytest.approx(80.0)
    assert by_name["neck_flexion"]["fastest_deg_s"] is None
    assert by_name["neck_flexion"]["fastest_is_noise"]
    assert by_name["neck_flexion"]["speed_ci95_deg_s"] > 0
    assert not by_name["right_elbow_flexion"]["fastest_is_noise"]
    assert document["duration_s"] == pytest.approx(149 / 30)
    single = measure_movement(bending(n_frames=1), source())
    assert movement_to_json(single)["rate_hz"] is None


def test_c3d_refuses_more_frames_than_it_counts(tmp_path):
    long = bending(n_frames=2)
    times_s = np.array([0.0, 70_000 / 30])
    track = track_of(np.linspace(*times_s, 70_001), np.repeat(long.joints_m[:1], 70_001, axis=0))
    with pytest.raises(ReportError, match="65535"):
        write_c3d(measure_movement(track, source()), tmp_path / "m.c3d")


def test_another_ending_is_a_mistake_of_the_program(movement, tmp_path):
    with pytest.raises(ValueError, match="docx"):
        write_movement(movement, tmp_path / "m.docx", "en")


@pytest.mark.parametrize("kind", MOVEMENT_KINDS)
def test_a_place_that_is_no_folder_is_told(movement, tmp_path, kind):
    (tmp_path / "file").touch()
    with pytest.raises(FileError):
        write_movement(movement, tmp_path / "file" / f"m{kind}", "en")
