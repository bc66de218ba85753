"""Pairs of colour and infrared images, through the pipeline and the command line."""

import json
import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from openpyxl import load_workbook

from adibas.calibration.files import read_calibration, write_calibration
from adibas.cli import main
from adibas.data.board import Board
from adibas.data.calibration import RgbdCalibration
from adibas.errors import CalibrationError
from adibas.geometry.distortion import project_distorted
from adibas.geometry.rigid import RigidTransform, rotation_vector
from adibas.pipeline.calibrating_infrared import calibrate_infrared, in_pairs
from adibas.simulation.boards import render_board
from adibas.simulation.boards_poses import Holding, random_board_poses
from adibas.simulation.device import draw_device

BOARD = Board(9, 6, 0.06)
DEVICE = draw_device(5, (480, 640))
COLOR_FROM_DEPTH = DEVICE.calibration.color_from_depth
TOLD = ["--board", "9x6", "--square-mm", "60"]


def is_in_view(pose, camera):
    pixels = project_distorted(pose.apply(BOARD.points_m()), camera.intrinsics, camera.distortion)
    return bool(((pixels > 20) & (pixels < (camera.width - 20, camera.height - 20))).all())


@pytest.fixture(scope="module")
def paths(tmp_path_factory):
    """Draw pairs of pictures; in the last one the board was moved in between."""
    folder, rng = tmp_path_factory.mktemp("pairs"), np.random.default_rng(11)
    holding = Holding(distance_m=(0.7, 1.8), border_px=60)
    poses = random_board_poses(rng, BOARD, DEVICE.color, 14, holding)
    poses = [p for p in poses if is_in_view(COLOR_FROM_DEPTH.inverse() @ p, DEVICE.depth)][:10]
    found = []
    for i, pose in enumerate(poses):
        nudge = RigidTransform(np.eye(3), np.array([0.02 if i == 9 else 0.0, 0.0, 0.0]))
        in_depth = COLOR_FROM_DEPTH.inverse() @ nudge @ pose
        for kind, camera, seen in (("c", DEVICE.color, pose), ("i", DEVICE.depth, in_depth)):
            path = folder / f"{kind}{i:02d}.png"
            cv2.imwrite(str(path), render_board(BOARD, seen, camera, rng).image)
            found.append(path)
    return found[::2], found[1::2]


def told(paths, out, *more):
    color, infrared = ([str(path) for path in kind] for kind in paths)
    return ["calibrate", *color, "--infrared", *infrared, *TOLD, "--out", str(out), *more]


def test_the_command_finds_both_cameras_and_their_pose(paths, tmp_path, capsys):
    book, page = tmp_path / "pairs.xlsx", tmp_path / "pairs.pdf"
    reports = ["--report", str(book), "--report", str(page), "--language", "en"]
    assert main(told(paths, tmp_path / "whole.json", "--json", *reports)) == 0
    document = json.loads(capsys.readouterr().out)
    found = read_calibration(tmp_path / "whole.json")
    assert document["outliers"] == ["c09.png, i09.png"]
    assert found.depth.intrinsics.fx == pytest.approx(DEVICE.depth.intrinsics.fx, rel=0.005)
    turn = rotation_vector(found.color_from_depth.rotation @ COLOR_FROM_DEPTH.rotation.T)
    away_m = found.color_from_depth.translation_m - COLOR_FROM_DEPTH.translation_m
    assert np.linalg.norm(turn) < math.radians(0.3)
    sds = np.sqrt(np.diag(found.covariance))[-6:]
    assert (np.abs(np.concatenate([turn, away_m])) < 4.0 * sds).all()
    assert sds[3:].max() < 0.003
    assert {"color.fx", "depth.fx", "color_from_depth.tx"} <= set(found.parameter_names)
    assert page.read_bytes().startswith(b"%PDF")
    sheets = load_workbook(book)
    assert sheets["Images"].max_row == 1 + 20
    rows = {row[0]: row[1] for row in sheets["Depth"].iter_rows(values_only=True)}
    assert rows["depth.fx"] == pytest.approx(found.depth.intrinsics.fx)
    assert rows["color_from_depth.tx"] == pytest.approx(
        1000.0 * found.color_from_depth.translation_m[0]
    )


def test_the_interval_of_the_centre_holds_a_shifted_depth_image_and_one_that_is_not(paths):
    """By half of the matching window, some pixels: infrared does not tell."""
    given = RgbdCalibration(color=DEVICE.color)
    found = calibrate_infrared(in_pairs(*paths), BOARD, given).calibration
    sds = dict(zip(found.parameter_names, np.sqrt(np.diag(found.covariance)), strict=True))
    truth = DEVICE.depth.intrinsics
    for name, cut_px in (("cx", 4.8), ("cy", 3.9)):
        for shift_px in (0.0, cut_px):
            away_px = getattr(found.depth.intrinsics, name) - (getattr(truth, name) - shift_px)
            assert abs(away_px) < 1.96 * sds[f"depth.{name}"]
    assert sds["depth.fx"] < 2.0
    assert sds["color_from_depth.tx"] < 0.003


def test_a_known_colour_camera_stays_as_it_is(paths):
    given = RgbdCalibration(color=DEVICE.color, sensor_serial="S1")
    outcome = calibrate_infrared(in_pairs(*paths), BOARD, given)
    assert outcome.calibration.color is DEVICE.color
    assert outcome.calibration.sensor_serial == "S1"
    assert not any(name.startswith("color.") for name in outcome.calibration.parameter_names)


def test_a_colour_camera_of_another_size_or_none_is_refused(paths):
    pairs = in_pairs(*paths)[:3]
    other = replace(DEVICE.color, width=1280, height=1024)
    with pytest.raises(CalibrationError, match="for colour images of 1280x1024"):
        calibrate_infrared(pairs, BOARD, RgbdCalibration(color=other))
    with pytest.raises(CalibrationError, match="no colour camera"):
        calibrate_infrared(pairs, BOARD, RgbdCalibration(depth=DEVICE.depth))


def test_images_without_partner_are_refused(paths, tmp_path, capsys):
    color, infrared = paths
    assert main(told((color, infrared[:-1]), tmp_path / "o.json")) == 1
    assert "There are 10 colour images, but 9 infrared images." in capsys.readouterr().err
    assert not (tmp_path / "o.json").exists()


def test_infrared_images_without_a_board_are_named(paths, tmp_path):
    blank = tmp_path / "blank.png"
    cv2.imwrite(str(blank), np.full((480, 640), 90, np.uint8))
    given = RgbdCalibration(color=DEVICE.color)
    with pytest.raises(CalibrationError, match="The infrared images do not determine a camera"):
        calibrate_infrared([(paths[0][0], blank)], BOARD, given)


def test_pairs_need_a_board(paths, tmp_path, capsys):
    command = ["calibrate", str(paths[0][0]), "--infrared", str(paths[1][0])]
    assert main([*command, "--out", str(tmp_path / "o.json")]) == 2
    assert "--infrared" in capsys.readouterr().err


def test_the_colour_calibration_may_be_a_file(paths, tmp_path, capsys):
    write_calibration(tmp_path / "color.json", RgbdCalibration(color=DEVICE.color))
    more = ["--calibration", str(tmp_path / "color.json")]
    main(told(paths, tmp_path / "whole.json", *more))
    assert "color_from_depth.tx" in capsys.readouterr().out
    assert read_calibration(tmp_path / "whole.json").color == DEVICE.color
