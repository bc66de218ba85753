"""From a recording of a board to the calibration of the whole sensor, by pipeline and command."""

import contextlib
import io
import json
import math
import threading
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from openpyxl import load_workbook

from adibas.calibration.files import read_calibration, write_calibration
from adibas.cli import main
from adibas.data.board import BoardCorners
from adibas.data.calibration import DepthBias, RgbdCalibration
from adibas.data.calibration_verdict import Grade
from adibas.data.surface import BurstDisparity
from adibas.errors import CalibrationError, RecordingError
from adibas.geometry.rigid import rotation_vector
from adibas.pipeline.calibrating_depth import (
    DepthRequest,
    calibrate_depth,
    starting_point,
)
from adibas.pipeline.calibrating_depth_checks import vertical_of
from adibas.pipeline.calibrating_depth_moments import mean_corners, spread_over
from adibas.pipeline.calibrating_recording import calibrate_color_of
from adibas.pipeline.still_moments import Moment
from adibas.simulation.boards_device import factory_info
from adibas.simulation.scenes import open_scene
from adibas.texts import use_language
from tests.unit.board_recordings import (
    BOARD,
    DEVICE,
    HEIGHT_M,
    board_moments,
    color_alone,
    record_moments,
    wall_moments,
)

TRUTH = DEVICE.calibration
TOLD = ["--board", "9x6", "--square-mm", "100"]


@pytest.fixture(scope="module", autouse=True)
def english():
    use_language("en")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("depth")


@pytest.fixture(scope="module")
def recording(folder):
    moments = [*board_moments(8, 1), *wall_moments([1.2])]
    return record_moments(folder / "board.mcap", moments)


@pytest.fixture(scope="module")
def run(folder, recording):
    """Run the command as a user does: return what it prints, and what it says beside that."""
    printed, said = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(said):
        code = main(
            [
                *("calibrate", str(recording), "--depth", "--wall", *TOLD, "--json"),
                *("--out", str(folder / "whole.json"), "--language", "en"),
                *("--report", str(folder / "whole.pdf"), "--report", str(folder / "whole.xlsx")),
            ]
        )
    assert code == 0
    return json.loads(printed.getvalue()), said.getvalue()


@pytest.fixture(scope="module")
def told(run):
    return run[0]


@pytest.fixture(scope="module")
def found(folder, told):
    assert told["out"] == str(folder / "whole.json")
    return read_calibration(folder / "whole.json")


def refusal(request, **changes):
    with pytest.raises((CalibrationError, RecordingError)) as caught:
        calibrate_depth(replace(request, **changes))
    return str(caught.value)


def test_the_recording_gives_the_pose_of_the_depth_camera(found):
    truth = TRUTH.color_from_depth
    turn = found.color_from_depth.rotation @ truth.rotation.T
    assert np.linalg.norm(rotation_vector(turn)) < math.radians(0.1)
    np.testing.assert_allclose(
        found.color_from_depth.translation_m, truth.translation_m, atol=0.004
    )
    np.testing.assert_allclose(
        [found.depth.intrinsics.fx, found.depth.intrinsics.fy],
        [DEVICE.depth.intrinsics.fx, DEVICE.depth.intrinsics.fy],
        rtol=0.003,
    )


def test_the_depth_is_right_to_some_millimetres_after_correction(found):
    k = DEVICE.depth.intrinsics
    x, y = (np.arange(640.0) - k.cx) / k.fx, ((np.arange(480.0) - k.cy) / k.fy)[:, None]
    bias = TRUTH.depth_bias
    p, q, r, s, t = bias.image_term
    square = bias.c + p * x + q * y + r * x * x + s * x * y + t * y * y
    for true_m in (1.0, 1.5, 2.0, 2.5):
        # What the device shows of a wall: the root of a + b z + c z^2 = truth.
        root = np.sqrt(bias.b**2 + 4.0 * square * (true_m - bias.a))
        shown_m = (2.0 * (true_m - bias.a) / (bias.b + root)).astype(np.float32)
        errors_m = found.corrected_depth(shown_m) - true_m
        assert np.sqrt(np.mean(errors_m**2)) < 0.0045
        assert np.sqrt(np.mean((shown_m - true_m) ** 2)) > 2.0 * np.sqrt(np.mean(errors_m**2))


def test_the_floor_gives_gravity(found):
    tilt_rad = float(np.linalg.norm(found.gravity - [0.0, 1.0, 0.0]))
    assert tilt_rad < 4.0 * found.gravity_sd_rad
    assert tilt_rad < math.radians(0.5)
    assert found.floor.offset_m == pytest.approx(HEIGHT_M, abs=0.01)
    assert 0.0 < found.gravity_sd_rad < 0.01
    assert 0.0 < found.floor_flatness_m < 0.01


def test_the_calibration_brings_its_covariance(found):
    names = found.parameter_names
    assert {"color_from_depth.tz", "depth_bias.b", "depth.fx"} <= set(names)
    sds = np.sqrt(np.diag(found.covariance))
    assert ((sds > 0) & (sds < 5.0)).all()
    shift_sds = [sds[names.index(f"color_from_depth.t{axis}")] for axis in "xyz"]
    away_m = found.color_from_depth.translation_m - TRUTH.color_from_depth.translation_m
    assert (np.abs(away_m) < 4.0 * np.array(shift_sds)).all()


def test_the_document_tells_what_was_seen(told):
    assert told["verdict"]["grade"] != Grade.REPEAT.value
    assert sum(not shot["is_wall"] for shot in told["shots"]) == 8
    assert told["n_still_moments"] == 9
    low, high = told["scale"]["ci95"]
    assert low < 1.0 < high
    assert not told["scale"]["is_wrong"]
    assert told["vertical"]["ci95_deg"] < 0.5
    assert told["parameters"]["depth_bias.b"]["ci95"][0] > 0.9


def test_the_reports_are_written(folder, told):
    assert told["color"]["model"]
    assert (folder / "whole.pdf").read_bytes().startswith(b"%PDF")
    assert (folder / "whole.xlsx").read_bytes().startswith(b"PK")


def test_the_reader_is_told_of_both_cameras(folder, run):
    said = run[1]
    assert "Lens model:" in said
    assert "Depth camera: 8 boards and 1 wall took part, of 9 still moments." in said
    assert "Depth of 2 m is corrected by" in said
    assert "By depth the squares of the board measure" in said
    assert f"{folder / 'whole.json'} is written." in said
    verdicts = ("Good:", "Usable,", "Repeat")
    assert sum(line.startswith(verdicts) for line in said.splitlines()) == 1


def test_an_error_of_the_colour_camera_moves_the_depth_camera(found):
    assert found.color.intrinsics.fx == pytest.approx(DEVICE.color.intrinsics.fx, rel=0.005)
    assert found.sensor_serial == TRUTH.sensor_serial
    names = found.parameter_names
    at = names.index("color.fx"), names.index("color_from_depth.tz")
    assert found.covariance[at] != 0.0


def test_the_colour_camera_comes_from_the_same_recording(recording):
    steps = []
    outcome = calibrate_color_of(
        [recording], BOARD, progress=lambda done, total: steps.append((done, total))
    )
    assert [image.search.corners is not None for image in outcome.images] == [True] * 8 + [False]
    found, truth = outcome.fit.camera.intrinsics, DEVICE.color.intrinsics
    assert found.fx == pytest.approx(truth.fx, rel=0.005)
    assert steps[-1] == (180, 180)


def test_whoever_stops_gets_nothing(recording):
    stop = threading.Event()
    stop.set()
    request = DepthRequest(recording, color_alone(), BOARD)
    assert calibrate_depth(request, stop=stop) is None
    assert calibrate_color_of([recording], BOARD, stop=stop) is None


def test_images_of_another_size_are_refused(recording):
    other = replace(DEVICE.color, width=1280, height=1024)
    text = refusal(DepthRequest(recording, color_alone(color=other), BOARD))
    assert text.startswith("The calibration is for colour images of 1280x1024")


def test_a_recording_without_depth_is_refused(tmp_path):
    blank = record_moments(tmp_path / "c.mcap", wall_moments([1.0]), 2, has_depth=False)
    text = refusal(DepthRequest(blank, color_alone(), BOARD))
    assert text.startswith("The recording has no depth.")


def test_a_recording_without_rest_is_refused(tmp_path):
    path = record_moments(tmp_path / "m.mcap", wall_moments([1.0, 1.5, 2.0, 2.5]), 2)
    assert refusal(DepthRequest(path, color_alone(), BOARD)).startswith("Nothing stands still")
    with pytest.raises(CalibrationError, match="Nothing stands still"):
        calibrate_color_of([path], BOARD)


def test_a_recording_without_the_board_says_what_is_seen_instead(tmp_path):
    path = record_moments(tmp_path / "w.mcap", wall_moments([1.4]))
    text = refusal(DepthRequest(path, color_alone(), BOARD))
    assert text.startswith("The board is seen in none of the 1 still moments.")
    assert text.endswith("No chessboard is seen. Hold it in view, in even light.")


def test_a_recording_without_colour_says_so(tmp_path):
    path = record_moments(tmp_path / "d.mcap", wall_moments([1.4]), has_color=False)
    assert "no colour" in refusal(DepthRequest(path, color_alone(), BOARD))
    with pytest.raises(CalibrationError, match="no colour"):
        calibrate_color_of([path], BOARD)


def test_a_wall_keeps_what_it_does_not_tell(tmp_path, found):
    path = record_moments(tmp_path / "w.mcap", wall_moments([1.0, 1.6]))
    write_calibration(tmp_path / "known.json", found)
    arguments = ["--depth", "--wall", "--calibration", str(tmp_path / "known.json")]
    arguments += ["--out", str(tmp_path / "w.json"), "--language", "en", "--keep-bad"]
    for kind in ("pdf", "xlsx"):
        arguments += ["--report", str(tmp_path / f"w.{kind}")]
    main(["calibrate", str(path), *arguments])
    assert (tmp_path / "w.pdf").read_bytes().startswith(b"%PDF")
    cells = load_workbook(tmp_path / "w.xlsx")["Summary"].iter_rows(values_only=True)
    facts = {row[0]: row[1] for row in cells if row[0]}
    assert "Board" not in facts
    assert facts["Depth at 2 m"].startswith("0")
    outcome = calibrate_depth(DepthRequest(path, found, has_wall=True))
    after = outcome.calibration
    np.testing.assert_allclose(
        after.color_from_depth.translation_m, found.color_from_depth.translation_m
    )
    assert (after.depth_bias.a, after.depth_bias.b) == (found.depth_bias.a, found.depth_bias.b)
    assert after.depth_bias.image_term != found.depth_bias.image_term
    assert set(after.parameter_names) == set(found.parameter_names)
    index, before = (
        after.parameter_names.index("depth_bias.b"),
        found.parameter_names.index("depth_bias.b"),
    )
    assert after.covariance[index, index] == found.covariance[before, before]
    assert outcome.scale is None


def by_infrared(shift_px):
    """What infrared images tell of the device, whose depth image is shifted from them."""
    k = DEVICE.depth.intrinsics
    moved = replace(k, cx=k.cx + shift_px[0], cy=k.cy + shift_px[1])
    names = [f"depth.{name}" for name in ("fx", "fy", "cx", "cy")]
    names += [f"color_from_depth.{name}" for name in ("rx", "ry", "rz", "tx", "ty", "tz")]
    sds = [0.3, 0.3, 5.0, 5.0, *[1e-4] * 3, *[2e-4] * 3]
    return color_alone(
        depth=replace(DEVICE.depth, intrinsics=moved),
        color_from_depth=TRUTH.color_from_depth,
        parameter_names=tuple(names),
        covariance=np.diag(np.square(sds)),
    )


def test_boards_find_the_shift_of_the_depth_image_that_infrared_images_do_not_tell(recording):
    given = by_infrared((4.8, 3.9))
    after = calibrate_depth(DepthRequest(recording, given, BOARD)).calibration
    found, truth = after.depth.intrinsics, DEVICE.depth.intrinsics
    at = [after.parameter_names.index(name) for name in ("depth.cx", "depth.cy")]
    sds = np.sqrt(np.diag(after.covariance))[at]
    away_px = np.array([found.cx - truth.cx, found.cy - truth.cy])
    assert (np.abs(away_px) < 3.0 * sds).all()
    assert np.abs(away_px).max() < 1.5
    assert (found.fx, found.fy) == (truth.fx, truth.fy)
    of_focal = after.parameter_names.index("depth.fx")
    assert after.covariance[of_focal, of_focal] == given.covariance[0, 0]


def test_a_depth_camera_that_boards_told_stays_as_it_is(recording, found):
    after = calibrate_depth(DepthRequest(recording, found, BOARD)).calibration
    assert after.depth == found.depth


def test_a_start_needs_a_colour_camera_and_the_makers_depth_camera():
    info = factory_info(DEVICE)
    with pytest.raises(CalibrationError, match="no colour camera"):
        starting_point(RgbdCalibration(depth=DEVICE.depth), info)
    with pytest.raises(CalibrationError, match="focal length"):
        starting_point(color_alone(), replace(info, calibration=None))
    start = starting_point(color_alone(), info)
    assert start.depth == info.calibration.depth
    assert start.sensor_serial == info.sensor_serial


def test_another_sensor_or_moved_depth_is_refused():
    info = factory_info(DEVICE)
    with pytest.raises(CalibrationError, match="of sensor X1, but the recording of sensor"):
        starting_point(color_alone(sensor_serial="X1"), info)
    with pytest.raises(CalibrationError, match="moved the depth into the colour image"):
        starting_point(color_alone(), replace(info, is_depth_registered=True))


def test_a_calibration_of_nothing_is_no_request(tmp_path):
    with pytest.raises(ValueError, match="needs a board or a wall"):
        DepthRequest(tmp_path, color_alone())


def test_corners_are_averaged_where_they_stay():
    def corners(shift_px, hidden=()):
        pixels = np.array([[10.0, 20.0], [30.0, 20.0], [50.0, 20.0]]) + shift_px
        sigma = np.full(3, 0.1)
        for index in hidden:
            pixels[index], sigma[index] = np.nan, np.nan
        return BoardCorners("b", 640, 480, pixels, sigma)

    mean = mean_corners([corners(0.0), corners(0.2, hidden=[1])], 1.0)
    np.testing.assert_allclose(mean.pixels[0], [10.1, 20.1])
    assert mean.n_seen == 2
    assert mean.sigma_px[0] == pytest.approx(0.1 / math.sqrt(2))
    assert mean_corners([corners(0.0), corners(4.0)], 1.0).n_seen == 0


def test_frames_are_spread_over_a_burst():
    assert spread_over(Moment(10, 40), 3).tolist() == [14, 24, 34]
    assert spread_over(Moment(10, 12), 6).tolist() == [10, 11]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["picture.png", "--depth", *TOLD], "give recordings"),
        (["b.mcap", "--depth"], "Give the board's inner corners"),
        (["b.mcap", "--depth", "--wall"], "A wall alone needs --wall and the --calibration"),
        (["b.mcap", "--wall", *TOLD], "--wall and --calibration go with --depth"),
    ],
)
def test_what_lacks_on_the_command_line_is_said(arguments, text, tmp_path, capsys):
    assert main(["calibrate", *arguments, "--out", str(tmp_path / "o.json")]) == 2
    assert text in capsys.readouterr().err


def test_a_missing_recording_writes_nothing(tmp_path, capsys):
    write_calibration(tmp_path / "c.json", color_alone())
    arguments = ["calibrate", str(tmp_path / "none.mcap"), "--depth", *TOLD]
    arguments += ["--calibration", str(tmp_path / "c.json"), "--out", str(tmp_path / "o.json")]
    assert main(arguments) == 1
    assert "none.mcap" in capsys.readouterr().err
    assert not (tmp_path / "o.json").exists()


@pytest.mark.parametrize("rotation_deg", [0, 90])
def test_the_floor_tells_the_vertical_of_a_sensor_on_its_side_whose_rotation_is_told(rotation_deg):
    scene = open_scene("empty", mounting="portrait", has_color=False)
    truth = scene.info.calibration
    depth_m = np.asarray(scene.frame(0).truth.depth_m, np.float32)
    disparity = BurstDisparity(1.0 / depth_m, np.ones(depth_m.shape, np.int64), 1)
    bare = replace(truth, gravity=None, floor=None, depth_bias=DepthBias())
    found = vertical_of([SimpleNamespace(disparity=disparity)], bare, rotation_deg)
    if rotation_deg == 0:
        assert found is None
    else:
        assert found.gravity @ truth.gravity > math.cos(math.radians(0.3))


def test_gravity_tells_where_the_floor_of_a_sensor_on_its_side_is():
    scene = open_scene("empty", mounting="portrait", has_color=False)
    truth = scene.info.calibration
    depth_m = np.asarray(scene.frame(0).truth.depth_m, np.float32)
    disparity = BurstDisparity(1.0 / depth_m, np.ones(depth_m.shape, np.int64), 1)
    known = replace(truth, floor=None, depth_bias=DepthBias())
    found = vertical_of([SimpleNamespace(disparity=disparity)], known)
    assert found.floor.offset_m == pytest.approx(truth.floor.offset_m, abs=0.01)
