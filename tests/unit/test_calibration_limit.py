"""A calibration older than the clinic allows is refused with its age."""

from datetime import UTC, datetime

import pytest

from adibas.data.calibration import RgbdCalibration
from adibas.errors import CalibrationError
from adibas.pipeline.calibration_age import check_age

NOW = datetime(2026, 11, 21, 12, 0, tzinfo=UTC)


@pytest.mark.parametrize("made", ["2026-11-11T13:00:00+00:00", "2026-11-11T12:30:00"])
def test_one_that_is_young_enough_is_taken(made):
    calibration = RgbdCalibration(created_utc=made)
    check_age(calibration, 10, NOW)
    with pytest.raises(CalibrationError, match="9 days old, and at most 8 are allowed"):
        check_age(calibration, 8, NOW)


def test_where_no_age_is_asked_for_any_will_do():
    calibration = RgbdCalibration(created_utc="1999-01-01")
    check_age(calibration, None, NOW)
    with pytest.raises(CalibrationError, match="days old"):
        check_age(calibration, 9_000, NOW)


@pytest.mark.parametrize("made", ["", "last week"])
def test_one_of_unknown_age_is_refused(made):
    with pytest.raises(CalibrationError, match="does not say when"):
        check_age(RgbdCalibration(created_utc=made), 10, NOW)
