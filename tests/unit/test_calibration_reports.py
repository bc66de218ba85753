"""What the report of a calibration says is what the fit and the images say."""

from dataclasses import replace
from datetime import UTC, datetime

import cv2
import numpy as np
import openpyxl
import pytest
from pypdf import PdfReader

from adibas.calibration.finder import TEXTS, BoardProblem, BoardSearch
from adibas.data.calibration_report import DepthReport
from adibas.data.calibration_verdict import Grade
from adibas.pipeline.calibrating import SearchedImage, color_calibration, fit_searched
from adibas.pipeline.calibration_report import report_of_calibration
from adibas.reports.calibration import write_calibration_report
from tests.unit.calibration_views import BOARD, SIZE, as_corners, drawn_pixels

NOW = datetime(2026, 5, 1, 9, 0, tzinfo=UTC)
N_VIEWS = 12
SURE = 1.959964


def clock():
    return NOW


@pytest.fixture(scope="module")
def outcome():
    pixels = drawn_pixels(np.random.default_rng(5), N_VIEWS)
    pixels[3, :4] = np.nan
    searched = [
        SearchedImage(corners.image, SIZE, BoardSearch(corners), 1.0)
        for corners in as_corners(pixels)
    ]
    none = SearchedImage("=empty", SIZE, BoardSearch(None, BoardProblem.NO_BOARD), np.nan)
    return fit_searched([*searched, none], BOARD)


@pytest.fixture(scope="module")
def report(outcome):
    calibration = color_calibration(outcome.fit, "SN7", clock)
    return report_of_calibration(outcome, calibration, "en", clock=clock)


@pytest.fixture(scope="module")
def workbook(report, tmp_path_factory):
    path = tmp_path_factory.mktemp("reports") / "calibration.xlsx"
    write_calibration_report(report, path)
    return openpyxl.load_workbook(path)


def table(sheet):
    """Return the rows of a sheet as dictionaries by its header."""
    header, *rows = sheet.iter_rows(values_only=True)
    return [dict(zip(header, row, strict=True)) for row in rows]


def facts(sheet):
    return {row[0]: row[1] for row in sheet.iter_rows(values_only=True) if row[0]}


def test_each_parameter_stands_with_its_interval(workbook, outcome):
    fit = outcome.fit
    rows = table(workbook["Parameters"])
    assert [row["Parameter"] for row in rows] == list(fit.parameter_names)
    sds = np.sqrt(np.diag(fit.covariance))
    assert [row["Value"] for row in rows] == pytest.approx(fit.values)
    assert [row["95 % from"] for row in rows] == pytest.approx(fit.values - SURE * sds)
    assert [row["95 % to"] for row in rows] == pytest.approx(fit.values + SURE * sds)
    assert {row["Unit"] for row in rows[:4]} == {"px"}


def test_the_parameters_are_those_of_the_camera_that_is_stored(workbook, report):
    rows = {row["Parameter"]: row["Value"] for row in table(workbook["Parameters"])}
    k = report.calibration.color.intrinsics
    assert [rows[name] for name in ("fx", "fy", "cx", "cy")] == pytest.approx(
        [k.fx, k.fy, k.cx, k.cy]
    )


def reprojection_px(view, fit):
    """Return the distances of the seen corners from where OpenCV projects them."""
    k = fit.camera.intrinsics
    matrix = np.array([[k.fx, 0.0, k.cx], [0.0, k.fy, k.cy], [0.0, 0.0, 1.0]])
    lens = np.array([*fit.camera.distortion, *np.zeros(5)])[:5]
    pose = view.camera_from_board
    vector = cv2.Rodrigues(pose.rotation)[0]
    found = cv2.projectPoints(BOARD.points_m(), vector, pose.translation_m, matrix, lens)[0][:, 0]
    away = np.linalg.norm(view.pixels - found, axis=1)
    return away[~np.isnan(away)]


def test_the_error_of_each_image_is_what_opencv_projects(workbook, outcome):
    rows = table(workbook["Images"])
    fit = outcome.fit
    assert len(rows) == N_VIEWS + 1
    for row, view in zip(rows, fit.views, strict=False):
        away_px = reprojection_px(view, fit)
        assert row["Image"] == view.image
        assert row["Corners found"] == len(away_px)
        assert row["Error, rms [px]"] == pytest.approx(np.sqrt(np.mean(away_px**2)), rel=0.02)
        assert row["Largest error [px]"] == pytest.approx(away_px.max(), rel=0.02)
        middle_m = view.camera_from_board.apply(BOARD.points_m()).mean(axis=0)
        assert row["Distance [m]"] == pytest.approx(np.linalg.norm(middle_m), rel=0.02)
        normal = view.camera_from_board.rotation[:, 2]
        assert row["Tilt [deg]"] == pytest.approx(np.degrees(np.arccos(abs(normal[2]))), abs=0.01)


def test_an_image_without_a_board_says_why_and_is_no_formula(workbook):
    row = table(workbook["Images"])[-1]
    assert row["Remark"] == str(TEXTS[BoardProblem.NO_BOARD])
    assert row["Corners found"] == 0
    cell = workbook["Images"].cell(N_VIEWS + 2, 2)
    assert cell.data_type == "s"
    assert cell.value.endswith("=empty")


def test_the_thesis_table_has_its_errors_and_q_k(workbook):
    """Q_k (8.1) is the mean length of the errors of an image's corners, in millimetres."""
    rows = table(workbook["Corners"])
    by_image = {}
    for row in rows:
        errors = np.array([row["error x [mm]"], row["error y [mm]"]])
        real = np.array([row["real x [mm]"], row["real y [mm]"]])
        computed = np.array([row["computed x [mm]"], row["computed y [mm]"]])
        assert errors == pytest.approx(real - computed, abs=1e-9)
        assert row["error [mm]"] == pytest.approx(np.linalg.norm(errors))
        assert (real % (1000 * BOARD.square_m)) == pytest.approx(np.zeros(2), abs=1e-6)
        found = (row["error [mm]"], row["Q_k of the image [mm]"])
        by_image.setdefault(row["Image"], []).append(found)
    assert len(by_image) == N_VIEWS
    q_k = {row["Image"]: row["Q_k [mm]"] for row in table(workbook["Images"])}
    for image, found in by_image.items():
        lengths, told = np.array(found).T
        assert told == pytest.approx(lengths.mean())
        assert q_k[image] == pytest.approx(lengths.mean())
    total = np.mean([row["error [mm]"] for row in rows])
    assert facts(workbook["Summary"])["Mean error on the board, Q [mm]"] == pytest.approx(
        total, rel=0.05
    )


def test_coverage_counts_every_corner_once(workbook, outcome):
    sheet = list(workbook["Coverage"].iter_rows(values_only=True))
    start = next(i for i, row in enumerate(sheet) if row[0] == "Corners in each part of the image")
    rows = []
    for row in sheet[start + 2 :]:
        if row[0] is None:
            break
        rows.append([value or 0 for value in row[1:] if not isinstance(value, str)])
    used = sum(int(view.is_used.sum()) for view in outcome.fit.used_views)
    assert sum(map(sum, rows)) == used
    assert facts(workbook["Summary"])["Corners that took part"] == used


def test_the_summary_says_the_verdict_and_what_to_do(workbook, outcome):
    told = facts(workbook["Summary"])
    grade, *findings = outcome.verdict.sentences()
    assert told["Verdict"] == grade
    assert ("Reason, and what to do" in told) == bool(findings)
    assert told["Sensor"] == "SN7"
    assert "2026-10-28" in told["What to do next"]  # 180 days later
    assert told["Images given"] == N_VIEWS + 1
    assert told["Images with the board"] == N_VIEWS


def text_of(path):
    return "\n".join(page.extract_text() for page in PdfReader(path).pages)


def test_the_page_says_the_same_in_another_language(report, outcome, tmp_path):
    path = tmp_path / "calibration.pdf"
    write_calibration_report(replace(report, language="es"), path)
    text = " ".join(text_of(path).split())
    assert f"{outcome.fit.rms_px:.3f}".replace(".", ",") in text
    assert "Informe de la calibración" in text
    for name in outcome.fit.parameter_names:
        assert name in text


def test_a_calibration_to_be_repeated_has_a_report_that_says_why(tmp_path):
    pixels = drawn_pixels(np.random.default_rng(6), 3)
    images = [
        SearchedImage(corners.image, SIZE, BoardSearch(corners), 1.0)
        for corners in as_corners(pixels)
    ]
    outcome = fit_searched(images, BOARD)
    assert outcome.verdict.grade is Grade.REPEAT
    report = report_of_calibration(outcome, None, "en", clock=clock)
    for ending in ("pdf", "xlsx"):
        write_calibration_report(report, tmp_path / f"bad.{ending}")
    told = facts(openpyxl.load_workbook(tmp_path / "bad.xlsx")["Summary"])
    assert "Too few images" in told["Reason, and what to do"]
    assert "What to do next" not in told
    assert "Too few images" in text_of(tmp_path / "bad.pdf")


def test_another_ending_is_a_mistake_of_the_caller(report, tmp_path):
    with pytest.raises(ValueError, match="txt"):
        write_calibration_report(report, tmp_path / "report.txt")


def test_a_report_refuses_a_search_that_did_not_end(report):
    with pytest.raises(ValueError, match="did not end"):
        replace(report, fit=replace(report.fit, is_settled=False))


def test_a_report_refuses_a_time_without_its_zone(report):
    with pytest.raises(ValueError, match="time zone"):
        replace(report, written_utc=NOW.replace(tzinfo=None))


def test_a_depth_report_gives_the_deviation_of_what_was_estimated_and_of_nothing_else(outcome):
    calibration = color_calibration(outcome.fit, "SN7", clock)
    depth = DepthReport(
        calibration.color_from_depth,
        calibration.depth_bias,
        outcome.fit.camera,
        ("depth_bias.a", "depth.fx"),
        np.array([[4e-6, 1e-6], [1e-6, 0.25]]),
    )
    assert depth.sd("depth_bias.a") == pytest.approx(0.002)
    assert depth.sd("depth.fx") == pytest.approx(0.5)
    assert np.isnan(depth.sd("depth.fy"))
