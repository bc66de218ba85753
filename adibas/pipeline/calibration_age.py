"""Whether a calibration is young enough for what the clinic allows."""

from datetime import UTC, datetime

from adibas.data.calibration import RgbdCalibration
from adibas.errors import CalibrationError


def check_age(calibration: RgbdCalibration, most_days: int | None, now_utc: datetime) -> None:
    """Refuse a calibration that is older than so many days, or does not say when it was made.

    Where nothing is allowed or forbidden (None), any age will do.

    Raises
    ------
    CalibrationError
        It is.
    """
    if most_days is None:
        return
    n_days = age_days(calibration, now_utc)
    if n_days is None:
        raise CalibrationError(
            "The calibration does not say when it was made, and one of at most {allowed} days is "
            "asked for. Calibrate the sensor again.",
            allowed=most_days,
        )
    if n_days > most_days:
        raise CalibrationError(
            "The calibration is {days} days old, and at most {allowed} are allowed. Calibrate the "
            "sensor again.",
            days=n_days,
            allowed=most_days,
        )


def age_days(calibration: RgbdCalibration, now_utc: datetime) -> int | None:
    """Return the whole days since a calibration was made; None where it does not say when."""
    made = _moment(calibration.created_utc)
    return None if made is None else (now_utc - made).days


def _moment(text: str) -> datetime | None:
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        return None
    return found if found.tzinfo is not None else found.replace(tzinfo=UTC)
