"""From image files to a calibration, through the pipeline and the command line."""

import json
import threading

import cv2
import numpy as np
import pytest
from openpyxl import load_workbook

from adibas.calibration.files import read_calibration
from adibas.cli import main
from adibas.data.board import Board
from adibas.data.calibration_verdict import Grade
from adibas.errors import CalibrationError
from adibas.pipeline.calibrating import (
    NamedImage,
    calibrate_camera,
    color_calibration,
    fit_searched,
    parameter_intervals,
    read_images,
)
from adibas.simulation.boards_novice import novice_set
from adibas.simulation.device import draw_device

BOARD = Board(9, 6, 0.03)
DEVICE = draw_device(7, color_size=(480, 640))
TOLD = ["--board", "9x6", "--square-mm", "30"]


def pictures(mistake, n=11, seed=1):
    rng = np.random.default_rng(seed)
    shots = novice_set(mistake, rng, BOARD, DEVICE.color, n=n).pictures(DEVICE.color, rng)
    return [NamedImage(f"{i:02d}.png", shot.image) for i, shot in enumerate(shots, 1)]


def saved(folder, images):
    paths = []
    for image in images:
        path = folder / image.name
        cv2.imwrite(str(path), image.gray)
        paths.append(str(path))
    return paths


@pytest.fixture(scope="module")
def careful():
    return pictures("none")


@pytest.fixture(scope="module")
def outcome(careful):
    return calibrate_camera(careful, BOARD)


def test_a_careful_set_gives_the_camera_that_took_it(outcome):
    fit = outcome.fit
    assert outcome.verdict.grade is Grade.GOOD
    truth = DEVICE.color.intrinsics
    found = fit.camera.intrinsics
    for name, sd in zip(("fx", "fy", "cx", "cy"), fit.standard_deviations, strict=False):
        assert abs(getattr(found, name) - getattr(truth, name)) < 5 * sd + 0.05


def test_intervals_are_1_96_standard_deviations_to_both_sides(outcome):
    intervals = parameter_intervals(outcome.fit)
    np.testing.assert_allclose(intervals.mean(axis=1), outcome.fit.values)
    np.testing.assert_allclose(
        np.diff(intervals)[:, 0], 2 * 1.959964 * outcome.fit.standard_deviations
    )


def test_the_stored_calibration_keeps_its_intervals(outcome):
    stored = color_calibration(outcome.fit, "SN1")
    assert stored.parameter_names[:2] == ("color.fx", "color.fy")
    np.testing.assert_array_equal(stored.covariance, outcome.fit.covariance)
    assert stored.rms_px == outcome.fit.rms_px
    assert stored.valid_region["color"]["rows"] == 6


def test_progress_is_told_and_a_stop_ends_the_work(careful):
    told = []
    stop = threading.Event()

    def progress(done, total):
        told.append((done, total))
        stop.set()

    assert calibrate_camera(careful, BOARD, n_images=11, progress=progress, stop=stop) is None
    assert told == [(1, 11)]


def test_images_of_two_sizes_are_refused(careful):
    other = NamedImage("other.png", careful[1].gray[:400].copy())
    with pytest.raises(CalibrationError, match=r"other.png has 640x400"):
        calibrate_camera([careful[0], other], BOARD)


def test_no_image_is_refused():
    with pytest.raises(CalibrationError, match="no images"):
        fit_searched([], BOARD)


def test_a_file_that_is_no_image_is_named(tmp_path):
    (tmp_path / "text.png").write_text("no image")
    (tmp_path / "empty.png").touch()
    for name in ("text.png", "empty.png", "missing.png"):
        with pytest.raises(CalibrationError, match=name):
            list(read_images([tmp_path / name]))


def test_the_command_writes_a_calibration_and_says_what_it_is_worth(careful, tmp_path, capsys):
    out = tmp_path / "calibration.json"
    code = main(["calibrate", *saved(tmp_path, careful), *TOLD, "--out", str(out), "--json"])
    document = json.loads(capsys.readouterr().out)
    assert (code, document["verdict"]["grade"]) == (0, "good")
    assert document["rms_convention"] == "points"
    fx = document["parameters"]["fx"]
    assert fx["ci95"][0] < fx["value"] < fx["ci95"][1]
    assert len(document["images"]) == 11
    assert document["images"][0]["q_mm"] < 0.5
    assert document["uncertainty"][1]["length_ci95_mm"] < 5
    assert read_calibration(out).color.intrinsics.fx == fx["value"]


def test_corners_may_be_placed_as_other_programs_do_and_the_file_says_so(careful, tmp_path, capsys):
    out, report = tmp_path / "calibration.json", tmp_path / "calibration.xlsx"
    argv = ["calibrate", *saved(tmp_path, careful[:6]), *TOLD, "--out", str(out), "--keep-bad"]
    by_method = {}
    for method in ("edges", "gradient"):
        main([*argv, "--corners", method, "--json", "--report", str(report), "--language", "en"])
        document = json.loads(capsys.readouterr().out)
        assert document["corners"] == read_calibration(out).corner_method == method
        by_method[method] = document["parameters"]["fx"]["value"]
    # The rendered lens has no coma: both definitions mean the same place, but not to the last bit.
    assert by_method["edges"] != by_method["gradient"]
    assert by_method["edges"] == pytest.approx(by_method["gradient"], rel=0.005)
    cells = [cell.value for row in load_workbook(report).active.iter_rows() for cell in row]
    assert "where the edges are steepest, as OpenCV's cornerSubPix places them" in cells


def test_a_bad_set_is_not_written_unless_asked_for(tmp_path, capsys):
    out = tmp_path / "calibration.json"
    argv = ["calibrate", *saved(tmp_path, pictures("mirrored")), *TOLD, "--out", str(out)]
    assert main(argv) == 1
    captured = capsys.readouterr()
    assert "mirrored" in captured.out
    assert "not written" in captured.err
    assert not out.exists()
    assert main([*argv, "--keep-bad"]) == 1
    assert out.exists()


def test_images_without_the_board_are_named_each_with_its_reason(tmp_path, capsys):
    out = tmp_path / "calibration.json"
    paths = saved(tmp_path, pictures("wrong_board_size", n=2))
    assert main(["calibrate", *paths, *TOLD, "--out", str(out)]) == 1
    captured = capsys.readouterr()
    assert "01.png: A board of 8 x 6" in captured.out
    assert not out.exists()


def test_a_model_can_be_fixed(careful, tmp_path, capsys):
    out = tmp_path / "calibration.json"
    argv = ["calibrate", *saved(tmp_path, careful), *TOLD, "--out", str(out), "--json"]
    assert main([*argv, "--model", "k1,k2"]) == 0
    assert json.loads(capsys.readouterr().out)["model"] == "k1 k2"
    assert main([*argv, "--model", "fisheye"]) == 1
    assert "no lens model fisheye" in capsys.readouterr().err


def test_images_need_a_board_and_a_board_has_a_size(tmp_path, capsys):
    assert main(["calibrate", "a.png", "--out", str(tmp_path / "c.json")]) == 2
    assert "--board 9x6" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        main(["calibrate", "a.png", "--board", "9", "--out", "c.json"])


def test_the_board_is_printed(tmp_path, capsys):
    out = tmp_path / "board.pdf"
    assert main(["calibrate", "--print-board", "A4", "--out", str(out), "--json"]) == 0
    assert out.read_bytes().startswith(b"%PDF")
    assert json.loads(capsys.readouterr().out)["square_mm"] > 0
