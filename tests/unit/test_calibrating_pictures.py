"""The wizard's pictures calibrate the depth camera, too, and show a board of the wrong size."""

from dataclasses import replace

import numpy as np
import pytest

from adibas.data.board import Board
from adibas.data.calibration_verdict import Finding, Grade, Reason, Verdict
from adibas.data.frames import SourceInfo
from adibas.geometry.planes import Plane
from adibas.pipeline import calibrating_depth, sensor_calibration
from adibas.pipeline.calibrating_depth import DepthOutcome
from adibas.pipeline.calibrating_pictures import NO_DEPTH, calibrate_depth_of, check_scales, joined
from tests.unit.board_pictures import (
    BIAS,
    BOARD,
    CAMERA,
    COLOR_FROM_DEPTH,
    INFO,
    MAKERS,
    N_POSES,
    taken,
)

KNOWN = replace(MAKERS, color=CAMERA)
MADE_OF = ("tx", "ty", "tz")


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    return taken(tmp_path_factory.mktemp("taken"))


@pytest.fixture(scope="module")
def outcome(session):
    return session.outcome()


def added_m(bias, measured_m):
    return bias.a + bias.b * measured_m + bias.c * measured_m**2 - measured_m


def test_the_error_of_the_depth_is_found_where_the_board_was(outcome):
    distances_m = np.linspace(0.55, 0.95, 5)
    found = added_m(outcome.calibration.depth_bias, distances_m)
    assert found == pytest.approx(added_m(BIAS, distances_m), abs=0.003)
    assert np.abs(added_m(BIAS, distances_m)).max() > 0.005  # there was something to find


def test_the_place_of_the_depth_camera_lies_in_its_interval(outcome):
    calibration = outcome.calibration
    names = [f"color_from_depth.{name}" for name in MADE_OF]
    at = [calibration.parameter_names.index(name) for name in names]
    sds = np.sqrt(np.diag(calibration.covariance))[at]
    away_m = calibration.color_from_depth.translation_m - COLOR_FROM_DEPTH.translation_m
    assert (np.abs(away_m) < 3.0 * sds).all()
    assert (sds < 0.002).all()


def test_the_colour_camera_is_the_one_of_the_pictures(outcome):
    assert outcome.calibration.color == outcome.camera.fit.camera
    names = outcome.calibration.parameter_names
    n_color = len(outcome.camera.fit.parameter_names)
    assert all(name.startswith("color.") for name in names[:n_color])
    assert outcome.calibration.covariance.shape == (len(names), len(names))
    assert outcome.calibration.covariance[:n_color, :n_color] == pytest.approx(
        outcome.camera.fit.covariance
    )


def test_what_the_depth_lacks_stands_in_the_verdict(outcome):
    findings = outcome.camera.verdict.findings
    assert outcome.is_good_enough
    assert any("farthest board stood at 1.0 m" in one.text for one in findings)
    assert {one.reason for one in outcome.depth.verdict.findings} == {Reason.DEPTH}


def test_without_a_floor_in_view_nothing_is_said_of_the_vertical(outcome):
    assert (outcome.calibration.gravity, outcome.calibration.floor) == (None, None)


def test_the_vertical_by_a_floor_in_view_stands_in_the_calibration(session, outcome, monkeypatch):
    down = np.array([0.0, 1.0, 0.0])
    seen = replace(
        outcome.depth.calibration,
        gravity=down,
        floor=Plane(-down, 1.1),
        gravity_sd_rad=0.002,
        floor_flatness_m=0.003,
    )
    depth = replace(outcome.depth, calibration=seen)
    monkeypatch.setattr(sensor_calibration, "calibrate_depth_of", lambda *_: depth)
    found = session.outcome().calibration
    np.testing.assert_array_equal(found.gravity, down)
    assert found.floor.offset_m == 1.1
    assert (found.gravity_sd_rad, found.floor_flatness_m) == (0.002, 0.003)


def test_the_floor_is_looked_for_as_the_picture_of_the_sensor_is_turned(session, monkeypatch):
    asked = []

    def vertical(_seen, _calibration, rotation_deg):
        asked.append(rotation_deg)

    monkeypatch.setattr(calibrating_depth, "vertical_of", vertical)
    monkeypatch.setattr(session, "sensor", replace(session.sensor, rotation_deg=270))
    session.outcome()
    assert asked == [270]


@pytest.mark.parametrize("factor", [0.75, 0.94, 1.06])
def test_a_board_of_another_size_than_said_is_found_out_by_depth(session, factor):
    wrong = Board(BOARD.columns, BOARD.rows, factor * BOARD.square_m)
    checks = check_scales(session.pictures, wrong, CAMERA, INFO)
    assert len(checks) == N_POSES
    factors = [check.by_depth_m / check.by_image_m for check in checks]
    assert np.median(factors) == pytest.approx(1.0 / factor, rel=0.015)
    session.board = wrong
    try:
        found = session.outcome()
    finally:
        session.board = BOARD
    assert Reason.SCALE in {one.reason for one in found.camera.verdict.findings}
    assert found.depth is None
    assert not found.is_good_enough


def test_a_board_of_the_right_size_is_not_suspected(session, outcome):
    checks = check_scales(session.pictures, BOARD, CAMERA, INFO)
    assert [check.by_depth_m for check in checks] == pytest.approx(
        [check.by_image_m for check in checks], rel=0.015
    )
    assert Reason.SCALE not in {one.reason for one in outcome.camera.verdict.findings}


def test_pictures_without_depth_leave_the_depth_camera_as_it_was(session):
    bare = [replace(one, depth_file=None, still_corners=None) for one in session.pictures]
    verdict = calibrate_depth_of(bare, BOARD, KNOWN, INFO)
    assert isinstance(verdict, Verdict)
    (finding,) = verdict.findings
    assert (finding.grade, finding.text) == (Grade.USABLE, str(NO_DEPTH))
    assert check_scales(bare, BOARD, CAMERA, INFO) == ()


def test_a_board_that_the_depth_camera_does_not_see_is_told(session):
    elsewhere = replace(INFO, calibration=replace(MAKERS, color_from_depth=COLOR_FROM_DEPTH))
    shifted = [replace(one, still_corners=session.pictures[0].corners) for one in session.pictures]
    verdict = calibrate_depth_of(shifted[1:2], BOARD, KNOWN, elsewhere)
    assert isinstance(verdict, Verdict)
    assert "still moments" in verdict.findings[0].text


def test_a_sensor_without_a_depth_camera_has_no_scale_to_check(session):
    assert check_scales(session.pictures, BOARD, CAMERA, SourceInfo()) == ()


def test_pictures_of_two_days_tell_nothing_of_drift(session):
    first, *others = session.pictures
    late = [replace(first, taken_ns=first.taken_ns + 10**14), *others]
    outcome = calibrate_depth_of(late, BOARD, KNOWN, INFO)
    assert isinstance(outcome, DepthOutcome)
    assert outcome.drift is None
    assert {shot.time_s for shot in outcome.fit.shots} == {0.0}


def test_a_joint_verdict_has_the_worst_first():
    worst = Finding(Reason.FRONTAL, Grade.REPEAT)
    some, other = (Finding(reason, Grade.USABLE) for reason in (Reason.FEW, Reason.DEPTH))
    found = joined(Verdict((some,)), Verdict((worst, other)))
    assert found.findings == (worst, some, other)
    assert joined(Verdict(), Verdict()).grade is Grade.GOOD
