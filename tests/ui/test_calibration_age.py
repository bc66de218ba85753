"""The capture screen reminds of a sensor that should be calibrated."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from unittest.mock import create_autospec

import pytest

from adibas.calibration.kept import REMIND_AFTER, KeptCalibrations
from adibas.errors import CalibrationError
from adibas.pipeline.live_frames import SensorState
from tests.unit.board_pictures import INFO, MAKERS
from ui.capture.calibration_age import CalibrationAge
from ui.capture.ports import CaptureView
from ui.capture.view import CaptureScreen

NOW = datetime(2026, 5, 1, 9, 0, tzinfo=UTC)
LIVE = SensorState("live", info=INFO)
NEVER = "This sensor was never calibrated on this computer."


@pytest.fixture
def kept(tmp_path):
    return KeptCalibrations(tmp_path / "calibrations")


def told(workspace, kept, source, age=None):
    """Return what the view is told of a sensor whose calibration has that age."""
    workspace.live.open(source, None)
    if age is not None:
        kept.keep(replace(MAKERS, created_utc=(NOW - age).isoformat()))
    view = create_autospec(CaptureView, instance=True)
    CalibrationAge(view, workspace, kept, lambda: NOW).show(LIVE)
    return view.show_calibration_due.call_args.args[0]


def test_a_sensor_without_calibration_is_told(workspace, kept):
    assert told(workspace, kept, "openni2") == NEVER


def test_a_calibration_of_last_month_is_no_news(workspace, kept):
    assert told(workspace, kept, "openni2", timedelta(days=30)) == ""


def test_an_old_calibration_should_be_made_anew(workspace, kept):
    age = REMIND_AFTER + timedelta(days=1)
    assert told(workspace, kept, "realsense", age).endswith("Calibrate it again.")


def test_the_clinic_says_how_old_a_calibration_may_be(workspace, kept):
    workspace.preferences.change(calibration_days=20)
    assert told(workspace, kept, "realsense", timedelta(days=30)).endswith("Calibrate it again.")
    workspace.preferences.change(calibration_days=365)
    assert told(workspace, kept, "realsense", timedelta(days=300)) == ""


@pytest.mark.parametrize("source", ["simulator:anterior", "/x/a.mcap", "openni2:/x/a.oni"])
def test_nothing_is_due_for_what_is_no_sensor(workspace, kept, source):
    assert told(workspace, kept, source) == ""


def test_a_sensor_that_is_not_live_changes_nothing(workspace, kept):
    view = create_autospec(CaptureView, instance=True)
    CalibrationAge(view, workspace, kept).show(SensorState("opening"))
    view.show_calibration_due.assert_not_called()


def test_a_damaged_calibration_is_a_problem_in_words(workspace, kept):
    kept.keep(replace(MAKERS, created_utc=NOW.isoformat()))
    next(kept.folder.glob("*/*.json")).write_text("[]", encoding="utf-8")
    with pytest.raises(CalibrationError):
        told(workspace, kept, "openni2")


def test_the_reminder_leads_to_the_wizard(workspace, kept):
    wanted = []
    workspace.screen_wanted.subscribe(wanted.append)
    CalibrationAge(create_autospec(CaptureView, instance=True), workspace, kept).calibrate()
    assert wanted == ["calibration"]


def test_the_reminder_is_seen_only_where_it_is_due(qtbot):
    screen = CaptureScreen()
    qtbot.addWidget(screen)
    assert screen._calibrate.isHidden()
    screen.show_calibration_due(NEVER)
    assert not screen._calibrate.isHidden()
    assert screen._due.text() == NEVER
